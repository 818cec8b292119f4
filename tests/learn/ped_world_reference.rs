//! The world compared with recordings of the same world in Python.

use std::f64::consts::PI;
use std::path::PathBuf;

use base::seed::Seed;
use learn::Env;
use needs::needs;
use serde_json::Value;

use super::ped_world::{End, PedWorld, Reward, Road, Rules, Start, TICKS, Units, WALK};

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("a list").iter().map(|x| x.as_f64().expect("a number")).collect()
}

/// Every recording of the world below the reference folder.
fn recordings() -> Vec<PathBuf> {
    let mut folders = vec![crate::reference::folder()];
    let mut found = Vec::new();
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
            match entry.file_type() {
                Ok(kind) if kind.is_dir() => folders.push(entry.path()),
                _ if entry.file_name() == "golden.json" => found.push(entry.path()),
                _ => {}
            }
        }
    }
    found
}

#[needs(reference = "/golden.json")]
#[test]
fn ped_world_reference() {
    let recordings = recordings();
    let (mut decisions, mut hits, mut worst) = (0, 0, 0.0f64);
    for path in recordings {
        let episodes: Value = serde_json::from_str(&std::fs::read_to_string(&path).unwrap()).unwrap();
        for (number, episode) in episodes.as_array().unwrap().iter().enumerate() {
            let first = &episode["start"];
            let start = Start {
                s: first["s0"].as_f64().unwrap_or(0.0),
                left: first["turn"].as_i64().unwrap_or(1) > 0,
                distance: first["r"].as_f64().unwrap(),
                bearing: first["phi"].as_f64().unwrap(),
                heading: first["psi_p"].as_f64().unwrap(),
            };
            let road = if episode["world"] == "tee" { Road::Tee } else { Road::Straight };
            let raw = Rules { road, obs: Units::Raw, act: Units::Raw, reward: Reward::R2, end: End::Paper };
            let other = Rules { obs: Units::Scaled, act: Units::Scaled, reward: Reward::R1, end: End::Lost, ..raw };
            let mut world = PedWorld::new(raw, Seed::root(0).stream());
            let mut twin = PedWorld::new(other, Seed::root(0).stream());
            let (mut obs, mut scaled) = ([0.0; 4], [0.0; 4]);
            world.begin(&start, &mut obs);
            twin.begin(&start, &mut scaled);
            let mut twin_ended = false;
            // Python returns observations in single precision.
            let close = |what: &str, step: usize, ours: &[f64], theirs: &[f64], worst: &mut f64| {
                assert_eq!(ours.len(), theirs.len());
                for (ours, theirs) in ours.iter().zip(theirs) {
                    let difference = (ours - theirs).abs();
                    *worst = worst.max(difference);
                    assert!(difference <= 1e-12, "episode {number}, step {step}, {what}: {ours} is not {theirs}");
                }
            };
            let single = |obs: &[f64]| obs.iter().map(|x| f64::from(*x as f32)).collect::<Vec<_>>();
            close("first observation", 0, &single(&obs), &numbers(&episode["obs0"]), &mut worst);
            let steps = episode["steps"].as_array().unwrap();
            for (i, row) in steps.iter().enumerate() {
                let action = numbers(&row["act"]);
                let step = world.step(&action, &mut obs);
                let mut check = |what: &str, ours: &[f64], theirs: &[f64]| close(what, i, ours, theirs, &mut worst);
                check("s and v", &[world.s, world.speed], &[row["s"].as_f64().unwrap(), row["v"].as_f64().unwrap()]);
                check("car", &world.car, &numbers(&row["car"]));
                check("pedestrian", &world.pedestrian, &numbers(&row["ped"]));
                check("observation", &single(&obs), &numbers(&row["obs"]));
                check("reward", &[step.reward], &[row["reward_R2"].as_f64().unwrap()]);
                assert_eq!(u64::from(world.tick), row["tick"].as_u64().unwrap());
                let hit = world.hit();
                assert_eq!(hit.is_some(), row["hit"].as_bool().unwrap());
                assert_eq!(hit.is_some_and(|hit| hit.front), row["front"].as_bool().unwrap());
                assert_eq!(hit.is_some_and(|hit| hit.moving), row["moving"].as_bool().unwrap());
                assert_eq!(step.terminated, hit.is_some());
                assert_eq!(step.truncated, i + 1 == steps.len() && hit.is_none());

                // The other half of the variants is not in the recordings; it follows from the first half.
                if !twin_ended {
                    let step = twin.step(&[action[0] / PI, 2.0 * action[1] / WALK - 1.0], &mut scaled);
                    let wanted = [obs[0] / PI, obs[1] / 30.0, obs[2] / PI, obs[3] / 8.0];
                    for (scaled, wanted) in scaled.iter().zip(wanted) {
                        assert!((scaled - wanted).abs() < 1e-9);
                    }
                    let [ahead, _] = world.seen_from_car();
                    let away = hit.is_none() && (obs[1] > 60.0 || (ahead < -10.0 && obs[3] > 3.5));
                    assert_eq!(step.reward, if hit.is_some() { 1.0 } else { 0.0 });
                    assert_eq!(step.terminated, hit.is_some() || (away && world.tick < TICKS));
                    twin_ended = step.done();
                }
                decisions += 1;
                hits += usize::from(hit.is_some());
            }
        }
    }
    eprintln!("{decisions} decisions with {hits} hits agree; the largest difference is {worst:e}");
    assert!(hits > 0 && decisions > 100, "the recordings show too little");
}

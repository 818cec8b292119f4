//! The natural pedestrian beside the recorded ones: speeds, changes within a second, and how it crosses.

use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;

use base::seed::Seed;
use compile::{Catalog, compile};
use episode::walker::{Gaps, Natural, NaturalKeys, RecordedWalking, Recording};
use episode::{Outcome, Scenario, Trace, evaluate_observed};
use needs::needs;
use road::geometry::{Vector, wrap_angle};

use crate::reference;

/// Pedestrians before a car that drives past at 10 m/s, with a body that reaches every command at once.
fn scenario(spawn: &str) -> Arc<Scenario> {
    let text = format!(
        "edition 1\nimport \"std/drivers.scn\"\nimport \"std/ncap.scn\"\n\
                body free {{ shape: adult ramp: 0 s turning: 20 Hz speed: 0 m/s .. 6 m/s }}\n\
                spawn beside {{ {spawn} ego_speed: 10 m/s }}\n\
                episode half_a_minute {{ ticks: 600 }}\n\
                campaign c {{ vehicle: model3 body: free spawn: beside episode: half_a_minute\n\
                evaluate {{ towns: [test_track] drivers: [blind] pedestrians: [natural] episodes: 1 }} }}"
    );
    let root = crate::repository().join("scenarios/test_of_natural_walking.scn");
    let read = |path: &Path| if path == root { Ok(text.to_string()) } else { std::fs::read_to_string(path) };
    let compiled = compile(std::slice::from_ref(&root), &Catalog::builtin(), &read, &mut Default::default()).unwrap();
    let plan = compiled.plan.unwrap_or_else(|| panic!("{:?}", compiled.diagnostics));
    plan.campaigns[0].nth::<compile::Evaluation>(0).scenario.clone()
}

const BESIDE: &str = "bearing: 10 deg .. 45 deg distance: 20 m .. 40 m";

fn episodes<T>(walker: Natural, spawn: &str, count: u32, mut note: impl FnMut(&Outcome, &Trace) -> T) -> Vec<T> {
    let seed = Seed::root(3);
    let mut note = |_: u32, outcome: &Outcome, trace: &Trace| note(outcome, trace);
    let (mut walker, scenario) = (walker, scenario(spawn));
    evaluate_observed(&mut walker, &scenario, 0..count, &seed, &seed, &mut note, &mut |_| ControlFlow::Continue(()))
}

/// Speeds, sizes of changes of speed and sizes of changes of heading, second by second from the first whole second of walking on.
fn figures(walking: RecordedWalking) -> [Vec<f64>; 3] {
    let velocities = |_: &Outcome, trace: &Trace| -> Vec<Vector> {
        let walked = trace.pedestrian(0).iter().skip_while(|state| state.speed() < 0.05);
        walked.skip(10).step_by(20).map(|state| state.velocity).collect()
    };
    let [mut speeds, mut changes, mut turns] = [Vec::new(), Vec::new(), Vec::new()];
    for track in episodes(Natural::new(walking, 0.0), BESIDE, 600, velocities) {
        speeds.extend(track.iter().map(|velocity| velocity.norm()));
        for pair in track.windows(2).filter(|pair| pair.iter().all(|velocity| velocity.norm() > 0.3)) {
            let heading = |velocity: &Vector| libm::atan2(velocity.y, velocity.x);
            changes.push((pair[1].norm() - pair[0].norm()).abs());
            turns.push(wrap_angle(heading(&pair[1]) - heading(&pair[0])).abs());
        }
    }
    let mut all = [speeds, changes, turns];
    all.iter_mut().for_each(|values| values.sort_by(f64::total_cmp));
    all
}

fn quantile(sorted: &[f64], share: f64) -> f64 {
    sorted[((sorted.len() - 1) as f64 * share).round() as usize]
}

/// The standard deviation about 0 of values whose sizes these are.
fn deviation(sizes: &[f64]) -> f64 {
    (sizes.iter().map(|size| size * size).sum::<f64>() / sizes.len() as f64).sqrt()
}

/// The sampler repeats the recorded figures that are in `natural_walking.csv`. A value may differ by a tenth, the
/// 5th percentile of speeds by 15 %, a 99th percentile by a fifth and a 99.9th by a quarter.
#[needs(reference = "next/natural_walking.csv")]
#[test]
fn a_natural_pedestrian_has_the_figures_of_recorded_ones_as_in_the_reference() {
    let path = reference::folder().join("reference/next/natural_walking.csv");
    let text = crate::gzip::read_text(&path).unwrap();
    let lines: Vec<Vec<&str>> =
        text.lines().filter(|line| !line.starts_with('#')).map(|line| line.split(',').collect()).collect();
    let recorded = |dataset: &str, column: &str| -> Option<f64> {
        let place = lines[0].iter().position(|name| *name == column).unwrap_or_else(|| panic!("no {column}"));
        let row = lines.iter().find(|row| row[0] == dataset).unwrap_or_else(|| panic!("no {dataset}"));
        row[place].parse().ok()
    };
    let mut compared = 0;
    for (dataset, walking) in [("DUT", RecordedWalking::DUT), ("VRU", RecordedWalking::VRU)] {
        let [speeds, changes, turns] = figures(walking);
        assert!(speeds.len() > 10_000, "{}", speeds.len());
        let mean = speeds.iter().sum::<f64>() / speeds.len() as f64;
        let spread =
            (speeds.iter().map(|speed| (speed - mean) * (speed - mean)).sum::<f64>() / speeds.len() as f64).sqrt();
        let rows = [
            ("speed_mean", mean, 0.1),
            ("speed_sd", spread, 0.1),
            ("speed_p5", quantile(&speeds, 0.05), 0.15),
            ("speed_p85", quantile(&speeds, 0.85), 0.1),
            ("speed_p99", quantile(&speeds, 0.99), 0.1),
            ("speed_p999", quantile(&speeds, 0.999), 0.25),
            ("change_sd", deviation(&changes), 0.1),
            ("change_p99", quantile(&changes, 0.99), 0.2),
            ("change_p999", quantile(&changes, 0.999), 0.25),
            ("heading_sd", deviation(&turns), 0.1),
            ("heading_p99", quantile(&turns, 0.99), 0.2),
            ("heading_p999", quantile(&turns, 0.999), 0.25),
        ];
        for (column, found, tolerance) in rows {
            let Some(wanted) = recorded(dataset, column) else { continue };
            eprintln!("{dataset} {column}: {found:.3}, recorded {wanted:.3}");
            assert!((found - wanted).abs() <= tolerance * wanted, "{dataset} {column}: {found:.3} and not {wanted:.3}");
            compared += 1;
        }
    }
    assert!(compared >= 18, "{compared} figures");
}

/// Those who heed the car wait for their gap, so fewer are hit, and they cross in the end, since the car drives past.
#[test]
fn pedestrians_that_heed_the_car_wait_for_a_gap() {
    let results = |heed: f64| {
        let crossed = |outcome: &Outcome, trace: &Trace| {
            let track = trace.pedestrian(0);
            let waited = track.iter().take_while(|state| state.speed() < 0.05).count();
            (outcome.is_collision(), waited, (track[0].pose.position() - track[track.len() - 1].pose.position()).norm())
        };
        episodes(Natural::new(RecordedWalking::DUT, heed), BESIDE, 200, crossed)
    };
    let (careful, heedless) = (results(1.0), results(0.0));
    let hits = |results: &[(bool, usize, f64)]| results.iter().filter(|(hit, ..)| *hit).count();
    let (few, many) = (hits(&careful), hits(&heedless));
    assert!(many > 0 && 4 * few <= many, "{few} who slow down in their gap are hit, and {many} who do not look");
    assert!(heedless.iter().all(|(_, waited, _)| *waited <= 1), "they set off at once");
    assert!(careful.iter().filter(|(_, waited, _)| *waited > 20).count() > 100, "most wait more than a second");
    assert!(careful.iter().all(|(_, _, way)| *way > 5.0), "all of them cross");
}

/// Pedestrians 3 to 5 m beside the middle of the car's way set off at once, or wait. The share that sets off, by the time until the car is there, grows, and
/// those of the capacity manual set off earlier than recorded ones. reports/natural_walking.md has the figures that this prints.
#[test]
#[ignore = "a large sample, which `.ci/run` takes"]
fn pedestrians_accept_the_gaps_that_they_say() {
    let accepted = |gaps: Gaps| -> Vec<(f64, usize, usize)> {
        let walker = Natural::from_keys(NaturalKeys {
            changes: Recording::Dut,
            heed: 1.0,
            gaps,
            destination: None,
            forces: None,
        });
        let first = |_: &Outcome, trace: &Trace| {
            let (car, track) = (trace.vehicle(0)[0].state.pose, trace.pedestrian(0));
            let place = car.to_local(track[0].pose.position());
            let sets_off = track.iter().take_while(|state| state.speed() < 0.05).count() <= 1;
            (place.x / 10.0, place.y.abs(), sets_off)
        };
        let all = episodes(walker, "bearing: 1.5 deg .. 12 deg distance: 20 m .. 200 m", 6_000, first);
        let within = |second: f64| {
            let some =
                all.iter().filter(|(gap, aside, _)| (second..second + 1.0).contains(gap) && (3.0..5.0).contains(aside));
            let (all, off) = some.fold((0, 0), |(all, off), (.., sets_off)| (all + 1, off + usize::from(*sets_off)));
            (second, off, all)
        };
        (3..16).map(|second| within(f64::from(second))).collect()
    };
    let (recorded, manual, observed) = (accepted(Gaps::Recorded), accepted(Gaps::Hcm), accepted(Gaps::HcmObserved));
    for (((second, off, all), (_, manual_off, manual_all)), (_, observed_off, _)) in
        recorded.iter().zip(&manual).zip(&observed)
    {
        let logit = 1.0 / (1.0 + libm::exp(6.2064 - 0.9420 * (second + 0.5)));
        let share = |off: &usize, all: &usize| 100.0 * *off as f64 / (*all).max(1) as f64;
        eprintln!(
            "{second:2} s to {:2} s: recorded {:3.0} % of {all}, manual {:3.0} % of {manual_all}, observed by it {:3.0} %, logit {:3.0} %",
            second + 1.0,
            share(off, all),
            share(manual_off, manual_all),
            share(observed_off, manual_all),
            100.0 * logit
        );
    }
    let many = |list: &[(f64, usize, usize)], from: f64| {
        let some = list.iter().filter(|(second, ..)| *second >= from);
        some.fold((0, 0), |(off, all), (_, more, of)| (off + more, all + of))
    };
    assert_eq!(manual[0].1, 0, "none sets off with less than 4 s");
    let (off, all) = many(&manual, 11.0);
    assert!(all > 80 && off * 100 > all * 95, "{off} of {all} set off with more than 11 s");
    let (off, all) = many(&recorded, 15.0);
    assert!(all > 10 && off * 100 > all * 60, "{off} of {all} of the recorded ones");
    let earlier = recorded.iter().zip(&manual).filter(|((_, off, all), (_, other, of))| off * of < other * all).count();
    assert!(earlier >= 5, "{earlier} bins");
    let (off, all) = many(&observed, 7.0);
    assert!(all > 80 && off * 100 > all * 95, "{off} of {all} set off with more than 7 s");
}

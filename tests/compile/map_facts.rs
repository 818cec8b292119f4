//! What a map says is driven by: speed limits, stop and yield signs.

use std::path::Path;
use std::sync::Arc;

use base::diagnostic::Sources;
use base::seed::Seed;
use compile::{Catalog, Compiled, compile};
use episode::{Draw, Scenario};

use crate::straight_road::map;

/// Drivers that heed signs.
const HEEDING: [&str; 6] = ["idm", "aeb", "rss", "predictive", "oracle", "careful_human"];
/// Where the second half of the road begins, and where the signs stand (m).
const MIDDLE: f64 = 300.0;

/// The limit of a road type from a place on (m), in km/h.
fn limit(s: f64, limit: &str) -> String {
    format!(r#"<type s="{s}" type="town"><speed max="{limit}" unit="km/h"/></type>"#)
}

fn compiled(map: &str, driver: &str, spawn: &str) -> Compiled {
    let lib = crate::repository().join("scenarios/lib");
    let text = format!(
        "edition 1\nimport \"{0}/paper.scn\"\nimport \"{0}/drivers.scn\"\n\
         town real = opendrive(file: \"real.xodr\")\n\
         spawn here {{ ego_poses: [(150 m, -1.75 m, 0 deg)]  bearing: 180 deg  distance: 900 m  {spawn} }}\n\
         episode brief {{ ticks: 100  hold: 10 }}\n\
         campaign c {{ vehicle: model3 body: suicidal spawn: here episode: brief training: ppo_paper\n\
         train {{ towns: [real] drivers: [blind] rewards: [r1] runs: 1 }}\n\
         evaluate {{ towns: [real] drivers: [{driver}] pedestrians: [intercept] episodes: 1 }} }}",
        lib.display(),
    );
    let root = crate::repository().join("scenarios/map_facts.scn");
    let read = |path: &Path| match path {
        path if path == root => Ok(text.clone()),
        path if path.ends_with("real.xodr") => Ok(map.to_owned()),
        path => std::fs::read_to_string(path),
    };
    compile(std::slice::from_ref(&root), &Catalog::builtin(), &read, &mut Sources::default()).expect("readable")
}

fn scenario(map: &str, driver: &str, spawn: &str) -> Arc<Scenario> {
    let compiled = compiled(map, driver, spawn);
    let plan = compiled.plan.unwrap_or_else(|| panic!("{:?}", compiled.diagnostics));
    plan.campaigns[0].nth::<compile::Evaluation>(0).scenario.clone()
}

/// The places of the front of the car (m) and its speeds (m/s), tick by tick up to a place (m) or 100 s.
fn drive(map: &str, driver: &str, spawn: &str, to: f64) -> Vec<(f64, f64)> {
    let mut env = scenario(map, driver, spawn).simulation();
    env.start(Draw::new(&Seed::root(4), 0));
    let still = [env.scene().homing(0)];
    env.decide(&still);
    let mut driven = Vec::new();
    for _ in 0..2000 {
        if env.tick().is_some() {
            env.decide(&still);
        }
        let ego = env.scene().world.ego();
        driven.push((ego.state.pose.x + ego.blueprint.half_length, ego.state.speed));
        if ego.state.pose.x > to {
            break;
        }
    }
    driven
}

/// The speed where the front first is beyond a place (m).
fn speed_at(driven: &[(f64, f64)], place: f64) -> f64 {
    driven.iter().find(|(front, _)| *front >= place).unwrap_or_else(|| panic!("it never comes to {place} m")).1
}

#[test]
fn two_limits_give_two_speeds_and_a_slower_stretch_is_entered_at_its_limit() {
    let fast_then_slow = map(&(limit(0.0, "50") + &limit(MIDDLE, "20")), "");
    let slow_then_fast = map(&(limit(0.0, "20") + &limit(MIDDLE, "50")), "");
    for driver in HEEDING.into_iter().chain(["blind"]) {
        let driven = drive(&fast_then_slow, driver, "", 400.0);
        let (fast, entry, slow) = (speed_at(&driven, 200.0), speed_at(&driven, MIDDLE + 2.4), speed_at(&driven, 380.0));
        assert!((11.5..=13.9).contains(&fast), "{driver} drives {fast} m/s at 50 km/h");
        assert!((3.5..=20.0 / 3.6).contains(&entry), "{driver} enters the slower stretch at {entry} m/s");
        assert!((4.2..=20.0 / 3.6).contains(&slow), "{driver} drives {slow} m/s at 20 km/h");
        let driven = drive(&slow_then_fast, driver, "", 450.0);
        let (before, after) = (speed_at(&driven, MIDDLE), speed_at(&driven, 440.0));
        assert!(before <= 20.0 / 3.6 && after > 11.0, "{driver}: {before} m/s, then {after} m/s");
    }
    // CARLA's agent has CARLA's limit, which is 30 km/h without a sign: 27 km/h.
    let driven = drive(&fast_then_slow, "behavior", "", 400.0);
    assert!([200.0, 380.0].iter().all(|place| (speed_at(&driven, *place) - 7.46).abs() < 0.1));
}

#[test]
fn a_test_speed_is_held_whatever_the_limit() {
    let slow = map(&limit(0.0, "20"), "");
    for driver in ["idm", "aeb", "blind", "behavior"] {
        let driven = drive(&slow, driver, "test_speed: 40 km/h", 200.0);
        let speed = speed_at(&driven, 190.0);
        assert!((speed - 40.0 / 3.6).abs() < 0.4, "{driver} drives {speed} m/s");
    }
}

#[test]
fn a_stop_sign_stops_the_car_before_its_line_and_lets_it_go_on() {
    let sign = |kind: u32| {
        map(&limit(0.0, "50"), &format!(r#"<signal id="7" s="{MIDDLE}" t="-4" type="{kind}" orientation="+"/>"#))
    };
    let (stop, give_way) = (sign(206), sign(205));
    for driver in HEEDING {
        let driven = drive(&stop, driver, "", 400.0);
        let stood = driven.iter().filter(|(_, speed)| *speed < 0.1).map(|(front, _)| *front).fold(f64::NAN, f64::max);
        assert!((MIDDLE - 2.5..MIDDLE).contains(&stood), "{driver} stands at {stood} m");
        let after = speed_at(&driven, 400.0);
        assert!(after > 8.0, "{driver} drives {after} m/s after the sign");
        let ticks = driven.iter().filter(|(_, speed)| *speed < 0.1).count();
        assert!(ticks < 20, "{driver} stands {ticks} ticks");
        let driven = drive(&give_way, driver, "", 400.0);
        let (line, least) = (speed_at(&driven, MIDDLE), driven.iter().map(|(_, speed)| *speed).fold(9.0, f64::min));
        assert!(
            line < 2.3 && least > 1.0,
            "{driver} passes the yield sign at {line} m/s, and {least} m/s is its least speed"
        );
    }
    // One sees no signs, and stop signs do not stop CARLA's agent.
    for driver in ["blind", "behavior"] {
        let least = drive(&stop, driver, "", 400.0).iter().map(|(_, speed)| *speed).fold(f64::INFINITY, f64::min);
        assert!(least > 7.0, "{driver} slows down to {least} m/s");
    }
}

#[test]
fn a_map_without_limits_says_what_is_assumed() {
    let said = |map: &str| {
        let diagnostics = compiled(map, "idm", "").diagnostics;
        diagnostics.iter().map(|each| format!("{each:?}")).collect::<String>()
    };
    let without = map("", "");
    assert!(said(&without).contains("30 km/h assumed on 1400 of 1400 m of driving lanes"), "{}", said(&without));
    assert!(!said(&map(&limit(0.0, "50"), "")).contains("assumed"));
    let driven = drive(&without, "idm", "", 200.0);
    assert!((speed_at(&driven, 190.0) - 0.9 * 30.0 / 3.6).abs() < 0.3);
}

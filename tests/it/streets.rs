//! What stands and lies in designed towns, and what drivers and pedestrians make of it.

use std::path::Path;

use falsify::internal::compile::{Campaign, Catalog, compile};
use falsify::internal::geometry::OrientedBox;

/// The campaign of a scenario whose imports are read from the folder of scenarios.
fn campaign(text: &str) -> Campaign {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/test_of_streets.scn");
    let read = |path: &Path| if path == root { Ok(text.to_string()) } else { std::fs::read_to_string(path) };
    let compiled = compile(std::slice::from_ref(&root), &Catalog::builtin(), &read, &mut Default::default()).unwrap();
    let plan = compiled.plan.unwrap_or_else(|| panic!("{:?}", compiled.diagnostics));
    plan.campaigns.into_iter().next().unwrap()
}

/// A campaign in a town with a street of 400 m along the x axis and these further parts.
fn in_street(parts: &str, rest: &str) -> Campaign {
    campaign(&format!(
        "edition 1\nimport \"std/paper.scn\"\nimport \"std/drivers.scn\"\n\
         town here {{ shoulder: 2.5 m  street main {{ through: [(-200 m, 0 m), (200 m, 0 m)] }}\n{parts} }}\n\
         spawn beside {{ ego_poses: [(-100 m, -1.75 m, 0 deg)] }}\n\
         campaign c {{ vehicle: model3  adversary: suicidal  episode: thirty_seconds  spawn: beside\n{rest} }}"
    ))
}

const STANDING: &str = "evaluate { towns: [here]  policies: [blind]  pedestrians: [homing]  episodes: 1 }";

#[test]
fn a_row_holds_as_many_cars_as_there_is_room_for() {
    let row = "parked_row { from: (10 m, -4.75 m)  to: (10 m, -40.9 m)  gap: 1.5 m }";
    let off_lane = row.replace("(10 m, -4.75 m)", "(10 m, -6 m)");
    let town = &in_street(&off_lane, STANDING).evaluations[0].scenario.town;
    // (34.9 m + 1.5 m) / 6 m: the sixth car ends 34.5 m from the start of the row.
    assert_eq!(town.obstacles.len(), 6);
    let ends = |car: &OrientedBox| {
        car.corners().iter().map(|corner| corner.y).fold((f64::MAX, f64::MIN), |(a, b), y| (a.min(y), b.max(y)))
    };
    for (number, car) in town.obstacles.iter().enumerate() {
        let (rear, front) = (-6.0 - 6.0 * number as f64, -10.5 - 6.0 * number as f64);
        let (low, high) = ends(car);
        assert!((low - front).abs() < 1e-9 && (high - rear).abs() < 1e-9, "{number}: {low} {high}");
        assert!((car.pose.yaw + std::f64::consts::FRAC_PI_2).abs() < 1e-12, "they look along the row");
        assert!((2.0 * car.half.y - 1.9).abs() < 1e-12);
    }
    let full = row.replace("-4.75", "-6").replace("-40.9", "-40.5");
    assert_eq!(in_street(&full, STANDING).evaluations[0].scenario.town.obstacles.len(), 6, "the last car just fits");
}

#[test]
fn a_bus_is_an_obstacle_of_its_size() {
    let town = &in_street("bus { at: (30 m, -5 m, 0 deg) }", STANDING).evaluations[0].scenario.town;
    let [bus] = town.obstacles.as_slice() else { panic!("{:?}", town.obstacles) };
    assert_eq!((bus.pose.x, bus.pose.y, bus.half.x, bus.half.y), (30.0, -5.0, 6.0, 1.275));
}

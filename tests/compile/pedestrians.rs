//! The pedestrians of `std/pedestrians.scn`: their bodies, and what they do in episodes.

use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;

use base::seed::Seed;
use compile::{Catalog, Plan, compile};
use episode::walker::{Homing, Intercept, Random, WalkPolicy};
use episode::{Destination, Outcome, ReferenceFrame, Scaling, Scenario, Trace, evaluate_observed};
use road::geometry::{Obstacles, Point, wrap_angle};
use road::{Town, TownParts};
use verdict::PedestrianMotion;
use world::sim::Gait;

const SCENARIO: &str = r#"
edition 1
import "std/paper.scn"
import "std/pedestrians.scn"
import "std/drivers.scn"
import "std/towns.scn"
campaign walked {
  vehicle: model3  body: plausible  spawn: ahead  episode: thirty_seconds
  evaluate {
    towns: [harbour] drivers: [behavior] pedestrians: [random] episodes: 1
    bodies: [plausible, child, elderly, runner, suicidal, literal]
  }
}
"#;

fn plan() -> Plan {
    let root = crate::repository().join("scenarios/walked.scn");
    let read = |path: &Path| if path == root { Ok(SCENARIO.to_string()) } else { std::fs::read_to_string(path) };
    compile(std::slice::from_ref(&root), &Catalog::builtin(), &read, &mut Default::default()).unwrap().plan.unwrap()
}

fn scenario(plan: &Plan, adversary: &str) -> Arc<Scenario> {
    let mut evaluations = plan.campaigns[0].all::<compile::Evaluation>();
    let found = evaluations.find(|each| *each.adversary == *adversary).unwrap();
    assert_eq!(found.controller.name(), "random");
    found.scenario.clone()
}

/// What the pedestrian did in each of some episodes.
fn motions(scenario: &Arc<Scenario>, walker: &mut dyn WalkPolicy, episodes: u32) -> Vec<PedestrianMotion> {
    let seed = Seed::root(3);
    let note = &mut |_: u32, _: &Outcome, trace: &Trace| PedestrianMotion::new(&trace.main_pair(scenario));
    let go_on = &mut |_| ControlFlow::Continue(());
    evaluate_observed(walker, scenario, 0..episodes, &seed, &seed.child("walker"), note, go_on)
}

#[test]
fn the_bodies_are_those_that_their_sources_give() {
    let plan = plan();
    let gait = |name: &str| scenario(&plan, name).cast.pedestrian().body.gait;
    let fastest = |name: &str| scenario(&plan, name).cast.pedestrian().action.speed.1;
    for (name, acceleration, degrees, speed) in [
        ("plausible", 1.65, 80.0_f64, 8.0 / 3.6),
        ("child", 0.96, 80.0, 5.0 / 3.6),
        ("elderly", 0.96, 41.0, 1.25),
        ("runner", 3.11, 80.0, 11.0 / 3.6),
    ] {
        let Gait::Inertial { acceleration: found, stopping, turn_rate } = gait(name) else { panic!("{name}") };
        assert_eq!((found, stopping), (acceleration, acceleration), "{name}");
        assert!((turn_rate - degrees.to_radians()).abs() < 1e-12 && (fastest(name) - speed).abs() < 1e-12, "{name}");
    }
    // The dummies of Euro NCAP reach their speed v within a distance d: v² / 2 d.
    for (kmh, distance, acceleration) in [(8.0_f64, 1.5, 1.65), (5.0, 1.0, 0.96), (11.0, 1.5, 3.11)] {
        assert!(((kmh / 3.6).powi(2) / (2.0 * distance) - acceleration).abs() < 0.005, "{kmh} km/h");
    }
    // The paper's pedestrians have the gait that they always had.
    let nimble = Gait::Carla { ramp: 0.0, turning: 20.0, stopping: f64::INFINITY };
    assert_eq!(gait("suicidal"), nimble);
    assert_eq!(gait("literal"), Gait::Carla { ramp: 2.0, turning: 8.0, stopping: 20.48 });
}

#[test]
fn what_a_plausible_pedestrian_does_in_free_space_is_foreseeable() {
    let plan = plan();
    let free = |name: &str| {
        let scenario = scenario(&plan, name);
        Arc::new(Scenario { obstacles: Arc::new(Obstacles::new(&[])), ..Scenario::clone(&scenario) })
    };
    type MakeWalker = fn() -> Box<dyn WalkPolicy>;
    let walkers: [(&str, MakeWalker); 3] = [
        ("random", || Box::new(Random::default())),
        ("homing", || Box::new(Homing)),
        ("intercept", || Box::new(Intercept)),
    ];
    for (name, walker) in walkers {
        for body in ["plausible", "child", "elderly"] {
            for motion in motions(&free(body), walker().as_mut(), 40) {
                assert!(motion.is_foreseeable(), "{name}, {body}: {motion:?}");
            }
        }
        let nimble = motions(&free("suicidal"), walker().as_mut(), 40);
        // A body without inertia starts and turns at once, unless it has run on for three seconds, straight or in a bend of at most 1 m/s².
        let unforeseeable = nimble.iter().filter(|motion| !motion.is_foreseeable()).count();
        assert!(unforeseeable >= 16, "{name}: {nimble:?}");
        let runs = |motion: &PedestrianMotion| !motion.is_fast() || motion.peak_acceleration < 1.000_01;
        assert!(nimble.iter().all(|motion| !motion.is_foreseeable() || runs(motion)));
    }
    let fastest = motions(&free("plausible"), &mut Intercept, 40);
    assert!(fastest.iter().any(|motion| motion.peak_speed > 2.2), "{fastest:?}");
    let changes = motions(&free("plausible"), &mut Random::default(), 40);
    assert!(changes.iter().any(|motion| motion.velocity_change > 1.6), "{changes:?}");
}

#[test]
fn a_pedestrian_that_corrects_its_way_stays_on_it() {
    const CORRECTION: f64 = 0.3;
    let plan = plan();
    let stops = vec![Point::new(900.0, 0.0), Point::new(20.0, 4.0)];
    let town = TownParts { bus_stops: stops, ..TownParts::clone(&scenario(&plan, "suicidal").town) };
    let (there, town) = (Point::new(20.0, 4.0), Arc::new(Town::new(town)));
    for destination in [None, Some(Destination::Point(there)), Some(Destination::BusStop)] {
        let mut scenario = Scenario { town: town.clone(), ..Scenario::clone(&scenario(&plan, "suicidal")) };
        let action = &mut scenario.cast.pedestrians[0].action;
        (action.frame, action.heading) = (ReferenceFrame::Destination, (-CORRECTION, CORRECTION));
        (action.scaling, action.destination) = (Scaling::Natural, destination);
        let scenario = Arc::new(scenario);
        let mut largest = 0.0_f64;
        let note = &mut |_: u32, _: &Outcome, trace: &Trace| {
            let pair = trace.main_pair(&scenario);
            let (car, start) = (pair.frame(0).ego.pose, pair.frame(0).pedestrian.pose.position());
            for tick in 0..pair.len() {
                let Some(command) = pair.decision(tick) else { continue };
                let frame = pair.frame(tick);
                let way = match destination {
                    None => car.left() * -car.to_local(start).y.signum(),
                    Some(_) => there - frame.pedestrian.pose.position(),
                };
                let correction = wrap_angle(command.heading - libm::atan2(way.y, way.x));
                assert!(correction.abs() < CORRECTION + 1e-9, "{destination:?} {correction}");
                assert!((pair.action(&frame, command)[0] - correction).abs() < 1e-9);
                largest = largest.max(correction.abs());
            }
        };
        let go_on = &mut |_| ControlFlow::Continue(());
        let seed = Seed::root(3);
        evaluate_observed(&mut Random::default(), &scenario, 0..20, &seed, &seed.child("walker"), note, go_on);
        assert!(largest > 0.8 * CORRECTION, "{largest}");
    }
}

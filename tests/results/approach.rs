//! The last seconds before a touch, as the car sees them.

use std::path::Path;

use compile::{Catalog, compile};
use results::analysis::Approach;
use world::env::{Actions, Observer, Scenario, Scene, Trace};
use world::geometry::{Pose, Vector};
use world::sim::{ActorId, Contact, World};

const SCENARIO: &str = r#"
edition 1
import "lib/paper.scn"
import "lib/drivers.scn"
import "lib/towns.scn"
campaign approached {
  vehicle: model3  adversary: suicidal  spawn: ahead  episode: thirty_seconds
  evaluate { towns: [harbour] policies: [blind] pedestrians: [intercept] episodes: 1 }
}
"#;

fn scenario() -> Scenario {
    let root = crate::repository().join("scenarios/approached.scn");
    let read = |path: &Path| if path == root { Ok(SCENARIO.to_string()) } else { std::fs::read_to_string(path) };
    let compiled = compile(std::slice::from_ref(&root), &Catalog::builtin(), &read, &mut Default::default()).unwrap();
    Scenario::clone(&compiled.plan.unwrap().campaigns[0].nth::<compile::Evaluation>(0).scenario)
}

#[test]
fn an_approach_is_the_pedestrian_as_the_car_sees_it() {
    let scenario = scenario();
    let (ego, body) = (&scenario.cast.ego().blueprint, scenario.cast.pedestrian().body);
    let mut world =
        World::new(scenario.town.clone(), scenario.obstacles.clone(), vec![ego.clone()], vec![body], None, 0.05);
    let (mut trace, mut actions) = (Trace::new(&scenario), Actions::new(&scenario.cast));
    let touch = ego.half_length + body.radius;
    // The car drives east at 10 m/s for three seconds, and touches a pedestrian who comes from the left at 1.39 m/s.
    for tick in 0..=60 {
        let time = f64::from(tick) * 0.05;
        world.vehicles[0].state.pose = Pose::new(10.0 * time, 0.0, 0.0);
        world.vehicles[0].state.speed = 10.0;
        world.pedestrians[0].state.pose = Pose::new(30.0 + touch, 1.39 * (3.0 - time), 0.0);
        world.pedestrians[0].state.velocity = Vector::new(0.0, -1.39);
        let pair = (ActorId::EGO, ActorId::Pedestrian(0));
        let contact = Contact { pair, fraction: 1.0, bearing: 0.0, ahead: touch, aside: 0.0, impact_speed: 10.0 };
        actions.contact = (tick == 60).then_some(contact);
        let scene = Scene::new(&scenario, &world, &actions);
        if tick == 0 {
            trace.begin(&scene);
            assert_eq!(Approach::new(&trace.main_pair(&scenario)), None, "nobody is touched");
        } else {
            trace.tick(&scene);
        }
    }
    let approach = Approach::new(&trace.main_pair(&scenario)).unwrap();
    for (i, station) in approach.stations.iter().enumerate() {
        let before = Approach::WINDOW - i as f64 * Approach::STEP;
        let wanted = [touch + 10.0 * before, 1.39 * before, 10.0];
        for (found, wanted) in [station.ahead, station.left, station.speed].into_iter().zip(wanted) {
            assert!((found - wanted).abs() < 2e-3, "{i}: {found}, not {wanted}");
        }
    }
}

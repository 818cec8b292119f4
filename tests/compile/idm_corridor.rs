//! The Intelligent Driver Model among many: its shorter searches along the path change nothing.

use std::path::Path;

use rand::RngExt;

use base::seed::Seed;
use compile::{Catalog, Evaluation, compile};
use road::LaneFilter;
use road::geometry::{Obstacles, Point, Pose, Vector};
use world::av::{Actor, DrivingPolicy, Perception};
use world::sim::{ActorId, Control};

fn standing(number: u8, pose: Pose) -> Actor {
    let half = Vector::new(0.188, 0.188);
    Actor { id: ActorId::Pedestrian(number), pose, velocity: Vector::zeros(), half, height: 0.93 }
}

/// What a driver that was just reset does: the pedals and the wheel.
fn control(driver: &mut dyn DrivingPolicy, perception: &Perception<'_>) -> [u64; 3] {
    driver.reset(perception, Seed::root(1).stream());
    let Control { throttle, brake, steer } = driver.drive(perception);
    [throttle, brake, steer].map(f64::to_bits)
}

#[test]
fn a_crowd_changes_what_is_in_the_corridor_and_not_how_it_is_found() {
    let text = r#"
        edition 1
        import "lib/pedestrians.scn"
        import "lib/drivers.scn"
        import "lib/towns.scn"
        spawn near { bearing: -60 deg .. 60 deg  distance: 7 m .. 40 m }
        episode short { ticks: 240  hold: 10 }
        campaign crowds {
          vehicle: model3  body: plausible  spawn: near  episode: short
          evaluate { towns: [village] drivers: [idm] pedestrians: [intercept] }
        }"#;
    let root = crate::repository().join("scenarios/crowds.scn");
    let read = |path: &Path| if path == root { Ok(text.to_owned()) } else { std::fs::read_to_string(path) };
    let compiled = compile(std::slice::from_ref(&root), &Catalog::builtin(), &read, &mut Default::default()).unwrap();
    let plan = compiled.plan.expect("the campaign has no errors");
    let scenario = &plan.campaigns[0].nth::<Evaluation>(0).scenario;
    let (town, mut driver) = (&scenario.town, (scenario.cast.ego().policy)());
    let (blueprint, obstacles) = (&scenario.cast.ego().blueprint, Obstacles::new(&[]));
    let mut stream = Seed::root(7).stream();
    let (mut free, mut braked) = (0, 0);
    for _ in 0..3000 {
        let near = Point::new(stream.random_range(-50.0..250.0), stream.random_range(-50.0..200.0));
        let pose = town.pose(town.nearest_lane(near, LaneFilter::Driving).unwrap());
        let speed = stream.random_range(0.0..14.0);
        let half = Vector::new(blueprint.half_length, blueprint.half_width);
        let ego = Actor { id: ActorId::Vehicle(0), pose, velocity: pose.forward() * speed, half, height: 0.0 };
        let mut crowd: Vec<Actor> = (0..5)
            .map(|number| {
                let way = Vector::new(stream.random_range(-10.0..60.0), stream.random_range(-12.0..12.0));
                let place = pose.to_world(way);
                standing(number, Pose::new(place.x, place.y, stream.random_range(-3.0..3.0)))
            })
            .collect();
        let around = Perception {
            town,
            blueprint,
            tick: 0,
            dt: 0.05,
            ego,
            ground: 0.0,
            speed_limit: 13.9,
            signed_limit: None,
            route: &[],
            pedestrians: &[],
            vehicles: &[],
            obstacles: &obstacles,
            lights: &[],
            affecting_light: None,
        };
        // Somebody hidden by another is not there.
        let all = Perception { pedestrians: &crowd, ..around };
        let hidden: Vec<bool> = crowd.iter().map(|actor| !all.in_sight(actor)).collect();
        let mut hidden = hidden.into_iter();
        crowd.retain(|_| !hidden.next().unwrap());
        let mut perceived = |pedestrians: &[Actor]| control(driver.as_mut(), &Perception { pedestrians, ..around });
        // One by one the whole path is searched; the strongest brake is that of the crowd.
        let alone: Vec<[u64; 3]> = crowd.iter().map(|actor| perceived(std::slice::from_ref(actor))).collect();
        let strongest = |a: &&[u64; 3], b: &&[u64; 3]| {
            let [one, other] = [a, b].map(|[throttle, brake, _]| f64::from_bits(*brake) - f64::from_bits(*throttle));
            one.total_cmp(&other)
        };
        let strongest = *alone.iter().max_by(strongest).unwrap();
        assert_eq!(perceived(&crowd), strongest, "{pose:?} at {speed} m/s, {crowd:?}");
        crowd.reverse();
        assert_eq!(perceived(&crowd), strongest, "the order of the crowd, {pose:?} at {speed} m/s, {crowd:?}");
        let is_braked = strongest != perceived(&[]);
        (free, braked) = (free + u32::from(!is_braked), braked + u32::from(is_braked));
    }
    assert!(free > 300 && braked > 300, "{free} free, {braked} braked");
}

use super::sample::Case;
use crate::analysis::{Cases, Feature, Scale};
use world::env::{Ground, Scenario, Spawn};
use world::geometry::{Vector, wrap_angle};
use world::road::LaneFilter;

/// The features of a start, in the order of [`row`].
const FEATURES: [Feature; 8] = [
    Feature { name: "distance", scale: Scale::Number("m") },
    Feature { name: "bearing", scale: Scale::Number("deg") },
    Feature { name: "turned away", scale: Scale::Number("deg") },
    Feature { name: "ego speed", scale: Scale::Number("m/s") },
    Feature { name: "begins in the lane", scale: Scale::Truth("begins beside the lanes") },
    Feature { name: "begins on a sidewalk", scale: Scale::Truth("begins on no sidewalk") },
    Feature { name: "hidden at first", scale: Scale::Truth("in sight at first") },
    Feature { name: "junction ahead", scale: Scale::Truth("no junction ahead") },
];
/// The distance ahead of the car in which junctions are searched (m).
const AHEAD: [f64; 3] = [10.0, 20.0, 30.0];

/// The starts of some episodes as numbers, and which of them ended in the outcome to explain.
pub fn cases(scenario: &Scenario, cases: &[Case], hit: fn(&Case) -> bool) -> Cases {
    Cases {
        features: FEATURES.to_vec(),
        rows: cases.iter().map(|case| row(scenario, &case.spawn)).collect(),
        episodes: cases.iter().map(|case| case.episode).collect(),
        hits: cases.iter().map(hit).collect(),
    }
}

fn row(scenario: &Scenario, spawn: &Spawn) -> Vec<f64> {
    let (ego, place) = (&spawn.ego, spawn.pedestrian.position());
    let from_car = ego.to_local(place);
    let to_car = ego.position() - place;
    let off = wrap_angle(spawn.pedestrian.yaw - libm::atan2(to_car.y, to_car.x));
    let ground = Ground::at(&scenario.town, place);
    let hidden = scenario.obstacles.blocks_sight(ego.position(), place);
    let junction = AHEAD.iter().any(|ahead| {
        let lane = scenario.town.nearest_lane(ego.to_world(Vector::new(*ahead, 0.0)), LaneFilter::Driving);
        lane.is_some_and(|lane| scenario.town.is_junction(lane))
    });
    let truth = |holds: bool| f64::from(u8::from(holds));
    vec![
        from_car.norm(),
        libm::atan2(from_car.y, from_car.x).to_degrees(),
        off.abs().to_degrees(),
        spawn.ego_speed,
        truth(ground == Ground::Driving),
        truth(ground == Ground::Sidewalk),
        truth(hidden),
        truth(junction),
    ]
}

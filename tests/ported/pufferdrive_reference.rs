//! PufferDrive's policy compared with what its own simulator and network computed.

use std::path::{Path, PathBuf};

use crate::reference;
use needs::needs;
use ported::pufferdrive::{Network, Observation, Polyline, RoadMap, action, control, polylines};
use road::geometry::{OrientedBox, Point, Pose, Vector, wrap_angle};
use road::{Town, opendrive};
use serde_json::Value;
use world::av::Actor;
use world::sim::{ActorId, ThrottleLine, VehicleBlueprint, VehicleState};

/// Half extents of its car (m).
const HALF: Vector = Vector::new(1.575, 0.7);
/// Time of a step (s).
const STEP: f64 = 0.1;

/// The files of a folder whose path ends so.
pub fn files(folder: &Path, end: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        if path.is_dir() {
            found.extend(files(&path, end));
        } else if path.to_string_lossy().to_lowercase().ends_with(end) {
            found.push(path);
        }
    }
    found.sort();
    found
}

/// The examples, each with the weights beside them.
pub fn examples() -> Vec<(Value, Network)> {
    let read = |path: PathBuf| {
        let document = serde_json::from_str(&std::fs::read_to_string(&path).expect("the file is there"));
        let weights = std::fs::read(path.with_file_name("weights.bin")).expect("weights lie beside the examples");
        (document.expect("examples are JSON"), Network::read(&weights).expect("the weights fit"))
    };
    let all: Vec<_> = files(&reference::folder(), "pufferdrive/examples.json").into_iter().map(read).collect();
    assert!(!all.is_empty(), "no examples");
    all
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

fn list(value: &Value) -> &Vec<Value> {
    value.as_array().unwrap_or_else(|| panic!("{value} is no list"))
}

fn floats(value: &Value) -> Vec<f32> {
    list(value).iter().map(|value| number(value) as f32).collect()
}

fn rows(value: &Value) -> Vec<[f32; 7]> {
    list(value).iter().map(|row| floats(row).try_into().expect("a row has seven numbers")).collect()
}

fn observation(case: &Value) -> Observation {
    let ego = floats(&case["ego"]).try_into().expect("the ego has seven numbers");
    Observation { ego, others: rows(&case["others"]), road: rows(&case["road"]) }
}

/// Half of the state; 0 means zeros.
fn state(value: &Value) -> [f32; 256] {
    if value.is_number() { [0.0; 256] } else { floats(value).try_into().expect("the state has 256 numbers") }
}

/// The map of the examples, moved.
fn lines(document: &Value, by: Vector) -> Vec<Polyline> {
    let point = |pair: &Value| Point::new(number(&pair[0]), number(&pair[1])) + by;
    let line = |line: &Value| (number(&line[0]) as u8, list(&line[1]).iter().map(point).collect());
    list(&document["map"]).iter().map(line).collect()
}

fn map(document: &Value) -> RoadMap {
    RoadMap::new(&lines(document, Vector::zeros()))
}

fn car(state: &Value) -> Actor {
    let at = |key: &str| number(&state[key]);
    Actor {
        id: ActorId::Vehicle(0),
        pose: Pose::new(at("x"), at("y"), at("h")),
        velocity: Vector::new(at("vx"), at("vy")),
        half: Vector::new(at("L") / 2.0, at("W") / 2.0),
        height: 0.0,
    }
}

/// The greatest difference between numbers.
fn apart(got: &[f32], wanted: &[f32]) -> f32 {
    assert_eq!(got.len(), wanted.len());
    let apart = got.iter().zip(wanted).map(|(got, wanted)| (got - wanted).abs());
    apart.fold(0.0, |most, next| if next.is_nan() { next } else { most.max(next) })
}

#[needs(reference = "pufferdrive examples.json")]
#[test]
fn the_network_agrees_with_the_reference() {
    let mut cases = 0;
    for (document, network) in examples() {
        for case in list(&document["net"]) {
            let mut after = [state(&case["h_before"]), state(&case["c_before"])];
            let logits = network.step(&observation(case), &mut after);
            let wanted = floats(&case["logits"]);
            let difference = apart(&logits, &wanted);
            assert!(difference < 1e-4, "{}: logits differ by {difference}", case["id"]);
            let most = (0..logits.len()).max_by(|a, b| logits[*a].total_cmp(&logits[*b]));
            assert_eq!(most.map(|most| most as u64), case["argmax"].as_u64(), "{}", case["id"]);
            for (half, name) in after.iter().zip(["h_after", "c_after"]) {
                if let Some(wanted) = case.get(name) {
                    assert!(apart(half, &state(wanted)) < 1e-4, "{}: {name}", case["id"]);
                }
            }
            cases += 1;
        }
    }
    loud!("PufferDrive: {cases} steps of the network");
    assert!(cases > 0);
}

#[needs(reference = "pufferdrive examples.json")]
#[test]
fn observations_agree_with_the_reference() {
    let mut worlds = 0;
    for (document, _) in examples() {
        let map = map(&document);
        for world in list(&document["worlds"]) {
            let (ego, state) = (car(&world["ego"]), &world["ego"]);
            let goal = Point::new(number(&state["gx"]), number(&state["gy"]));
            let others: Vec<Actor> = list(&world["others"]).iter().map(car).collect();
            let mut seen = Observation::default();
            seen.look(&ego, goal, others.iter().copied(), (&map, 200));
            let wanted = observation(&world["observation"]);
            for (got, wanted) in [(&seen.others, &wanted.others), (&seen.road, &wanted.road)] {
                let difference = apart(got.as_flattened(), wanted.as_flattened());
                // Their places are 32-bit numbers of up to 100 m, scaled by 0.02.
                assert!(difference < 2e-5, "{} {}: rows differ by {difference}", world["run"], world["t"]);
            }
            assert!(apart(&seen.ego, &wanted.ego) < 1e-5, "{:?} instead of {:?}", seen.ego, wanted.ego);
            worlds += 1;
        }
    }
    loud!("PufferDrive: {worlds} observations");
    assert!(worlds > 0);
}

/// A car that turns as that of PufferDrive, without what CARLA's cars have besides.
pub fn small_car() -> VehicleBlueprint {
    let line = |throttle, at_rest| ThrottleLine { throttle, at_rest, slope: 0.0 };
    VehicleBlueprint {
        wheelbase: 3.15,
        greatest_wheel_angle: 1.1,
        throttle: vec![line(0.0, 0.0), line(1.0, 5.0)],
        ..VehicleBlueprint::generic()
    }
}

/// Each step of the traces by the equations of the reference and the actions of ours: places, goals, and edges that are not touched. Our own car
/// turns as much in it, and slips as much but for 0.02 rad.
#[needs(reference = "pufferdrive examples.json")]
#[test]
fn traces_agree_with_the_reference() {
    let (mut steps, mut goals) = (0, 0);
    for (document, _) in examples() {
        let map = map(&document);
        for trace in list(&document["traces"]) {
            let rows: Vec<Vec<f64>> =
                list(&trace["rows"]).iter().map(|row| list(row).iter().map(number).collect()).collect();
            let (mut x, mut y, mut heading, mut speed) = (rows[0][1], rows[0][2], rows[0][3], rows[0][6]);
            for pair in rows.windows(2) {
                let (row, next) = (&pair[0], &pair[1]);
                let number = row[7] as usize;
                let (acceleration, angle) = action(number);
                speed += acceleration * STEP;
                let slip = libm::tanh(libm::tan(angle) / 2.0);
                let (before, turn) = (heading, speed * libm::cos(slip) * libm::tan(angle) / 3.15 * STEP);
                x += speed * libm::cos(heading + slip) * STEP;
                y += speed * libm::sin(heading + slip) * STEP;
                heading += turn;
                let apart = (x - next[1]).abs().max((y - next[2]).abs()).max((heading - next[3]).abs());
                assert!(apart < 2e-3, "{} {} step {}: {apart}", trace["run"], trace["agent"], row[0]);
                assert!((speed - next[6]).abs() < 1e-3);

                let pose = Pose::new(next[1], next[2], next[3]);
                if (row[8], row[9]) != (next[8], next[9]) {
                    let goal = map.next_goal(&pose);
                    assert!((goal - Point::new(next[8], next[9])).norm() < 1e-3, "{goal}");
                    goals += 1;
                }
                assert_eq!(map.touches_edge(&OrientedBox { pose, half: HALF }), next[10] == 2.0);

                // Ours turns as much for its way.
                let car = VehicleState { pose: Pose::new(0.0, 0.0, before), speed, ..VehicleState::default() };
                let moved = car.step(control(action(number), &small_car(), speed.max(0.0)), &small_car(), STEP);
                let way = libm::hypot(moved.pose.x, moved.pose.y);
                assert!((wrap_angle(moved.pose.yaw - before) * speed * STEP - turn * way).abs() < 1e-9);
                let sideways = libm::atan2(moved.pose.y, moved.pose.x) - before - slip;
                assert!(speed < 0.1 || wrap_angle(sideways).abs() < 0.02, "{sideways}");
                steps += 1;
            }
        }
    }
    loud!("PufferDrive: {steps} steps, {goals} new goals");
    assert!(steps > 0 && goals > 0);
}

/// How far the pieces of a kind are beside those of another map of the same direction (m), in the order of their distances.
fn beside(pieces: &[Polyline], others: &[Polyline], kind: u8) -> Vec<f64> {
    let of = |map: &[Polyline]| -> Vec<[Point; 2]> {
        let lines = map.iter().filter(|line| line.0 == kind);
        lines.flat_map(|line| line.1.windows(2).map(|pair| [pair[0], pair[1]])).collect()
    };
    let others = of(others);
    let distance = |[from, to]: [Point; 2]| {
        let (middle, way) = (from + (to - from) / 2.0, to - from);
        let along = others.iter().map(|[from, to]| (middle - from, to - from));
        let same = along.filter(|(_, along)| along.dot(&way) > 0.5 * along.norm() * way.norm());
        let apart = same.map(|(offset, along)| {
            let share = (offset.dot(&along) / along.norm_squared()).clamp(0.0, 1.0);
            (offset - along * share).norm()
        });
        apart.fold(f64::INFINITY, f64::min)
    };
    let mut distances: Vec<f64> = of(pieces).into_iter().map(distance).collect();
    distances.sort_by(f64::total_cmp);
    distances
}

/// The map that is cut from Town02 has the lanes, lines and edges of the one that the policy learnt on, edges with the road on the same side. One
/// turning lane has another course in it, and one piece of an edge is missing.
#[needs(reference = "pufferdrive examples.json")]
#[needs(reference = "maps town02.xodr")]
#[test]
fn the_map_of_a_town_is_that_of_the_reference() {
    let path = files(&reference::folder(), "maps/town02.xodr").remove(0);
    let town = Town::new(opendrive::read(&std::fs::read_to_string(path).unwrap(), "Town02").unwrap());
    let ours = polylines(&town);
    for (document, _) in examples() {
        let mean = Vector::new(number(&document["mean_subtracted"][0]), number(&document["mean_subtracted"][1]));
        let theirs = lines(&document, mean);
        for (kind, near) in [(0, 0.5), (1, 0.3), (2, 0.2)] {
            for (name, distances) in [("ours", beside(&ours, &theirs, kind)), ("theirs", beside(&theirs, &ours, kind))]
            {
                let far = distances.iter().filter(|distance| **distance > near).count();
                loud!("PufferDrive: kind {kind}, {name}: {} pieces, {far} over {near} m", distances.len());
                assert!(far <= [6, 0, 1][usize::from(kind)], "{distances:?}");
            }
        }
    }
}

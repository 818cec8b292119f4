//! LAV's planner and controller compared with numbers computed by its own code.

use std::path::{Path, PathBuf};

use crate::reference;
use needs::needs;
use ported::lav::{
    Blob, BlobKind, BrakeRules, Command, Controller, Detector, EgoPoint, Forecast, Overruled, Pedals, Situation,
    Verdict, Version, WalkerView,
};
use serde_json::Value;
use world::sim::{PedestrianBody, VehicleBlueprint};

/// Examples are rounded to nine decimals.
const TOLERANCE: f64 = 1e-6;

/// The example files below a folder.
fn files(folder: &Path) -> Vec<PathBuf> {
    let mut open = vec![folder.to_path_buf()];
    let mut found = Vec::new();
    while let Some(folder) = open.pop() {
        for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
            let path = entry.path();
            let name = path.file_name().map(|name| name.to_string_lossy().to_lowercase()).unwrap_or_default();
            if path.is_dir() {
                open.push(path);
            } else if name.contains("lav") && name.contains("example") && name.ends_with(".json") {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}

fn documents() -> Vec<(PathBuf, Value)> {
    let read = |path: PathBuf| {
        let text = crate::gzip::read_text(&path).expect("the file is there");
        let document = serde_json::from_str(&text).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        (path, document)
    };
    files(&reference::folder()).into_iter().map(read).collect()
}

/// Runs a check on every case of a category and fails with a list of all errors. A category without a case fails, too.
fn every_case(category: &str, check: impl Fn(&Value, &mut Differences)) {
    let documents = documents();
    let mut cases = 0;
    let mut wrong = Differences::default();
    for (path, document) in &documents {
        let list = document[category].as_array().unwrap_or_else(|| panic!("{}: no {category}", path.display()));
        for case in list {
            wrong.case = case["id"].as_str().expect("a case has an id").to_string();
            check(case, &mut wrong);
            cases += 1;
        }
    }
    loud!("LAV {category}: {cases} cases, largest difference {:.1e}", wrong.largest);
    assert!(cases > 0, "no case of {category}");
    assert!(wrong.list.is_empty(), "{:#?}", wrong.list);
}

/// The errors of the cases that have been checked.
#[derive(Default)]
struct Differences {
    case: String,
    list: Vec<String>,
    largest: f64,
}

impl Differences {
    fn number(&mut self, what: &str, got: f64, wanted: &Value) {
        let wanted = wanted.as_f64().unwrap_or_else(|| panic!("{}: {what} is no number: {wanted}", self.case));
        let difference = (got - wanted).abs();
        self.largest = self.largest.max(difference);
        if difference.is_nan() || difference > TOLERANCE {
            self.list.push(format!("{}: {what} is {got} instead of {wanted}", self.case));
        }
    }

    fn same<T: PartialEq + std::fmt::Debug>(&mut self, what: &str, got: T, wanted: T) {
        if got != wanted {
            self.list.push(format!("{}: {what} is {got:?} instead of {wanted:?}", self.case));
        }
    }
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

fn version(value: &Value) -> Version {
    match value.to_string().trim_matches('"').trim_start_matches('v') {
        "1" => Version::V1,
        "2" => Version::V2,
        "2_fast" => Version::V2Fast,
        other => panic!("unknown version {other}"),
    }
}

fn points(value: &Value) -> Vec<EgoPoint> {
    let point = |pair: &Value| EgoPoint::new(number(&pair[0]), number(&pair[1]));
    value.as_array().expect("points are a list").iter().map(point).collect()
}

fn command(inputs: &Value) -> Command {
    Command::ALL[inputs["command_index"].as_u64().expect("a command is an index") as usize]
}

fn forecast(other: &Value) -> Forecast {
    let mut forecast = Forecast { modes: [[EgoPoint::default(); 20]; 6], scores: [0.0; 6] };
    let modes = other["trajectories_right_back_m"].as_array().expect("forecasts have modes");
    for (mode, given) in forecast.modes.iter_mut().zip(modes) {
        for (point, given) in mode.iter_mut().zip(points(given)) {
            *point = given;
        }
    }
    for (score, given) in forecast.scores.iter_mut().zip(other["mode_scores"].as_array().expect("modes have scores")) {
        *score = number(given);
    }
    forecast
}

fn pedals(wrong: &mut Differences, what: &str, got: Pedals, wanted: &Value) {
    wrong.number(&format!("{what} steer"), got.steer, &wanted["steer"]);
    wrong.number(&format!("{what} throttle"), got.throttle, &wanted["throttle"]);
    wrong.number(&format!("{what} brake"), got.brake, &wanted["brake"]);
}

#[needs(reference = "lav example .json")]
#[test]
fn the_controller_agrees_with_the_reference() {
    every_case("controller", |case, wrong| {
        let inputs = &case["inputs"];
        let plan = points(&inputs["ego_plan_right_back_m"]);
        let others = inputs["others"].as_array().expect("others are a list");
        let forecasts: Vec<Forecast> = others.iter().map(forecast).collect();
        let verdict = Controller::new(version(&case["version"])).run(&Situation {
            speed: number(&inputs["speed_mps"]),
            command: command(inputs),
            brake_score: number(&inputs["brake_probability"]),
            plan: &plan,
            forecasts: &forecasts,
        });
        let expected = &case["expected"];
        wrong.number("desired speed", verdict.desired_speed, &expected["desired_speed_mps"]);
        pedals(wrong, "PID's", verdict.pid, &expected["pid"]);
        pedals(wrong, "final", verdict.pedals, &expected["vehicle_control"]);
        wrong.same("collision", Some(verdict.collides), expected["plan_collide"].as_bool());
        let overruled = match verdict.overruled {
            None => "none",
            Some(Overruled::Classifier) => "brake_classifier",
            Some(Overruled::Collision) => "plan_collide",
        };
        wrong.same("override", Some(overruled), expected["override"].as_str());
    });
}

/// The plan that the words of a sequence describe: a number of points at a speed, straight on or along an arc of a radius to one side, such
/// as `arc left, radius 20 m, 10 points, 5 m/s`. A curvature in 1/m may stand for the radius.
fn described_plan(words: &str) -> Vec<EgoPoint> {
    // A unit may follow its number without a blank.
    let split = |part: &str| part.find(|c: char| c.is_ascii_alphabetic()).unwrap_or(part.len());
    let words_and_numbers: Vec<&str> = words
        .split([' ', ',', '(', ')', ';', '=', ':'])
        .flat_map(|part| <[&str; 2]>::from(part.split_at(split(part))))
        .filter(|part| !part.is_empty())
        .collect();
    let pairs = words_and_numbers.windows(2).filter_map(|pair| Some((pair[0].parse::<f64>().ok()?, pair[1])));
    let numbers: Vec<(f64, &str)> = pairs.collect();
    let with_unit = |units: &[&str]| numbers.iter().find(|(_, unit)| units.contains(unit)).map(|(number, _)| *number);
    let wanted = |units: &[&str]| with_unit(units).unwrap_or_else(|| panic!("no number in {units:?} in `{words}`"));
    let (count, speed) = (wanted(&["points"]) as usize, wanted(&["m/s"]));
    let curvature = match words.starts_with("straight") {
        true => 0.0,
        false => with_unit(&["1/", "rad/m"]).unwrap_or_else(|| 1.0 / wanted(&["m", "metres", "meters"])).abs(),
    };
    assert!(curvature == 0.0 || words.contains("left") != words.contains("right"), "an arc needs one side: `{words}`");
    let right = if words.contains("left") { -1.0 } else { 1.0 };
    let point = |k: usize| {
        let along = 0.25 * speed * (k + 1) as f64;
        if curvature == 0.0 {
            return EgoPoint::new(0.0, -along);
        }
        let turn = along * curvature;
        EgoPoint::new(right * (1.0 - libm::cos(turn)) / curvature, -libm::sin(turn) / curvature)
    };
    (0..count).map(point).collect()
}

#[test]
fn plans_in_words_are_straight_or_arcs() {
    let straight = described_plan("straight, 10 points, 5.5 m/s (point k at 0.25*5.5*(k+1) m)");
    assert_eq!((straight.len(), straight[9].back), (10, -13.75));
    let arc = described_plan("arc left, radius 20 m, 10 points, 4 m/s");
    // The places are at equal distances on the circle around (-20, 0).
    for (k, point) in arc.iter().enumerate() {
        let radius = ((point.right + 20.0).powi(2) + point.back.powi(2)).sqrt();
        let angle = libm::atan2(-point.back, point.right + 20.0);
        assert!((radius - 20.0).abs() < 1e-12 && (angle - (k + 1) as f64 / 20.0).abs() < 1e-12, "{point:?}");
    }
    assert_eq!(described_plan("arc to the left of 0.05 1/m, 10 points, 4 m/s"), arc);
    assert_eq!(described_plan("left arc R=20m, 10 points, 4m/s"), arc);
    assert!((described_plan("arc, right, radius 20 m, 3 points, 4 m/s")[0].right + arc[0].right).abs() < 1e-12);
}

#[needs(reference = "lav example .json")]
#[test]
fn sequences_agree_with_the_reference() {
    every_case("sequences", |case, wrong| {
        let inputs = &case["inputs"];
        let plan = match &inputs["ego_plan_right_back_m"] {
            Value::Null => described_plan(inputs["plan"].as_str().expect("a plan is described")),
            given => points(given),
        };
        let given = &inputs["ticks_speed_bra"];
        let ticks: Vec<(f64, f64)> = match given.as_array() {
            Some(list) => list.iter().map(|pair| (number(&pair[0]), number(&pair[1]))).collect(),
            None => {
                let (value, repeat) = (&given["value"], given["repeat"].as_u64().expect("a value is repeated"));
                vec![(number(&value[0]), number(&value[1])); repeat as usize]
            }
        };
        let mut controller = Controller::new(version(&case["version"]));
        let run = |(speed, brake_score)| {
            let command = command(inputs);
            controller.run(&Situation { speed, command, brake_score, plan: &plan, forecasts: &[] })
        };
        let verdicts: Vec<Verdict> = ticks.into_iter().map(run).collect();
        for expected in case["expected"].as_array().expect("a sequence has ticks") {
            let tick = expected["tick"].as_u64().expect("a tick is a number");
            let verdict = &verdicts[tick as usize];
            wrong.number("desired speed", verdict.desired_speed, &expected["desired_speed_mps"]);
            wrong.number(&format!("PID's throttle at {tick}"), verdict.pid.throttle, &expected["pid_throttle"]);
            wrong.number(&format!("PID's brake at {tick}"), verdict.pid.brake, &expected["pid_brake"]);
            pedals(wrong, &format!("at {tick}"), verdict.pedals, expected);
            let counted = (u64::from(verdict.ticks_at_rest), u64::from(verdict.creeping));
            let count = |name: &str| expected[name].as_u64().expect("a count is a number");
            // v1 does not count; its recorded value is 0.
            wrong.same("counters", counted, (count("stop_counter"), count("force_move")));
        }
    });
}

#[needs(reference = "lav example .json")]
#[test]
fn detections_agree_with_the_reference() {
    every_case("detection", |case, wrong| {
        let kind = |value: &Value| match value["cls"].as_str() {
            Some("pedestrian") => BlobKind::Pedestrian,
            Some("vehicle") => BlobKind::Vehicle,
            other => panic!("unknown class {other:?}"),
        };
        let blob = |given: &Value| Blob {
            kind: kind(given),
            column: number(&given["x_px"]),
            row: number(&given["y_px"]),
            score: number(&given["score"]),
            half_length: number(&given["w_px"]),
            half_width: number(&given["h_px"]),
            yaw: number(&given["yaw"]),
        };
        let blobs: Vec<Blob> = case["inputs"]["blobs"].as_array().expect("blobs are a list").iter().map(blob).collect();
        let mut detector = Detector::new(version(&case["version"]));
        let mut found = detector.detect(&blobs).to_vec();
        let mut expected = case["expected"].as_array().expect("detections are a list").clone();
        wrong.same("number of detections", found.len(), expected.len());
        // The order among equal values is unspecified.
        found.sort_by(|a, b| {
            (a.blob.kind, a.blob.column, a.blob.row).partial_cmp(&(b.blob.kind, b.blob.column, b.blob.row)).unwrap()
        });
        let key = |value: &Value| (kind(value), number(&value["x_px"]), number(&value["y_px"]));
        expected.sort_by(|a, b| key(a).partial_cmp(&key(b)).unwrap());
        for (found, expected) in found.iter().zip(&expected) {
            wrong.same("class", found.blob.kind, kind(expected));
            wrong.number("column", found.blob.column, &expected["x_px"]);
            wrong.number("row", found.blob.row, &expected["y_px"]);
            wrong.number("right", found.place.right, &expected["right_m"]);
            wrong.number("back", found.place.back, &expected["back_m"]);
            wrong.number("half length", found.blob.half_length, &expected["w_px"]);
            wrong.number("half width", found.blob.half_width, &expected["h_px"]);
            wrong.number("yaw", found.blob.yaw, &expected["yaw"]);
        }
    });
}

#[needs(reference = "lav example .json")]
#[test]
fn forecasts_come_into_the_ego_frame_as_in_the_reference() {
    every_case("forecast_transform", |case, wrong| {
        let inputs = &case["inputs"];
        let object = points(&Value::Array(vec![inputs["object_right_back_m"].clone()]))[0];
        let yaw = number(&inputs["object_yaw_rad"]);
        let expected = case["expected_ego_right_back_m"].as_array().expect("points are a list");
        let local = points(&inputs["local_right_back_m"]);
        wrong.same("number of points", local.len(), expected.len());
        for (local, expected) in local.iter().zip(expected) {
            let seen = local.out_of_object(object, yaw);
            wrong.number("right", seen.right, &expected[0]);
            wrong.number("back", seen.back, &expected[1]);
        }
    });
}

#[needs(reference = "lav example .json")]
#[test]
fn brake_labels_agree_with_the_reference() {
    every_case("expert_brake_label", |case, wrong| {
        let inputs = &case["inputs"];
        let known = ["forward_m", "right_m", "lane_match", "on_sidewalk", "speed_limit_kmh"];
        for key in inputs.as_object().expect("inputs are named").keys() {
            assert!(known.contains(&key.as_str()), "{}: unknown input {key}", wrong.case);
        }
        let limit = inputs["speed_limit_kmh"].as_f64().unwrap_or(30.0);
        let rules = BrakeRules { ego_half_length: VehicleBlueprint::mkz_2017().half_length, speed_limit: limit / 3.6 };
        let place = EgoPoint::new(number(&inputs["right_m"]), -number(&inputs["forward_m"]));
        let walker = WalkerView {
            place,
            half: PedestrianBody::adult().radius,
            on_sidewalk: inputs["on_sidewalk"].as_bool().unwrap_or(false),
            in_lane: inputs["lane_match"].as_bool().unwrap_or(true),
            from_lane_point: place.distance(EgoPoint::default()),
        };
        let expected = &case["expected"];
        wrong.same("map rule", Some(rules.on_map(&walker)), expected["map_rule"].as_bool());
        wrong.same("behaviour rule", Some(rules.by_expert(&walker)), expected["behaviour_rule"].as_bool());
        wrong.same("label", Some(rules.brake(&walker)), expected["brake_label"].as_bool());
    });
}

//! InterFuser's planner compared with runs of the published code: all examples of all files that are present.

use std::fs;
use std::path::{Path, PathBuf};

use crate::reference;
use needs::needs;
use ported::interfuser::{
    Cell, Controller, EgoVector, Forecast, HORIZONS, Inputs, ObjectClass, ObjectMap, Settings, Sighting, Tracker,
    find_detections,
};
use road::geometry::Point;
use serde_json::Value;

/// The files state this value too.
const TOLERANCE: f64 = 1e-6;

/// The disagreements, by example.
#[derive(Default)]
struct Disagreements {
    id: String,
    lines: Vec<String>,
    compared: usize,
}

impl Disagreements {
    fn number(&mut self, what: &str, expected: &Value, ours: f64) {
        self.compared += 1;
        let expected = number(expected, what);
        if ours.is_nan() || (expected - ours).abs() > TOLERANCE {
            self.lines.push(format!("{} {what}: {ours} instead of {expected}", self.id));
        }
    }

    fn equal<T: PartialEq + std::fmt::Debug>(&mut self, what: &str, expected: T, ours: T) {
        self.compared += 1;
        if expected != ours {
            self.lines.push(format!("{} {what}: {ours:?} instead of {expected:?}", self.id));
        }
    }
}

fn number(value: &Value, what: &str) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{what} is a number, not {value}"))
}

fn list(value: &Value) -> &[Value] {
    value.as_array().map_or(&[], Vec::as_slice)
}

fn cell(value: &Value) -> Cell {
    let get = |key: &str| number(&value[key], key);
    Cell {
        row: get("row") as usize,
        col: get("col") as usize,
        existence: get("prob"),
        dx: get("dx_m"),
        dy: get("dy_m"),
        theta: get("theta_over_pi"),
        half_length: get("half_len_m"),
        half_width: get("half_wid_m"),
        speed: get("speed_mps"),
    }
}

fn detections(cells: &Value) -> Vec<Cell> {
    let mut map = ObjectMap::default();
    for value in list(cells) {
        map.set(&cell(value));
    }
    let mut found = Vec::new();
    find_detections(&map, &mut found);
    found
}

fn forecast(detections: &[Cell]) -> Forecast {
    let mut forecast = Forecast::new();
    forecast.draw(detections);
    forecast
}

fn places(cells: &[Cell]) -> Vec<[usize; 2]> {
    cells.iter().map(|cell| [cell.row, cell.col]).collect()
}

fn place_list(value: &Value) -> Vec<[usize; 2]> {
    let place = |pair: &Value| [0, 1].map(|index| number(&pair[index], "a place") as usize);
    list(value).iter().map(place).collect()
}

fn waypoints(value: &Value) -> [EgoVector; 10] {
    let points = list(value);
    assert_eq!(points.len(), 10, "the planner takes ten waypoints");
    std::array::from_fn(|index| {
        let at = |axis: usize| number(&points[index][axis], "a waypoint");
        EgoVector::new(at(0), at(1))
    })
}

fn settings(overrides: &Value) -> Settings {
    let mut settings = Settings::default();
    for (key, value) in overrides.as_object().into_iter().flatten() {
        let value_of = || number(value, key);
        match key.as_str() {
            "max_speed" => settings.max_speed = value_of(),
            "max_throttle" => settings.max_throttle = value_of(),
            "brake_ratio" => settings.brake_ratio = value_of(),
            "clip_delta" => settings.speed_step = value_of(),
            "detect_threshold" => settings.overlap = value_of(),
            "collision_buffer" => settings.margin = [0, 1].map(|index| number(&value[index], key)),
            "speed_KP" => settings.speed_gains[0] = value_of(),
            "speed_KI" => settings.speed_gains[1] = value_of(),
            "speed_KD" => settings.speed_gains[2] = value_of(),
            "turn_KP" => settings.turn_gains[0] = value_of(),
            "turn_KI" => settings.turn_gains[1] = value_of(),
            "turn_KD" => settings.turn_gains[2] = value_of(),
            other => panic!("unknown override {other}"),
        }
    }
    settings
}

fn inputs(waypoints: [EgoVector; 10], [speed, p_not_junction, p_red, p_no_stop_sign]: [f64; 4]) -> Inputs {
    Inputs { speed, waypoints, p_not_junction, p_red, p_no_stop_sign }
}

fn one_decision(example: &Value, out: &mut Disagreements) {
    let (given, expected) = (&example["inputs"], &example["expected"]);
    let found = detections(&given["cells"]);
    let columns = ["speed_mps", "p_not_junction", "p_red_or_yellow", "p_no_stop_sign"];
    let inputs =
        inputs(waypoints(&given["waypoints_right_back_m"]), columns.map(|column| number(&given[column], column)));
    let decision = Controller::new(&settings(&given["config_overrides"])).step(&inputs, &forecast(&found));
    out.equal("peaks", place_list(&expected["peaks"]), places(&found));
    for (name, class) in
        [("car", ObjectClass::Car), ("bike", ObjectClass::Bike), ("pedestrian", ObjectClass::Pedestrian)]
    {
        let ours: Vec<Cell> = found.iter().filter(|cell| ObjectClass::of(cell) == class).copied().collect();
        out.equal(name, place_list(&expected["peak_class"][name]), places(&ours));
    }
    out.number("path points", &expected["num_downsampled_waypoints"], decision.path_points as f64);
    for (time, ours) in HORIZONS.iter().zip(decision.safe_distances) {
        out.number(&format!("distance at {time} s"), &expected["max_safe_distance_m"][format!("t{time}")], ours);
    }
    for (name, ours) in ["d0_minus_2", "d05_minus_2", "d1_minus_2"].into_iter().zip(decision.room) {
        out.number(name, &expected[name], ours);
    }
    out.number("safe distance", &expected["safe_dis_returned_m"], decision.safe_distance);
    out.number("desired speed", &expected["desired_speed_mps"], decision.desired_speed);
    out.number("steer", &expected["controller_steer"], decision.steer);
    out.number("throttle", &expected["controller_throttle"], decision.throttle);
    out.equal("brake", expected["controller_brake"].as_bool(), Some(decision.brake));
    let (control, published) = (decision.control(), &expected["vehicle_control"]);
    out.number("steer of the car", &published["steer"], -control.steer);
    out.number("throttle of the car", &published["throttle"], control.throttle);
    out.number("brake of the car", &published["brake"], control.brake);
}

fn sequence(example: &Value, out: &mut Disagreements) {
    let given = &example["inputs"];
    let columns: Vec<&str> = list(&given["tick_columns"]).iter().filter_map(Value::as_str).collect();
    let place = |name: &str| columns.iter().position(|column| *column == name).expect("a tick has this column");
    let order = ["speed_mps", "p_not_junction", "p_red_or_yellow", "p_no_stop_sign"].map(place);
    let row = |row: &Value| order.map(|column| number(&row[column], "a tick's value"));
    let ticks: Vec<[f64; 4]> = match given["ticks"].as_array() {
        Some(rows) => rows.iter().map(row).collect(),
        None => vec![row(&given["ticks"]["value"]); number(&given["ticks"]["repeat"], "repeat") as usize],
    };
    let mut controller = Controller::new(&settings(&given["config_overrides"]));
    let forecast = forecast(&detections(&given["cells"]));
    let waypoints = waypoints(&given["waypoints_right_back_m"]);
    let mut expected = list(&example["expected"]).iter().peekable();
    for (tick, values) in ticks.into_iter().enumerate() {
        let decision = controller.step(&inputs(waypoints, values), &forecast);
        let Some(now) = expected.next_if(|row| row["tick"].as_u64() == Some(tick as u64)) else { continue };
        let counters = controller.counters();
        let at = |what: &str| format!("{what} at tick {tick}");
        out.number(&at("throttle"), &now["controller_throttle"], decision.throttle);
        out.number(&at("steer"), &now["steer"], decision.steer);
        out.equal(&at("brake"), now["controller_brake"].as_bool(), Some(decision.brake));
        out.equal(&at("stop sign"), now["in_stop_sign_effect"].as_bool(), Some(counters.in_stop_sign_effect));
        for (name, ours) in [
            ("stop_steps", f64::from(counters.stop_steps)),
            ("forced_forward_steps", f64::from(counters.forced_forward_steps)),
            ("red_light_steps", f64::from(counters.red_light_steps)),
            ("block_red_light", f64::from(counters.block_red_light)),
            ("block_stop_sign_distance", counters.block_stop_sign_distance),
            ("stop_sign_trigger_times", f64::from(counters.stop_sign_trigger_times)),
        ] {
            out.number(&at(name), &now[name], ours);
        }
    }
    out.equal("ticks left over", 0, expected.count());
}

fn tracking(example: &Value, out: &mut Disagreements) {
    let given = &example["inputs"];
    let mut tracker = Tracker::new();
    for step in list(&example["sequence"]) {
        let update = step["update"].as_i64().expect("an update has a number");
        let mut found = detections(&step["input_cells"]);
        let [north, east] = [0, 1].map(|axis| number(&step["ego_north_east_m"][axis], "a position"));
        let compass = step.get("compass_rad").unwrap_or(&given["compass_rad"]);
        tracker.update(&mut found, Point::new(east, north), number(compass, "the compass"), update);
        let expected = list(&step["output"]);
        out.equal(
            &format!("detections of update {update}"),
            expected.iter().map(|each| [&each["row"], &each["col"]].map(|at| number(at, "a place") as usize)).collect(),
            places(&found),
        );
        for (each, ours) in expected.iter().zip(&found) {
            out.number(&format!("heading in update {update}"), &each["theta_over_pi"], ours.theta);
            out.number(&format!("speed in update {update}"), &each["speed_mps"], ours.speed);
        }
    }
}

fn label(example: &Value, out: &mut Disagreements) {
    let sighting = |object: &Value| {
        let get = |key: &str| number(&object[key], key);
        Sighting {
            right: get("right_m"),
            forward: get("forward_m"),
            theta: get("theta_over_pi"),
            half: [get("half_len_m"), get("half_wid_m")],
            speed: get("speed_mps"),
        }
    };
    let expected = &example["expected"];
    let mut map = ObjectMap::default();
    let pixels = map.perceive(list(&example["inputs"]["objects"]).iter().map(sighting));
    out.number("pixels", &expected["heatmap_pixels"], f64::from(pixels));
    let ours: Vec<Cell> = map.cells().collect();
    let theirs: Vec<Cell> = list(&expected["cells"]).iter().map(cell).collect();
    out.equal("cells", places(&theirs), places(&ours));
    for (ours, theirs) in ours.iter().zip(list(&expected["cells"])) {
        for (key, value) in [
            ("prob", ours.existence),
            ("dx_m", ours.dx),
            ("dy_m", ours.dy),
            ("theta_over_pi", ours.theta),
            ("half_len_m", ours.half_length),
            ("half_wid_m", ours.half_width),
            ("speed_mps", ours.speed),
        ] {
            out.number(&format!("{key} of cell {} {}", ours.row, ours.col), &theirs[key], value);
        }
    }
    let mut found = Vec::new();
    find_detections(&map, &mut found);
    out.equal("peaks", place_list(&expected["peaks"]), places(&found));
}

/// The example files in a folder and in its subfolders.
fn example_files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        let name = entry.file_name().to_string_lossy().to_lowercase();
        let of_ours = ["interfuser", "example", ".json"].iter().all(|part| name.contains(part));
        if path.is_dir() {
            example_files(&path, found);
        } else if of_ours {
            found.push(path.with_file_name(entry.file_name().to_string_lossy().trim_end_matches(".gz")));
        }
    }
}

#[needs(reference = "reference/ interfuser example .json")]
#[test]
fn the_published_planner_is_repeated_reference() {
    let root = reference::folder().join("reference");
    let mut files = Vec::new();
    example_files(&root, &mut files);
    files.sort();
    let mut all = Disagreements::default();
    type Check = fn(&Value, &mut Disagreements);
    let checks: [(&str, Check); 4] = [
        ("controller", one_decision),
        ("controller_sequences", sequence),
        ("tracker", tracking),
        ("perception_labels", label),
    ];
    for file in files {
        let text = crate::gzip::read_text(&file).expect("a file that was found is readable");
        let examples: Value = serde_json::from_str(&text).expect("examples are JSON");
        for (category, cases) in examples.as_object().expect("examples come in categories") {
            if category == "meta" {
                continue;
            }
            let check = checks.iter().find(|(name, _)| name == category);
            let (_, check) = check.unwrap_or_else(|| panic!("{}: unknown category {category}", file.display()));
            let before = (all.compared, all.lines.len());
            for case in list(cases) {
                all.id = case["id"].as_str().unwrap_or(category).to_owned();
                check(case, &mut all);
            }
            eprintln!(
                "{}, {category}: {} examples, {} values, {} differ",
                file.display(),
                list(cases).len(),
                all.compared - before.0,
                all.lines.len() - before.1
            );
        }
    }
    assert!(all.compared > 0, "the files have no examples");
    assert!(all.lines.is_empty(), "{:#?}", all.lines);
}

/// Twelve pairs of a speed and a heading of the ego; at 1.2 m/s displacements lie exactly at a limit of the tracker.
#[test]
fn a_crossing_pedestrian_is_tracked_as_by_the_published_code() {
    let recorded: Value = serde_json::from_str(include_str!("../reference/interfuser/tracker.json")).unwrap();
    let mut compared = 0;
    for case in list(&recorded["cases"]) {
        let mut tracker = Tracker::new();
        let compass = number(&case["compass_rad"], "the compass");
        for (update, row) in list(&case["updates"]).iter().enumerate() {
            let at = |column: usize| number(&row[column], "a column");
            // The published code divides by the units of the network and multiplies again.
            let (dx, dy) = (at(3) / 3.5 * 3.5, at(4) / 3.5 * 3.5);
            let (row, col) = (at(0) as usize, at(1) as usize);
            let (half_length, half_width) = (at(6), at(7));
            let (existence, theta, speed) = (at(2), at(5), at(8));
            let mut found = [Cell { row, col, existence, dx, dy, theta, half_length, half_width, speed }];
            tracker.update(&mut found, Point::origin(), compass, update as i64);
            let (heading, speed) = (at(9), at(10));
            let near = (found[0].theta - heading).abs() < 1e-9 && (found[0].speed - speed).abs() < 1e-9;
            assert!(near, "compass {compass}, update {update}: {:?} instead of {heading}, {speed}", found[0]);
            compared += 1;
        }
    }
    assert!(compared > 500, "{compared}");
}

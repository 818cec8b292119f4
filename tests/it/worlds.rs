//! Other worlds as a user meets them: a check of a bridge, a report with two worlds, and its failures met again in another one.

use std::path::Path;

use crate::program::falsify;

fn has_python() -> bool {
    let found = std::process::Command::new("python3").arg("--version").output();
    let found = found.is_ok_and(|output| output.status.success());
    if !found {
        loud!("skipped: there is no python3");
    }
    found
}

fn top(path: &str) -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path).display().to_string()
}

/// The exit code of the program and what it prints.
fn said(arguments: &[&str], place: &Path) -> (Option<i32>, String) {
    let output = falsify(arguments, place);
    let text = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    (output.status.code(), text)
}

#[test]
fn a_check_of_a_bridge_names_what_is_wrong() {
    if !has_python() {
        return;
    }
    let place = tempfile::tempdir().unwrap();
    let check = |command: &str| said(&["check", "--world", command], place.path());
    let (code, text) = check(&format!("python3 {}", top("scenarios/external/my_world.py")));
    assert_eq!(code, Some(0), "{text}");
    assert!(text.contains("ok    leaves contacts to us") && text.contains("it has no drivers of its own"), "{text}");
    let (code, text) = check(&format!("python3 {} unseeded", top("tests/external/world.py")));
    assert!(
        code == Some(0) && text.contains("it has no friction of the road, no traffic lights for its drivers, no seeds"),
        "{text}"
    );
    for (fault, message) in [
        ("mirrored", "steer and yaw are positive to the left, y is north"),
        ("half_tick", "it gets 0.50 times as far; its time step is not the tick of 0.05 s"),
        ("shifted", "it has lanes up to 300 mm from those of the town"),
        ("elsewhere", "it moved a pedestrian to 20 mm from where it was told"),
        ("ends", "it ended the episode before it was over"),
        (
            "straight",
            "turns the car as it is told: with the wheel to the left it moves 38.4 m ahead and 0.0 m to the left",
        ),
        ("weak_steer", "on a circle of 26"),
        ("strong_steer", "on a circle of 13 m; with the wheelbase of our car that is one of 27 m"),
        ("no_brake", "after 80 ticks of full brake from 8.0 m/s it still drives 8.0 m/s"),
        ("weak_brake", "after 80 ticks of full brake from 8.0 m/s it still drives"),
        ("stuck_yaw", "beside its `yaw`, on average"),
        ("drifts", "after 60 ticks with its wheels straight it is 1.2 m to the left, turned by 0°"),
        ("ends_near", "contacts are judged from the poses that come back, so go on"),
        ("lax", "a `tolerance` that is not between 0 and 0.5"),
    ] {
        let (code, text) = check(&format!("python3 {} {fault}", top("tests/external/world.py")));
        assert!(code == Some(5) && text.contains(message), "{fault}: {text}");
    }
    let file = place.path().join("towns.scn");
    let scenario = std::fs::read_to_string(top("scenarios/external/my_world.scn")).unwrap();
    std::fs::write(&file, scenario.replace("../lib", "std")).unwrap();
    std::fs::copy(top("scenarios/external/my_world.py"), place.path().join("my_world.py")).unwrap();
    let compare = |fault: &str| {
        let command = format!("python3 {} {fault}", top("tests/external/world.py"));
        said(&["check", "--allow-external", "--world", &command, "towns.scn"], place.path())
    };
    let (code, text) = compare("none");
    assert!(code == Some(0) && text.contains("0.050 m apart on average and at most 0.050 m"), "{text}");
    let (code, text) = compare("shifted");
    assert!(code == Some(5) && text.contains("it has lanes up to 300 mm from those of the town"), "{text}");
    let (code, text) = check("no_such_program --here");
    assert!(code == Some(5) && text.contains("no_such_program"), "{text}");
    let (code, text) = check("metadriv");
    assert!(code == Some(5) && text.contains("the bridges of the Python package are metadrive, sumo"), "{text}");
}

#[test]
fn a_report_names_worlds_and_its_faults_are_met_again_in_another_one() {
    if !has_python() {
        return;
    }
    let place = tempfile::tempdir().unwrap();
    let scenario = std::fs::read_to_string(top("scenarios/external/my_world.scn")).unwrap();
    let scenario = scenario.replace("../lib", "std").replace("episodes: 20", "episodes: 30");
    std::fs::write(place.path().join("two.scn"), scenario).unwrap();
    std::fs::copy(top("scenarios/external/my_world.py"), place.path().join("my_world.py")).unwrap();
    let (code, text) = said(&["run", "--allow-external", "--out", "out", "two.scn"], place.path());
    assert_eq!(code, Some(0), "{text}");
    let report = place.path().join("out/two_worlds");
    let table = std::fs::read_to_string(report.join("episodes.csv")).unwrap();
    let column = table.lines().next().unwrap().split(',').position(|name| name == "world").unwrap();
    let worlds = |name: &str| table.lines().filter(|row| row.split(',').nth(column) == Some(name)).count();
    assert_eq!((worlds("here"), worlds("mine")), (30, 30), "{table}");
    let manifest = std::fs::read_to_string(report.join("manifest.toml")).unwrap();
    assert!(manifest.contains("my_world.py"), "the program is recorded");

    let world = format!("python3 {}", top("scenarios/external/my_world.py"));
    let arguments = ["recheck", "--allow-external", "out/two_worlds", "--world", &world, "--format", "json"];
    let output = falsify(&arguments, place.path());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let found: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(found["notes"].to_string().contains("the new drivers drive in `my_world` (1)"), "{found}");
    assert_eq!(found["crossings"], serde_json::json!([]), "the fixed list is left out");
    let rows = found["failures"].as_array().unwrap();
    assert!(!rows.is_empty());
    for row in rows {
        assert_eq!(row["still_faults"], row["old_faults"], "our kinematics: {row}");
        assert_eq!(row["still_collisions"], row["failures"], "{row}");
        assert_eq!(row["still_fault_share"].is_null(), row["old_faults"] == 0, "{row}");
        assert_eq!(row["walked_by"], "controller", "a recorded walk says little there");
    }
    let sampled = falsify(&[&arguments[..], &["--sample", "1"]].concat(), place.path());
    let sampled: serde_json::Value = serde_json::from_slice(&sampled.stdout).unwrap();
    let rows = sampled["failures"].as_array().unwrap();
    let sum = |column: &str| rows.iter().map(|row| row[column].as_u64().unwrap()).sum::<u64>();
    assert!(sum("old_faults") <= 1 && sum("failures") == sum("old_faults") + 1, "one near miss: {rows:?}");
    assert_eq!((sum("turned_faults"), sum("failed_encounters")), (0, 0), "our kinematics: {rows:?}");
    let crash = format!("python3 {} crash", top("tests/external/world.py"));
    let (code, text) = said(&["recheck", "--allow-external", "out/two_worlds", "--world", &crash], place.path());
    let reason = "failed as a program; first in ";
    assert!(code == Some(5) && text.contains(reason) && text.contains("with exit code 3"), "{text}");
    let (code, text) = said(&[&arguments[..], &["--only", "1a2b3c4d:0"]].concat(), place.path());
    assert!(code == Some(2) && text.contains("has no collision and no near miss 1a2b3c4d:0"), "{text}");
}

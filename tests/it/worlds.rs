//! Other worlds as a user meets them: a check of a bridge, a report with two worlds, and its failures met again in another one.

use std::path::Path;

use crate::program::falsify;
use needs::needs;

fn world_with(fault: &str) -> String {
    format!("python3 {} {fault}", top("tests/external/world.py"))
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

#[needs(python)]
#[test]
fn a_check_of_a_bridge_names_what_is_wrong() {
    let place = tempfile::tempdir().unwrap();
    let check = |command: &str| said(&["check", "--world", command], place.path());
    let (code, text) = check(&format!("python3 {}", top("scenarios/external/my_world.py")));
    assert_eq!(code, Some(0), "{text}");
    assert!(text.contains("ok    leaves collisions to us") && text.contains("it has no drivers of its own"), "{text}");
    assert!(text.contains("the lanes of the town are not compared: the bridge states no lanes"), "{text}");
    let (code, text) = check(&format!("python3 {} unseeded", top("tests/external/world.py")));
    assert!(
        code == Some(0) && text.contains("it has no friction of the road, no traffic lights for its drivers, no seeds"),
        "{text}"
    );
    let (code, text) = check(&format!("python3 {} declared", top("tests/external/world.py")));
    assert!(code == Some(0) && text.contains("it follows its pedals up to 0.3 s late"), "{text}");
    for (fault, message) in [
        ("mirrored", "in episode 0 it turned the car by -3° in about 2 s, and its control by 1°, positive to the left"),
        ("no_right", "carry out `wheel_angle`, in rad, or `steer`, in the tick that they come with"),
        ("mirrored_fast", "speeds up, steers and brakes as it is told: it turned the car by -"),
        ("half_tick", "that is not in m/s, or a step not a tick"),
        ("kmh", "from where its `speed` and `yaw` lead in a tick"),
        ("off", "from where its `speed` and `yaw` lead in a tick"),
        ("bad_driver", "runs 4 episodes of its driver `blind` to their end: in episode 0 it ended before it answered"),
        ("late_start", "2000 ms, its `start_timeout`; `--start-timeout` here gives it more time"),
        ("shifted", "it has lanes up to 300 mm from those of the town"),
        ("elsewhere", "it moved a pedestrian to 20 mm from where it was told"),
        ("ends", "it ended the episode before it was over"),
        ("straight", "it turned the car by 0° in about 2 s, and its control by 4°"),
        ("weak_steer", "it turned the car by 1° in about 2 s, and its control by 5°"),
        ("strong_steer", "it turned the car by 14° in about 2 s, and its control by 9°"),
        ("no_brake", "it slowed the car by 0.0 m/s while its brake was on, and its brake by "),
        ("weak_brake", "carry out `acceleration` or `brake` in the tick that it comes with, or state `pedal_delay`"),
        ("tenth", "while its brake was on"),
        ("mild_brake", "while its brake was on"),
        (
            "late_control",
            "runs 4 episodes of a driver of ours to their end: in episode 0 it slowed the car by 0.0 m/s while its brake was on, and its brake by 0.3 m/s",
        ),
        ("late", "it puts pedestrians where they were to be 1 tick earlier"),
        ("later", "it puts pedestrians where they were to be 3 ticks earlier"),
        ("stuck_yaw", "it turned the car by 0° in about 2 s, and its control by 4°"),
        ("aside", "it put the car 150 mm from where"),
        ("creeps", "0.20 m to the left, our car 0.00 m ahead and 0.00 m to the left; the place of a car is the middle"),
        ("drifts", "beside its `yaw`"),
        ("ends_near", "collisions are judged from the poses that come back, so go on"),
        ("lax", "a `tolerance` that is not between 0 and 0.5"),
    ] {
        let command = format!("python3 {} {fault}", top("tests/external/world.py"));
        let limit = if fault == "late_start" { "2" } else { "60" };
        let (code, text) = said(&["check", "--world", &command, "--start-timeout", limit], place.path());
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

#[needs(python)]
#[test]
fn a_report_names_worlds_and_its_faults_are_met_again_in_another_one() {
    let place = tempfile::tempdir().unwrap();
    let scenario = std::fs::read_to_string(top("scenarios/external/my_world.scn")).unwrap();
    let scenario = scenario.replace("../lib", "std").replace("episodes: 20", "episodes: 30");
    std::fs::write(place.path().join("two.scn"), scenario).unwrap();
    std::fs::copy(top("scenarios/external/my_world.py"), place.path().join("my_world.py")).unwrap();
    let (code, text) = said(&["run", "--allow-external", "--out", "out", "two.scn"], place.path());
    assert_eq!(code, Some(0), "{text}");
    let report = place.path().join("out/two_worlds");
    for text in [text, std::fs::read_to_string(report.join("summary.md")).unwrap()] {
        assert!(text.contains("fault, here (95 %)") && text.contains("fault, mine (95 %)"), "side by side: {text}");
    }
    let table = std::fs::read_to_string(report.join("episodes.csv")).unwrap();
    let column = table.lines().next().unwrap().split(',').position(|name| name == "world").unwrap();
    let worlds = |name: &str| table.lines().filter(|row| row.split(',').nth(column) == Some(name)).count();
    assert_eq!((worlds("here"), worlds("mine")), (30, 30), "{table}");
    for table in ["results", "failures"] {
        let table = std::fs::read_to_string(report.join(format!("{table}.csv"))).unwrap();
        let column = table.lines().next().unwrap().split(',').position(|name| name == "world").unwrap();
        let has = |name: &str| table.lines().any(|row| row.split(',').nth(column) == Some(name));
        assert!(has("here") && has("mine"), "{table}");
    }
    let compare = |other: &str| said(&["compare", "out/two_worlds", "--worlds", "here", other], place.path());
    let (code, text) = compare("mine");
    assert!(code == Some(0) && text.contains("harbour (here and mine), intercept: 30 common starts"), "{text}");
    assert!(text.contains("Failures: 0 new, 0 worse, 0 fixed, 0 better, "), "our kinematics: {text}");
    let (code, text) = compare("moon");
    assert!(
        code == Some(2) && text.contains("no evaluated episodes in a simulator `moon`; it has here, mine"),
        "{text}"
    );
    let (_, listed) = said(&["failures", "out/two_worlds"], place.path());
    assert!(listed.lines().next().unwrap().contains("world") && listed.contains(" mine"), "{listed}");
    let (_, listed) = said(&["failures", "out/two_worlds", "--format", "json"], place.path());
    assert!(listed.contains(r#""world":"here""#) && listed.contains(r#""world":"mine""#), "{listed}");
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
        assert_eq!(row["world"], "my_world");
        assert_eq!(row["walked_by"], "pedestrian", "a recorded walk says little there");
    }
    let sampled = falsify(&[&arguments[..], &["--sample", "1"]].concat(), place.path());
    let sampled: serde_json::Value = serde_json::from_slice(&sampled.stdout).unwrap();
    let rows = sampled["failures"].as_array().unwrap();
    let sum = |column: &str| rows.iter().map(|row| row[column].as_u64().unwrap()).sum::<u64>();
    assert!(sum("old_faults") <= 1 && sum("failures") == sum("old_faults") + 1, "one near miss: {rows:?}");
    assert_eq!((sum("turned_faults"), sum("failed_encounters")), (0, 0), "our kinematics: {rows:?}");
    let mild = said(
        &[
            "recheck",
            "--allow-external",
            "out/two_worlds",
            "--world",
            &world_with("mild_brake"),
            "--fail-if",
            "still_faults > 99",
        ],
        place.path(),
    );
    assert!(mild.0 == Some(5) && mild.1.contains("still_faults > 99: episodes in error in idm in "), "{mild:?}");
    assert!(mild.1.contains("errors") && mild.1.contains("nothing is known of them"), "{mild:?}");
    let crash = format!("python3 {} crash", top("tests/external/world.py"));
    for gate in [&[][..], &["--fail-if", "failed_encounters > 0"], &["--fail-if", "still_faults > 99"]] {
        let arguments = [&["recheck", "--allow-external", "out/two_worlds", "--world", &crash], gate].concat();
        let (code, text) = said(&arguments, place.path());
        let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
        let reason = "failed as a program; first in ";
        assert!(code == Some(5) && text.contains(reason) && text.contains("with exit code 3"), "{gate:?}: {text}");
    }
    let rails = format!("python3 {} rails", top("tests/external/world.py"));
    let (code, text) = said(&["recheck", "--allow-external", "out/two_worlds", "--world", &rails], place.path());
    let reason =
        "`idm` cannot drive in `my_world`, whose cars only its own drivers drive; name a driver of the kind `native`";
    assert!(code == Some(2) && text.contains(reason), "{text}");
    let (code, text) = said(&[&arguments[..], &["--only", "1a2b3c4d:0"]].concat(), place.path());
    assert!(code == Some(2) && text.contains("has no collision and no near miss 1a2b3c4d:0"), "{text}");
}

#[needs(python)]
#[test]
fn a_comparison_says_which_episodes_were_in_error_and_its_gate_fails() {
    let place = tempfile::tempdir().unwrap();
    let scenario = std::fs::read_to_string(top("scenarios/external/my_world.scn")).unwrap();
    let half = world_with("ends_near");
    let scenario = scenario.replace("python3 my_world.py\", files: [\"my_world.py\"]", &format!("{half}\""));
    std::fs::write(place.path().join("two.scn"), scenario.replace("../lib", "std")).unwrap();
    let (code, text) = said(&["run", "--allow-external", "--out", "out", "two.scn"], place.path());
    assert!(code == Some(5) && text.contains("episodes are in error"), "{text}");
    let compare = ["compare", "out/two_worlds", "--worlds", "here", "mine"];
    let (code, text) = said(&compare, place.path());
    let error = "the first is ";
    assert!(code == Some(0) && text.contains("episodes in error") && text.contains(error), "{text}");
    let (code, text) = said(&[&compare[..], &["--fail-if", "fault_rate_difference > 0.9"]].concat(), place.path());
    assert!(code == Some(7) && text.contains("--fail-if: episodes in error"), "{text}");
}

/// A run of short episodes in the world of the tests.
fn run_in(fault: &str, episodes: u32) -> (Option<i32>, String) {
    let place = tempfile::tempdir().unwrap();
    let scenario = std::fs::read_to_string(top("scenarios/external/my_world.scn")).unwrap();
    let world = format!("{}\", timeout: 60 s)", world_with(fault));
    let scenario =
        scenario.replace("python3 my_world.py\", files: [\"my_world.py\"])", &world).replace("../lib", "std");
    let scenario = scenario.replace("episodes: 20", &format!("episodes: {episodes}")).replace("[here, mine]", "[mine]");
    let brief = "episode brief { ticks: 40 }\ncampaign";
    let scenario = scenario.replace("thirty_seconds", "brief").replacen("\ncampaign", &format!("\n{brief}"), 1);
    std::fs::write(place.path().join("one.scn"), scenario).unwrap();
    said(&["run", "--allow-external", "--threads", "1", "--out", "out", "one.scn"], place.path())
}

#[needs(python)]
#[test]
fn one_error_in_a_hundred_episodes_of_a_world_is_a_warning() {
    let (code, text) = run_in("rare", 130);
    let said =
        "1 of 130 episodes are in error, at most one in a hundred of those in other simulators, and count for nothing";
    assert!(code == Some(0) && text.contains("warning") && text.contains(said), "{text}");
    let (code, text) = run_in("often", 40);
    assert!(code == Some(5) && text.contains("of 40 episodes are in error and count for nothing"), "{text}");
}

#[needs(python)]
#[test]
fn a_world_that_draws_what_its_seed_does_not_decide_is_found() {
    let (code, text) = run_in("draws", 3);
    assert!(code == Some(0) && text.contains("`mine` says of itself `seeds: true`, and "), "{text}");
    for fault in ["none", "unseeded"] {
        let (code, text) = run_in(fault, 3);
        assert!(code == Some(0) && !text.contains("says of itself"), "{fault}: {text}");
    }
}

#[needs(python)]
#[test]
fn a_world_that_is_another_one_at_its_second_start_is_refused() {
    let (code, text) = run_in("another", 3);
    assert!(code == Some(5) && text.contains("greeted wrongly: otherwise than at its first start"), "{text}");
}

#[needs(python)]
#[test]
fn a_log_says_how_far_a_slow_world_is() {
    let place = tempfile::tempdir().unwrap();
    let scenario = std::fs::read_to_string(top("scenarios/external/my_world.scn")).unwrap();
    let hang = format!("{} hang\", timeout: 12 s)", top("tests/external/world.py"));
    let scenario = scenario.replace("my_world.py\", files: [\"my_world.py\"])", &hang).replace("../lib", "std");
    let scenario = scenario.replace("episodes: 20", "episodes: 1").replace("[here, mine]", "[mine]");
    std::fs::write(place.path().join("slow.scn"), scenario).unwrap();
    let (code, text) = said(&["run", "--allow-external", "--out", "out", "slow.scn"], place.path());
    assert!(
        code == Some(5)
            && text.contains("[0/1] trying intercept in harbour of mine against idm, run 0: 0 of 1 episodes (1"),
        "{text}"
    );
}

#[needs(python)]
#[test]
fn the_fixed_list_may_be_met_in_another_world() {
    let place = tempfile::tempdir().unwrap();
    let scenario = std::fs::read_to_string(top("scenarios/external/my_world.scn")).unwrap();
    let scenario = scenario.replace("../lib", "std").replace("worlds: [here, mine]", "");
    let brief = "episode brief { ticks: 60 }\ncampaign";
    let scenario = scenario.replace("thirty_seconds", "brief").replacen("\ncampaign", &format!("\n{brief}"), 1);
    std::fs::write(place.path().join("brief.scn"), scenario).unwrap();
    std::fs::copy(top("scenarios/external/my_world.py"), place.path().join("my_world.py")).unwrap();
    let (code, text) = said(&["run", "--allow-external", "--out", "out", "brief.scn"], place.path());
    assert_eq!(code, Some(0), "{text}");
    let world = format!("python3 {}", top("scenarios/external/my_world.py"));
    let arguments =
        ["recheck", "--allow-external", "out/two_worlds", "--world", &world, "--starts", "1", "--format", "json"];
    let found: serde_json::Value = serde_json::from_slice(&falsify(&arguments, place.path()).stdout).unwrap();
    let row = &found["crossings"][0];
    assert_eq!((&row["world"], &row["starts"]), (&"my_world".into(), &1.into()), "{row}");
    assert_eq!((&row["faults_new"], &row["faults_fixed"]), (&0.into(), &0.into()), "our kinematics: {row}");
}

#[needs(python)]
#[test]
fn a_recheck_stays_in_a_world_and_says_what_another_one_lacks() {
    let place = tempfile::tempdir().unwrap();
    let world = |fault: &str| format!("python3 {} {fault}", top("tests/external/world.py"));
    let scenario = format!(
        "edition 1\nimport \"std/paper.scn\"\nimport \"std/drivers.scn\"\nimport \"std/towns.scn\"\n\
         world there = bridge(command: \"{}\")\ndriver theirs = native(name: \"blind\")\nepisode wet {{ friction: 0.4 }}\n\
         spawn driving {{ bearing: -45 deg .. 45 deg distance: 15 m .. 40 m }}\n\
         campaign native {{ vehicle: model3 body: suicidal spawn: driving episode: thirty_seconds\n\
         evaluate {{ towns: [harbour] drivers: [theirs] pedestrians: [intercept] episodes: 8 worlds: [there] }} }}\n\
         campaign slippery {{ vehicle: model3 body: suicidal spawn: driving episode: wet\n\
         evaluate {{ towns: [harbour] drivers: [blind] pedestrians: [intercept] episodes: 8 }} }}\n\
         campaign traffic {{ vehicle: model3 body: suicidal spawn: driving episode: thirty_seconds\n\
         cast {{ child: pedestrian() follower: vehicle(driver: blind, behind: ego, gap: 1 s .. 2 s) }}\n\
         evaluate {{ towns: [harbour] drivers: [blind] pedestrians: [intercept] episodes: 8 }} }}\n",
        world("none")
    );
    std::fs::write(place.path().join("three.scn"), scenario).unwrap();
    let (code, text) = said(&["run", "--allow-external", "--out", "out", "three.scn"], place.path());
    assert_eq!(code, Some(0), "{text}");

    let arguments = ["recheck", "--allow-external", "out/native", "--format", "json"];
    let output = falsify(&arguments, place.path());
    let found: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let rows = found["failures"].as_array().unwrap();
    assert!(!rows.is_empty() && rows.iter().all(|row| row["world"] == "there"), "{found}");
    assert!(rows.iter().all(|row| row["still_collisions"] == row["failures"]), "{found}");
    assert!(found["notes"].to_string().contains("the fixed list is left out in another simulator"), "{found}");

    let elsewhere = |report: &str, fault: &str| {
        said(&["recheck", "--allow-external", report, "--world", &world(fault)], place.path())
    };
    for (report, fault, message) in [
        ("out/native", "stranger", "`my_world` has no driver `blind`; it has none"),
        ("out/slippery", "none", "the episode sets the `friction` of the road, and `my_world` has none"),
        ("out/traffic", "none", "the cast has further cars, and `my_world` moves the car under test alone"),
    ] {
        let (code, text) = elsewhere(report, fault);
        assert!(code == Some(2) && text.contains(message), "{report} {fault}: {text}");
    }
    let (code, text) = elsewhere("out/native", "unseeded");
    assert!(code == Some(0) && text.contains("the seed of an episode does not reach `theirs`"), "{text}");
}

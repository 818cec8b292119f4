//! What a user sees while a campaign learns and searches: events, and learning curves that grow.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::time::{Duration, Instant};

use crate::program::{command, error, falsify, report, said};

const SCENARIO: &str = r#"
edition 1
import "std/paper.scn"
import "std/rewards.scn"
import "std/drivers.scn"
import "std/towns.scn"
training quick = ppo(steps: 240, steps_per_update: 10, epochs: 1, environments: 2, hidden: [8])
campaign curves {
  vehicle: model3  body: suicidal  spawn: ahead  episode: thirty_seconds  training: quick
  train { towns: [harbour] drivers: [blind] rewards: [r1] runs: 2 }
}
"#;

fn write(folder: &Path, text: &str) {
    std::fs::write(folder.join("curves.scn"), text).unwrap();
}

/// The growing curves below a folder for reports.
fn curves(out: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    report(&out.join(".falsify/learning/curves"))
}

#[test]
fn a_growing_curve_has_the_rows_of_the_report_after_any_interruption_and_on_any_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    write(here, SCENARIO);
    let run = |out: &str, threads: &str| {
        let output = falsify(&["run", "curves.scn", "--out", out, "-j", threads], here);
        assert!(output.status.success(), "{}", error(&output));
        (curves(&here.join(out)), error(&output))
    };
    let (whole, told) = run("one", "1");
    assert!(told.contains("the learning curves grow in one/.falsify/learning/curves\n"), "{told}");
    let names: Vec<&str> = whole.keys().map(|path| path.to_str().unwrap()).collect();
    assert_eq!(names, ["r1-harbour-blind-0.csv", "r1-harbour-blind-1.csv"]);
    assert_eq!(run("two", "2").0, whole);

    // The same rows as in the report.
    let texts: Vec<String> = whole.into_values().map(|bytes| String::from_utf8(bytes).unwrap()).collect();
    let (head, _) = texts[0].split_once('\n').unwrap();
    let rows: String = texts.iter().map(|text| text.split_once('\n').unwrap().1).collect();
    assert_eq!(format!("{head}\n{rows}"), std::fs::read_to_string(here.join("one/curves/learning_curve.csv")).unwrap());
    assert_eq!(texts[0].lines().count(), 1 + 12);

    // A process that is killed leaves whole rows, which the next one continues.
    let mut child = command();
    child.args(["run", "curves.scn", "--out", "cut", "-j", "1", "--checkpoint", "0.001"]).current_dir(here);
    let mut child = child.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    let growing = here.join("cut/.falsify/learning/curves/r1-harbour-blind-0.csv");
    let since = Instant::now();
    let cut = loop {
        let text = std::fs::read_to_string(&growing).unwrap_or_default();
        if text.lines().count() >= 4 {
            break text;
        }
        assert!(since.elapsed() < Duration::from_secs(120), "no curve grows: {text}");
        std::thread::sleep(Duration::from_millis(1));
    };
    child.kill().unwrap();
    child.wait().unwrap();
    let left = std::fs::read_to_string(&growing).unwrap();
    assert!(left.starts_with(&cut) && texts[0].starts_with(&left) && left.ends_with('\n'), "{left}");
    assert_eq!(run("cut", "2").0, curves(&here.join("one")));
    // All is stored now: another run changes nothing and names no folder.
    let (again, told) = run("cut", "1");
    assert_eq!(again, curves(&here.join("one")));
    assert!(!told.contains("grow in"), "{told}");
}

#[test]
fn status_has_the_newest_update_of_a_training_under_way() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    write(here, &SCENARIO.replace("steps: 240", "steps: 100_000_000").replace("runs: 2", "runs: 1"));
    let mut child = command();
    child.args(["run", "curves.scn", "-j", "1", "--checkpoint", "0.001"]).current_dir(here);
    let mut child = child.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    let status = |more: &[&str]| said(&falsify(&[&["status"], more].concat(), here));
    let since = Instant::now();
    let (text, json) = loop {
        let text = status(&[]);
        if text.contains("mean reward") || since.elapsed() > Duration::from_secs(120) {
            break (text, status(&["--format", "json"]));
        }
        std::thread::sleep(Duration::from_millis(20));
    };
    child.kill().unwrap();
    child.wait().unwrap();
    let under_way = text.lines().find(|line| line.contains("under way: train r1 in harbour against blind, run 0"));
    assert!(under_way.is_some_and(|line| line.contains("mean reward") && line.contains("% collisions")), "{text}");
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    let newest = &json["learning"][0];
    assert_eq!(newest["training"], "r1 in harbour against blind, run 0");
    // The reward is 1 for a hit and 0 otherwise.
    assert!(newest["mean_reward"].is_f64() && newest["mean_reward"] == newest["collision_rate"], "{newest}");
    assert_eq!(newest["steps"].as_u64().unwrap(), 20 * newest["updates"].as_u64().unwrap());
    // No process works on it any more.
    assert!(!status(&[]).contains("mean reward"));
}

#[test]
fn events_of_a_training_end_with_its_last_row_and_a_curve_that_cannot_be_written_is_a_warning() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    write(here, SCENARIO);
    // A folder is in the place of a file.
    std::fs::create_dir_all(here.join("reports/.falsify/learning/curves/r1-harbour-blind-1.csv")).unwrap();
    let output = falsify(&["run", "curves.scn", "--format", "json"], here);
    assert!(output.status.success(), "{}", error(&output));
    assert_eq!(error(&output).matches("cannot be written while it grows").count(), 1, "{}", error(&output));
    let events: Vec<serde_json::Value> =
        said(&output).lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let folders: Vec<&serde_json::Value> =
        events.iter().filter(|event| event["event"] == "learning_curves").map(|event| &event["folder"]).collect();
    assert_eq!(folders, ["reports/.falsify/learning/curves"]);
    let ended: Vec<&serde_json::Value> =
        events.iter().filter(|event| event["event"] == "task_finished" && event["kind"] == "training").collect();
    assert_eq!(ended.len(), 2);
    let table = std::fs::read_to_string(here.join("reports/curves/learning_curve.csv")).unwrap();
    let head: Vec<&str> = table.lines().next().unwrap().split(',').collect();
    let column = |name: &str| head.iter().position(|column| *column == name).unwrap();
    for event in ended {
        let run = &event["place"];
        let rows: Vec<Vec<&str>> = table.lines().skip(1).map(|line| line.split(',').collect()).collect();
        let rows: Vec<&Vec<&str>> = rows.iter().filter(|row| row[column("run")].parse().ok() == run.as_u64()).collect();
        let (learning, last) = (&event["learning"], rows.last().unwrap());
        assert_eq!(learning["updates"], 12);
        let episodes: u64 = rows.iter().map(|row| row[column("episodes")].parse::<u64>().unwrap()).sum();
        assert_eq!(learning["episodes"], episodes);
        assert!(episodes > 0);
        for name in ["mean_reward", "mean_length_decisions", "collision_rate"] {
            assert_eq!(learning[name].as_f64().unwrap(), last[column(name)].parse::<f64>().unwrap(), "{name}");
        }
        // The reward is 1 for a hit and 0 otherwise.
        assert_eq!(learning["collision_rate"], learning["mean_reward"]);
        let note = event["note"].as_str().unwrap();
        assert!(note.contains("mean reward") && note.contains("% collisions"), "{note}");
    }
}

#[test]
fn rates_of_all_methods_are_units_over_time_and_stored_work_has_none() {
    let search = r#"
method chance = random()
method meet = intercept()
method home = homing()
method grid = exhaustive(levels: 2)
method elites = archive(reward: r1)
method cross = cem(tries: 20, population: 10, elite: 3)
method strategy = cma_es(tries: 20)
method tree = mcts(reward: ast, tries: 20)
method learner = ppo(reward: r1)
campaign curves {
  vehicle: model3  body: suicidal  spawn: ahead  episode: thirty_seconds  training: quick
  search { towns: [harbour] drivers: [blind] methods: [chance, meet, home, grid, elites, cross, strategy, tree, learner] budget: 3_000 runs: 1 }
}
"#;
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let (declarations, _) = SCENARIO.split_once("campaign").unwrap();
    write(here, &format!("{declarations}{search}"));
    let run = || {
        let output = falsify(&["run", "curves.scn", "--format", "json"], here);
        assert!(output.status.success(), "{}", error(&output));
        let events = said(&output);
        let events = events.lines().map(|line| serde_json::from_str::<serde_json::Value>(line).unwrap());
        events.filter(|event| event["event"] == "task_finished").collect::<Vec<_>>()
    };
    let first = run();
    assert_eq!(first.len(), 10, "nine searches, and the price of the driver");
    for event in &first {
        let number = |key: &str| event[key].as_f64().unwrap();
        assert!(number("took_s") > 0.0 && number("done") > 0.0 && number("reused") == 0.0, "{event}");
        let rate = number("done") / number("took_s");
        assert!((number("rate_per_s") - rate).abs() <= 1e-9 * rate, "{event}");
        // The event of a search that took no time once had rates of a hundred billion ticks a second.
        assert!(number("rate_per_s") < 1e8 && event.get("learning").is_none(), "{event}");
    }
    for event in &run() {
        assert!(event["rate_per_s"].is_null() && event["reused"] == event["total"], "{event}");
    }
}

#[test]
fn a_training_with_more_steps_continues_a_finished_one_bit_for_bit() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let with = |steps: u32, more: &str| {
        write(
            here,
            &SCENARIO
                .replace("steps: 240", &format!("steps: {steps}"))
                .replace("hidden: [8]", &format!("hidden: [8]{more}")),
        );
    };
    // How many decisions each training found.
    let run = |out: &str, more: &[&str]| -> Vec<u64> {
        let output =
            falsify(&[&["run", "curves.scn", "--format", "json", "--replace", "--out", out], more].concat(), here);
        assert!(output.status.success(), "{}", error(&output));
        let events = said(&output);
        let events = events.lines().map(|line| serde_json::from_str::<serde_json::Value>(line).unwrap());
        let ended = events.filter(|event| event["event"] == "task_finished");
        ended.map(|event| event["reused"].as_u64().unwrap()).collect()
    };
    let whole = |out: &str| (report(&here.join(out).join("curves")), curves(&here.join(out)));
    let timeless = |out: &str| {
        let (mut files, curves) = whole(out);
        files.remove(Path::new("manifest.toml"));
        files.remove(Path::new("report.html"));
        (files, curves)
    };
    with(120, "");
    assert_eq!(run("grown", &[]), [0, 0]);
    with(240, "");
    let listed = said(&falsify(&["run", "curves.scn", "--list", "--out", "grown"], here));
    assert!(listed.contains("unfinished, 120 of 240 decisions"), "{listed}");
    assert_eq!(run("grown", &[]), [120, 120]);
    assert_eq!(run("whole", &[]), [0, 0]);
    assert_eq!(timeless("grown"), timeless("whole"));
    // Each candidate continues its own.
    let several = |steps: u32| {
        let text =
            SCENARIO.replace("steps: 240", &format!("steps: {steps}")).replace("runs: 2", "runs: 2  candidates: 2");
        assert!(text.contains("candidates"));
        write(here, &text);
    };
    several(120);
    assert_eq!(run("candidates", &[]), [0, 0]);
    several(240);
    assert_eq!(run("candidates", &[]), [240, 240]);
    assert_eq!(run("anew", &[]), [0, 0]);
    assert_eq!(timeless("candidates"), timeless("anew"));
    // A shorter training is the one that was stored.
    with(120, "");
    assert_eq!(run("grown", &[]), [120, 120]);
    // Nothing of it is used by a fresh run, with another setting, or where a schedule depends on the number of steps.
    with(360, "");
    assert_eq!(run("grown", &["--fresh"]), [0, 0]);
    with(380, ", gamma: 0.9");
    assert_eq!(run("grown", &[]), [0, 0]);
    for (steps, found) in [(120, 0), (160, 0), (160, 160)] {
        with(steps, ", learning_rate_schedule: linear");
        assert_eq!(run("linear", &[]), [found, found]);
    }
}

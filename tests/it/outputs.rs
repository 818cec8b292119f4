//! Outputs that cannot be written are errors with their cause; inputs without an end are refused; nothing else on the disk is replaced.
#![cfg(target_os = "linux")]

use std::collections::BTreeSet;
use std::fs;
use std::os::unix::fs::FileTypeExt;
use std::path::Path;
use std::process::{Command, Output, Stdio};

use crate::program::{command, error, falsify, said};

/// A campaign with a collision that is found in a moment.
const SCENARIO: &str = r#"
edition 1
import "std/paper.scn"
import "std/drivers.scn"
import "std/towns.scn"
campaign cut {
  vehicle: model3  body: suicidal  spawn: ahead  episode: thirty_seconds
  evaluate { towns: [village] drivers: [blind] pedestrians: [random] episodes: 8 }
}
"#;

/// A folder with the campaign and its report, `out/cut`.
fn place() -> tempfile::TempDir {
    let place = tempfile::tempdir().unwrap();
    fs::write(place.path().join("cut.scn"), SCENARIO).unwrap();
    let output = falsify(&["run", "cut.scn", "--out", "out", "--threads", "1"], place.path());
    assert!(output.status.success(), "{output:?}");
    place
}

/// The name of a failure of the report.
fn failure(place: &Path) -> String {
    let names = said(&falsify(&["failures", "out/cut", "--names"], place));
    let (_, name) = names.lines().next().unwrap().rsplit_once('/').unwrap();
    name.to_owned()
}

/// Runs `falsify` with its output on a device that is always full.
fn to_full(arguments: &[&str], folder: &Path) -> Output {
    let full = fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    command().args(arguments).current_dir(folder).stdout(full).output().unwrap()
}

#[test]
fn a_full_output_is_an_error_of_every_command_that_prints() {
    let place = place();
    let name = failure(place.path());
    fs::write(place.path().join("wrong.scn"), "edition 1\nreward r { on touch => x }\n").unwrap();
    for arguments in [
        &["failures", "out/cut"][..],
        &["failures", "out/cut", "--format", "json"],
        &["failures", "out/cut", "--format", "csv"],
        &["failures", "out/cut", "--names"],
        &["compare", "out/cut", "out/cut"],
        &["compare", "out/cut", "out/cut", "--format", "json"],
        &["replay", &name, "--report", "out/cut"],
        &["replay", &name, "--report", "out/cut", "--json"],
        &["status", "--out", "out"],
        &["export", "--formats"],
        &["explain", "state"],
        &["completions", "bash"],
        &["check", "cut.scn", "--sample", "10", "--format", "json"],
    ] {
        let output = to_full(arguments, place.path());
        assert_eq!(output.status.code(), Some(6), "{arguments:?}: {output:?}");
        assert!(error(&output).contains("the output cannot be written"), "{arguments:?}: {}", error(&output));
    }
    // The mistakes of a file are the worse news.
    let output = to_full(&["check", "wrong.scn", "--format", "json"], place.path());
    assert_eq!(output.status.code(), Some(3), "{output:?}");
}

#[test]
fn a_device_is_written_to_and_a_file_is_no_folder() {
    let place = place();
    let name = failure(place.path());
    let device = |path: &str| fs::metadata(path).unwrap().file_type().is_char_device();
    let written = falsify(&["compare", "out/cut", "out/cut", "--page", "/dev/null"], place.path());
    assert!(written.status.success() && device("/dev/null"), "{written:?}");
    let full = falsify(&["compare", "out/cut", "out/cut", "--page", "/dev/full"], place.path());
    assert_eq!(full.status.code(), Some(6), "{full:?}");
    assert!(device("/dev/full") && error(&full).contains("No space left"), "{}", error(&full));
    for arguments in [
        &["export", &name, "--report", "out/cut", "--as", "xosc-1.3", "--out", "cut.scn"][..],
        &["preview", "cut.scn", "--once", "--out", "cut.scn"],
        &["compare", "out/cut", "out/cut", "--page", "cut.scn/page.html"],
    ] {
        let output = falsify(arguments, place.path());
        assert_eq!(output.status.code(), Some(6), "{arguments:?}: {output:?}");
        assert!(error(&output).contains("`cut.scn` is not a folder"), "{arguments:?}: {}", error(&output));
    }
    assert_eq!(fs::read_to_string(place.path().join("cut.scn")).unwrap(), SCENARIO);
}

#[test]
fn a_new_scenario_that_cannot_be_written_leaves_nothing() {
    let place = tempfile::tempdir().unwrap();
    let mut shell = Command::new("sh");
    shell.args(["-c", "trap '' XFSZ; ulimit -f 1; exec \"$0\" new a.scn --template own-driver"]);
    let output = shell.arg(env!("CARGO_BIN_EXE_falsify")).current_dir(place.path()).output().unwrap();
    assert_eq!(output.status.code(), Some(6), "{output:?}");
    assert!(error(&output).contains("cannot write `a.scn`"), "{}", error(&output));
    assert_eq!(fs::read_dir(place.path()).unwrap().count(), 0);
}

#[test]
fn an_input_without_an_end_is_refused() {
    let place = tempfile::tempdir().unwrap();
    for (arguments, code) in [(&["check", "-"][..], 2), (&["fmt", "--stdin"], 2), (&["replay", "-"], 2)] {
        let zeros = fs::File::open("/dev/zero").unwrap();
        let output = command().args(arguments).current_dir(place.path()).stdin(zeros).output().unwrap();
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {output:?}");
        assert!(error(&output).contains("it has more than 256 MiB"), "{arguments:?}: {}", error(&output));
    }
    let line = place.path().join("line");
    fs::write(&line, vec![0; 1 << 20]).unwrap();
    let input = fs::File::open(&line).unwrap();
    let output = command().args(["replay", "-"]).current_dir(place.path()).stdin(input).output().unwrap();
    assert_eq!(output.status.code(), Some(2), "{:?}", output.status);
    assert!(error(&output).contains("line 1 of the input") && error(&output).len() < 1000, "{}", error(&output).len());
}

#[test]
fn a_reader_that_has_enough_ends_a_list_of_repetitions() {
    let place = place();
    let name = failure(place.path());
    let names = format!("{name}\n").repeat(100_000);
    fs::write(place.path().join("names"), names).unwrap();
    let mut child = command()
        .args(["replay", "-", "--report", "out/cut"])
        .current_dir(place.path())
        .stdin(fs::File::open(place.path().join("names")).unwrap())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    assert!(child.wait().unwrap().success());
}

/// An untrained pedestrian walks the same for every reward. Its episodes are counted once; its mean rewards are two.
#[test]
fn what_does_not_depend_on_the_reward_is_counted_once() {
    let folder = tempfile::tempdir().unwrap();
    let campaign = |rewards: &str| {
        format!(
            "edition 1\nimport \"std/pedestrians.scn\"\nimport \"std/rewards.scn\"\nimport \"std/drivers.scn\"\nimport \"std/towns.scn\"\n\
             training quick = ppo(steps: 120, steps_per_update: 10, epochs: 1, environments: 2, hidden: [8])\n\
             spawn near {{ bearing: -60 deg .. 60 deg  distance: 7 m .. 40 m }}\nepisode short {{ ticks: 120  hold: 10 }}\n\
             campaign mine {{ vehicle: model3 body: plausible spawn: near episode: short training: quick\n\
             train {{ towns: [harbour] drivers: [behavior] rewards: [{rewards}] runs: 1 }}\n\
             evaluate {{ towns: [harbour] drivers: [blind] pedestrians: [trained, intercept] episodes: 40 }} }}\n"
        )
    };
    let tables = |rewards: &str, out: &str| {
        std::fs::write(folder.path().join("mine.scn"), campaign(rewards)).unwrap();
        let run = falsify(&["run", "mine.scn", "--out", out], folder.path());
        assert!(run.status.success(), "{run:?}");
        let lines = |table: &str| {
            let text = fs::read_to_string(folder.path().join(out).join(format!("mine/{table}.csv"))).unwrap();
            text.lines().map(String::from).collect::<Vec<_>>()
        };
        let of_intercept = |table: &str| lines(table).into_iter().filter(|line| line.contains("intercept"));
        // The names of runs come first.
        let run = |line: &String| line.split(',').next().unwrap().to_owned();
        let runs: BTreeSet<String> = of_intercept("episodes").map(|line| run(&line)).collect();
        let failed: BTreeSet<String> = lines("failures").iter().map(run).filter(|id| runs.contains(id)).collect();
        (of_intercept("results").count(), of_intercept("metrics").collect::<Vec<_>>(), runs.len(), failed.len())
    };
    let (results, metrics, runs, failed) = tables("fault, fault_focused", "two");
    let (alone, metrics_alone, run, failed_alone) = tables("fault", "one");
    assert_eq!(((results, runs, failed), (alone, run, failed_alone)), ((1, 2, 1), (1, 1, 1)));
    let rewards = metrics.iter().filter(|line| line.contains(",episode_reward,")).count();
    assert_eq!((rewards, metrics.len()), (2, metrics_alone.len() + 1), "{metrics:?}");
}

/// A gate over evaluations says nothing of a campaign of searches alone, and judges the others.
#[test]
fn a_gate_meets_a_campaign_without_evaluations() {
    let folder = tempfile::tempdir().unwrap();
    let text = "edition 1\nimport \"std/pedestrians.scn\"\nimport \"std/drivers.scn\"\nimport \"std/towns.scn\"\n\
        spawn near { bearing: -30 deg .. 30 deg  distance: 7 m .. 25 m }\nepisode e { ticks: 120  hold: 10 }\nmethod meet = intercept()\n\
        campaign a { vehicle: model3 body: plausible spawn: near episode: e\n\
        evaluate { towns: [harbour] drivers: [blind] pedestrians: [intercept] episodes: 10 } }\n\
        campaign b { vehicle: model3 body: plausible spawn: near episode: e\n\
        search { towns: [harbour] drivers: [blind] methods: [meet] budget: 5_000 runs: 1 } }\n";
    fs::write(folder.path().join("s.scn"), text).unwrap();
    for (gate, code) in [("collision_rate > 0.01", 7), ("fault_rate > 0.99", 0)] {
        let run = falsify(&["run", "s.scn", "--fail-if", gate, "--junit", "out.xml"], folder.path());
        assert_eq!(run.status.code(), Some(code), "{gate}: {run:?}");
    }
}

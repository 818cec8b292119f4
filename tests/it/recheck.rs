//! A new version of a driver meets the failures of an old report again, and both versions a fixed list of crossings.

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Command, Stdio};

use serde_json::Value;

use crate::program::{command, error, falsify};

const SCENARIO: &str = r#"
edition 1
import "std/drivers.scn"
import "std/pedestrians.scn"
import "std/towns.scn"
param delay: time = 0 s
param braking: acceleration = 7 m/s^2
param view: angle = 360 deg
sensors eyes { sector { width: view } }
driver mine = idm(actuation_delay: delay, sensors: eyes)
driver other = aeb()
vehicle car = model3(full_brake: braking)
spawn near { bearing: -60 deg .. 60 deg  distance: 7 m .. 40 m }
episode until_passed { hold: 10  ticks: 240  end_when: ahead < -6 m }
method meet = intercept()
method plans = cem(tries: 20)
campaign versions {
  vehicle: car  body: plausible  spawn: near  episode: until_passed
  evaluate { towns: [harbour] drivers: [mine, other] pedestrians: [intercept, random] episodes: 60 }
  search { towns: [harbour] drivers: [mine, other] methods: [meet, plans] budget: 20_000 runs: 1 episodes: 0 }
}
"#;

fn run(here: &Path) {
    run_seeded(here, "6");
}

fn run_seeded(here: &Path, seed: &str) {
    std::fs::write(here.join("versions.scn"), SCENARIO).unwrap();
    let output = falsify(&["run", "versions.scn", "--seed", seed], here);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
}

fn recheck(here: &Path, more: &[&str]) -> Value {
    let output = falsify(&[&["recheck", "reports/versions", "--format", "json"], more].concat(), here);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    serde_json::from_slice(&output.stdout).unwrap()
}

fn rows<'a>(object: &'a Value, table: &str) -> &'a Vec<Value> {
    object[table].as_array().unwrap()
}

fn sum(rows: &[Value], column: &str) -> u64 {
    rows.iter().map(|row| row[column].as_u64().unwrap_or_else(|| panic!("{column} of {row}"))).sum()
}

#[test]
fn the_same_driver_has_nothing_new_and_nothing_fixed() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    run_seeded(here, "1");
    let same = recheck(here, &["--starts", "20"]);
    for row in rows(&same, "crossings") {
        assert_eq!((&row["starts"], &row["crossings"]), (&20.into(), &120.into()));
        for column in [
            "faults_new",
            "faults_fixed",
            "fault_starts_new",
            "fault_starts_fixed",
            "starts_worse",
            "failed_encounters",
        ] {
            assert_eq!(row[column], 0, "{column} of {row}");
        }
        assert_eq!((&row["p"], &row["injury_difference"]), (&1.0.into(), &0.0.into()), "{row}");
    }
    assert!(sum(rows(&same, "crossings"), "faults_same") > 0, "the list finds faults: {same}");
    let failures = rows(&same, "failures");
    for row in failures {
        assert_eq!((&row["gone"], &row["turned_faults"], &row["not_met"]), (&0.into(), &0.into(), &0.into()), "{row}");
        assert_eq!(row["still_faults"], row["old_faults"], "{row}");
        assert_eq!(row["still_collisions"], row["failures"], "{row}");
        assert_eq!((&row["still_collisions_worse"], &row["still_collisions_better"]), (&0.into(), &0.into()), "{row}");
    }
    // Evaluations walk in both ways, and so does a search that only evaluates a controller.
    let of = |found_in: &str, walked_by: &str| -> u64 {
        let chosen = failures.iter().filter(|row| row["found_in"] == found_in && row["walked_by"] == walked_by);
        chosen.map(|row| row["failures"].as_u64().unwrap()).sum()
    };
    assert!(of("evaluation", "pedestrian") > 0 && of("evaluation", "pedestrian") == of("evaluation", "commands"));
    assert!(of("search", "pedestrian") > 0 && of("search", "pedestrian") < of("search", "commands"), "{failures:?}");
    assert!(same["notes"].to_string().contains("by their recorded commands alone"), "{}", same["notes"]);
    // From a file instead of the report, and once more: the same bytes.
    let file = recheck(here, &["versions.scn", "--starts", "20"]);
    assert_eq!((&file["crossings"], &file["failures"]), (&same["crossings"], &same["failures"]));

    let gated = |starts: &str, condition: &str| {
        let call = ["recheck", "reports/versions", "--driver", "mine", "--starts", starts];
        falsify(&[&call[..], &["--fail-if", condition]].concat(), here)
    };
    let gate = |starts: &str, condition: &str| gated(starts, condition).status.code();
    assert_eq!(gate("0", "turned_faults > 0"), Some(0));
    assert_eq!(gate("0", "failures > 0"), Some(7));
    assert_eq!(gate("10", "starts >= 2 and driver == mine"), Some(7));
    assert_eq!(gate("10", "starts >= 2 and driver == none_such"), Some(2), "it speaks of nothing");
    assert_eq!(gate("0", "fault_new > 0"), Some(2), "no such column");
    // What cannot pass is refused before the first episode.
    for (starts, reason) in [
        ("0", "met again have `still_collisions_worse`"),
        ("1", "1 start cannot show that a driver is no worse; give `--starts 10` or more"),
    ] {
        let refused = gated(starts, "injury_difference > 0");
        let said = error(&refused);
        assert_eq!(refused.status.code(), Some(2), "{said}");
        assert!(said.contains(reason) && !said.contains("met again: "), "{said}");
    }
}

#[test]
fn an_old_failure_that_is_faster_is_worse() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    run(here);
    let weaker = ["--set", "braking=3 m/s^2", "--driver", "mine", "--starts", "0"];
    let found = recheck(here, &weaker);
    let words = found["failure_changes"].to_string();
    let worse = sum(rows(&found, "failures"), "still_collisions_worse");
    assert!(worse > 0 && worse == words.matches(r#""change":"worse""#).count() as u64, "{found}");
    assert_eq!(sum(rows(&found, "failures"), "turned_faults"), 0, "no verdict shows it");
    let gate = ["recheck", "reports/versions", "--fail-if", "still_collisions_worse > 0"];
    let blocked = falsify(&[&gate[..], &weaker].concat(), here);
    assert_eq!(blocked.status.code(), Some(7), "{blocked:?}");
    let text = String::from_utf8_lossy(&blocked.stdout).into_owned();
    assert!(text.contains("worse, a collision of both that is at least 1 m/s faster"), "{text}");
}

#[test]
fn a_worse_driver_has_more_faults() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    run(here);
    for worse in ["delay=0.3 s", "braking=3 m/s^2", "view=20 deg"] {
        let found = recheck(here, &["--set", worse, "--driver", "mine", "--starts", "20"]);
        let row = &rows(&found, "crossings")[0];
        let number = |column: &str| row[column].as_u64().unwrap();
        assert!(number("faults_after") >= number("faults_before"), "{worse}: {row}");
        assert!(number("faults_new") >= number("faults_fixed"), "{worse}: {row}");
        assert!(number("starts_worse") > number("starts_better"), "{worse}: {row}");
        assert!(row["injury_difference"].as_f64().unwrap() > 0.0, "{worse}: {row}");
    }
    let pair = recheck(here, &["--driver", "mine=other", "--starts", "2"]);
    assert!(rows(&pair, "crossings").iter().all(|row| row["driver"] == "mine" && row["other_driver"] == "other"));
    let shown = falsify(&["recheck", "reports/versions", "--set", "delay=0.3 s", "--starts", "2"], here);
    let progress = error(&shown);
    for (stage, all) in [("failures met again: ", ""), ("episodes of the fixed list: ", "960 of 960 (")] {
        let line = progress.lines().find_map(|line| line.strip_prefix(stage)).unwrap_or_else(|| panic!("{progress}"));
        assert!(line.starts_with(all) && line.ends_with(" s)"), "{line}");
    }
    let quiet = ["recheck", "reports/versions", "--set", "delay=0.3 s", "--starts", "2", "--progress", "none"];
    assert!(!error(&falsify(&quiet, here)).contains("of the fixed list"));
    let text = String::from_utf8_lossy(&shown.stdout).split_whitespace().collect::<Vec<_>>().join(" ");
    for part in ["met again by the new driver", "starts with a fault", "the list says nothing about faults; --starts N"]
    {
        assert!(text.contains(part), "{part}: {text}");
    }
}

#[test]
#[cfg(unix)]
fn ctrl_c_shows_what_was_met_up_to_then() {
    let folder = tempfile::tempdir().unwrap();
    run(folder.path());
    let mut long = command();
    long.args(["recheck", "reports/versions", "--starts", "20000", "--fail-if", "faults_new > 0"]);
    long.args(["--progress", "lines"]).current_dir(folder.path()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = long.spawn().unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines();
    let met = lines.find_map(|line| line.unwrap().strip_prefix("failures met again: ").map(str::to_owned));
    let is_whole = |met: String| met.split_once(" of ").is_some_and(|(met, all)| all.starts_with(&format!("{met} ")));
    assert!(met.is_some_and(is_whole));
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let told: Vec<String> = lines.map(Result::unwrap).collect();
    assert!(told.iter().any(|line| line.contains("--fail-if: nothing is judged")), "{told:?}");
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(130), "{told:?}");
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.contains("stopped: the fixed list") && text.contains("still"), "{text}");
    assert!(!text.contains("20000 starts"), "no list that was under way: {text}");
}

#[test]
fn a_pedestrian_whom_a_slower_driver_does_not_meet_says_nothing_of_it() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    run(here);
    let slower = ["--set", "mine.limit_share=0.4", "--driver", "mine", "--starts", "0"];
    let found = recheck(here, &slower);
    let failures = rows(&found, "failures");
    let by = |who: &str| failures.iter().filter(|row| row["walked_by"] == who).cloned().collect::<Vec<_>>();
    assert!(sum(&by("commands"), "not_met") > 0 && sum(&by("commands"), "gone") > 0, "{failures:?}");
    let parts = ["still_collisions", "gone", "not_met"];
    assert_eq!(sum(failures, "failures"), parts.iter().map(|part| sum(failures, part)).sum::<u64>(), "{failures:?}");
    let words = found["failure_changes"].to_string();
    assert_eq!(words.matches("not met").count() > 0, sum(failures, "not_met") > 0, "{words}");
    let blind = SCENARIO
        .replace("driver other", "driver unseeing = cruise()\ndriver other")
        .replace("[mine, other]", "[unseeing]");
    std::fs::write(here.join("blind.scn"), blind).unwrap();
    let unseeing = recheck(here, &["blind.scn", "--driver", "mine=unseeing", "--starts", "0"]);
    assert_eq!(sum(rows(&unseeing, "failures"), "gone"), 0, "it sees nobody: {unseeing}");
    let shown =
        falsify(&[&["recheck", "reports/versions", "--fail-if", "still_faults > 1000"], &slower[..]].concat(), here);
    assert_eq!(shown.status.code(), Some(0), "{shown:?}");
    assert!(error(&shown).contains("the new driver did not meet "), "{}", error(&shown));
}

#[test]
fn drivers_that_are_not_there_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    run(here);
    let refused = |more: &[&str]| {
        let output = falsify(&[&["recheck", "reports/versions"], more].concat(), here);
        assert_eq!(output.status.code(), Some(2), "{output:?}");
        error(&output)
    };
    let text = refused(&["--driver", "mine=none_such"]);
    assert!(text.contains("have no driver `none_such`; they have `mine`, `other`"), "{text}");
    let text = refused(&["--driver", "none_such"]);
    assert!(text.contains("the runs of the report have no driver `none_such`"), "{text}");
    let renamed = SCENARIO.replace("mine", "yours").replace("other", "another");
    std::fs::write(here.join("new.scn"), renamed).unwrap();
    let text = refused(&["new.scn"]);
    assert!(text.contains("`--driver OLD=NEW`"), "{text}");
    let pair = recheck(here, &["new.scn", "--driver", "mine=yours", "--starts", "0"]);
    assert!(rows(&pair, "crossings").is_empty());
    assert_eq!(rows(&pair, "failures")[0]["other_driver"], "yours");
}

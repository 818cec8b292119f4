//! Trainings that learnt nothing: a warning in every output, and a gate that fails.

use std::path::Path;
use std::process::Output;

use crate::program::falsify;

/// The reward is never paid, so nothing can be learnt. Hits are paid for the second campaign, and the pedestrian that comes near is
/// worse than `intercept` after so short a training.
const SCENARIO: &str = r#"
edition 1
import "std/paper.scn"
import "std/drivers.scn"
import "std/towns.scn"
training short = ppo(steps: 256, steps_per_update: 128)
reward unpaid { on touch => 0 }
campaign unpaid_hits {
  vehicle: model3  body: suicidal  spawn: ahead  episode: thirty_seconds  training: short
  train { towns: [harbour] drivers: [behavior] rewards: [unpaid] runs: 1 }
  evaluate { towns: [harbour] drivers: [behavior] pedestrians: [trained, random] episodes: 10 }
}
campaign short_of_steps {
  vehicle: model3  body: suicidal  spawn: ahead  episode: thirty_seconds  training: short
  train { towns: [harbour] drivers: [behavior] rewards: [r1] runs: 2 }
  evaluate { towns: [harbour] drivers: [behavior] pedestrians: [trained, random, intercept] episodes: 120 }
}
"#;

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&[output.stdout.as_slice(), &output.stderr].concat()).into_owned()
}

fn read(folder: &Path, file: &str) -> String {
    std::fs::read_to_string(folder.join(file)).unwrap()
}

#[test]
fn a_training_that_learnt_nothing_is_a_warning_in_every_output_and_fails_a_gate() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    std::fs::write(here.join("doubtful.scn"), SCENARIO).unwrap();
    let run = falsify(&["run", "doubtful.scn"], here);
    assert_eq!(run.status.code(), Some(0), "a warning is no failure: {run:?}");
    let text = said(&run);
    assert!(text.contains("warning"), "{text}");
    assert!(text.contains("no sign of learning in 1 of 1 trainings: rewards of 0.000 an episode"), "{text}");
    assert!(text.contains("2 of 2 trainings got less reward than `intercept` beyond chance: "), "{text}");
    assert!(text.contains(" an episode, and `intercept` 0."), "{text}");
    assert!(text.contains("train for more `steps`"), "{text}");
    for (campaign, doubt) in [("unpaid_hits", "no sign of learning"), ("short_of_steps", "got less reward than ")] {
        let report = here.join("reports").join(campaign);
        let summary = read(&report, "summary.md");
        assert!(summary.contains("Some trainings are doubtful") && summary.contains(doubt), "{summary}");
        let page = read(&report, "report.html");
        assert!(page.contains(doubt) && page.contains("Do the trainings beat untrained pedestrians?"), "{campaign}");
    }
    let results = read(&here.join("reports/short_of_steps"), "results.csv");
    let column = results.lines().next().unwrap().split(',').position(|name| name == "beats_untrained").unwrap();
    let learnt: Vec<&str> = results.lines().skip(1).map(|line| line.split(',').nth(column).unwrap()).collect();
    assert_eq!(learnt, ["no", "", ""]);

    // The same from the store, for programs.
    let json = falsify(&["run", "--format", "json", "--fail-if", "beats_untrained != yes", "doubtful.scn"], here);
    assert_eq!(json.status.code(), Some(7), "{json:?}");
    let events: Vec<serde_json::Value> =
        String::from_utf8_lossy(&json.stdout).lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let warned =
        |campaign: &str| events.iter().any(|event| event["event"] == "warning" && event["campaign"] == campaign);
    assert!(warned("unpaid_hits") && warned("short_of_steps"), "{events:?}");
    assert!(said(&json).contains("beats_untrained is no"), "{}", said(&json));

    // No training hides what `intercept` finds.
    let of_trained = ["--fail-if", "collision_rate > 0.3 and pedestrian == trained"];
    let of_all = ["--fail-if", "max over pedestrians collision_rate > 0.3"];
    for (gate, code) in [(of_trained, 0), (of_all, 7)] {
        let run = falsify(&[&["run", "doubtful.scn"], &gate[..]].concat(), here);
        assert_eq!(run.status.code(), Some(code), "{gate:?}: {}", said(&run));
    }
}

#[test]
fn a_smoke_run_has_no_doubts() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    std::fs::write(here.join("doubtful.scn"), SCENARIO).unwrap();
    let run = falsify(&["run", "--smoke", "doubtful.scn"], here);
    assert_eq!(run.status.code(), Some(0), "{run:?}");
    assert!(!said(&run).contains("no sign of learning"), "{}", said(&run));
    let summary = read(&here.join("reports/unpaid_hits-smoke"), "summary.md");
    assert!(
        !summary.contains("no sign of learning") && summary.contains("Do the trainings beat untrained pedestrians?"),
        "{summary}"
    );
}

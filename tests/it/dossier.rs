//! The dossier of a run: every heading has its figures or says that it was not done, and threads change nothing.

use std::path::Path;

use serde_json::Value;

use crate::program::falsify;

const SCENARIO: &str = r#"edition 1
import "std/pedestrians.scn"
import "std/drivers.scn"
import "std/towns.scn"
import "std/requirements.scn"
spawn near { bearing: -60 deg .. 60 deg  distance: 7 m .. 30 m }
episode short { ticks: 240  hold: 10  end_when: ahead < -6 m }
method meet = intercept()
sensors slow { latency: 100 ms  sector { width: 3 rad  range: 0.05 km } }
driver near = idm(margin: 20 cm, time_headway: 1.5 s, crosswalks: yield, sensors: slow)
campaign c {
  vehicle: model3  body: pursuer  spawn: near  episode: short
  REQUIRED
  evaluate { towns: [village]  drivers: [behavior, near]  pedestrians: [hunter]  episodes: 60 }
  search { towns: [harbour]  drivers: [behavior]  methods: [meet]  budget: 8_000  runs: 1  episodes: 0 }
}
"#;

fn read(here: &Path) -> String {
    std::fs::read_to_string(here.join("reports/c/dossier.html")).unwrap()
}

/// The folder in which it ran, and its dossier.
fn dossier(required: &str, threads: &str) -> (tempfile::TempDir, String) {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("c.scn"), SCENARIO.replace("REQUIRED", required)).unwrap();
    let output = falsify(&["run", "c.scn", "--dossier", "--threads", threads], folder.path());
    assert!(output.status.success(), "{output:?}");
    let page = read(folder.path());
    (folder, page)
}

/// Checks that dossier, summary and replay say the same of a failure, and what is violated first.
fn assert_one_cause(here: &Path, page: &str) {
    let replay = |name: &str| -> Value {
        let output = falsify(&["replay", name, "--json"], here);
        serde_json::from_slice(&output.stdout).unwrap_or_else(|_| panic!("{output:?}"))
    };
    let page = page.replace("<code>", "`").replace("</code>", "`");
    let findings = page.split("<h2>").skip(1).find(|section| section.contains("Failures and their causes")).unwrap();
    let rows = findings.split("<th scope=\"row\">`").skip(1);
    let names: Vec<&str> = rows.filter_map(|row| row.split('`').next()).collect();
    assert!(!names.is_empty(), "{findings}");
    let summary = std::fs::read_to_string(here.join("reports/c/summary.md")).unwrap();
    for name in names {
        let replayed = replay(name);
        let sentence = replayed["cause"]["sentence"].as_str().unwrap();
        assert!(findings.contains(sentence), "{name} {sentence} {findings}");
        let row = summary.lines().find(|line| line.contains(&format!("`{name}` | The driver")));
        assert!(row.is_none_or(|row| row.contains(sentence)), "{sentence} {row:?}");
    }
    let listed = falsify(&["failures", "--verdict", "violation", "--names"], here);
    let listed = String::from_utf8(listed.stdout).unwrap();
    let mut violations = listed.lines().filter_map(|path| path.rsplit(['/', '\\']).next()).map(replay);
    let violation = violations.find(|each| each["collision"] == false).expect("there is a violation alone");
    let sentence = violation["cause"]["sentence"].as_str().unwrap();
    assert!(sentence.starts_with("The driver violates `safe_passing` "), "{sentence}");
}

#[test]
fn every_heading_has_figures_or_says_that_it_was_not_done() {
    let (folder, page) = dossier("requirements: [safe_passing]", "1");
    let (other, same) = dossier("requirements: [safe_passing]", "3");
    assert_eq!(page, same);
    // A dossier is a file of the report, which a second run may replace.
    for seed in ["2", "1"] {
        let again = falsify(&["run", "c.scn", "--dossier", "--seed", seed, "--replace"], other.path());
        assert!(again.status.success(), "{again:?}");
        assert_eq!(read(other.path()) == page, seed == "1");
    }
    assert_one_cause(folder.path(), &page);
    let sections: Vec<&str> = page.split("<h2>").skip(1).collect();
    assert_eq!(sections.len(), 8);
    for section in &sections {
        let has_figures = section.contains("<td");
        assert!(
            has_figures != section.contains("Not done in this campaign."),
            "{}",
            &section[..200.min(section.len())]
        );
    }
    assert!(
        sections[0].contains("margin: 0.2 m, crosswalks: yield, sensors.latency: 0.1 s, sensors.sector.width: 3 rad, sensors.sector.range: 50 m"),
        "{}",
        sections[0]
    );
    assert!(sections[4].contains("Not done in this campaign."), "no other simulator ran");
    assert!(
        sections[3].contains("`hunter` against `behavior` in harbour")
            || sections[3].contains("<code>hunter</code> against")
    );
    assert!(!page.contains("http-equiv=\"refresh\"") && !page.contains("src=\"http"));
    let varied = ["<th scope=\"row\">hunter</th>", "-60 to 60"];
    assert!(varied.iter().all(|part| sections[0].contains(part)), "{}", sections[0]);
    let (_, without) = dossier("", "2");
    assert_eq!(without.matches("Not done in this campaign.").count(), 2, "nor were there requirements");
}

#[test]
fn requirements_that_nobody_judged_are_not_called_kept_and_a_dossier_stays() {
    let folder = tempfile::tempdir().unwrap();
    let evaluate = SCENARIO.lines().find(|line| line.contains("evaluate")).unwrap();
    let text = SCENARIO.replace(evaluate, "").replace("REQUIRED", "requirements: [safe_passing]");
    std::fs::write(folder.path().join("c.scn"), text).unwrap();
    assert!(falsify(&["run", "c.scn", "--dossier"], folder.path()).status.success());
    let file = folder.path().join("reports/c/dossier.html");
    let page = std::fs::read_to_string(&file).unwrap();
    assert!(page.contains("No evaluation judged these requirements"), "{page}");
    assert_eq!(page.matches("not judged").count(), 2, "{page}");
    assert!(falsify(&["run", "c.scn", "--seed", "2", "--replace"], folder.path()).status.success());
    assert!(std::fs::read_to_string(&file).unwrap() != page, "that of the new run");
}

#[test]
fn the_dossier_of_a_protocol_says_what_its_limits_allow_and_that_it_is_no_rating() {
    let folder = tempfile::tempdir().unwrap();
    let text = r#"edition 1
import "std/drivers.scn"
import "std/r152.scn"
campaign p {
  vehicle: model3  body: adult_target  spawn: r152_crossing  episode: protocol_test
  evaluate { towns: [test_track]  drivers: [behavior]  pedestrians: [scripted] }
}
"#;
    std::fs::write(folder.path().join("p.scn"), text).unwrap();
    assert!(falsify(&["run", "p.scn", "--dossier"], folder.path()).status.success());
    let page = std::fs::read_to_string(folder.path().join("reports/p/dossier.html")).unwrap();
    let sections: Vec<&str> = page.split("<h2>").skip(1).collect();
    let (scope, required, covered, models) = (sections[0], sections[2], sections[3], sections[6]);
    for said in ["Some of them allow a collision", "This is not a rating.", "A cell is the impact speed"] {
        assert!(required.contains(said), "{said} {required}");
    }
    assert!(!required.contains("Not done in this campaign."), "{required}");
    assert!(covered.contains("beside the limits of the protocol's tests"), "{covered}");
    assert!(scope.contains("extrapolation") && scope.contains("What was varied"), "{scope}");
    assert!(!models.contains("Tefft") && !models.contains("fixed cycles"), "{models}");
}

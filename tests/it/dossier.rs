//! The dossier of a run: every heading has its figures or says that it was not done, and threads change nothing.

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

fn dossier(required: &str, threads: &str) -> String {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("c.scn"), SCENARIO.replace("REQUIRED", required)).unwrap();
    let output = falsify(&["run", "c.scn", "--dossier", "--threads", threads], folder.path());
    assert!(output.status.success(), "{output:?}");
    // A dossier is a file of the report, which a second run may replace.
    let again = falsify(&["run", "c.scn", "--dossier", "--seed", "2", "--replace"], folder.path());
    assert!(again.status.success(), "{again:?}");
    assert!(falsify(&["run", "c.scn", "--dossier", "--replace"], folder.path()).status.success());
    std::fs::read_to_string(folder.path().join("reports/c/dossier.html")).unwrap()
}

#[test]
fn every_heading_has_figures_or_says_that_it_was_not_done() {
    let page = dossier("requirements: [safe_passing]", "1");
    assert_eq!(page, dossier("requirements: [safe_passing]", "3"));
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
    let without = dossier("", "2");
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

//! Why a program failed: in its dossier, and where a gate fails.

use std::path::Path;

use needs::needs;
use serde_json::Value;

use crate::program::{error, falsify};

/// The program of the tests, blind on its right, has two faults of one kind.
const SCENARIO: &str = r#"edition 1
import "std/pedestrians.scn"
import "std/drivers.scn"
import "std/towns.scn"
spawn right { bearing: -90 deg .. 0 deg  distance: 8 m .. 40 m }
episode short { tick: 0.1 s  ticks: 60  hold: 10  end_when: ahead < -6 m }
driver own = external(command: "python3 driver.py", worlds: 4, route_points: 12)
campaign c {
  vehicle: model3  body: pursuer  spawn: right  episode: short
  evaluate { towns: [village]  drivers: [own]  pedestrians: [intercept]  episodes: 30 }
}
"#;

/// The sentence of the planted defect.
const CAUSE: &str = "on its right it reacts to people only up to 0.5 m beside its axis";

fn run(here: &Path) {
    let driver = std::fs::read_to_string(crate::repository().join("tests/external/braking.py")).unwrap();
    let blind = driver.replace("beside < 1.6", "beside < 1.6 and left > -0.5");
    assert!(blind != driver);
    std::fs::write(here.join("driver.py"), blind).unwrap();
    std::fs::write(here.join("c.scn"), SCENARIO).unwrap();
    let output = falsify(&["run", "c.scn", "--allow-external", "--dossier", "--seed", "3"], here);
    assert!(output.status.success(), "{output:?}");
}

#[needs(python)]
#[test]
fn the_cause_of_a_program_stands_in_its_dossier_and_below_a_gate_that_fails() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    run(here);
    let page = std::fs::read_to_string(here.join("reports/c/dossier.html")).unwrap();
    let of = |title: &str| page.split("<h2>").find(|section| section.contains(title)).unwrap().to_string();
    let (findings, error_of_ticks) = (of("Failures and their causes"), of("Numerical error"));
    let rows: Vec<&str> = findings.split("<tr>").filter(|row| row.contains("<td")).collect();
    let [asked, same_kind] = rows[..] else { panic!("{findings}") };
    assert!(asked.contains(CAUSE), "{asked}");
    assert!(
        same_kind.contains("not asked") && same_kind.contains("falsify replay --why --allow-external"),
        "{same_kind}"
    );
    assert!(
        error_of_ticks.contains("Not done in this campaign.") && !error_of_ticks.contains("<td"),
        "{error_of_ticks}"
    );

    let listed = falsify(&["failures", "--verdict", "fault", "--format", "json"], here);
    let worst: Value = serde_json::from_slice(listed.stdout.split(|byte| *byte == b'\n').next().unwrap()).unwrap();
    let name = format!("{}:{}", worst["run_id"].as_str().unwrap(), worst["number"]);
    let recheck = |gate: &str| {
        let met = ["recheck", "reports/c", "--allow-external", "--starts", "0", "--only", &name];
        falsify(&[&met[..], &["--fail-if", gate]].concat(), here)
    };
    let failed = recheck("still_faults > 0");
    let said = error(&failed);
    let (gate, why) =
        (said.find("--fail-if still_faults > 0: still_faults is 1"), said.find(&format!("{name}: The driver")));
    assert!(failed.status.code() == Some(7) && gate.is_some() && why > gate && said.contains(CAUSE), "{said}");
    let passed = recheck("still_faults > 1");
    assert!(passed.status.success() && !error(&passed).contains("The driver"), "nothing is asked: {passed:?}");
}

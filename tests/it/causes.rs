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

/// What `failures --why` says of a driver that brakes late for somebody who moves and gently for somebody who stands, after a change of its text.
fn why(here: &Path, changed: &str) -> String {
    let driver = std::fs::read_to_string(crate::repository().join("tests/external/braking.py")).unwrap();
    let gentle = driver
        .replace("beside < 1.6", "(abs(left) < 4 if math.hypot(actor['vx'], actor['vy']) > 0.1 else abs(left) < 1.6)")
        .replace("reach = 6 +", "reach = 1 +")
        .replace(
            "-8 if brakes",
            "(-8 if any(math.hypot(a['vx'], a['vy']) > 0.1 for a in world['actors']) else -0.7) if brakes",
        )
        .replace(
            "    ego = world[\"ego\"]\n    if not",
            &format!("    ego = world[\"ego\"]\n    {changed}\n    if not"),
        );
    assert!(gentle.contains(changed) && gentle.contains("-0.7"));
    std::fs::write(here.join("driver.py"), gentle).unwrap();
    let street = "town open { street along { through: [(0 m, 0 m), (150 m, 0 m), (300 m, 0 m)] } }\ndriver own";
    std::fs::write(here.join("c.scn"), SCENARIO.replace("driver own", street).replace("[village]", "[open]")).unwrap();
    let output = falsify(&["run", "c.scn", "--allow-external", "--seed", "3"], here);
    assert!(output.status.success(), "{output:?}");
    let output = falsify(&["failures", "--why", "--allow-external", "--verdict", "fault", "--top", "1"], here);
    String::from_utf8(output.stdout).unwrap().split_whitespace().collect::<Vec<_>>().join(" ")
}

#[needs(python)]
#[test]
fn what_a_driver_sees_with_one_thing_changed_is_somewhere() {
    let folder = tempfile::tempdir().unwrap();
    let null = "[open('null.txt', 'w') for actor in world['actors'] if None in actor.values()]";
    let said = why(folder.path(), null);
    assert!(said.contains("The driver has the pedestrian in sight"), "{said}");
    assert!(!folder.path().join("null.txt").exists(), "{said}");
}

#[needs(python)]
#[test]
fn a_driver_that_ends_with_one_thing_changed_has_not_answered() {
    let folder = tempfile::tempdir().unwrap();
    // Somebody stands where only walkers come in an episode.
    let ends = "[sys.exit(4) for a in world['actors'] if a['vx'] == a['vy'] == 0 and math.dist((a['x'], a['y']), (ego['x'], ego['y'])) < 6 and ego['speed'] > 3]";
    let said = why(folder.path(), ends);
    let unknown = "A cause was not found. With one thing changed, the driver ended before it answered with exit code 4";
    assert!(said.contains(unknown) && !said.contains("--max-runs"), "{said}");
}

#[needs(python)]
#[test]
fn the_cause_of_a_program_stands_in_its_dossier_and_below_a_gate_that_fails() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    run(here);
    let page = std::fs::read_to_string(here.join("reports/c/dossier.html")).unwrap();
    let of = |title: &str| page.split("<h2>").skip(1).find(|section| section.contains(title)).unwrap().to_string();
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

//! One pedestrian trained against several drivers, or in several towns.

use std::collections::BTreeSet;
use std::path::Path;

use base::diagnostic::Sources;
use base::seed::Seed;
use compile::{Catalog, Plan, compile};
use search::TrainingRun;

use crate::program::{error, falsify, report};

const SCENARIO: &str = r#"
edition 1
import "lib/paper.scn"
import "lib/drivers.scn"
import "lib/towns.scn"
training quick = ppo(steps: 360, steps_per_update: 30, epochs: 1, environments: 3, hidden: [8])
campaign joint {
  vehicle: model3  body: suicidal  spawn: ahead  episode: thirty_seconds  training: quick
  train { towns: [harbour, village] drivers: [idm, blind] rewards: [r1] runs: 1 TOGETHER }
  evaluate { towns: [harbour, village] drivers: [idm, blind] pedestrians: [trained] episodes: 6 }
}
"#;

fn plan(together: &str) -> Plan {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/together.scn");
    let text = SCENARIO.replace("TOGETHER", together);
    let read = |path: &Path| if path == root { Ok(text.clone()) } else { std::fs::read_to_string(path) };
    let compiled = compile(std::slice::from_ref(&root), &Catalog::builtin(), &read, &mut Sources::default()).unwrap();
    compiled.plan.unwrap_or_else(|| panic!("{:?}", compiled.diagnostics))
}

#[test]
fn a_training_is_of_each_pair_or_of_all_that_are_trained_together() {
    let keys = |together: &str| -> Vec<(String, String, usize)> {
        let plan = plan(together);
        let trainings = plan.campaigns[0].all::<compile::Training>();
        trainings.map(|each| (each.key.town.clone(), each.key.policy.clone(), each.scenarios().len())).collect()
    };
    let key = |town: &str, policy: &str, places| (town.to_string(), policy.to_string(), places);
    assert_eq!(keys("").len(), 4);
    assert_eq!(keys("together: drivers"), [key("harbour", "idm+blind", 2), key("village", "idm+blind", 2)]);
    assert_eq!(keys("together: towns"), [key("harbour+village", "idm", 2), key("harbour+village", "blind", 2)]);
    assert_eq!(keys("together: all"), [key("harbour+village", "idm+blind", 4)]);
    let fingerprint = |together: &str| plan(together).campaigns[0].nth::<compile::Training>(0).origin.fingerprint;
    let all: BTreeSet<_> = ["", "together: drivers", "together: towns", "together: all"].map(fingerprint).into();
    assert_eq!(all.len(), 4);
}

#[test]
fn a_training_in_several_scenarios_continues_bit_for_bit() {
    let plan = plan("together: all");
    let training = &plan.campaigns[0].nth::<compile::Training>(0);
    let (scenarios, seed, none) = (training.scenarios(), Seed::root(4), Default::default());
    let begin = || TrainingRun::begin(&scenarios, training.config.environments, &training.config, &seed).unwrap();
    let (mut whole, mut states) = (begin(), Vec::new());
    while !whole.is_done() {
        whole.update().unwrap();
        states.push(whole.state(&none));
    }
    assert_eq!(states.len(), 4);
    for (updates, state) in (1..).zip(&states) {
        let resumed =
            TrainingRun::resume(state, &scenarios, None, training.config.environments, &training.config, &seed)
                .unwrap();
        assert_eq!(&resumed.state(&none), state, "after {updates} updates");
        let mut resumed = resumed;
        while !resumed.is_done() {
            resumed.update().unwrap();
        }
        assert_eq!(&resumed.state(&none), states.last().unwrap(), "after {updates} updates");
    }
    // Another order of the scenarios is another training, and its state does not fit.
    let turned: Vec<_> = scenarios.iter().rev().cloned().collect();
    let other = TrainingRun::resume(&states[3], &turned, None, training.config.environments, &training.config, &seed);
    assert!(other.is_err());
    let fewer =
        TrainingRun::resume(&states[3], &scenarios[..1], None, training.config.environments, &training.config, &seed);
    assert!(fewer.is_err());
}

#[test]
fn a_joint_pedestrian_is_evaluated_in_each_town_against_each_driver_and_reported() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let text = SCENARIO.replace("lib/", "std/").replace("TOGETHER", "together: all");
    std::fs::write(here.join("joint.scn"), text).unwrap();
    let run = |out: &str, threads: &str| {
        let output = falsify(&["run", "joint.scn", "--out", out, "-j", threads], here);
        assert!(output.status.success(), "{}", error(&output));
        report(&here.join(out).join("joint"))
    };
    let one = run("one", "1");
    let results = String::from_utf8(one[Path::new("results.csv")].clone()).unwrap();
    let trained = results.lines().filter(|line| line.contains("harbour+village") && line.contains("idm+blind"));
    assert_eq!(trained.count(), 4, "{results}");
    let mut two = run("two", "2");
    let mut one = one;
    for varies in ["manifest.toml", "report.html"] {
        one.remove(Path::new(varies));
        two.remove(Path::new(varies));
    }
    assert_eq!(one, two);
}

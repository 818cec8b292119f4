//! Trainings that start from networks of a file.

use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::path::Path;
use std::slice::from_ref;

use base::diagnostic::Sources;
use base::seed::Seed;
use compile::{Catalog, Plan, Training, compile};
use lang::Reader;
use learn::ActorCritic;
use search::TrainingRun;

use crate::program::{error, falsify, said};

/// Reads one text, and one file of networks.
struct With {
    text: String,
    networks: Vec<u8>,
}

impl Reader for With {
    fn text(&self, path: &Path) -> std::io::Result<String> {
        let missing = || std::io::ErrorKind::NotFound.into();
        path.ends_with("test.scn").then(|| self.text.clone()).ok_or_else(missing)
    }

    fn bytes(&self, path: &Path) -> std::io::Result<Vec<u8>> {
        let missing = || std::io::ErrorKind::NotFound.into();
        path.ends_with("start.safetensors").then(|| self.networks.clone()).ok_or_else(missing)
    }
}

/// A campaign with one training, which has these keys in addition.
fn text(keys: &str) -> String {
    format!(
        "edition 1\nimport \"std/paper.scn\"\nimport \"std/rewards.scn\"\nimport \"std/drivers.scn\"\nimport \"std/towns.scn\"\n\
         training quick = ppo(steps: 60, steps_per_update: 20, epochs: 1, {keys})\n\
         campaign warm {{ vehicle: model3 body: suicidal spawn: ahead episode: thirty_seconds training: quick\n\
         train {{ towns: [harbour] drivers: [blind] rewards: [r1] runs: 1 }} }}\n"
    )
}

fn compiled(keys: &str, networks: &[u8]) -> Result<Plan, Vec<String>> {
    let reader = With { text: text(keys), networks: networks.to_vec() };
    let compiled = compile(&["test.scn".into()], &Catalog::builtin(), &reader, &mut Sources::default()).unwrap();
    let said = compiled.diagnostics.iter().map(|each| format!("{}: {}", each.code, each.message)).collect();
    compiled.plan.ok_or(said)
}

fn training(keys: &str, networks: &[u8]) -> Training {
    compiled(keys, networks).unwrap().campaigns[0].nth::<compile::Training>(0).clone()
}

fn networks(inputs: usize, outputs: usize, hidden: &[usize], seed: u64) -> ActorCritic {
    ActorCritic::new(inputs, outputs, hidden, -1.0, &mut Seed::root(seed).stream())
}

fn bytes(networks: &ActorCritic) -> Vec<u8> {
    networks.to_safetensors(&BTreeMap::new())
}

const KEYS: &str = "hidden: [8], from: \"start.safetensors\"";

#[test]
fn a_training_starts_with_the_weights_of_the_file_and_goes_on_after_an_interruption() {
    let first = networks(4, 2, &[8], 1);
    let training = training(KEYS, &bytes(&first));
    let begin = || TrainingRun::begin(from_ref(&training.scenario), 1, &training.config, &Seed::root(3)).unwrap();
    let present = |run: &TrainingRun| ActorCritic::from_safetensors(&run.state(&BTreeMap::new())).unwrap().0;
    assert_eq!(present(&begin()), first);
    let whole = begin().carry_on(&mut |_| ControlFlow::Continue(())).unwrap();
    assert_ne!(whole.policies[0], first, "it learns");
    let mut cut = begin();
    cut.update().unwrap();
    let state = cut.state(&BTreeMap::new());
    let resumed =
        TrainingRun::resume(&state, from_ref(&training.scenario), None, 1, &training.config, &Seed::root(3)).unwrap();
    let resumed = resumed.carry_on(&mut |_| ControlFlow::Continue(())).unwrap();
    assert_eq!(resumed.policies[0], whole.policies[0]);
    // A training that started elsewhere is not continued.
    let mut other = training.config.clone();
    other.from = None;
    assert!(TrainingRun::resume(&state, from_ref(&training.scenario), None, 1, &other, &Seed::root(3)).is_err());
}

#[test]
fn the_contents_of_the_file_are_a_part_of_the_training() {
    let of = |seed| training(KEYS, &bytes(&networks(4, 2, &[8], seed)));
    let (one, same, other) = (of(1), of(1), of(2));
    assert!(one.lineage.is_some());
    assert_eq!((one.origin.fingerprint, one.lineage), (same.origin.fingerprint, same.lineage));
    assert!(one.origin.fingerprint != other.origin.fingerprint && one.lineage != other.lineage);
}

#[test]
fn networks_that_do_not_fit_are_errors_with_the_key_to_change() {
    for (keys, file, reason) in [
        (KEYS, networks(5, 2, &[8], 1), "its states have 5 numbers, and those of this training have 4"),
        (KEYS, networks(4, 3, &[8], 1), "its actions have 3 numbers, and those of this training have 2"),
        (KEYS, networks(4, 2, &[16, 8], 1), "its hidden layers are [16, 8], so `hidden` must be that, and it is [8]"),
        ("frame_stack: 2, hidden: [8], from: \"start.safetensors\"", networks(4, 2, &[8], 1), "`frame_stack`"),
        (
            "normalize_observations: true, hidden: [8], from: \"start.safetensors\"",
            networks(4, 2, &[8], 1),
            "`normalize_observations: false`",
        ),
        ("hidden: [8], from: \"missing.safetensors\"", networks(4, 2, &[8], 1), "missing.safetensors"),
    ] {
        let said = compiled(keys, &bytes(&file)).expect_err(reason);
        assert!(said.len() == 1 && said[0].starts_with("unusable-model") && said[0].contains(reason), "{said:?}");
    }
    let said = compiled(KEYS, b"no networks").expect_err("not a file of networks");
    assert!(said.len() == 1 && said[0].contains("not a safetensors file"), "{said:?}");
}

#[test]
fn networks_of_a_report_are_taken_and_held_by_the_next_report() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let run = |keys: &str, out: &str| {
        std::fs::write(here.join("warm.scn"), text(keys)).unwrap();
        let output = falsify(&["run", "warm.scn", "--out", out], here);
        assert!(output.status.success(), "{}", error(&output));
    };
    run("hidden: [8]", "first");
    let name = "first/warm/pedestrians/r1-harbour-blind-0.safetensors";
    assert!(here.join(name).is_file(), "{:?}", std::fs::read_dir(here.join("first/warm/pedestrians")).unwrap().next());
    run(&format!("hidden: [8], from: \"{name}\""), "second");
    let held = here.join("second/warm/scenario").join(name);
    assert_eq!(std::fs::read(held).unwrap(), std::fs::read(here.join(name)).unwrap());
    let verified = falsify(&["replay", "--all", "second/warm", "--trainings"], here);
    assert!(verified.status.success(), "{} {}", said(&verified), error(&verified));
}

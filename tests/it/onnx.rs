//! Learned drivers from ONNX files.

use std::ops::ControlFlow;

use base::diagnostic::Sources;
use base::seed::Seed;
use compile::{Catalog, compile};
use episode::walker::Random;
use episode::{Outcome, evaluate};

use crate::beside_files::With;
use crate::program::command;

fn text(worlds: u32) -> String {
    let root = env!("CARGO_MANIFEST_DIR");
    format!(
        "edition 1\nimport \"{root}/scenarios/lib/paper.scn\"\nimport \"{root}/scenarios/lib/drivers.scn\"\n\
         import \"{root}/scenarios/lib/towns.scn\"\n\
         driver learnt = onnx(model: \"{root}/tests/reference/onnx/follow.onnx\", worlds: {worlds})\n\
         campaign learnt {{ vehicle: model3 body: suicidal spawn: ahead episode: thirty_seconds training: ppo_paper\n\
         train {{ towns: [harbour] drivers: [blind] rewards: [r1] runs: 1 }}\n\
         evaluate {{ towns: [harbour] drivers: [learnt] pedestrians: [random] episodes: 10 }} }}\n"
    )
}

fn outcomes(worlds: u32) -> Vec<Outcome> {
    let catalog = Catalog::builtin();
    let compiled = compile(&["test.scn".into()], &catalog, &With(text(worlds)), &mut Sources::default()).unwrap();
    let plan = compiled.plan.unwrap_or_else(|| panic!("{:?}", compiled.diagnostics));
    let (scenario, seed) = (&plan.campaigns[0].nth::<compile::Evaluation>(0).scenario, Seed::root(2));
    evaluate(&mut Random::default(), scenario, 10, &seed, &seed.child("walker"), &mut |_| ControlFlow::Continue(()))
}

#[test]
fn a_network_drives_and_company_changes_nothing() {
    let alone = outcomes(1);
    assert!(alone.iter().all(|outcome| outcome.fault().is_none()), "{alone:?}");
    assert!(alone.iter().any(|outcome| outcome.ticks > 100), "somebody gets away");
    assert_eq!(outcomes(4), alone);
}

#[test]
fn a_campaign_with_a_network_runs_and_the_manifest_names_its_file() {
    let place = tempfile::tempdir().unwrap();
    std::fs::write(place.path().join("learnt.scn"), text(8)).unwrap();
    let mut command = command();
    let output = command.args(["run", "--smoke", "learnt.scn"]).current_dir(place.path()).output().unwrap();
    assert!(output.status.success(), "{output:?}");
    let manifest = std::fs::read_to_string(place.path().join("reports/learnt-smoke/manifest.toml")).unwrap();
    assert!(manifest.contains("follow.onnx"), "{manifest}");
}

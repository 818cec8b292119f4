//! The same files, seed and version give the same bytes, at any number of threads.

use std::path::Path;

use crate::program::command;

const SCENARIO: &str = r#"
edition 1
import "lib/paper.scn"
import "lib/drivers.scn"
import "lib/towns.scn"
training short = ppo(steps: 600, environments: 2)
campaign twice {
  vehicle: model3  body: suicidal  spawn: ahead  episode: thirty_seconds  training: short
  train { towns: [harbour] drivers: [behavior, idm] rewards: [r1, r2] runs: 2 }
  evaluate { towns: [village] drivers: [behavior, blind] pedestrians: [trained, random, intercept] episodes: 6 }
}
"#;

fn run(threads: &str, seed: &str) -> Vec<(String, Vec<u8>)> {
    let folder = tempfile::tempdir().unwrap();
    let scenarios = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios");
    let file = folder.path().join("twice.scn");
    std::fs::write(&file, SCENARIO.replace("lib/", &format!("{}/lib/", scenarios.display()))).unwrap();
    let out = folder.path().join("out");
    let output = command()
        .args(["run", "--threads", threads, "--seed", seed, "--out"])
        .arg("out")
        .arg("twice.scn")
        .current_dir(folder.path())
        .output()
        .unwrap();
    assert!(output.status.success(), "{output:?}");
    let mut files = Vec::new();
    let mut open = vec![out.join("twice")];
    while let Some(folder) = open.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                open.push(path);
            } else if path.file_name().unwrap() != "manifest.toml" {
                files.push((path.strip_prefix(&out).unwrap().display().to_string(), std::fs::read(&path).unwrap()));
            }
        }
    }
    files.sort();
    files
}

#[test]
fn one_thread_and_four_give_the_same_bytes_and_another_seed_others() {
    let (one, four, other) = (run("1", "7"), run("4", "7"), run("1", "8"));
    let names = |files: &[(String, Vec<u8>)]| files.iter().map(|(name, _)| name.clone()).collect::<Vec<_>>();
    assert_eq!(names(&one), names(&four));
    assert!(one.len() > 15, "{:?}", names(&one));
    for ((name, a), (_, b)) in one.iter().zip(&four) {
        assert!(a == b, "{name} differs between 1 and 4 threads");
    }
    let episodes =
        |files: &[(String, Vec<u8>)]| files.iter().find(|(name, _)| name.ends_with("episodes.csv")).unwrap().1.clone();
    assert_ne!(episodes(&one), episodes(&other));
}

/// The digest of many episodes. It changes when the behaviour changes; a change must be intended.
#[test]
fn a_long_chaotic_run_has_the_digest_it_always_had() {
    use base::seed::Seed;
    use compile::{Catalog, compile};
    use episode::evaluate;
    use episode::walker::Random;
    use std::ops::ControlFlow;

    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/twice.scn");
    let read = |path: &Path| if path == root { Ok(SCENARIO.to_string()) } else { std::fs::read_to_string(path) };
    let compiled = compile(std::slice::from_ref(&root), &Catalog::builtin(), &read, &mut Default::default()).unwrap();
    let plan = compiled.plan.unwrap();
    let digests: Vec<u64> = ["behavior", "blind"]
        .into_iter()
        .map(|policy| {
            let evaluation =
                plan.campaigns[0].all::<compile::Evaluation>().find(|each| *each.policy == *policy).unwrap();
            let (seed, go_on) = (Seed::root(11), &mut |_| ControlFlow::Continue(()));
            let outcomes = evaluate(&mut Random::default(), &evaluation.scenario, 50, &seed, &seed.child("w"), go_on);
            outcomes.iter().fold(0, |sum: u64, outcome| sum.rotate_left(7) ^ outcome.digest)
        })
        .collect();
    assert_eq!(digests, [415_457_693_162_913_634, 2_739_261_974_103_536_177]);
}

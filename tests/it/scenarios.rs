//! Every scenario that is shipped checks without a diagnostic and passes a smoke run.

use std::path::{Path, PathBuf};

use crate::shipped::shipped;

use crate::program::command;

#[test]
fn every_file_checks_without_a_word() {
    // Two studies keep the towns of their figures, in which drivers meet turns too fast.
    let is_kept = |file: &Path| ["studies/casts.scn", "studies/worlds.scn"].iter().any(|kept| file.ends_with(kept));
    let files = shipped("scenarios");
    assert!(files.len() >= 4, "{files:?}");
    for file in &files {
        // Campaigns in real towns need maps that are not shipped.
        let text = std::fs::read_to_string(file).unwrap();
        if text.contains("opendrive(") {
            continue;
        }
        let mut check = command();
        // Other simulators would be asked, and need packages.
        let is_named = |name: &&str| text.contains(&format!("command: \"{name}"));
        if text.contains("falsify_av.bridges") || compile::BRIDGES.iter().any(is_named) {
            let output = check.args(["check", "--format", "json"]).arg(file).output().unwrap();
            let said = String::from_utf8_lossy(&output.stdout).into_owned();
            let mut others = said.lines().filter(|line| !line.contains("external-not-allowed"));
            let is_known = |line: &str| ["fast-bend", "unfit-pedestrian"].iter().any(|code| line.contains(code));
            assert!(others.all(|line| is_kept(file) && is_known(line)), "{}: {said}", file.display());
            continue;
        }
        let output = check.args(["check", "--allow-external"]).arg(file).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        let is_bend = is_kept(file) && said.matches("warning[").count() == 1 && said.contains("fast-bend");
        assert!(output.status.success() && (said.is_empty() || is_bend), "{}: {said}", file.display());
    }
}

#[test]
fn the_main_campaigns_survive_a_smoke_run() {
    let out = tempfile::tempdir().unwrap();
    let top = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios");
    let campaigns = shipped("scenarios").into_iter().filter(|path| path.parent() == Some(&top));
    let output = command().args(["run", "--smoke", "--out"]).arg(out.path()).args(campaigns).output().unwrap();
    assert!(output.status.success(), "{output:?}");
    let reports: Vec<PathBuf> = std::fs::read_dir(out.path()).unwrap().map(|entry| entry.unwrap().path()).collect();
    let is_report = |path: &PathBuf| !path.file_name().unwrap().to_string_lossy().starts_with('.');
    let reports: Vec<PathBuf> = reports.into_iter().filter(is_report).collect();
    assert!(!reports.is_empty());
    for report in reports {
        for file in [
            "manifest.toml",
            "report.html",
            "summary.md",
            "episodes.csv",
            "episodes.parquet",
            "results.csv",
            "learning_curve.csv",
        ] {
            let path = report.join(file);
            assert!(std::fs::metadata(&path).is_ok_and(|data| data.len() > 100), "{}", path.display());
        }
    }
}

#[test]
fn the_examples_in_the_documents_check() {
    use base::diagnostic::Sources;
    use compile::{Catalog, compile};
    let top = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut blocks = 0;
    for document in ["README.md", "grammar/README.md", "docs/src/reference/commands.md"] {
        let text = std::fs::read_to_string(top.join(document)).unwrap();
        for block in text.split("```scn\n").skip(1) {
            let body = block.split("```").next().unwrap();
            // Examples import the standard library, or are in a folder of shipped scenarios.
            let root = top.join("scenarios/example.scn");
            let read = |path: &Path| if path == root { Ok(body.to_string()) } else { std::fs::read_to_string(path) };
            let compiled =
                compile(std::slice::from_ref(&root), &Catalog::builtin(), &read, &mut Sources::default()).unwrap();
            assert_eq!(compiled.diagnostics, [], "{document}");
            blocks += 1;
        }
    }
    assert!(blocks >= 3);
}

#[test]
fn a_matrix_over_the_eyes_of_a_driver_changes_how_it_drives() {
    use base::diagnostic::Sources;
    use base::seed::Seed;
    use compile::{Catalog, compile};
    use results::jobs::watch;
    const SCENARIO: &str = r#"
edition 1
import "lib/paper.scn"
import "lib/drivers.scn"
import "lib/towns.scn"
param missed: number = 0.5
sensors eyes { miss_near: missed  miss_far: missed  far: 100 m  miss_correlation: 3 s }
driver watched = aeb(sensors: eyes)
campaign looks {
  vehicle: model3  body: suicidal  spawn: ahead  episode: thirty_seconds  training: ppo_paper
  matrix { missed: [0, 1] }
  train { towns: [harbour]  drivers: [watched]  rewards: [r1]  runs: 1 }
  evaluate { towns: [harbour]  drivers: [watched]  pedestrians: [intercept]  episodes: 60 }
}
"#;
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/looks.scn");
    let read = |path: &Path| if path == root { Ok(SCENARIO.to_string()) } else { std::fs::read_to_string(path) };
    let compiled = compile(std::slice::from_ref(&root), &Catalog::builtin(), &read, &mut Sources::default()).unwrap();
    let campaigns = compiled.plan.unwrap().campaigns;
    let moving = |campaign: usize| {
        let note = &mut |outcome: &episode::Outcome, _: &episode::Trace| {
            outcome.impact_speed().is_some_and(|speed| speed > 0.1)
        };
        let go_on = &mut |_| std::ops::ControlFlow::Continue(());
        let evaluation = &campaigns[campaign].nth::<compile::Evaluation>(0);
        let hits = watch(evaluation, None, 0..60, &Seed::root(1), note, go_on);
        hits.into_iter().filter(|hit| *hit).count()
    };
    assert_eq!(campaigns.len(), 2);
    assert_ne!(
        campaigns[0].nth::<compile::Evaluation>(0).origin.fingerprint,
        campaigns[1].nth::<compile::Evaluation>(0).origin.fingerprint
    );
    assert!(moving(0) + 10 < moving(1), "{} with good eyes, {} without", moving(0), moving(1));
}

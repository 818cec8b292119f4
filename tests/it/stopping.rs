//! A stopping rule ends an evaluation early, at the same episode for any number of threads.

use std::path::Path;

use base::diagnostic::Sources;
use base::seed::Seed;
use compile::StoppingRule;
use compile::{Catalog, compile};
use results::campaign::{InMemory, Silent, run};
use results::record::EpisodeRow;

const SCENARIO: &str = r#"
edition 1
import "lib/paper.scn"
import "lib/drivers.scn"
import "lib/towns.scn"
training short = ppo(steps: 600)
campaign stopped {
  vehicle: model3  adversary: suicidal  spawn: ahead  episode: thirty_seconds  training: short
  train { towns: [harbour] policies: [blind] rewards: [r1] runs: 1 }
  evaluate { towns: [harbour] policies: [blind] pedestrians: [random, intercept] episodes: 2_200 halfwidth: 0.04 }
}
"#;

fn rows(threads: usize) -> Vec<EpisodeRow> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/stopped.scn");
    let read = |path: &Path| if path == root { Ok(SCENARIO.to_string()) } else { std::fs::read_to_string(path) };
    let compiled = compile(std::slice::from_ref(&root), &Catalog::builtin(), &read, &mut Sources::default()).unwrap();
    let campaign = &compiled.plan.unwrap().campaigns[0];
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    pool.install(|| {
        let kept = InMemory::default();
        run(campaign, &Seed::root(1), &kept, &Silent);
        kept.into_rows()
    })
}

#[test]
fn an_evaluation_ends_at_the_first_look_at_which_its_interval_is_narrow_enough() {
    let (one, two) = (rows(1), rows(2));
    assert_eq!(one, two);
    let rule = StoppingRule::new(Some(0.04), 2_200);
    assert_eq!(rule.looks(), [1_000, 2_000, 2_200]);
    for pedestrian in ["random", "intercept"] {
        let rows: Vec<_> = one.iter().filter(|row| row.key.cell.controller == pedestrian).collect();
        let hits = |look: u32| rows[..look as usize].iter().filter(|row| row.outcome.is_collision()).count() as u64;
        let first = rule
            .looks()
            .into_iter()
            .find(|look| *look as usize > rows.len() || rule.is_met(hits(*look), u64::from(*look)));
        assert_eq!(first, Some(rows.len() as u32), "{pedestrian}");
        assert!(rows.iter().zip(0..).all(|(row, episode)| row.episode == episode));
    }
    assert!(one.len() < 2 * 2_200, "a rate is known to 0.04 after 1,500 episodes at the latest");
}

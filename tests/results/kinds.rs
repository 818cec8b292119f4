//! Kinds of failure, from the tables of episodes to their own.

use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::path::Path;

use base::seed::Seed;
use compile::{Campaign, Catalog, Evaluation, compile};
use polars::prelude::{Column, DataFrame, NamedFrom, Series};
use results::jobs::watch;
use results::record::{EpisodeRow, EpisodeTable, RunKey, episodes};
use results::report::{FailureModes, csv_text, failure_modes};
use world::judge::{Judged, NearMiss, judge};

const SCENARIO: &str = r#"
edition 1
import "lib/paper.scn"
import "lib/drivers.scn"
import "lib/towns.scn"
campaign kinds {
  vehicle: model3  adversary: suicidal  spawn: ahead  episode: thirty_seconds  training: ppo_paper
  train { towns: [harbour] policies: [behavior] rewards: [r1] runs: 2 }
  evaluate { towns: [harbour] policies: [behavior] pedestrians: [random, intercept] episodes: 90 }
}
"#;

fn campaign() -> Campaign {
    let root = crate::repository().join("scenarios/kinds.scn");
    let read = |path: &Path| if path == root { Ok(SCENARIO.to_string()) } else { std::fs::read_to_string(path) };
    let compiled = compile(std::slice::from_ref(&root), &Catalog::builtin(), &read, &mut Default::default()).unwrap();
    compiled.plan.unwrap().campaigns.remove(0)
}

/// A row for each of an evaluation's episodes.
fn rows(evaluation: &Evaluation, seed: &Seed) -> Vec<EpisodeRow> {
    let noted = watch(
        evaluation,
        None,
        0..evaluation.episodes,
        seed,
        &mut |outcome, trace| {
            let scenario = &evaluation.scenario;
            (*outcome, judge(&trace.main_pair(scenario)), NearMiss::new(&trace.main_pair(scenario)))
        },
        &mut |_| ControlFlow::Continue(()),
    );
    let key = std::sync::Arc::new(RunKey::of(evaluation));
    let row = |(episode, (outcome, verdict, near_miss))| EpisodeRow {
        lane: None,
        key: key.clone(),
        episode,
        judged: Judged { outcome, verdict, degrees: Vec::new() },
        false_alarms: None,
        near_miss,
        motion: Default::default(),
    };
    (0..).zip(noted).map(row).collect()
}

/// The table of failure modes of these runs as CSV.
fn modes(campaign: &Campaign, seed: &Seed, runs: &[DataFrame]) -> String {
    let mut modes = FailureModes::new(campaign, &[], seed);
    for run in runs.iter().filter(|run| run.height() > 0) {
        modes.add(&RunKey::read(run, 0).unwrap(), &EpisodeTable::new(run).unwrap());
    }
    csv_text(&failure_modes(&modes.finish()))
}

/// The rows of a table as maps.
fn table(text: &str) -> Vec<BTreeMap<String, String>> {
    let mut lines = text.lines();
    let head: Vec<&str> = lines.next().unwrap().split(',').collect();
    let row = |line: &str| {
        assert_eq!(line.split(',').count(), head.len(), "{line}");
        head.iter().zip(line.split(',')).map(|(name, value)| (name.to_string(), value.to_string())).collect()
    };
    lines.map(row).collect()
}

#[test]
fn kinds_add_up_and_their_examples_can_be_repeated() {
    let (campaign, seed) = (campaign(), Seed::root(7));
    let rows: Vec<Vec<EpisodeRow>> = campaign.all::<Evaluation>().map(|each| rows(each, &seed)).collect();
    let frames: Vec<DataFrame> = rows.iter().map(|rows| episodes(rows)).collect();
    let text = modes(&campaign, &seed, &frames);
    let backwards: Vec<DataFrame> = frames.iter().rev().cloned().collect();
    assert_eq!(modes(&campaign, &seed, &backwards), text, "the order of the runs does not matter");

    let modes = table(&text);
    for pedestrian in ["random", "intercept"] {
        let number = |row: &BTreeMap<String, String>, name: &str| row[name].parse::<f64>().unwrap();
        let here: Vec<_> = modes.iter().filter(|row| row["controller"] == pedestrian).collect();
        let collisions: Vec<&EpisodeRow> = rows
            .iter()
            .flatten()
            .filter(|row| row.key.cell.controller == pedestrian && row.judged.outcome.is_collision())
            .collect();
        assert!(collisions.len() > 10, "{}", collisions.len());
        let counted: f64 =
            here.iter().filter(|row| row["cluster"] == "0").map(|row| number(row, "kind_failures")).sum();
        assert_eq!(counted, collisions.len() as f64);
        assert!((here.iter().map(|row| number(row, "share")).sum::<f64>() - 1.0).abs() < 1e-9);
        for row in here {
            let (run, episode) = (number(row, "example_run") as u32, number(row, "example_episode") as u32);
            let is_it = |each: &&Evaluation| each.controller.name() == pedestrian && each.trained.run == run;
            let evaluation = campaign.all::<Evaluation>().find(is_it).unwrap();
            let again = watch(
                evaluation,
                None,
                episode..episode + 1,
                &seed,
                &mut |outcome, trace| (*outcome, judge(&trace.main_pair(&evaluation.scenario)).unwrap()),
                &mut |_| ControlFlow::Continue(()),
            );
            let (outcome, verdict) = &again[0];
            assert_eq!(row["verdict"], verdict.label.name(), "{row:?}");
            assert_eq!(row["driving_mode"], outcome.last_mode.name());
        }
    }
}

#[test]
fn what_does_not_repeat_is_counted_and_not_clustered() {
    let (campaign, seed) = (campaign(), Seed::root(7));
    let evaluation = campaign.all::<Evaluation>().find(|each| each.controller.name() == "intercept").unwrap();
    let mut run = episodes(&rows(evaluation, &seed));
    let wrong = vec!["0123456789abcdef"; run.height()];
    run.with_column(Column::from(Series::new("digest".into(), wrong))).unwrap();
    let rows = table(&modes(&campaign, &seed, std::slice::from_ref(&run)));
    assert!(!rows.is_empty());
    for row in rows {
        assert_eq!((row["kind_failures"].as_str(), row["spread_m"].as_str()), (row["cluster_members"].as_str(), ""));
    }
    assert!(table(&modes(&campaign, &seed, &[])).is_empty());
}

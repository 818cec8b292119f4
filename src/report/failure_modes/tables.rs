use polars::prelude::{Column, DataFrame, NamedFrom, Series};

use super::cell::{CellModes, Mode, Target};
use crate::analysis::{Explanation, Importance, Rule, accumulation};
use crate::record::{CellKey, cell_key};
use crate::statistics::wilson;

/// Points of an accumulation curve.
const POINTS: u64 = 25;

/// Rows that belong to cells, as columns in the making.
struct Table<'a, T> {
    rows: Vec<(&'a CellModes<'a>, T)>,
    columns: Vec<Column>,
}

impl<'a, T> Table<'a, T> {
    /// Begins with what the rows belong to.
    fn new(rows: Vec<(&'a CellModes<'a>, T)>) -> Self {
        let mut table = Self { rows, columns: Vec::new() };
        let keys: Vec<&CellKey> = table.rows.iter().map(|(cell, _)| &cell.key).collect();
        table.columns.extend(cell_key(|key: &&CellKey| *key).iter().map(|entry| entry.values(&keys)));
        table
    }

    fn text(&mut self, name: &str, value: impl Fn(&CellModes<'_>, &T) -> String) {
        let values: Vec<String> = self.rows.iter().map(|(cell, row)| value(cell, row)).collect();
        self.columns.push(Series::new(name.into(), values).into());
    }

    fn count(&mut self, name: &str, value: impl Fn(&CellModes<'_>, &T) -> u64) {
        let values: Vec<u32> =
            self.rows.iter().map(|(cell, row)| u32::try_from(value(cell, row)).unwrap_or(u32::MAX)).collect();
        self.columns.push(Series::new(name.into(), values).into());
    }

    fn number(&mut self, name: &str, value: impl Fn(&CellModes<'_>, &T) -> f64) {
        self.maybe(name, |cell, row| Some(value(cell, row)));
    }

    fn maybe(&mut self, name: &str, value: impl Fn(&CellModes<'_>, &T) -> Option<f64>) {
        let values: Vec<Option<f64>> = self.rows.iter().map(|(cell, row)| value(cell, row)).collect();
        self.columns.push(Series::new(name.into(), values).into());
    }

    fn finish(self) -> DataFrame {
        DataFrame::new(self.rows.len(), self.columns).expect("all columns have a value for every row")
    }
}

/// The modes of all cells, one row each.
pub fn failure_modes(cells: &[CellModes<'_>]) -> DataFrame {
    let rows = cells.iter().flat_map(|cell| cell.modes.iter().map(move |mode| (cell, mode)));
    let mut table: Table<'_, &Mode> = Table::new(rows.collect());
    table.text("impact", |_, row| row.mode.kind.impact.name().into());
    table.text("motion", |_, row| row.mode.kind.motion().into());
    table.text("verdict", |_, row| row.mode.kind.verdict.name().into());
    table.text("sight", |_, row| if row.mode.kind.occluded { "occluded" } else { "in_sight" }.into());
    table.text("driving_mode", |_, row| row.mode.kind.mode.name().into());
    table.count("kind_failures", |_, row| row.mode.failures as u64);
    table.count("cluster", |_, row| row.mode.cluster as u64);
    table.count("clusters", |_, row| row.mode.clusters as u64);
    table.count("cluster_members", |_, row| row.mode.members.len() as u64);
    table.number("share", |_, row| row.mode.share);
    for (index, name) in ["p10", "median", "p90"].into_iter().enumerate() {
        table.number(&format!("impact_speed_{name}_mps"), |_, row| row.mode.impact_speed[index]);
    }
    table.number("median_length_s", |_, row| row.mode.length);
    table.maybe("spread_m", |_, row| row.mode.spread);
    table.maybe("halves_agreement", |_, row| row.mode.stability.map(|stability| stability.halves));
    table.maybe("bootstrap_agreement", |_, row| row.mode.stability.map(|stability| stability.bootstrap));
    table.maybe("silhouette", |_, row| row.mode.stability.map(|stability| stability.silhouette));
    table.text("example", |_, row| row.example_name());
    table.count("example_run", |_, row| row.example.0.into());
    table.count("example_episode", |_, row| row.example.1.into());
    table.finish()
}

/// How many kinds there are in each cell, and how many may be unseen.
pub fn mode_counts(cells: &[CellModes<'_>]) -> DataFrame {
    let mut table: Table<'_, ()> = Table::new(cells.iter().map(|cell| (cell, ())).collect());
    table.count("episodes", |cell, ()| cell.all.0);
    table.count("collisions", |cell, ()| cell.all.1);
    table.count("sampled_episodes", |cell, ()| cell.sampled.0);
    table.count("sampled_collisions", |cell, ()| cell.sampled.1);
    table.count("repeated_collisions", |cell, ()| cell.repeated);
    table.count("kinds", |cell, ()| cell.richness.seen);
    table.count("kinds_seen_once", |cell, ()| cell.richness.once);
    table.count("kinds_seen_twice", |cell, ()| cell.richness.twice);
    table.number("kinds_estimate", |cell, ()| cell.richness.estimate);
    table.number("kinds_estimate_se", |cell, ()| cell.richness.standard_error);
    table.number("kinds_estimate_low", |cell, ()| cell.richness.interval.0);
    table.number("kinds_estimate_high", |cell, ()| cell.richness.interval.1);
    table.number("coverage", |cell, ()| cell.richness.coverage);
    table.number("entropy_nat", |cell, ()| cell.richness.entropy);
    table.number("effective_kinds", |cell, ()| cell.richness.effective());
    table.number("new_kinds_per_1000_episodes", |cell, ()| {
        1000.0 * cell.richness.once as f64 / cell.sampled.0.max(1) as f64
    });
    table.count("modes", |cell, ()| cell.modes.len() as u64);
    table.finish()
}

/// The expected number of kinds over the number of episodes, from none to all that were analysed.
pub fn accumulated(cell: &CellModes<'_>) -> Vec<(u64, f64)> {
    let all = cell.sampled.0;
    let mut points: Vec<u64> = (0..=POINTS).map(|point| all * point / POINTS).collect();
    points.dedup();
    points.into_iter().map(|episodes| (episodes, accumulation(&cell.counts, all, episodes))).collect()
}

/// The accumulation curves of all cells.
pub fn mode_accumulation(cells: &[CellModes<'_>]) -> DataFrame {
    let rows = cells.iter().flat_map(|cell| {
        let points = accumulated(cell);
        let steps: Vec<(u64, f64, Option<f64>)> = (0..points.len())
            .map(|i| {
                let (episodes, kinds) = points[i];
                let before = i.checked_sub(1).map(|before| points[before]);
                (episodes, kinds, before.map(|(from, had)| 1000.0 * (kinds - had) / (episodes - from) as f64))
            })
            .collect();
        steps.into_iter().map(move |step| (cell, step))
    });
    let mut table = Table::new(rows.collect());
    table.count("episodes", |_, row| row.0);
    table.number("expected_kinds", |_, row| row.1);
    table.maybe("new_kinds_per_1000_episodes", |_, row| row.2);
    table.finish()
}

/// The rules of all cells.
pub fn explanations(cells: &[CellModes<'_>]) -> DataFrame {
    type Row<'a> = (Target, &'a Explanation, &'a Rule);
    let mut rows: Vec<(&CellModes<'_>, Row<'_>)> = Vec::new();
    for cell in cells {
        for (target, found) in &cell.explanations {
            rows.extend(found.rules.iter().map(|rule| (cell, (*target, found, rule))));
        }
    }
    let mut table = Table::new(rows);
    let rate = |(hits, all): (u64, u64)| (all > 0).then(|| hits as f64 / all as f64);
    table.text("target", |_, row| row.0.name().into());
    table.text("rule", |_, row| row.2.to_string());
    table.count("learnt_episodes", |_, row| row.2.learnt.1);
    table.maybe("learnt_rate", |_, row| rate(row.2.learnt));
    table.count("held_out_episodes", |_, row| row.2.held_out.1);
    table.maybe("held_out_rate", |_, row| rate(row.2.held_out));
    table.number("held_out_rate_wilson_low", |_, row| wilson(row.2.held_out.0, row.2.held_out.1).0);
    table.number("held_out_rate_wilson_high", |_, row| wilson(row.2.held_out.0, row.2.held_out.1).1);
    table.maybe("overall_rate", |_, row| rate(row.1.overall));
    table.number("accuracy", |_, row| row.1.accuracy);
    table.number("majority_accuracy", |_, row| row.1.majority);
    table.number("skill", |_, row| row.1.skill);
    table.finish()
}

/// What the rules of all cells need.
pub fn explanation_features(cells: &[CellModes<'_>]) -> DataFrame {
    let mut rows: Vec<(&CellModes<'_>, (Target, Importance))> = Vec::new();
    for cell in cells {
        for (target, found) in &cell.explanations {
            rows.extend(found.importances.iter().map(|importance| (cell, (*target, *importance))));
        }
    }
    let mut table = Table::new(rows);
    table.text("target", |_, row| row.0.name().into());
    table.text("feature", |_, row| row.1.feature.name.into());
    table.number("loss_of_skill", |_, row| row.1.loss);
    table.finish()
}

use std::collections::BTreeMap;

use polars::prelude::DataFrame;

use super::searches::search_key;
use crate::analysis::{Impact, Kind};
use crate::jobs::Find;
use crate::jobs::SearchResult;
use crate::record::columns::{DRIVING_MODE, EPISODE_LENGTH, IMPACT, IMPACT_SPEED, VERDICT};
use crate::record::{Column, Table};
use base::statistics::quantile;
use compile::SearchKey;
use world::env::{Ending, Outcome};
use world::falsifier::Failure;
use world::judge::Verdict;

/// The kind of a failure of a search; as that of a collision in an evaluation.
pub(super) fn kind(outcome: &Outcome, verdict: &Verdict) -> Option<Kind> {
    let Ending::Touch { front, bearing, .. } = outcome.ending else { return None };
    Some(Kind {
        impact: Impact::new(front, bearing),
        verdict: verdict.label,
        occluded: verdict.sight.is_occluded(),
        mode: outcome.last_mode,
    })
}

/// The failures of one kind that the runs of a falsifier found in one town against one policy.
#[derive(Debug, Clone, PartialEq)]
pub struct SearchKind {
    /// The falsifier, the town and the policy; the run is that of the example.
    pub key: SearchKey,
    pub kind: Kind,
    pub failures: usize,
    /// The number of these with a foreseeable pedestrian.
    pub foreseeable: usize,
    /// Their share of the failures with a verdict.
    pub share: f64,
    /// Median of the car's speed at the touch (m/s).
    pub impact_speed: f64,
    /// Median of the time from the start of the episode to the touch (s).
    pub length: f64,
    /// The number of the example in its search: the first one found, a fault one if there is any.
    pub example: usize,
}

impl SearchKind {
    /// The name of its example, `RUN_ID:FAILURE`.
    pub fn example_name(&self) -> String {
        format!("{}:{}", self.key.id, self.example)
    }
}

/// The kinds of failures of all searches: cells in the order of first appearance, in each the most frequent kind first. Failures without a
/// verdict have no kind.
pub fn search_kinds(results: &[SearchResult]) -> Vec<SearchKind> {
    let mut cells: Vec<Vec<&SearchResult>> = Vec::new();
    for result in results {
        match cells.iter_mut().find(|cell| cell[0].key.is_of_same_cell(&result.key)) {
            Some(cell) => cell.push(result),
            None => cells.push(vec![result]),
        }
    }
    cells.iter().flat_map(|cell| kinds_of(cell)).collect()
}

fn kinds_of(cell: &[&SearchResult]) -> Vec<SearchKind> {
    type Member<'a> = (Find<'a>, Verdict);
    let mut kinds: BTreeMap<Kind, Vec<Member<'_>>> = BTreeMap::new();
    let mut all = 0;
    for find in cell.iter().flat_map(|result| result.finds()) {
        let Some(verdict) = find.verdict() else { continue };
        if let Some(kind) = kind(&find.failure.outcome, &verdict) {
            kinds.entry(kind).or_default().push((find, verdict));
            all += 1;
        }
    }
    let median = |members: &[Member<'_>], value: fn(&Failure) -> f64| {
        let mut values: Vec<f64> = members.iter().map(|(find, _)| value(find.failure)).collect();
        values.sort_by(f64::total_cmp);
        quantile(&values, 0.5).unwrap_or_default()
    };
    let mut found: Vec<SearchKind> = kinds
        .into_iter()
        .map(|(kind, members)| {
            let fault = members.iter().find(|(_, verdict)| verdict.is_fault());
            let (example, _) = fault.unwrap_or(&members[0]);
            SearchKind {
                key: example.key.clone(),
                kind,
                failures: members.len(),
                foreseeable: members.iter().filter(|(_, verdict)| verdict.foreseeable).count(),
                share: members.len() as f64 / all as f64,
                impact_speed: median(&members, |failure| failure.outcome.impact_speed().unwrap_or_default()),
                length: median(&members, |failure| failure.outcome.duration),
                example: example.number,
            }
        })
        .collect();
    found.sort_by_key(|kind| std::cmp::Reverse(kind.failures));
    found
}

/// The stem of the files of the table of kinds.
pub const SEARCH_KINDS: &str = "search_kinds";

/// The kinds of failures as a table, one row each, in the order given.
pub fn search_kind_table(kinds: &[SearchKind]) -> DataFrame {
    search_kind_columns().frame(kinds)
}

/// The columns of [`search_kind_table`].
pub fn search_kind_columns() -> Table<'static, SearchKind> {
    let (text, count, number) = (Column::<String>::new, Column::<u64>::new, Column::<f64>::new);
    let doc = "median over the failures of the kind";
    Table::new(
        SEARCH_KINDS,
        "One row for each kind of failure that a falsifier found in one town against one policy, over all runs. A kind is that of \
         [failure modes](#kinds-of-failure), without clusters.",
    )
    .columns(search_key(|kind: &SearchKind| &kind.key))
    .column(IMPACT.of(|row: &SearchKind| row.kind.impact.name()))
    .column(VERDICT.of(|row: &SearchKind| row.kind.verdict.name()).meaning("verdict on the failures of the kind"))
    .column(
        text("sight", "", "`in_sight`, or `occluded`: in sight for less than 1.15 s before the touch")
            .of(|row: &SearchKind| if row.kind.occluded { "occluded" } else { "in_sight" }),
    )
    .column(DRIVING_MODE.of(|row: &SearchKind| row.kind.mode.name()))
    .column(count("failures", "", "number of failures of the kind").of(|row: &SearchKind| row.failures as u64))
    .column(
        count("foreseeable_failures", "", "number of these with a foreseeable pedestrian")
            .of(|row: &SearchKind| row.foreseeable as u64),
    )
    .column(number("share", "", "their share of the failures with a verdict").of(|row: &SearchKind| row.share))
    .column(number(IMPACT_SPEED.name, IMPACT_SPEED.unit, doc).of(|row: &SearchKind| row.impact_speed))
    .column(number(EPISODE_LENGTH.name, EPISODE_LENGTH.unit, doc).of(|row: &SearchKind| row.length))
    .column(
        text("example", "", "`RUN_ID:FAILURE`: the first one found, a fault one if there is any")
            .of(|row: &SearchKind| row.example_name()),
    )
}

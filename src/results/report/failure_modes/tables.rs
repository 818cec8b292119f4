use polars::prelude::DataFrame;

use super::cell::{CellModes, Mode, Target};
use crate::analysis::{Explanation, Rule};
use crate::record::columns::{DRIVING_MODE, IMPACT, IMPACT_SPEED, VERDICT};
use crate::record::{Column, Entry, Interval, Table, TableReference, cell_key};
use base::statistics::wilson;

/// A row that belongs to a cell.
type Row<'a, T> = (&'a CellModes, T);

/// A table whose rows belong to cells.
fn table<'a, T: 'a>(name: &'static str, doc: &'static str) -> Table<'a, Row<'a, T>> {
    Table::new(name, doc).columns(cell_key(|row: &Row<'a, T>| &row.0.key))
}

/// A column of counts, up to the largest number of 32 bits.
fn count<'a, T: 'a>(
    name: &'static str,
    doc: &'static str,
    value: impl Fn(&CellModes, &T) -> u64 + 'a,
) -> Entry<'a, Row<'a, T>> {
    let value = move |row: &Row<'a, T>| u32::try_from(value(row.0, &row.1)).unwrap_or(u32::MAX);
    Column::<u32>::new(name, "", doc).of(value)
}

/// A column of numbers, some of which may be missing.
fn number<'a, T: 'a>(
    (name, unit): (&'static str, &'static str),
    doc: &'static str,
    value: impl Fn(&CellModes, &T) -> Option<f64> + 'a,
) -> Entry<'a, Row<'a, T>> {
    Column::<f64>::new(name, unit, doc).of(move |row: &Row<'a, T>| value(row.0, &row.1))
}

/// The reference of all tables of this module.
pub fn references() -> [TableReference; 2] {
    [mode_table().reference(), rule_table().reference()]
}

/// The modes of all cells, one row each.
pub fn failure_modes(cells: &[CellModes]) -> DataFrame {
    let rows = cells.iter().flat_map(|cell| cell.modes.iter().map(move |mode| (cell, mode)));
    mode_table().frame(&rows.collect::<Vec<_>>())
}

fn mode_table<'a>() -> Table<'a, Row<'a, &'a Mode>> {
    type Of<'a> = Row<'a, &'a Mode>;
    let mut table = table(
        "failure_modes",
        "One row for each mode of each cell: the collisions by kind and by how they came about, with an example of each.",
    )
    .column(IMPACT.of(|row: &Of<'_>| row.1.mode.kind.impact.name()))
    .column(VERDICT.of(|row: &Of<'_>| row.1.mode.kind.verdict.name()).meaning("verdict on the collisions of the kind"))
    .column(
        Column::<String>::new("sight", "", "`in_sight`, or `occluded`: in sight for less than 1.15 s before the touch")
            .of(|row: &Of<'_>| if row.1.mode.kind.occluded { "occluded" } else { "in_sight" }),
    )
    .column(DRIVING_MODE.of(|row: &Of<'_>| row.1.mode.kind.mode.name()))
    .column(count("kind_failures", "number of collisions of the kind", |_, row: &&Mode| row.mode.failures as u64))
    .column(count("cluster", "number of the cluster within the kind, the largest first", |_, row: &&Mode| {
        row.mode.cluster as u64
    }))
    .column(count("clusters", "number of clusters of the kind", |_, row: &&Mode| row.mode.clusters as u64))
    .column(count(
        "cluster_members",
        "collisions of the cluster among those that were repeated; of the kind, if none could be",
        |_, row: &&Mode| row.mode.members.len() as u64,
    ))
    .column(number(
        ("share", ""),
        "share of the cell's collisions; a cluster's part of its kind is that among the repeated ones",
        |_, row: &&Mode| Some(row.mode.share),
    ));
    let (stem, end) = IMPACT_SPEED.name.split_at(IMPACT_SPEED.name.len() - "_mps".len());
    for (index, name) in ["p10", "median", "p90"].into_iter().enumerate() {
        let doc = "quantile of the car's speed at the touch, over the members";
        let value = move |row: &Of<'a>| row.1.mode.impact_speed[index];
        let name = format!("{stem}_{name}{end}").into();
        table = table.column(Entry::new::<f64, _>(name, IMPACT_SPEED.unit.into(), doc.into(), value));
    }
    table
        .column(number(
            ("median_length_s", "s"),
            "median of the time from the start of the episode to the touch",
            |_, row: &&Mode| Some(row.mode.length),
        ))
        .column(number(
            ("spread_m", "m"),
            "root mean square distance of the approaches from the medoid's",
            |_, row: &&Mode| row.mode.spread,
        ))
        .column(number(
            ("halves_agreement", ""),
            "adjusted Rand index between the partitions of the two halves; missing without clusters",
            |_, row: &&Mode| row.mode.stability.map(|stability| stability.halves),
        ))
        .column(number(
            ("bootstrap_agreement", ""),
            "mean adjusted Rand index between the partition and those of ten bootstrap samples; missing without clusters",
            |_, row: &&Mode| row.mode.stability.map(|stability| stability.bootstrap),
        ))
        .column(number(("silhouette", ""), "mean silhouette of the kind's clusters", |_, row: &&Mode| {
            row.mode.stability.map(|stability| stability.silhouette)
        }))
        .column(
            Column::<String>::new(
                "example",
                "",
                "name of the medoid, `RUN:EPISODE`: the member with the least sum of distances from all others",
            )
            .of(|row: &Of<'_>| row.1.example.name()),
        )
        .column(count("example_run", "number of its run", |_, row: &&Mode| row.example.key.run.into()))
        .column(count("example_episode", "number of its episode", |_, row: &&Mode| row.example.number))
}

type Explained<'a> = (Target, &'a Explanation, &'a Rule);

/// The rules of all cells.
pub fn explanations(cells: &[CellModes]) -> DataFrame {
    let mut rows: Vec<Row<'_, Explained<'_>>> = Vec::new();
    for cell in cells {
        for (target, found) in &cell.explanations {
            rows.extend(found.rules.iter().map(|rule| (cell, (*target, found, rule))));
        }
    }
    rule_table().frame(&rows)
}

const TARGET: Column<String> =
    Column::new("target", "", "`collision` or `preventable`: the ending of an episode that is explained");

fn rule_table<'a>() -> Table<'a, Row<'a, Explained<'a>>> {
    type Of<'a> = Row<'a, Explained<'a>>;
    let rate = |(hits, all): (u64, u64)| (all > 0).then(|| hits as f64 / all as f64);
    let held_out = |row: &Of<'a>| Some(wilson(row.1.2.held_out.0, row.1.2.held_out.1));
    table("explanations", "One row for each rule: which starts end in collisions.")
        .column(TARGET.of(|row: &Of<'_>| row.1.0.name()))
        .column(
            Column::<String>::new("rule", "", "which starts; each satisfies one rule of its cell and target")
                .of(|row: &Of<'_>| row.1.2.to_string()),
        )
        .column(count(
            "learnt_episodes",
            "number of episodes that the rule was learnt from",
            |_, row: &Explained<'_>| row.2.learnt.1,
        ))
        .column(number(("learnt_rate", ""), "share of them that ended so", move |_, row: &Explained<'_>| {
            rate(row.2.learnt)
        }))
        .column(count("held_out_episodes", "number of episodes of the other half", |_, row: &Explained<'_>| {
            row.2.held_out.1
        }))
        .column(number(("held_out_rate", ""), "share of them that ended so", move |_, row: &Explained<'_>| {
            rate(row.2.held_out)
        }))
        .columns(Interval::new("held_out_rate_wilson", "", "Wilson's 95 % interval of that rate").of(held_out))
        .column(number(
            ("overall_rate", ""),
            "rate of both halves, whatever the rule",
            move |_, row: &Explained<'_>| rate(row.1.overall),
        ))
        .column(number(
            ("accuracy", ""),
            "share of the other half whose ending the tree predicts",
            |_, row: &Explained<'_>| Some(row.1.accuracy),
        ))
        .column(number(
            ("majority_accuracy", ""),
            "share of the other half whose ending is the commoner one",
            |_, row: &Explained<'_>| Some(row.1.majority),
        ))
        .column(number(
            ("skill", ""),
            "share of the other half's variance that the rules' rates explain; at 0 they say nothing",
            |_, row: &Explained<'_>| Some(row.1.skill),
        ))
}

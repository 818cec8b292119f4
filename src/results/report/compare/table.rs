use polars::prelude::DataFrame;

use super::comparison::{Changed, ComparedCell};
use crate::record::columns::{ADVERSARY, BLOCK, CONTROLLER, POLICY, REWARD, TOWN, TRAIN_POLICY, TRAIN_TOWN, VEHICLE};
use crate::record::{Column, Family, Table, TableReference};
use crate::report::Figure;
use crate::report::infer::Comparison;

const BEFORE: Family<f64> = Family::new("_before", "", "rate of the first side over the common starts, mean over runs");
const AFTER: Family<f64> = Family::new("_after", "", "the same of the second side");
const DIFFERENCE: Family<f64> = Family::new("_difference", "", "second less first");
const LOW: Family<f64> = Family::new(
    "_low",
    "",
    "low end of an interval of the difference: in 95 % of comparisons those of all rows and rates hold the truth (Bonferroni; Bonett and Price's for \
     one run, else Student's; missing for two and three runs)",
);
const HIGH: Family<f64> = Family::new("_high", "", "high end of the same");
const HOLM: Family<f64> = Family::new(
    "_p_holm",
    "",
    "probability of such a difference by chance (McNemar's exact test for one run, Student's over several trainings), adjusted by Holm's method for \
     all rows and rates, so that in 95 % of comparisons no finding below 0.05 is false",
);
const FIXED: Family<u64> = Family::new("_fixed", "", "common starts with such a collision on the first side only");
const NEW: Family<u64> = Family::new("_new", "", "common starts with such a collision on the second side only");
const SAME: Family<u64> = Family::new("_same", "", "common starts with such a collision on both sides");

/// The number of starts that both sides have.
pub const COMMON_STARTS: Column<u64> = Column::new("common_starts", "", "pairs of episodes with equal starts");

/// The cells of a comparison as a table, one row each.
pub fn compared_cells(cells: &[ComparedCell]) -> DataFrame {
    table().frame(cells)
}

/// The columns of [`compared_cells`].
pub fn comparison_reference() -> TableReference {
    table().reference()
}

fn table() -> Table<'static, ComparedCell> {
    type Row = ComparedCell;
    let text = Column::<String>::new;
    let mut table = Table::new("comparison", "One row for each place, driver and controller that both sides have.")
        .column(POLICY.of(|row: &Row| row.keys[0].policy.clone()))
        .column(
            text("other_policy", "", "name of the driving policy on the second side")
                .of(|row: &Row| row.keys[1].policy.clone()),
        )
        .column(TOWN.of(|row: &Row| row.keys[0].town.clone()))
        .column(CONTROLLER.of(|row: &Row| row.keys[0].controller.clone()))
        .column(REWARD.of(|row: &Row| row.keys[0].reward.clone()))
        .column(TRAIN_TOWN.of(|row: &Row| row.keys[0].train_town.clone()))
        .column(TRAIN_POLICY.of(|row: &Row| row.keys[0].train_policy.clone()))
        .column(VEHICLE.of(|row: &Row| row.keys[0].vehicle.clone()))
        .column(ADVERSARY.of(|row: &Row| row.keys[0].adversary.clone()))
        .column(BLOCK.of(|row: &Row| row.keys[0].block))
        .column(Column::<u64>::new("runs", "", "matched runs").of(|row: &Row| row.runs))
        .column(COMMON_STARTS.of(|row: &Row| row.starts));
    for figure in Figure::COMPARED {
        let name = figure.name();
        let of = move |value: fn(&Comparison) -> Option<f64>| move |row: &Row| row.figure(figure).and_then(value);
        table = table
            .column(BEFORE.of(name, of(|each| Some(each.values[1]))))
            .column(AFTER.of(name, of(|each| Some(each.values[0]))))
            .column(DIFFERENCE.of(name, of(|each| Some(each.difference))))
            .column(LOW.of(name, of(|each| each.interval.map(|ends| ends.0))))
            .column(HIGH.of(name, of(|each| each.interval.map(|ends| ends.1))))
            .column(HOLM.of(name, of(|each| each.holm)));
    }
    type Counted = (&'static str, fn(&Row) -> Changed);
    let counted: [Counted; 3] =
        [("collisions", |row| row.collisions), ("preventable", |row| row.preventable), ("fault", |row| row.fault)];
    for (name, changed) in counted {
        table = table
            .column(FIXED.of(name, move |row: &Row| changed(row).fixed))
            .column(NEW.of(name, move |row: &Row| changed(row).new))
            .column(SAME.of(name, move |row: &Row| changed(row).same));
    }
    table
}

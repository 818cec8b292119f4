use polars::prelude::DataFrame;

use super::{Cell, Failures, Rate};
use crate::failure::Failure;
use crate::record::columns::{DRIVER, PEDESTRIAN, REWARD, TOWN, TRAIN_DRIVER, TRAIN_TOWN, WORLD};
use crate::record::{Column, Entry, Interval, Table};
use crate::report::infer::{BEATS_UNTRAINED, CellEvidence};

/// The stem of the files of the table of results.
pub const RESULTS: &str = "results";

/// A cell, whether its trainings beat untrained pedestrians, and the worst of its failures.
type Row<'a> = (&'a Cell, Option<&'static str>, Option<&'a Failure>);

/// The table to open first: one row for each cell.
pub fn results(cells: &[Cell], evidence: &[CellEvidence], failures: &Failures) -> DataFrame {
    let beats = |found: &CellEvidence| found.learning.as_ref().map(|learning| learning.beats_untrained().name());
    let rows: Vec<Row<'_>> =
        cells.iter().zip(evidence).map(|(cell, found)| (cell, beats(found), failures.worst_of(&cell.key))).collect();
    results_table().frame(&rows)
}

/// The columns of [`results`].
pub fn results_table<'a>() -> Table<'a, Row<'a>> {
    let count = Column::<u32>::new;
    let mut table = Table::new(
        RESULTS,
        "One row for each pedestrian, town, driver and world. Open this table first; `metrics` has all that is known.",
    )
    .column(PEDESTRIAN.of(|row: &Row<'_>| row.0.key.controller.clone()))
    .column(REWARD.of(|row: &Row<'_>| row.0.key.reward.clone()))
    .column(TRAIN_TOWN.of(|row: &Row<'_>| row.0.key.train_town.clone()))
    .column(TRAIN_DRIVER.of(|row: &Row<'_>| row.0.key.train_policy.clone()))
    .column(TOWN.of(|row: &Row<'_>| row.0.key.town.clone()))
    .column(DRIVER.of(|row: &Row<'_>| row.0.key.policy.clone()))
    .column(WORLD.of(|row: &Row<'_>| row.0.key.world.clone()))
    .column(count("runs", "", "trainings, or seeds of an untrained pedestrian").of(|row: &Row<'_>| row.0.runs))
    .column(count("episodes", "", "episodes in which no program failed").of(|row: &Row<'_>| row.0.episodes))
    .column(BEATS_UNTRAINED.of(|row: &Row<'_>| row.1));
    let collision = "collisions of all episodes, with Wilson's 95 % interval over starts; bumps do not count";
    table = rate(table, "collision_rate", collision, |cell| &cell.collision);
    let fault = "faults of the driver, of all episodes, as above";
    table = rate(table, "fault_rate", fault, |cell| &cell.fault);
    table.column(
        Column::<String>::new("worst", "", "name of the failure that counts most against the driver, `RUN:EPISODE`")
            .of(|row: &Row<'_>| row.2.map(Failure::name)),
    )
}

fn rate<'a>(
    table: Table<'a, Row<'a>>,
    name: &'static str,
    doc: &'static str,
    of: fn(&Cell) -> &Rate,
) -> Table<'a, Row<'a>> {
    let mean: Entry<'a, Row<'a>> = Column::<f64>::new(name, "", doc).of(move |row: &Row<'a>| of(row.0).value);
    table.column(mean).columns(Interval::new(name, "", doc).of(move |row: &Row<'a>| of(row.0).interval))
}

use polars::prelude::DataFrame;

use crate::failure::Failure;
use crate::record::columns::{DRIVER, PEDESTRIAN, REWARD, TOWN, TRAIN_DRIVER, TRAIN_TOWN, WORLD};
use crate::record::{Column, Entry, Table, interval};
use crate::report::Findings;
use crate::report::infer::BEATS_UNTRAINED;
use crate::tables::Cell;
use crate::tables::metrics::{COLLISION_RATE, EPISODES, FAULT_RATE};

/// The stem of the files of the table of results.
pub const RESULTS: &str = "results";

/// A cell, whether its trainings beat untrained pedestrians, and the worst of its failures.
type Row<'a> = (&'a Cell, Option<&'static str>, Option<&'a Failure>);

/// The table to open first: one row for each cell.
pub fn results(found: &Findings<'_>) -> DataFrame {
    let beats = |cell| Some(found.evidence(cell)?.learning.as_ref()?.beats_untrained().name());
    let worst = |cell: &Cell| found.gathered.failures.worst_of(&cell.key, None);
    let rows: Vec<Row<'_>> = found.cells.iter().map(|cell| (cell, beats(cell), worst(cell))).collect();
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
    .column(count("runs", "", "trainings, or seeds of an untrained pedestrian").of(|row: &Row<'_>| row.0.runs()))
    .column(count("episodes", "", "episodes in which no program failed").of(|row: &Row<'_>| row.0.count(&EPISODES)))
    .column(BEATS_UNTRAINED.of(|row: &Row<'_>| row.1));
    let collision = "collisions of all episodes, with Wilson's 95 % interval over starts; bumps do not count";
    for (metric, doc) in
        [(&COLLISION_RATE, collision), (&FAULT_RATE, "faults of the driver, of all episodes, as above")]
    {
        let mean: Entry<'a, Row<'a>> = Column::<f64>::new(metric.name, "", doc).of(|row: &Row<'a>| row.0.value(metric));
        let ends = move |row: &Row<'a>| row.0.rate(metric).interval;
        table = table.column(mean).columns(interval(metric.name, metric.name, doc, ends));
    }
    table.column(
        Column::<String>::new("worst", "", "name of the failure that counts most against the driver, `RUN:EPISODE`")
            .of(|row: &Row<'_>| row.2.map(Failure::name)),
    )
}

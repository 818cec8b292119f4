use polars::prelude::DataFrame;

use super::comparison::{ComparedCell, ReportComparison};
use super::paired_rate::{CountedEvent, PairedRate};
use crate::record::columns::{BLOCK, BODY, DRIVER, PEDESTRIAN, REWARD, TOWN, TRAIN_DRIVER, TRAIN_TOWN, VEHICLE, WORLD};
use crate::record::{Role, Table, TableReference, columns};
use crate::tables::Changed;

columns! {
    /// rate of the first side over all common starts (also of a requirement, which need not apply there), mean over runs; `worse_rate` is of collisions of
    /// both sides that are worse on this side
    BEFORE: Family<f64> = "_before" as Share;
    /// the same of the second side
    AFTER: Family<f64> = "_after" as Share;
    /// second less first
    DIFFERENCE: Family<f64> = "_difference" as ShareDifference;
    /// low end of an interval of the difference: in 95 % of comparisons those of this rate hold the truth in all rows of single pedestrians, and in all rows
    /// of all untrained pedestrians (Bonferroni; Bonett and Price's for one run and for all untrained pedestrians, else Student's; missing for two and three
    /// runs; 0 for an unchanged driver)
    LOW: Family<f64> = "_low" as LowerBound;
    /// high end of the same
    HIGH: Family<f64> = "_high" as UpperBound;
    /// probability of such a difference by chance (McNemar's exact test for one run, Student's over several trainings, the exact randomisation test over
    /// starts for all pedestrians), adjusted by Holm's method for this rate in all rows of single pedestrians, or in all rows of all untrained pedestrians,
    /// so that in 95 % of comparisons no finding below 0.05 of either is false. Rows without a pair that differs in it count in no correction, and have 1
    HOLM: Family<f64> = "_p_holm" as AdjustedP;
    /// common starts with such a failure on the first side only; of all untrained pedestrians, with more of them on that side
    FIXED: Family<u64> = "_fixed";
    /// the same of the second side
    NEW: Family<u64> = "_new";
    /// common starts with such a failure on both sides; of all untrained pedestrians, with as many
    SAME: Family<u64> = "_same";

    /// common starts with a collision on both sides that is worse on the second: at least 1 m/s faster, a fault only there, or faster and therefore no fault
    /// any more; of all untrained pedestrians, with as many of them as of better ones or more
    WORSE: Family<u64> = "_worse";
    /// the same on the first side, and not on the second
    BETTER: Family<u64> = "_better";

    /// name of the driver on the second side
    pub OTHER_DRIVER: Column<String> = "other_driver";
    /// matched runs
    pub MATCHED_RUNS: Column<u64> = "runs";

    /// pairs of episodes with equal starts; of all untrained pedestrians the number of different starts
    pub COMMON_STARTS: Column<u64> = "common_starts";

    /// pairs of episodes with equal starts that are not the same byte for byte; 0 of a driver that did not change
    pub DIFFERING: Column<u64> = "differing_episodes";
}

/// The cells of a comparison as a table, one row each.
pub fn compared_cells(comparison: &ReportComparison) -> DataFrame {
    table(&comparison.events).frame(&comparison.cells)
}

/// The columns of [`compared_cells`] with these requirements.
pub fn comparison_reference(requirements: &[&str]) -> TableReference {
    let requirements: Vec<String> = requirements.iter().map(ToString::to_string).collect();
    table(&CountedEvent::all(requirements.iter())).reference()
}

fn table(events: &[CountedEvent]) -> Table<'static, ComparedCell> {
    type Row = ComparedCell;
    let mut table = Table::new(
        "comparison",
        "One row for each place, driver and pedestrian that both sides have, and one with the pedestrian `all untrained` for a driver that has several.",
    )
    .column(DRIVER.of(|row: &Row| row.keys[0].policy.clone()))
    .column(OTHER_DRIVER.of(|row: &Row| row.keys[1].policy.clone()))
    .column(TOWN.of(|row: &Row| row.keys[0].town.clone()))
    .column(PEDESTRIAN.of(|row: &Row| row.keys[0].controller.clone()))
    .column(REWARD.of(|row: &Row| row.keys[0].reward.clone()))
    .column(TRAIN_TOWN.of(|row: &Row| row.keys[0].train_town.clone()))
    .column(TRAIN_DRIVER.of(|row: &Row| row.keys[0].train_policy.clone()))
    .column(VEHICLE.of(|row: &Row| row.keys[0].vehicle.clone()))
    .column(BODY.of(|row: &Row| row.keys[0].adversary.clone()))
    .column(WORLD.of(|row: &Row| row.keys[0].world.clone()))
    .column(BLOCK.of(|row: &Row| row.keys[0].block))
    .column(MATCHED_RUNS.of(|row: &Row| row.runs))
    .column(COMMON_STARTS.of(|row: &Row| row.starts))
    .column(DIFFERING.of(|row: &Row| row.differing));
    for (place, event) in events.iter().enumerate() {
        let name = &event.rate();
        let of = move |value: fn(&PairedRate) -> Option<f64>| {
            move |row: &Row| row.rates.get(place)?.as_ref().and_then(value)
        };
        table = table
            .column(BEFORE.of(name, of(|rate| Some(rate.values[0]))))
            .column(AFTER.of(name, of(|rate| Some(rate.values[1]))))
            .column(DIFFERENCE.of(name, of(|rate| Some(rate.difference()))))
            .column(LOW.of(name, of(|rate| Some(rate.interval?.0))))
            .column(HIGH.of(name, of(|rate| Some(rate.interval?.1))))
            .column(HOLM.of(name, of(|rate| rate.holm)));
    }
    for (place, event) in events.iter().enumerate() {
        let name = &event.number();
        let of = move |count: fn(Changed) -> u64| {
            move |row: &Row| row.rates.get(place).and_then(Option::as_ref).map_or(0, |rate| count(rate.changed))
        };
        if *event == CountedEvent::WORSE {
            table = table
                .column(BETTER.of(name, of(|all| all.fixed)).of_figure(event.rate(), Role::Differing))
                .column(WORSE.of(name, of(|all| all.new + all.same)).of_figure(event.rate(), Role::Differing));
            continue;
        }
        table = table
            .column(FIXED.of(name, of(|all| all.fixed)).of_figure(event.rate(), Role::Differing))
            .column(NEW.of(name, of(|all| all.new)).of_figure(event.rate(), Role::Differing))
            .column(SAME.of(name, of(|all| all.same)));
    }
    table
}

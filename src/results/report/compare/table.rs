use polars::prelude::DataFrame;

use super::comparison::{ComparedCell, ReportComparison};
use super::paired_rate::{CountedEvent, PairedRate};
use crate::record::columns::{BLOCK, BODY, DRIVER, PEDESTRIAN, REWARD, TOWN, TRAIN_DRIVER, TRAIN_TOWN, VEHICLE, WORLD};
use crate::record::{Column, Family, Role, Table, TableReference};
use crate::tables::Changed;

const BEFORE: Family<f64> = Family::new(
    "_before",
    "",
    "rate of the first side over all common starts (also of a requirement, which need not apply there), mean over runs; `worse_rate` is of collisions of both \
     sides that are worse on this side",
)
.with_role(Role::Share);
const AFTER: Family<f64> = Family::new("_after", "", "the same of the second side").with_role(Role::Share);
const DIFFERENCE: Family<f64> = Family::new("_difference", "", "second less first").with_role(Role::ShareDifference);
const LOW: Family<f64> = Family::new(
    "_low",
    "",
    "low end of an interval of the difference: in 95 % of comparisons those of this rate hold the truth in all rows of single pedestrians, and in all rows of \
     all untrained pedestrians (Bonferroni; Bonett and Price's for one run and for all untrained pedestrians, else Student's; missing for two and three runs; 0 for an unchanged \
     driver)",
)
.with_role(Role::LowerBound);
const HIGH: Family<f64> = Family::new("_high", "", "high end of the same").with_role(Role::UpperBound);
const HOLM: Family<f64> = Family::new(
    "_p_holm",
    "",
    "probability of such a difference by chance (McNemar's exact test for one run, Student's over several trainings, the exact randomisation test over starts for all \
     pedestrians), adjusted by Holm's method for this rate in all rows of single pedestrians, or in all rows of all untrained pedestrians, so that in 95 % of comparisons \
     no finding below 0.05 of either is false. Rows without a pair that differs in it count in no correction, and have 1",
)
.with_role(Role::AdjustedP);
const FIXED: Family<u64> = Family::new(
    "_fixed",
    "",
    "common starts with such a failure on the first side only; of all untrained pedestrians, with more of them on that side",
);
const NEW: Family<u64> = Family::new("_new", "", "the same of the second side");
const SAME: Family<u64> = Family::new(
    "_same",
    "",
    "common starts with such a failure on both sides; of all untrained pedestrians, with as many",
);

const WORSE: Family<u64> = Family::new(
    "_worse",
    "",
    "common starts with a collision on both sides that is worse on the second: at least 1 m/s faster, a fault only there, or faster and therefore no fault any \
     more; of all untrained pedestrians, with as many of them as of better ones or more",
);
const BETTER: Family<u64> = Family::new("_better", "", "the same on the first side, and not on the second");

pub const OTHER_DRIVER: Column<String> = Column::new("other_driver", "", "name of the driver on the second side");
pub const MATCHED_RUNS: Column<u64> = Column::new("runs", "", "matched runs");

/// The number of starts that both sides have.
pub const COMMON_STARTS: Column<u64> = Column::new(
    "common_starts",
    "",
    "pairs of episodes with equal starts; of all untrained pedestrians the number of different starts",
);

/// The number of pairs of episodes that tell anything of a change.
pub const DIFFERING: Column<u64> = Column::new(
    "differing_episodes",
    "",
    "pairs of episodes with equal starts that are not the same byte for byte; 0 of a driver that did not change",
);

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

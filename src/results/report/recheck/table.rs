use super::{CrossedStarts, RecheckedFailures, RerunOutcome, StartFaults};
use crate::record::columns::{DRIVER, TOWN, WORLD};
use crate::record::{Column, Role, Table};

fn other_policy<'t, R: 't>(name: impl Fn(&R) -> String + 't) -> crate::record::Entry<'t, R> {
    Column::<String>::new("other_driver", "", "name of the new driver").of(name)
}

/// The column of the number of failures that a new driver did not meet.
pub const NOT_MET: &str = "not_met";

/// Whether a collision is none any more for a driver that reacts.
pub fn is_gone(before: &RerunOutcome, after: &RerunOutcome) -> bool {
    before.is_collision() && !after.is_collision() && !after.is_missed
}

/// Whether a collision is none any more, and would be none if the driver saw nobody.
pub fn is_not_met(before: &RerunOutcome, after: &RerunOutcome) -> bool {
    before.is_collision() && after.is_missed
}

/// Whether a collision is still one, and counts less against the new driver.
pub fn is_better(before: &RerunOutcome, after: &RerunOutcome) -> bool {
    before.is_worse_than(after) && !after.is_worse_than(before)
}

/// What the ends of an interval are.
const LOW: &str = "its interval (95 %, Clopper and Pearson): lower end";
const HIGH: &str = "upper end";

/// The failures of a report that were met again as a table, one row for each set.
pub fn rechecked_table() -> Table<'static, RecheckedFailures> {
    type Row = RecheckedFailures;
    let injuries = |name, doc| Column::<f64>::new(name, "", doc);
    let is = |is: fn(&RerunOutcome, &RerunOutcome) -> bool| move |row: &Row| row.encounters.count(is);
    let share = |name, doc, role| Column::<f64>::new(name, "", doc).with_role(role);
    let of_share =
        |was_fault, part: fn((f64, (f64, f64))) -> f64| move |row: &Row| row.fault_share(was_fault).map(part);
    Table::new("recheck_failures", "One row for each driver, town, world, source of failures and walk.")
        .column(DRIVER.of(|row: &Row| row.policies[0].clone()))
        .column(other_policy(|row: &Row| row.policies[1].clone()))
        .column(TOWN.of(|row: &Row| row.town.clone()))
        .column(WORLD.of(|row: &Row| row.world.clone()))
        .text("found_in", "`evaluation` or `search`", |row| row.found_in.name())
        .text("walked_by", "what moves the pedestrian: `pedestrian`, or the recorded `commands`", |row| {
            row.walked_by.name()
        })
        .count("failures", "collisions in the report, met again; with --sample near misses, too", is(|_, _| true))
        .count("old_faults", "of them faults of the old driver", is(|before, _| before.fault))
        .count(
            "still_faults",
            "of these faults, those that the new driver still has",
            is(|before, after| before.fault && after.fault),
        )
        .column(
            share("still_fault_share", "`still_faults` as a share of the `old_faults` that were met", Role::Share)
                .of(of_share(true, |share| share.0)),
        )
        .column(share("still_fault_share_low", LOW, Role::LowerBound).of(of_share(true, |share| share.1.0)))
        .column(share("still_fault_share_high", HIGH, Role::UpperBound).of(of_share(true, |share| share.1.1)))
        .count(
            "turned_faults",
            "failures that were no fault of the old driver and are one of the new",
            is(|before, after| !before.fault && after.fault),
        )
        .column(
            share(
                "turned_fault_share",
                "`turned_faults` as a share of the `failures` that were met, without `old_faults`",
                Role::Share,
            )
            .of(of_share(false, |share| share.0)),
        )
        .column(share("turned_fault_share_low", LOW, Role::LowerBound).of(of_share(false, |share| share.1.0)))
        .column(share("turned_fault_share_high", HIGH, Role::UpperBound).of(of_share(false, |share| share.1.1)))
        .count(
            "still_collisions",
            "failures that are still collisions with the new driver",
            is(|_, after| after.is_collision()),
        )
        .count(
            "still_collisions_worse",
            "of these, those that are at least 1 m/s faster, a fault only now, or faster and therefore no fault any more",
            is(|before, after| after.is_worse_than(before)),
        )
        .count(
            "still_collisions_better",
            "of these, those that are at least 1 m/s slower, or no fault any more, and not worse",
            is(is_better),
        )
        .count(
            "gone",
            "failures that are none any more since the new driver reacts; a pedestrian may bump into the standing car",
            is(is_gone),
        )
        .count(
            NOT_MET,
            "failures of which nothing is known: the pedestrian would miss the new driver even if that saw nobody",
            is(is_not_met),
        )
        .column(
            injuries(
                "avoidable_injuries_before",
                "expected severe injuries (AIS 4 or more, or death) in the old driver's faults",
            )
            .of(|row: &Row| row.encounters.ends().map(|(before, _)| before.avoidable_injury()).sum::<f64>()),
        )
        .column(
            injuries("avoidable_injuries_after", "the same in the new driver's")
                .of(|row: &Row| row.encounters.ends().map(|(_, after)| after.avoidable_injury()).sum::<f64>()),
        )
        .count(
            "failed_encounters",
            "failures left out, since a driver, a pedestrian or the world failed as a program",
            |row| row.encounters.errors(),
        )
}

/// The fixed list as a table, one row for each driver, town and setup.
pub fn crossed_table() -> Table<'static, CrossedStarts> {
    type Row = CrossedStarts;
    let number = Column::<f64>::new;
    let is = |is: fn(&RerunOutcome, &RerunOutcome) -> bool| move |row: &Row| row.encounters.count(is);
    let starts = |is: fn(StartFaults) -> bool| move |row: &Row| row.count_starts(is);
    Table::new(
        "recheck_crossings",
        "One row for each driver, town and setup: an episode for every walk of a grid, from the same starts.",
    )
    .column(DRIVER.of(|row: &Row| row.policies[0].clone()))
    .column(other_policy(|row: &Row| row.policies[1].clone()))
    .column(TOWN.of(|row: &Row| row.town.clone()))
    .column(WORLD.of(|row: &Row| row.world.clone()))
    .count("setup", "number of the spawn, episode and pedestrian in the town, from 0", |row| row.setup)
    .count("starts", "starts", |row| row.starts().len() as u64)
    .count("crossings", "episodes from each start", |row| row.crossings)
    .count("faults_before", "episodes that are a fault of the old driver", is(|before, _| before.fault))
    .count(
        "faults_after",
        "episodes that are a fault of the new driver",
        |row| row.encounters.valid().filter(|encounter| encounter.after.fault).count() as u64,
    )
    .count("faults_new", "of the new driver only", is(|before, after| after.fault && !before.fault))
    .count("faults_fixed", "of the old driver only", is(|before, after| before.fault && !after.fault))
    .count("faults_same", "of both", is(|before, after| before.fault && after.fault))
    .count(
        "fault_starts_before",
        "starts from which an episode is a fault of the old driver",
        starts(|faults| faults.before > 0),
    )
    .count("fault_starts_after", "the same of the new driver", Row::fault_starts_after)
    .count("fault_starts_new", "such starts of the new driver only", starts(StartFaults::is_new))
    .count("fault_starts_fixed", "such starts of the old driver only", starts(StartFaults::is_fixed))
    .count("fault_starts_same", "such starts of both", starts(|faults| faults.before > 0 && faults.after > 0))
    .column(
        number("fault_share_before", "", "share of the starts with a fault of the old driver")
            .with_role(Role::Share)
            .of(|row: &Row| row.share(row.count_starts(|faults| faults.before > 0)?)),
    )
    .column(
        number("fault_share_after", "", "the same of the new driver")
            .with_role(Role::Share)
            .of(|row: &Row| row.share(row.fault_starts_after())),
    )
    .column(
        number("p", "", "probability of such a change of the share by chance: McNemar's exact test over starts")
            .with_role(Role::AdjustedP)
            .of(Row::p),
    )
    .column(
        number("p_holm", "", "the same, adjusted by Holm's method for all rows in which a start differs; else 1")
            .with_role(Role::AdjustedP)
            .of(|row: &Row| row.holm),
    )
    .count(
        "starts_worse",
        "starts from which the new driver's faults weigh more (avoidable injury)",
        starts(StartFaults::is_worse),
    )
    .count("starts_better", "starts from which they weigh less", starts(StartFaults::is_better))
    .column(
        number(
            "p_starts",
            "",
            "probability of a difference at least this large between the numbers of worse and better starts by chance: the exact sign test",
        )
        .with_role(Role::AdjustedP)
        .of(Row::p_starts),
    )
    .measure(
        "avoidable_injury_before",
        "1/1000",
        "expected severe injuries (AIS 4 or more, or death) in the old driver's faults, for 1,000 episodes",
        Row::avoidable_injury_before,
    )
    .measure("avoidable_injury_after", "1/1000", "the same in the new driver's", Row::avoidable_injury_after)
    .measure(
        "avoidable_injury_difference",
        "1/1000",
        "after less before",
        |row| Some(row.avoidable_injury_after()? - row.avoidable_injury_before()?),
    )
    .measure(
        "injury_difference",
        "1/1000",
        "expected severe injuries in all collisions of the new driver, avoidable or not, less the old driver's",
        Row::injury_difference,
    )
    .count(
        "failed_encounters",
        "episodes left out, since a driver failed as a program",
        |row| row.encounters.errors(),
    )
}

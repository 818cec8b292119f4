use polars::prelude::DataFrame;

use crate::jobs::EstimateResult;
use crate::record::columns::{POLICY, TOWN};
use crate::record::{Column, Table};
use world::likelihood::{Estimate, Likelihood};

/// The stem of the files of the table.
pub const ESTIMATES: &str = "estimates";

/// How likely an event is, as a row of the table.
pub struct Row<'a> {
    result: &'a EstimateResult,
    estimate: &'a Estimate,
    likelihood: &'a Likelihood,
}

/// The estimates of a campaign as a table: one row for each event of each estimate that ended.
pub fn estimate_table(results: &[EstimateResult]) -> DataFrame {
    let rows: Vec<Row<'_>> = results
        .iter()
        .filter_map(|result| Some((result, result.estimate.as_ref()?)))
        .flat_map(|(result, estimate)| {
            estimate.likelihoods.iter().map(move |likelihood| Row { result, estimate, likelihood })
        })
        .collect();
    estimate_columns().frame(&rows)
}

/// What a reader must know about an estimate; empty if nothing, and if it failed.
pub fn estimate_doubts(result: &EstimateResult) -> Vec<&'static str> {
    let Some(estimate) = &result.estimate else { return Vec::new() };
    let mut doubts = Vec::new();
    if result.has_program {
        doubts.push("a program draws numbers of its own: over starts, pedestrian and the seeds that it is given");
    }
    if estimate.short {
        doubts.push("error above the wanted");
    }
    doubts
}

/// The columns of [`estimate_table`].
pub fn estimate_columns<'a>() -> Table<'a, Row<'a>> {
    let text = Column::<String>::new;
    let count = Column::<u64>::new;
    let number = Column::<f64>::new;
    let share = |name, doc| number(name, "", doc);
    Table::new(
        ESTIMATES,
        "One row for each event of each estimate: the probability of the event in an encounter with this pedestrian, from a start that the `spawn` draws, among encounters \
         that count.",
    )
    .column(text("estimate", "", "short name of the estimate").of(|row: &Row<'_>| row.result.key.id.to_string()))
    .column(TOWN.of(|row: &Row<'_>| row.result.key.town.clone()))
    .column(POLICY.of(|row: &Row<'_>| row.result.key.policy.clone()))
    .column(text("pedestrian", "", "the pedestrian, who walks by itself").of(|row: &Row<'_>| row.result.key.walker.clone()))
    .column(
        text("requirement", "", "the requirement whose violation is the failure; empty for collisions")
            .of(|row: &Row<'_>| row.result.key.requirement.clone()),
    )
    .column(count("block", "", "number of the `estimate` block in its campaign, from 0").of(|row: &Row<'_>| u64::from(row.result.key.block)))
    .column(count("run", "", "number of the run, from 0").of(|row: &Row<'_>| u64::from(row.result.key.run)))
    .column(
        text("event", "", "`failure`, `preventable` (a careful human would have avoided it) or `fault` (it counts against the driver)")
            .of(|row: &Row<'_>| row.likelihood.event.name().to_string()),
    )
    .column(share("probability", "probability of the event in an encounter").of(|row: &Row<'_>| row.likelihood.probability))
    .column(
        share("probability_low", "low end of its 95 % interval; 0 where the event was never seen")
            .of(|row: &Row<'_>| row.likelihood.low),
    )
    .column(
        share("probability_high", "high end of its 95 % interval; where the event was never seen, the one-sided 95 % bound")
            .of(|row: &Row<'_>| row.likelihood.high),
    )
    .column(
        share("relative_error", "standard error as a fraction of the probability; missing if the event was never seen")
            .of(|row: &Row<'_>| row.likelihood.relative_error),
    )
    .column(count("seen", "", "encounters in which it was seen").of(|row: &Row<'_>| row.likelihood.seen))
    .column(count("encounters", "", "encounters that were simulated").of(|row: &Row<'_>| row.estimate.encounters))
    .column(count("ticks", "", "simulator ticks that were used").of(|row: &Row<'_>| row.estimate.ticks))
    .column(share("counting", "fraction of encounters that count").of(|row: &Row<'_>| row.estimate.counting()))
    .column(
        number("per_hour", "1/h", "events per hour, at the encounters per hour that the scenario states; missing without")
            .of(|row: &Row<'_>| exposed(row, 0)),
    )
    .column(
        number("per_1000_km", "", "events per 1,000 km, at the encounters per 1,000 km that the scenario states; missing without")
            .of(|row: &Row<'_>| exposed(row, 1)),
    )
    .column(
        text("doubts", "", "what a reader must know: a program that draws numbers of its own, an error that was not reached")
            .of(|row: &Row<'_>| estimate_doubts(row.result).join("; ")),
    )
}

fn exposed(row: &Row<'_>, unit: usize) -> Option<f64> {
    row.result.exposure[unit].map(|encounters| encounters * row.likelihood.probability)
}

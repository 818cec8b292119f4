use super::Row;
use crate::record::columns::{DRIVER, RUN, RUN_ID, TOWN};
use crate::record::{Column, Table};
use compile::Estimation;
use search::likelihood::Estimate;

/// What a reader must know about an estimate; empty if nothing.
pub fn doubts(job: &Estimation, estimate: &Estimate) -> Vec<&'static str> {
    let mut doubts = Vec::new();
    if !job.origin.programs.is_empty() {
        doubts.push("a program draws numbers of its own: over starts, pedestrian and the seeds that it is given");
    }
    if estimate.short {
        doubts.push("error above the wanted");
    }
    doubts
}

/// The columns of the table: a row for each event of each estimate that ended.
pub fn columns<'a>() -> Table<'a, Row<'a>> {
    let number = Column::<f64>::new;
    let share = |name, doc| number(name, "", doc);
    Table::<Row<'a>>::new(
        "estimates",
        "One row for each event of each estimate: the probability of the event in an encounter with this pedestrian, from a start that the `spawn` draws, among encounters \
         that count.",
    )
    .column(RUN_ID.of(|row: &Row<'_>| row.job.origin.id.to_string()))
    .column(TOWN.of(|row: &Row<'_>| row.job.town.clone()))
    .column(DRIVER.of(|row: &Row<'_>| row.job.policy.clone()))
    .text("pedestrian", "the pedestrian, who walks by itself", |row| row.job.pedestrian.clone())
    .text(
        "requirement",
        "the requirement whose violation is the failure; empty for collisions",
        |row| row.job.requirement.clone(),
    )
    .column(RUN.of(|row: &Row<'_>| row.job.origin.run))
    .text(
        "event",
        "`failure`, `preventable` (a careful human would have avoided it) or `fault` (it counts against the driver)",
        |row| row.likelihood.event.name().to_string(),
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
    .count("seen", "encounters in which it was seen", |row| row.likelihood.seen)
    .count("encounters", "encounters that were simulated", |row| row.estimate.encounters)
    .column(share("counting", "fraction of encounters that count").of(|row: &Row<'_>| row.estimate.counting()))
    .measure(
        "per_hour",
        "1/h",
        "events per hour, at the encounters per hour that the scenario states; missing without",
        |row| exposed(row, 0),
    )
    .number(
        "per_1000_km",
        "events per 1,000 km, at the encounters per 1,000 km that the scenario states; missing without",
        |row| exposed(row, 1),
    )
    .text(
        "doubts",
        "what a reader must know: a program that draws numbers of its own, an error that was not reached",
        |row| doubts(row.job, row.estimate).join("; "),
    )
}

fn exposed(row: &Row<'_>, unit: usize) -> Option<f64> {
    row.job.exposure[unit].map(|encounters| encounters * row.likelihood.probability)
}

use super::Row;
use crate::record::columns::{DRIVER, RUN, RUN_ID, TOWN};
use crate::record::{Column, Table, entries};
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
    Table::<Row<'a>>::new(
        "estimates",
        "One row for each event of each estimate: the probability of the event in an encounter with this pedestrian, from a start that the `spawn` draws, among encounters \
         that count.",
    )
    .columns(entries! { row: &Row<'_>;
        RUN_ID = row.job.origin.id.to_string();
        TOWN = row.job.town.clone();
        DRIVER = row.job.policy.clone();
        /// the pedestrian, who walks by itself
        pedestrian: String = row.job.pedestrian.clone();
        /// the requirement whose violation is the failure; empty for collisions
        requirement: String = row.job.requirement.clone();
        RUN = row.job.origin.run;
        /// `failure`, `preventable` (a careful human would have avoided it) or `fault` (it counts against the driver)
        event: String = row.likelihood.event.name().to_string();
        /// probability of the event in an encounter
        probability: f64 = row.likelihood.probability;
        /// low end of its 95 % interval; 0 where the event was never seen
        probability_low: f64 = row.likelihood.low;
        /// high end of its 95 % interval; where the event was never seen, the one-sided 95 % bound
        probability_high: f64 = row.likelihood.high;
        /// standard error as a fraction of the probability; missing if the event was never seen
        relative_error: f64 = row.likelihood.relative_error;
        /// encounters in which it was seen
        seen: u64 = row.likelihood.seen;
        /// encounters that were simulated
        encounters: u64 = row.estimate.encounters;
    })
    .column(Column::<f64>::new("counting", "", "fraction of encounters that count").of(|row: &Row<'_>| row.estimate.counting()))
    .columns(entries! { row: &Row<'_>;
        /// events per hour, at the encounters per hour that the scenario states; missing without
        per_hour: f64 ["1/h"] = exposed(row, 0);
        /// events per 1,000 km, at the encounters per 1,000 km that the scenario states; missing without
        per_1000_km: f64 = exposed(row, 1);
        /// what a reader must know: a program that draws numbers of its own, an error that was not reached
        doubts: String = doubts(row.job, row.estimate).join("; ");
    })
}

fn exposed(row: &Row<'_>, unit: usize) -> Option<f64> {
    row.job.exposure[unit].map(|encounters| encounters * row.likelihood.probability)
}

use super::section;
use crate::failure::Failure;
use crate::report::distinct::distinct_failures;
use crate::report::render::{Column, Section, Table, Value, share_of_two};
use crate::report::{DistinctFailure, Findings};
use base::seed::Seed;

/// The listed failures that count against their drivers, each finding once, the worst first.
pub fn shown(found: &Findings<'_>, seed: &Seed) -> Vec<DistinctFailure> {
    let of_driver = |driver: &crate::report::DriverResult| found.gathered.failures.of(&driver.driver.name);
    let violations = found.gathered.failures.violations().iter().map(|(_, failure)| failure);
    let all = found.drivers.iter().flat_map(of_driver).chain(violations).filter(|failure| failure.fault);
    let mut all: Vec<&Failure> = all.collect();
    all.sort_by(|one, other| one.worse_first(other));
    distinct_failures(found, &all, usize::MAX, seed)
}

/// Stands in place of a cause.
const NOT_ASKED: &str = "not asked: the driver is a program, or its failure does not repeat";

/// The distinct failures with their causes.
pub fn findings(found: &Findings<'_>, shown: &[DistinctFailure]) -> Section {
    let row = |finding: &DistinctFailure| {
        let Failure { key, impact_speed, impact, .. } = &finding.failure;
        vec![
            Value::Code(finding.failure.name()),
            Value::from(&key.cell.policy),
            key.cell.place().into(),
            Value::from(finding.failure.finder()),
            Value::from(finding.failure.violation.as_ref().map_or("collision", |violated| &violated.requirement)),
            Value::Number(impact.is_some().then_some(*impact_speed), 1),
            Value::Count(finding.merged as u64),
            finding.commands.map_or_else(|| "–".into(), |[before, now]| format!("{before} → {now}").into()),
            Value::from(finding.cause.as_deref().unwrap_or(NOT_ASKED)),
        ]
    };
    let words = ["failure", "driver", "town", "found by", "what failed"].map(Column::text);
    let numbers = ["impact, m/s", "failures", "commands"].map(Column::number);
    let table = Table {
        head: words.into_iter().chain(numbers).chain([Column::text("cause")]).collect(),
        rows: shown.iter().map(row).collect(),
        ..Table::default()
    };
    let faults: usize = shown.iter().map(|finding| finding.merged).sum();
    let mut lead = vec![
        format!(
            "{faults} failures that count against a driver are listed (the worst of each start, at most 100 a driver). Those of built-in drivers were repeated with as few commands of the pedestrian as 600 runs find; \
             those of a driver that become the same are one finding, named after the worst. {} are left. A cause was tried: the failure ran again with one thing changed.",
            shown.len()
        ),
        "`falsify replay NAME` shows a failure, `falsify failures REPORT --distinct --why` lists these.".into(),
    ];
    if !found.cast_failures.is_empty() {
        lead.push(share_of_two(&found.cast_failures));
    }
    if shown.is_empty() {
        let episodes: u64 = found.cells.iter().map(|cell| u64::from(cell.episodes)).sum();
        lead = vec![format!(
            "No failure counts against a driver. {episodes} episodes were evaluated, beside what searches tried."
        )];
    }
    section("failures", "Failures and their causes", lead, if shown.is_empty() { Vec::new() } else { vec![table] })
}

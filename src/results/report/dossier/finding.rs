use super::section;
use crate::failure::Failure;
use crate::parallel;
use crate::report::Findings;
use crate::report::render::{Column, Section, Table, Value};
use crate::report::replayed::played_failure;
use base::seed::Seed;
use world::cause::{FailureKind, explain, shrink};

/// Maximum number of runs in which a failure is shrunk.
const MAX_RUNS: u32 = 600;

/// Failures that shrink to the same: the worst, how many there are, and why it failed.
pub struct Finding {
    worst: Failure,
    merged: u64,
    /// The number of commands before and after it was shrunk; `None` if it was not repeated.
    commands: Option<[usize; 2]>,
    cause: String,
}

/// The listed failures that count against their drivers, each finding once, the worst first.
pub fn shown(found: &Findings<'_>, seed: &Seed) -> Vec<Finding> {
    let of_driver = |driver: &crate::report::DriverResult| found.gathered.failures.of(&driver.driver.name);
    let violations = found.gathered.failures.violations().iter().map(|(_, failure)| failure);
    let all = found.drivers.iter().flat_map(of_driver).chain(violations).filter(|failure| failure.fault);
    let mut all: Vec<&Failure> = all.collect();
    all.sort_by(|one, other| one.worse_first(other));
    let is_program = |failure: &Failure| {
        found.drivers.iter().any(|each| each.driver.name == failure.key.cell.policy && each.driver.is_external())
    };
    let shrunk = parallel::map(&all, |failure| {
        let (.., repeated) = (!is_program(failure)).then(|| played_failure(&failure.name(), found, seed))??;
        shrink(&repeated.incident()?, MAX_RUNS)
    });
    let mut classes: Vec<Option<(&str, (FailureKind, usize))>> = Vec::new();
    let mut findings: Vec<(Finding, Option<world::cause::Incident>)> = Vec::new();
    for (failure, shrunk) in all.into_iter().zip(shrunk) {
        let class = shrunk.as_ref().map(|shrunk| (failure.key.cell.policy.as_str(), shrunk.class()));
        let known = class.as_ref().and_then(|_| classes.iter().position(|known| *known == class));
        if let Some(place) = known {
            findings[place].0.merged += 1;
            continue;
        }
        classes.push(class);
        let commands = shrunk.as_ref().map(|shrunk| shrunk.counts);
        let finding = Finding { worst: failure.clone(), merged: 1, commands, cause: String::new() };
        findings.push((finding, shrunk.map(|shrunk| shrunk.incident)));
    }
    let causes = parallel::map(&findings, |(_, incident)| Some(explain(incident.as_ref()?, false)?.sentence()));
    let explained = |((finding, _), cause): ((Finding, _), Option<String>)| Finding {
        cause: cause.unwrap_or_else(|| "not asked: the driver is a program, or its failure does not repeat".into()),
        ..finding
    };
    findings.into_iter().zip(causes).map(explained).collect()
}

/// The distinct failures with their causes.
pub fn findings(found: &Findings<'_>, shown: &[Finding]) -> Section {
    let row = |finding: &Finding| {
        let Failure { key, impact_speed, .. } = &finding.worst;
        vec![
            Value::Code(finding.worst.name()),
            Value::from(&key.cell.policy),
            Value::from(&key.cell.town),
            Value::from(finding.worst.finder()),
            Value::from(finding.worst.violation.as_ref().map_or("collision", |violated| &violated.requirement)),
            Value::Number(Some(*impact_speed), 1),
            Value::Count(finding.merged),
            finding.commands.map_or_else(|| "–".into(), |[before, now]| format!("{before} → {now}").into()),
            Value::from(&finding.cause),
        ]
    };
    let words = ["failure", "driver", "town", "found by", "what failed"].map(Column::text);
    let numbers = ["impact, m/s", "failures", "commands"].map(Column::number);
    let table = Table {
        head: words.into_iter().chain(numbers).chain([Column::text("cause")]).collect(),
        rows: shown.iter().map(row).collect(),
        ..Table::default()
    };
    let faults: u64 = shown.iter().map(|finding| finding.merged).sum();
    let mut lead = vec![
        format!(
            "{faults} failures that count against a driver are listed (the worst of each start, at most 100 a driver). Each was repeated with the fewest commands of the pedestrian that keep it; \
             those of a driver that become the same are one finding, named after the worst. {} are left. A cause was tried: the failure ran again with one thing changed.",
            shown.len()
        ),
        "`falsify replay NAME` shows a failure, `falsify failures REPORT --distinct --why` lists these.".into(),
    ];
    if shown.is_empty() {
        let episodes: u64 = found.cells.iter().map(|cell| u64::from(cell.episodes)).sum();
        lead = vec![format!(
            "No failure counts against a driver. {episodes} episodes were evaluated, beside what searches tried."
        )];
    }
    section("failures", "Failures and their causes", lead, if shown.is_empty() { Vec::new() } else { vec![table] })
}

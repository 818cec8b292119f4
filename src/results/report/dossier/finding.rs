use super::section;
use crate::failure::Failure;
use crate::report::distinct::{MAX_OF_PROGRAMS, distinct_failures};
use crate::report::render::{Section, Selection, Value, place, share_of_two, who};
use crate::report::{DistinctFailure, DriverResult, Findings};
use crate::tables::metrics::{EPISODES, FAULT_RATE};
use base::seed::Seed;
use verdict::cause::{Cause, MAX_RUNS_OF_PROGRAM};

/// The listed failures that count against their drivers, each finding once, the worst first.
pub fn shown(found: &Findings<'_>, seed: &Seed) -> Vec<DistinctFailure> {
    let of_driver = |driver: &crate::report::DriverResult| found.gathered.failures.of(&driver.driver.name);
    let violations = found.gathered.failures.violations();
    let all = found.drivers.iter().flat_map(of_driver).chain(violations).filter(|failure| failure.fault);
    let mut all: Vec<&Failure> = all.collect();
    all.sort_by(|one, other| one.worse_first(other));
    distinct_failures(found, &all, usize::MAX, seed)
}

/// What stands in place of a cause that is missing.
fn no_cause(finding: &DistinctFailure) -> String {
    let Failure { key, .. } = &finding.failure;
    let command = format!("`falsify replay --why --allow-external {}`", finding.failure.name());
    match () {
        () if finding.is_asked || finding.commands.is_some() => "none: the failure does not repeat".into(),
        () if key.cell.is_elsewhere() => format!("not asked, since it happened in another simulator: {command}"),
        () => format!("not asked, since the driver is a program: {command}"),
    }
}

/// What was found about each driver, in two sentences: how often it has faults with its worst failure, and the most frequent cause of those that are shown.
pub fn bottom_lines(found: &Findings<'_>, shown: &[DistinctFailure]) -> Vec<String> {
    let line = |result: &DriverResult| {
        let name = &result.driver.name;
        let rate = match (result.cell.map(|cell| &found.cells[cell]), result.searched) {
            (Some(cell), _) => format!(
                "fault rate {} with {} in {}, where it is highest",
                Value::share(cell, &FAULT_RATE),
                who(cell, &found.cells),
                place(cell, &found.cells)
            ),
            (None, Some(searched)) => {
                format!("{} of {} episodes of searches are faults", searched.fault, searched.episodes)
            }
            (None, None) => "not evaluated".into(),
        };
        let named = result.worst.as_ref().map_or_else(String::new, |worst| format!(" (`{}`)", worst.name()));
        let own = || shown.iter().filter(|finding| finding.failure.key.cell.policy == *name);
        let mut causes: Vec<(&Cause, String, usize)> = Vec::new();
        for finding in own() {
            let Some(cause) = &finding.cause else { continue };
            match causes.iter_mut().find(|(known, ..)| known.weakness == cause.weakness) {
                Some((.., count)) => *count += finding.merged,
                None => causes.push((cause, finding.failure.name(), finding.merged)),
            }
        }
        // Of equal ones that of the worst failure.
        causes.reverse();
        let all: usize = own().map(|finding| finding.merged).sum();
        let cause = match causes.into_iter().max_by_key(|(.., count)| *count) {
            Some((cause, name, count)) => format!(
                "The most frequent cause, of {count} of the {all} listed failures (one of each start) that count against it, in the words of `{name}`: {}.",
                cause.why()
            ),
            None if all == 0 => "No listed failure counts against it.".into(),
            None => format!("No cause is known of the {all} listed failures that count against it."),
        };
        format!("**{name}**: {rate}; worst failure: {}{named}. {cause}", result.worst_in_words())
    };
    let road = "No rate or count of this page is a probability on the road.".into();
    found.drivers.iter().map(line).chain([road]).collect()
}

/// The distinct failures with their causes.
pub fn findings(found: &Findings<'_>, shown: &[DistinctFailure]) -> Section {
    let selection = Selection::new()
        .text("failure", |finding: &DistinctFailure| Value::code(finding.failure.name()))
        .text("driver", |finding| finding.failure.key.cell.policy.clone())
        .text("town", |finding| finding.failure.key.cell.place())
        .text("found by", |finding| finding.failure.finder())
        .text("what failed", |finding| {
            let violation = finding.failure.violation.as_ref();
            violation.map_or("collision".into(), |violated| violated.requirement.clone())
        })
        .number("impact, m/s", |DistinctFailure { failure, .. }| {
            Value::number(failure.impact.is_some().then_some(failure.impact_speed), 1)
        })
        .number("failures", |finding| finding.merged)
        .number("commands", |finding| finding.commands.map(|[before, now]| format!("{before} → {now}")))
        .text("cause", |finding| finding.cause.as_ref().map_or_else(|| no_cause(finding), Cause::sentence));
    let table = selection.table(shown);
    let faults: usize = shown.iter().map(|finding| finding.merged).sum();
    let mut lead = vec![
        format!(
            "Listed failures that count against a driver: {faults} (the worst of each start, at most 100 a driver). Those of built-in drivers were repeated with as few commands of the pedestrian as 600 runs find; \
             those of a driver that become the same are one finding, named after the worst: {} below. A cause is that of the failure named, as it was recorded: it ran again with one thing changed. Of failures of programs the {} worst of different kinds were asked, with at most {} runs each.",
            shown.len(),
            MAX_OF_PROGRAMS,
            MAX_RUNS_OF_PROGRAM
        ),
        "`falsify replay NAME` shows a failure, `falsify failures REPORT --distinct --why` lists these.".into(),
    ];
    if !found.cast_failures.is_empty() {
        lead.push(share_of_two(&found.cast_failures));
    }
    if shown.is_empty() {
        let episodes: u64 = found.cells.iter().map(|cell| u64::from(cell.count(&EPISODES))).sum();
        lead = vec![format!(
            "No failure counts against a driver. {episodes} episodes were evaluated, beside what searches tried."
        )];
    }
    section("failures", "Failures and their causes", lead, if shown.is_empty() { Vec::new() } else { vec![table] })
}

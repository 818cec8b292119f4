//! What a comparison of two sides found.

use super::change_report::{ChangeReport, ChangeSection};
use super::table::{Column, Table, Value};
use crate::report::{Changed, ComparedCell, ComparedSearch, FailureChange, Figure, ReportComparison};
use base::statistics::mcnemar;

/// Maximum number of kinds in a table.
const MAX_KINDS: usize = 20;

/// The result of a comparison.
pub fn comparison_report(comparison: &ReportComparison) -> ChangeReport {
    let [before, after] = &comparison.folders;
    let mut sections: Vec<ChangeSection> = Vec::new();
    sections.extend(comparison.cells.iter().map(|cell| ChangeSection {
        heading: format!("{}: {}", cell.title(), common_starts(cell)),
        tables: Vec::from_iter((!cell.figures.is_empty()).then(|| rates(cell))),
        ..ChangeSection::default()
    }));
    if !comparison.changes.is_empty() {
        let mut failures = ChangeSection {
            heading: "failures".into(),
            tables: vec![counts(comparison, "verdict"), counts(comparison, "kind")],
            changes: comparison.changes.clone(),
            ..ChangeSection::default()
        };
        if let Some(worst) = FailureChange::worst(&comparison.changes, 1).first() {
            let [one, other] = &worst.sides;
            let (before, after) = (before.join(&one.name), after.join(&other.name));
            failures.paragraphs.push(format!(
                "falsify export --as animation {} {} draws the worst",
                after.display(),
                before.display()
            ));
        }
        sections.push(failures);
    }
    if !comparison.searches.is_empty() {
        sections.push(ChangeSection {
            heading: "searches, over the starts that both tried".into(),
            paragraphs: vec![
                "Share of these starts from which a fault was found. A search goes where its driver fails, so a start that is fixed was not proved safe."
                    .into(),
            ],
            tables: vec![searches(comparison)],
            changes: comparison.searches.iter().flat_map(|search| search.changes.clone()).collect(),
        });
    }
    ChangeReport {
        sides: [before, after].map(|folder| folder.display().to_string()),
        notes: comparison.caveats.iter().map(ToString::to_string).collect(),
        lead: std::iter::once(headline(comparison)).chain(power(comparison)).collect(),
        sections,
    }
}

/// The number of episodes that are compared.
fn common_starts(cell: &ComparedCell) -> String {
    match cell.runs {
        1 => format!("{} common starts", cell.starts),
        runs => format!("{} pairs of episodes with common starts, over {runs} runs", cell.starts),
    }
}

/// How many failures are new, fixed and the same, and how many fault ones: a collision on both sides can be fault on one.
fn headline(comparison: &ReportComparison) -> String {
    let part = |of: fn(&ComparedCell) -> Changed| {
        let sum = |part: fn(Changed) -> u64| comparison.cells.iter().map(|cell| part(of(cell))).sum::<u64>();
        format!("{} new, {} fixed, {} same", sum(|all| all.new), sum(|all| all.fixed), sum(|all| all.same))
    };
    let mut line = format!("Failures: {}; fault: {}", part(|cell| cell.collisions), part(|cell| cell.fault));
    for (name, Changed { new, fixed, same }) in comparison.violations() {
        line.push_str(&format!("; violations of {name}: {new} new, {fixed} fixed, {same} same"));
    }
    line
}

/// How many starts must differ for a difference of single runs to show; `None` without one.
fn power(comparison: &ReportComparison) -> Option<String> {
    let single = || comparison.cells.iter().filter(|cell| cell.runs == 1 && cell.starts > 0);
    let tests = comparison.cells.iter().flat_map(|cell| &cell.figures).filter(|figure| figure.holm.is_some()).count();
    let least = single().map(|cell| cell.starts).min().filter(|_| tests > 0)?;
    let needed = (1..).find(|starts| tests as f64 * mcnemar(0, *starts) < 0.05)?;
    let few = if least < needed { format!("; with {least} common starts none can show") } else { String::new() };
    Some(format!(
        "A difference shows (p below 0.05) from {needed} starts on that fail on one side only, with none on the other{few}."
    ))
}

/// The rates of a cell on both sides.
fn rates(cell: &ComparedCell) -> Table {
    let mut head = vec![Column::text("rate")];
    head.extend(["before", "after", "difference (95 %)", "p (Holm)", "new", "fixed"].map(Column::number));
    let row = |figure: Figure| {
        let found = cell.figure(figure)?;
        let changed = match figure {
            Figure::Collision => Some(cell.collisions),
            Figure::Preventable => Some(cell.preventable),
            Figure::Fault => Some(cell.fault),
            Figure::Touch | Figure::Front | Figure::Reward | Figure::Length | Figure::ImpactSpeed => None,
        };
        let count = |count: Option<u64>| count.map_or(Value::Text(String::new()), Value::Count);
        Some(vec![
            Value::Text(figure.name().trim_end_matches("_rate").into()),
            Value::Number(Some(found.values[1]), 3),
            Value::Number(Some(found.values[0]), 3),
            difference(found.difference, found.interval, &found.by_run[0]),
            Value::Text(found.holm.map_or("–".into(), p)),
            count(changed.map(|changed| changed.new)),
            count(changed.map(|changed| changed.fixed)),
        ])
    };
    Table { head, rows: Figure::COMPARED.into_iter().filter_map(row).collect(), ..Table::default() }
}

/// A difference with its interval; without one that of each run, if there are several.
fn difference(value: f64, interval: Option<(f64, f64)>, by_run: &[f64]) -> Value {
    match interval {
        Some((low, high)) => Value::Text(format!("{value:+.3} ({low:+.3}..{high:+.3})")),
        None if by_run.len() > 1 => Value::Runs(by_run.to_vec(), 3, true),
        None => Value::Text(format!("{value:+.3}")),
    }
}

/// A probability.
pub fn p(value: f64) -> String {
    if value < 0.001 { "<0.001".into() } else { format!("{value:.3}") }
}

/// Failures by verdict or by kind.
fn counts(comparison: &ReportComparison, by: &'static str) -> Table {
    let counts = comparison.counts(|found| match by {
        "verdict" => found.verdict.to_owned(),
        _ => found.kind.clone(),
    });
    let mut rows: Vec<_> = counts.into_iter().collect();
    rows.sort_by_key(|(_, changed)| std::cmp::Reverse(changed.new + changed.fixed + changed.same));
    let mut head = vec![Column::text(by)];
    head.extend(["before", "after", "new", "fixed", "same"].map(Column::number));
    let row = |(name, changed): (String, Changed)| {
        let mut row = vec![Value::Text(name)];
        let sums = [changed.fixed + changed.same, changed.new + changed.same, changed.new, changed.fixed, changed.same];
        row.extend(sums.map(Value::Count));
        row
    };
    Table { head, rows: rows.into_iter().take(MAX_KINDS).map(row).collect(), ..Table::default() }
}

/// The searches of both sides over the starts that both tried.
fn searches(comparison: &ReportComparison) -> Table {
    let mut head = vec![Column::text("search")];
    head.extend(["starts", "before", "after", "difference (95 %)", "p (Holm)", "new", "fixed"].map(Column::number));
    let row = |search: &ComparedSearch| {
        vec![
            Value::Text(search.title()),
            Value::Count(search.starts),
            Value::Number(Some(search.shares[0]), 3),
            Value::Number(Some(search.shares[1]), 3),
            difference(search.difference(), search.interval, &search.differences),
            Value::Text(search.holm.map_or("–".into(), p)),
            Value::Count(search.fault.new),
            Value::Count(search.fault.fixed),
        ]
    };
    Table { head, rows: comparison.searches.iter().map(row).collect(), ..Table::default() }
}

//! A comparison of two sides as tables, for a terminal and for a page.

use super::table::{Column, Table, Value};
use crate::record::CellKey;
use crate::report::{Changed, ComparedCell, FailureChange, FailureOrder, Figure, ReportComparison};

/// Most kinds that a terminal shows.
const KINDS: usize = 12;

/// The text for a terminal. `shown` is the number of failures in each list.
pub fn comparison_for_terminal(comparison: &ReportComparison, shown: usize) -> String {
    let [before, after] = &comparison.folders;
    let mut text = format!("before  {}\nafter   {}\n", before.display(), after.display());
    comparison.caveats.iter().for_each(|caveat| text.push_str(&format!("note    {caveat}\n")));
    for cell in &comparison.cells {
        text.push_str(&format!("\n{}: {} common starts\n", title(cell), cell.starts));
        if !cell.figures.is_empty() {
            text.push_str(&rates(cell).to_terminal());
        }
    }
    text.push_str(&format!("\n{}\n", headline(comparison)));
    if !comparison.changes.is_empty() {
        text.push_str(&counts(comparison, "verdict", usize::MAX).to_terminal());
        text.push_str(&counts(comparison, "kind", KINDS).to_terminal());
    }
    for word in ["new", "fixed", "same"] {
        let all = changes(comparison, word);
        if all.is_empty() {
            continue;
        }
        text.push_str(&format!("\n{word}: {}, the worst first\n", all.len()));
        text.push_str(&list(&all[..all.len().min(shown)]).to_terminal());
    }
    if let Some(worst) = changes(comparison, "new").first() {
        let [one, other] = &worst.sides;
        text.push_str(&format!(
            "\nfalsify render --animate {} {}\n",
            after.join(&other.name).display(),
            before.join(&one.name).display()
        ));
    }
    text
}

/// The place, the controller and the drivers of a cell.
pub fn title(cell: &ComparedCell) -> String {
    let [before, after] = &cell.keys;
    let driver = |key: &CellKey| key.policy.clone();
    let drivers = if before.policy == after.policy {
        driver(before)
    } else {
        format!("{} and {}", driver(before), driver(after))
    };
    let who = if before.is_trained() { before.who() } else { before.controller.clone() };
    format!("{drivers} in {}, {who}", before.town)
}

/// How many failures are new, fixed and the same, and how many attributable ones: a collision on both sides can be attributable on one.
pub fn headline(comparison: &ReportComparison) -> String {
    let part = |of: fn(&ComparedCell) -> Changed| {
        let sum = |part: fn(Changed) -> u64| comparison.cells.iter().map(|cell| part(of(cell))).sum::<u64>();
        format!("{} new, {} fixed, {} same", sum(|all| all.new), sum(|all| all.fixed), sum(|all| all.same))
    };
    format!("failures: {}; attributable: {}", part(|cell| cell.collisions), part(|cell| cell.attributable))
}

/// The rates of a cell on both sides.
pub fn rates(cell: &ComparedCell) -> Table {
    let mut head = vec![Column::text("rate")];
    head.extend(["before", "after", "difference (95 %)", "p (Holm)", "new", "fixed"].map(Column::number));
    let row = |figure: Figure| {
        let found = cell.figure(figure)?;
        let changed = match figure {
            Figure::Collision => Some(cell.collisions),
            Figure::Preventable => Some(cell.preventable),
            Figure::Attributable => Some(cell.attributable),
            Figure::Front | Figure::Moving | Figure::Reward | Figure::Length | Figure::ImpactSpeed => None,
        };
        let count = |count: Option<u64>| count.map_or(Value::Text(String::new()), Value::Count);
        Some(vec![
            Value::Text(figure.name().trim_end_matches("_rate").into()),
            Value::Number(Some(found.values[1]), 3),
            Value::Number(Some(found.values[0]), 3),
            Value::Text(difference(found.difference, found.interval())),
            Value::Text(found.holm.map_or("–".into(), p)),
            count(changed.map(|changed| changed.new)),
            count(changed.map(|changed| changed.fixed)),
        ])
    };
    Table { head, rows: Figure::COMPARED.into_iter().filter_map(row).collect(), ..Table::default() }
}

fn difference(value: f64, (low, high): (f64, f64)) -> String {
    format!("{value:+.3} ({low:+.3}..{high:+.3})")
}

fn p(value: f64) -> String {
    if value < 0.001 { "<0.001".into() } else { format!("{value:.3}") }
}

/// Failures by verdict or by kind.
pub fn counts(comparison: &ReportComparison, by: &'static str, most: usize) -> Table {
    let counts = comparison.counts(|failure| match by {
        "verdict" => failure.verdict_name().replace('_', " "),
        _ => failure.kind(),
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
    Table { head, rows: rows.into_iter().take(most).map(row).collect(), ..Table::default() }
}

/// The changes of a word, those that count most against the driver first.
pub fn changes<'a>(comparison: &'a ReportComparison, word: &str) -> Vec<&'a FailureChange> {
    let mut found: Vec<&FailureChange> = comparison.changes.iter().filter(|change| change.word() == word).collect();
    found.sort_by(|a, b| FailureOrder::Severity.compare(a.failure(), b.failure()));
    found
}

/// The worst new changes, then the worst fixed ones, at most this number; new ones take at least half if there are that many.
pub fn worst_changes(comparison: &ReportComparison, most: usize) -> Vec<&FailureChange> {
    let (new, fixed) = (changes(comparison, "new"), changes(comparison, "fixed"));
    let of_fixed = fixed.len().min(most / 2).max(most.saturating_sub(new.len()).min(fixed.len()));
    new.into_iter().take(most - of_fixed).chain(fixed.into_iter().take(of_fixed)).collect()
}

/// Changes with the names of both episodes.
pub fn list(changes: &[&FailureChange]) -> Table {
    let mut head = vec![Column::text("after"), Column::text("before"), Column::text("verdict"), Column::number("m/s")];
    head.extend(["driver", "kind"].map(Column::text));
    let row = |change: &&FailureChange| {
        let (failure, [before, after]) = (change.failure(), &change.sides);
        vec![
            Value::Code(after.name.clone()),
            Value::Code(before.name.clone()),
            failure.verdict_text().into(),
            Value::Number(Some(failure.impact_speed), 1),
            failure.policy.clone().into(),
            failure.kind().into(),
        ]
    };
    Table { head, rows: changes.iter().map(row).collect(), ..Table::default() }
}

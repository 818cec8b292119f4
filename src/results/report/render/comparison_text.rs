//! A comparison of two sides as tables, for a terminal and for a page.

use super::table::{Column, Table, Value};
use crate::report::{
    Changed, ComparedCell, ComparedSearch, FailureChange, FailureOrder, Figure, ListedFailure, ReportComparison,
    SideEpisode, StartChange,
};
use base::statistics::mcnemar;

/// Most kinds that a terminal shows.
const KINDS: usize = 12;

/// The text for a terminal of this width (columns). `shown` is the number of failures in each list.
pub fn comparison_for_terminal(comparison: &ReportComparison, shown: usize, width: u16) -> String {
    let [before, after] = &comparison.folders;
    let mut text = format!("before  {}\nafter   {}\n", before.display(), after.display());
    comparison.caveats.iter().for_each(|caveat| text.push_str(&format!("note    {caveat}\n")));
    for cell in &comparison.cells {
        text.push_str(&format!("\n{}: {}\n", title(cell), common_starts(cell)));
        if !cell.figures.is_empty() {
            text.push_str(&rates(cell).to_terminal(width));
        }
    }
    text.push_str(&format!("\n{}\n", headline(comparison)));
    if let Some(power) = power(comparison) {
        text.push_str(&format!("{power}\n"));
    }
    if !comparison.changes.is_empty() {
        text.push_str(&counts(comparison, "verdict", usize::MAX).to_terminal(width));
        text.push_str(&counts(comparison, "kind", KINDS).to_terminal(width));
    }
    for word in FailureChange::WORDS {
        let all = changes(comparison, word);
        if all.is_empty() {
            continue;
        }
        text.push_str(&format!("\n{}: {}, the worst first\n", change_title(word), all.len()));
        text.push_str(&list(&all[..all.len().min(shown)]).to_terminal(width));
    }
    if !comparison.searches.is_empty() {
        text.push_str("\nsearches: starts from which a fault was found\n");
        text.push_str(&searches(comparison).to_terminal(width));
    }
    for word in ["new", "fixed"] {
        let all = start_changes(comparison, word);
        if !all.is_empty() {
            text.push_str(&format!("\n{word} starts of searches: {}, the worst first\n", all.len()));
            text.push_str(&start_list(&all[..all.len().min(shown)]).to_terminal(width));
        }
    }
    if let Some(worst) = worst_changes(comparison, 1).first() {
        let [one, other] = &worst.sides;
        text.push_str(&format!(
            "\nfalsify export --as animation {} {}\n",
            after.join(&other.name).display(),
            before.join(&one.name).display()
        ));
    }
    text
}

/// The number of episodes that are compared.
pub fn common_starts(cell: &ComparedCell) -> String {
    match cell.runs {
        1 => format!("{} common starts", cell.starts),
        runs => format!("{} pairs of episodes with common starts, over {runs} runs", cell.starts),
    }
}

/// A word of a change, explained where it does not explain itself.
pub fn change_title(word: &str) -> String {
    match word {
        "worse" => "worse, a collision on both sides that is a fault only after".into(),
        "better" => "better, a collision on both sides that was a fault only before".into(),
        word => word.into(),
    }
}

/// The place, the controller and the drivers of a cell.
pub fn title(cell: &ComparedCell) -> String {
    let before = &cell.keys[0];
    let drivers = drivers(&cell.keys.each_ref().map(|key| key.policy.clone()));
    let who = if before.is_of_reward() { before.who() } else { before.controller.clone() };
    format!("{drivers} in {}, {who}", before.town)
}

/// How many failures are new, fixed and the same, and how many fault ones: a collision on both sides can be fault on one.
pub fn headline(comparison: &ReportComparison) -> String {
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

/// How many starts must differ for a difference of single runs to show; none without one.
pub fn power(comparison: &ReportComparison) -> Option<String> {
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
pub fn rates(cell: &ComparedCell) -> Table {
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

fn p(value: f64) -> String {
    if value < 0.001 { "<0.001".into() } else { format!("{value:.3}") }
}

/// Failures by verdict or by kind.
pub fn counts(comparison: &ReportComparison, by: &'static str, most: usize) -> Table {
    let counts = comparison.counts(|failure| match by {
        "verdict" => failure.word().to_owned(),
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

/// The falsifier, the drivers and the town of a search.
pub fn search_title(search: &ComparedSearch) -> String {
    format!("{} against {} in {}", search.falsifier, drivers(&search.policies), search.town)
}

/// The driver of both sides, or both drivers.
fn drivers([before, after]: &[String; 2]) -> String {
    if before == after { before.clone() } else { format!("{before} and {after}") }
}

/// The searches of both sides over the starts that both tried.
pub fn searches(comparison: &ReportComparison) -> Table {
    let mut head = vec![Column::text("search")];
    head.extend(["starts", "before", "after", "difference (95 %)", "p (Holm)", "new", "fixed"].map(Column::number));
    let row = |search: &ComparedSearch| {
        vec![
            Value::Text(search_title(search)),
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

/// The starts of searches with a fault on one side only, as a word says, those that count most against the driver first.
pub fn start_changes<'a>(comparison: &'a ReportComparison, word: &str) -> Vec<(&'a ComparedSearch, &'a StartChange)> {
    let all = comparison.searches.iter().flat_map(|search| search.changes.iter().map(move |change| (search, change)));
    let mut found: Vec<_> = all.filter(|(_, change)| change.word(|failure| failure.fault) == Some(word)).collect();
    found.sort_by(|(_, a), (_, b)| {
        let worst = |change: &'a StartChange| fault(change).expect("it is of this word");
        FailureOrder::Severity.compare(worst(a), worst(b))
    });
    found
}

/// The fault of a start: that of the second side, or else of the first.
fn fault(change: &StartChange) -> Option<&ListedFailure> {
    change.sides.iter().rev().flatten().find(|failure| failure.fault)
}

/// Starts of searches, each with the name of its failure.
pub fn start_list(changes: &[(&ComparedSearch, &StartChange)]) -> Table {
    let mut head = vec![Column::text("failure"), Column::number("start"), Column::number("m/s")];
    head.extend(["driver", "falsifier", "kind"].map(Column::text));
    let row = |(search, change): &(&ComparedSearch, &StartChange)| {
        let failure = fault(change)?;
        Some(vec![
            Value::Code(failure.name()),
            Value::Count(change.start),
            Value::Number(Some(failure.impact_speed), 1),
            failure.policy.clone().into(),
            search.falsifier.clone().into(),
            failure.kind().into(),
        ])
    };
    Table { head, rows: changes.iter().filter_map(row).collect(), ..Table::default() }
}

/// The worst new and worse changes, then the worst fixed and better ones, at most this number; those against the second side take at least half if
/// there are that many.
pub fn worst_changes(comparison: &ReportComparison, most: usize) -> Vec<&FailureChange> {
    let of = |words: [&str; 2]| words.into_iter().flat_map(|word| changes(comparison, word)).collect::<Vec<_>>();
    let (new, fixed) = (of(["new", "worse"]), of(["fixed", "better"]));
    let of_fixed = fixed.len().min(most / 2).max(most.saturating_sub(new.len()).min(fixed.len()));
    new.into_iter().take(most - of_fixed).chain(fixed.into_iter().take(of_fixed)).collect()
}

/// Changes with the names of both episodes.
pub fn list(changes: &[&FailureChange]) -> Table {
    let mut head = vec![Column::text("after"), Column::text("before"), Column::text("verdict")];
    head.extend(["m/s before", "m/s after"].map(Column::number));
    head.extend(["driver", "kind"].map(Column::text));
    let row = |change: &&FailureChange| {
        let (failure, [before, after]) = (change.failure(), &change.sides);
        let speed = |side: &SideEpisode| Value::Number(side.failure.as_ref().map(|failure| failure.impact_speed), 1);
        vec![
            Value::Code(after.name.clone()),
            Value::Code(before.name.clone()),
            change.verdict().into(),
            speed(before),
            speed(after),
            failure.policy.clone().into(),
            failure.kind().into(),
        ]
    };
    Table { head, rows: changes.iter().map(row).collect(), ..Table::default() }
}

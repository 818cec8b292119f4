//! What a comparison of two sides found.

use super::change_report::{ChangeReport, ChangeSection, without};
use super::table::{Column, Table, Value};
use crate::report::compare::drivers;
use crate::report::{ComparedCell, ComparedSearch, CountedEvent, FailureChange, PairedRate, ReportComparison};
use crate::tables::Changed;
use crate::tables::metrics::{ANSWER, COLLISION_RATE, FAULT_RATE};
use base::statistics::{clopper_pearson, mcnemar};

/// The probability with which a change is to show.
const POWER: f64 = 0.8;
/// Maximum number of kinds in a table.
const MAX_KINDS: usize = 20;
/// What the figures of rates are.
const LEGEND: &str = "p decides: the interval is of another method, and may hold 0 where p is below 0.05. Worse: a collision of both sides that \
                      is worse on this one.";
/// The same of requirements.
const LEGEND_OF_REQUIREMENTS: &str =
    " Rates of requirements are of all common starts, also of those in which the requirement did not apply.";

/// The result of a comparison.
pub fn comparison_report(comparison: &ReportComparison) -> ChangeReport {
    let subject = subject(comparison);
    let mut sections: Vec<ChangeSection> = Vec::new();
    sections.extend(comparison.cells.iter().map(|cell| ChangeSection {
        heading: format!("{}: {}", without(&subject, &cell.title()), common_starts(cell)),
        tables: Vec::from_iter((!cell.rates.is_empty()).then(|| rates(&comparison.events, cell))),
        is_unchanged: is_unchanged(cell),
        ..ChangeSection::default()
    }));
    if let Some(first) = sections.iter_mut().find(|section| !section.tables.is_empty() && !section.is_unchanged) {
        let is_of_requirements = comparison.events.iter().any(CountedEvent::is_violation);
        let of_requirements = if is_of_requirements { LEGEND_OF_REQUIREMENTS } else { "" };
        first.paragraphs.push(format!("{LEGEND}{of_requirements}"));
    }
    sections.extend((!comparison.changes.is_empty()).then(|| failures(comparison)));
    if !comparison.searches.is_empty() {
        sections.push(ChangeSection {
            heading: "searches, over the starts that both tried".into(),
            is_unchanged: false,
            paragraphs: vec![
                "Share of these starts from which a fault was found. A search goes where its driver fails, so a start that is fixed was not proved safe."
                    .into(),
            ],
            tables: vec![searches(comparison)],
            changes: comparison.searches.iter().flat_map(|search| search.changes.clone()).collect(),
        });
    }
    ChangeReport {
        sides: sides(comparison),
        subject,
        notes: comparison.caveats.iter().map(ToString::to_string).collect(),
        lead: [answer(comparison), headline(comparison)]
            .into_iter()
            .chain(apart(comparison))
            .chain(comparison.prices.iter().map(|(price, _)| format!("{price}.")))
            .chain(power(comparison))
            .collect(),
        sections,
    }
}

/// The failures of both sides.
fn failures(comparison: &ReportComparison) -> ChangeSection {
    let [before, after] = &comparison.folders;
    let mut failures = ChangeSection {
        heading: "failures".into(),
        tables: vec![counts(comparison, "verdict"), counts(comparison, "kind")],
        changes: comparison.changes.clone(),
        ..ChangeSection::default()
    };
    let harder = comparison.changes.iter().filter(|change| change.is_faster_and_milder()).count();
    if harder > 0 {
        failures.paragraphs.push(format!(
                "Collisions of both that are faster after and have a milder verdict: {harder}. A faster car leaves less time, so that is no improvement."
            ));
    }
    if let Some(worst) = FailureChange::worst(&comparison.changes, 1).first() {
        let [one, other] = &worst.sides;
        let (before, after) = (before.join(&one.name), after.join(&other.name));
        failures.paragraphs.push(format!(
            "falsify export --as animation {} {} draws the worst",
            after.display(),
            before.display()
        ));
    }
    failures
}

/// The drivers of all rows; empty if they differ.
fn subject(comparison: &ReportComparison) -> String {
    let cells = comparison.cells.iter().map(|cell| drivers(&cell.keys.each_ref().map(|key| key.policy.clone())));
    let mut all = cells.chain(comparison.searches.iter().map(|search| drivers(&search.policies)));
    let first = all.next().unwrap_or_default();
    if all.all(|other| other == first) { first } else { String::new() }
}

/// The reports, and what differs where they are one.
fn sides(comparison: &ReportComparison) -> [String; 2] {
    let keys =
        comparison.cells.first().filter(|_| comparison.folders[0] == comparison.folders[1]).map(|cell| &cell.keys);
    std::array::from_fn(|side| {
        let folder = comparison.folders[side].display();
        match keys {
            Some(keys) if keys[0].policy != keys[1].policy => format!("{folder}: {}", keys[side].policy),
            Some(keys) if keys[0].world != keys[1].world => format!("{folder}: {}", keys[side].simulator()),
            _ => folder.to_string(),
        }
    })
}

/// The rows without a common start.
fn apart(comparison: &ReportComparison) -> Option<String> {
    let apart: Vec<String> = comparison.cells.iter().filter(|cell| cell.starts == 0).map(ComparedCell::title).collect();
    (!apart.is_empty()).then(|| {
        format!(
            "Not compared, since no episode that counts has an equal start on the other side: {}.",
            apart.join("; ")
        )
    })
}

/// Whether a cell was compared, and nothing that is counted is new or fixed.
fn is_unchanged(cell: &ComparedCell) -> bool {
    let mut rates = cell.rates.iter().flatten();
    cell.starts > 0 && !cell.rates.is_empty() && rates.all(|rate| rate.changed.new + rate.changed.fixed == 0)
}

/// The number of episodes that are compared.
fn common_starts(cell: &ComparedCell) -> String {
    let same = if cell.starts > 0 && cell.differing == 0 { ", all of them the same episodes" } else { "" };
    match cell.runs {
        _ if cell.is_pooled() => format!("{} common starts{same}", cell.starts),
        1 => format!("{} common starts{same}", cell.starts),
        runs => format!("{} pairs of episodes with common starts, over {runs} runs{same}", cell.starts),
    }
}

/// What is shown to differ: by faults, those of searches too, and by collisions. Rows of several pedestrians count, or each pedestrian where there is one.
struct Shown {
    /// Whether all common starts end in the same episodes.
    is_same: bool,
    /// What is less after, and what is more.
    fewer: Vec<String>,
    more: Vec<String>,
}

/// Whether the driver after is better.
fn answer(comparison: &ReportComparison) -> String {
    let Shown { is_same, fewer, more } = shown(comparison);
    let names: Vec<[&str; 2]> =
        comparison.cells.iter().map(|cell| cell.keys.each_ref().map(|key| &*key.policy)).collect();
    let who = Compared::of(&names);
    match [fewer.is_empty(), more.is_empty()].map(|is_none| !is_none) {
        _ if is_same => "Nothing changed: all common starts end in the same episodes.".into(),
        [false, false] => "No difference in faults or collisions is shown.".into(),
        shown => {
            let costs = comparison.prices.iter().any(|(_, costs)| *costs);
            format!("{}: {}.", who.verdict(shown, costs), [fewer, more].concat().join(", "))
        }
    }
}

/// The answer of a comparison in which the driver after is shown to be worse, in part or as a whole.
pub fn worsening(comparison: &ReportComparison) -> Option<String> {
    (!shown(comparison).more.is_empty()).then(|| answer(comparison))
}

fn shown(comparison: &ReportComparison) -> Shown {
    let is_pooled_too = |cell: &ComparedCell| {
        let keys = |other: &ComparedCell| other.keys.each_ref().map(|key| key.policy.clone());
        comparison.cells.iter().any(|other| other.is_pooled() && keys(other) == keys(cell))
    };
    let cells =
        comparison.cells.iter().filter(|cell| cell.is_pooled() || cell.keys[0].is_of_reward() || !is_pooled_too(cell));
    let cells: Vec<&ComparedCell> = cells.collect();
    let mut weighed = ANSWER.map(|(metric, what)| {
        let place = comparison.events.iter().position(|event| event.requirement.is_none() && event.figure == metric);
        let rates = cells.iter().filter_map(|cell| cell.rates.get(place?)?.as_ref());
        (rates.collect::<Vec<&PairedRate>>(), what)
    });
    let is_same = weighed.iter().flat_map(|(rates, _)| rates).all(|rate| rate.is_unchanged);
    let searches = || comparison.searches.iter().map(|each| &each.found);
    // Of a row without a common start nothing is known.
    let is_whole = comparison.cells.iter().all(|cell| cell.starts > 0);
    let is_same = is_same && is_whole && !weighed[0].0.is_empty() && searches().all(|rate| rate.changed.is_same());
    weighed[0].0.extend(searches());
    let shown = |rates: &[&PairedRate], is_more: bool, what: &str| {
        let side = rates.iter().filter(|rate| (rate.difference() > 0.0) == is_more);
        let found: Vec<f64> = side.filter_map(|rate| rate.holm.filter(|p| *p < 0.05)).collect();
        let least = found.iter().copied().reduce(f64::min)?;
        Some(format!("{what} in {} of {} rows (p {})", found.len(), rates.len(), at_most(least)))
    };
    let [fewer, more] = [false, true].map(|is_more| {
        let word = if is_more { "more" } else { "fewer" };
        let all = weighed.iter().filter_map(|(rates, what)| shown(rates, is_more, &format!("{word} {what}")));
        all.collect::<Vec<String>>()
    });
    Shown { is_same, fewer, more }
}

/// The driver after and the driver before, as a sentence calls them.
pub struct Compared(String, String);

impl Compared {
    /// By their names, where all rows are of the same two drivers.
    pub fn of(names: &[[&str; 2]]) -> Self {
        match names {
            [first @ [before, after], others @ ..] if before != after && others.iter().all(|pair| pair == first) => {
                Self((*after).into(), (*before).into())
            }
            _ => Self("the driver after".into(), "the driver before".into()),
        }
    }

    /// Who is better, where it is shown that the driver after is so, or is worse, or both, and whether it costs more.
    pub fn verdict(&self, [better, worse]: [bool; 2], costs: bool) -> String {
        let word = match [better, worse] {
            [true, false] if costs => "is safer, at a price, than",
            [true, false] => "is better than",
            [false, true] => "is worse than",
            [true, true] => "is better in part and worse in part than",
            [false, false] => "is not shown to differ from",
        };
        let text = format!("{} {word} {}", self.0, self.1);
        text.replacen("the driver after", "The driver after", usize::from(text.starts_with("the driver")))
    }
}

/// A probability in a sentence.
pub fn at_most(value: f64) -> String {
    if value < 0.001 { "< 0.001".into() } else { format!("= {value:.3}") }
}

/// How many failures are new, worse, fixed, better and the same, and how many faults are new, fixed and the same.
fn headline(comparison: &ReportComparison) -> String {
    let is_told = |event: &&CountedEvent| {
        let is_of_collisions = [COLLISION_RATE, FAULT_RATE].contains(event.figure);
        event.is_violation() || event.requirement.is_none() && is_of_collisions
    };
    let of_both = |word| FailureChange::of_word(&comparison.changes, word).len();
    let told = comparison.events.iter().filter(is_told).map(|event| {
        let Changed { new, fixed, same } = comparison.changed(event);
        let what = match (&event.requirement, event.figure) {
            (Some(name), _) => format!("violations of {name}"),
            (None, figure) if *figure == FAULT_RATE => "fault".into(),
            (None, _) => {
                let [worse, better, same] = ["worse", "better", "same"].map(of_both);
                return format!("Failures: {new} new, {worse} worse, {fixed} fixed, {better} better, {same} same");
            }
        };
        format!("{what}: {new} new, {fixed} fixed, {same} same")
    });
    told.collect::<Vec<_>>().join("; ")
}

/// Which change of single runs shows; `None` without one. Holm's correction counts the rows of one rate that differ in it, also those of several runs.
fn power(comparison: &ReportComparison) -> Option<String> {
    let cells = || comparison.cells.iter().filter(|cell| cell.starts > 0 && !cell.is_pooled());
    let differing = |event: usize| {
        cells()
            .filter_map(|cell| cell.rates.get(event)?.as_ref())
            .filter(|rate| rate.changed.fixed + rate.changed.new > 0)
            .count()
    };
    let tests = (0..comparison.events.len()).map(differing).max()?.max(1);
    let single = || cells().filter(|cell| cell.runs == 1);
    let least = single().map(|cell| cell.starts).min().filter(|_| single().any(|cell| cell.differing > 0))?;
    let needed = (1..).find(|starts| tests as f64 * mcnemar(0, *starts) < 0.05)?;
    if least < needed {
        return Some(format!("With {least} common starts no difference can show; it takes {needed} or more."));
    }
    // The share of starts that differ in at least as many with this probability.
    let (_, share) = clopper_pearson(needed - 1, least, 2.0 * (1.0 - POWER));
    let shown = (share * least as f64).ceil() as u64;
    let place =
        comparison.events.iter().position(|event| event.requirement.is_none() && *event.figure == COLLISION_RATE);
    let cell = single().find(|cell| cell.starts == least)?;
    let changed = place.and_then(|place| Some(cell.rates.get(place)?.as_ref()?.changed));
    let before = changed.map_or(0, |changed| changed.fixed + changed.same);
    let of = match before {
        0 => String::new(),
        _ => format!(" ({:.0} % of the {before} before)", 100.0 * shown as f64 / before as f64),
    };
    Some(format!(
        "{least} common starts show, in {:.0} % of cases, a change that only fixes or only adds collisions, from {shown} of them{of}.",
        100.0 * POWER
    ))
}

/// The rates of a cell on both sides.
fn rates(events: &[CountedEvent], cell: &ComparedCell) -> Table {
    let mut head = vec![Column::text("rate")];
    head.extend(["before", "after", "difference (95 %)", "p (Holm)", "new", "fixed"].map(Column::number));
    let row = |(event, rate): (&CountedEvent, &Option<PairedRate>)| {
        let name = Value::text(event.rate().replacen("_rate", "", 1));
        let Some(rate) = rate else {
            let none = std::iter::repeat_n("–".into(), 5);
            return [name, "never applied".into()].into_iter().chain(none).collect();
        };
        vec![
            name,
            Value::number(Some(rate.values[0]), 3),
            Value::number(Some(rate.values[1]), 3),
            difference(rate),
            Value::text(rate.holm.map_or("–".into(), p)),
            Value::Count(rate.changed.new),
            Value::Count(rate.changed.fixed),
        ]
    };
    // Of what nobody asks first a row says only that it changed.
    let is_told = |(event, rate): &(&CountedEvent, &Option<PairedRate>)| {
        let is_asked = event.requirement.is_some() || ANSWER.iter().any(|(metric, _)| event.figure == *metric);
        is_asked || rate.as_ref().is_none_or(|rate| !rate.changed.is_same())
    };
    let rows = events.iter().zip(&cell.rates).filter(is_told).map(row).collect();
    Table { head, rows, ..Table::default() }
}

/// A difference with its interval; without one that of each run, if there are several.
fn difference(rate: &PairedRate) -> Value {
    let value = rate.difference();
    match rate.interval {
        Some((low, high)) => Value::text(format!("{value:+.3} ({low:+.3}..{high:+.3})")),
        None if rate.by_run.len() > 1 => Value::runs(rate.by_run.clone(), 3, true),
        None => Value::text(format!("{value:+.3}")),
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
    // A verdict that only one side has may be that of a collision of both.
    head.extend(["before", "after", "only after", "only before", "both"].map(Column::number));
    let row = |(name, changed): (String, Changed)| {
        let mut row = vec![Value::text(name)];
        let sums = [changed.fixed + changed.same, changed.new + changed.same, changed.new, changed.fixed, changed.same];
        row.extend(sums.map(Value::Count));
        row
    };
    Table { head, rows: rows.into_iter().take(MAX_KINDS).map(row).collect(), ..Table::default() }
}

/// The searches of both sides over the starts that both tried.
fn searches(comparison: &ReportComparison) -> Table {
    let mut head: Vec<Column> = ["search", "driver", "town"].map(|name| Column::text(name).key()).into();
    head.extend(["starts", "before", "after", "difference (95 %)", "p (Holm)", "new", "fixed"].map(Column::number));
    let row = |search: &ComparedSearch| {
        vec![
            search.falsifier.clone().into(),
            drivers(&search.policies).into(),
            search.town.clone().into(),
            Value::Count(search.starts),
            Value::number(Some(search.found.values[0]), 3),
            Value::number(Some(search.found.values[1]), 3),
            difference(&search.found),
            Value::text(search.found.holm.map_or("–".into(), p)),
            Value::Count(search.found.changed.new),
            Value::Count(search.found.changed.fixed),
        ]
    };
    Table { head, rows: comparison.searches.iter().map(row).collect(), ..Table::default() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_answer_names_the_drivers_where_there_are_two_and_says_what_it_costs() {
        let two = Compared::of(&[["v1", "v2"], ["v1", "v2"]]);
        assert_eq!(two.verdict([true, false], false), "v2 is better than v1");
        assert_eq!(two.verdict([true, false], true), "v2 is safer, at a price, than v1");
        assert_eq!(two.verdict([false, true], true), "v2 is worse than v1");
        let versions = Compared::of(&[["v1", "v1"]]);
        assert_eq!(versions.verdict([false, true], false), "The driver after is worse than the driver before");
        assert_eq!(Compared::of(&[["v1", "v2"], ["a", "b"]]).0, versions.0);
    }

    #[test]
    fn a_change_that_shows_in_four_of_five_cases_does() {
        // The share of starts from which six or more of 400 differ with a probability of 0.8.
        let (_, share) = clopper_pearson(5, 400, 2.0 * (1.0 - POWER));
        let first = (1.0 - share).powi(400);
        let terms = std::iter::successors(Some((0.0, first)), |(k, term)| {
            Some((k + 1.0, term * (400.0 - k) / (k + 1.0) * share / (1.0 - share)))
        });
        let below: f64 = terms.take(6).map(|(_, term)| term).sum();
        assert!((1.0 - below - POWER).abs() < 1e-6, "{below}");
    }
}

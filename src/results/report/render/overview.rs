//! The overview of several reports: tables, as a page and for a terminal.

use maud::html;

use super::page::{document, paragraph};
use super::sections::{Scale, failed_starts, injury, searcher};
use super::table::{Column, Table, Value};
use crate::report::overview::{Found, Overview, OverviewRow};
use crate::report::pooled::{Pooled, SEED};
use crate::report::{DriverResult, Rate, Variant};
use crate::tables::metrics::{EPISODES, compared};

/// How to read the tables.
const READING: &str = "A row is a pedestrian, or a search, in a town against a driver. Rates are shares of all episodes: the mean over runs \
± one standard deviation. Variants of a matrix meet the same starts. `overview.csv` has the same numbers, and intervals.";

pub fn overview_page(overview: &Overview<'_>, version: &str) -> String {
    let body = html! {
        header.top {
            p.kind { "falsify · overview" }
            h1 { "Overview" }
            p.meta { (reports(overview)) " reports · falsify " (version) }
            button #theme type="button" hidden { "Dark" }
        }
        main #main {
            section #table {
                h2 { "What was found" }
                @for line in doubtful(overview) { (paragraph(&line)) }
                @for table in pooled(overview, true).into_iter().chain(tables(overview)) { (table.to_html()) }
                (paragraph(READING))
            }
        }
    };
    document("Overview", version, &body, false)
}

pub fn overview_for_terminal(overview: &Overview<'_>) -> String {
    let pooled = pooled(overview, false);
    let pooled_seeds = pooled.len() > 1;
    // The reports of the seeds are on the page.
    let shown = if pooled.is_empty() { tables(overview) } else { pooled };
    let tables: Vec<String> = shown.iter().map(|table| table.to_terminal(80)).collect();
    let doubts: String = doubtful(overview).iter().map(|line| format!("\n{}", line.replace("**", ""))).collect();
    let more = if pooled_seeds { "\nThe page has the differences of all figures and pairs.\n" } else { "" };
    tables.join("\n") + more + &doubts
}

/// What a reader must know before rows are compared: trainings that are in doubt, and that the best of many rows is the best by chance, too.
fn doubtful(overview: &Overview<'_>) -> Vec<String> {
    let in_doubt: Vec<String> = overview
        .variants
        .iter()
        .filter(|variant| !variant.doubts.is_empty())
        .map(|variant| format!("`{}`", variant.report))
        .collect();
    let mut lines = Vec::new();
    if !in_doubt.is_empty() {
        lines.push(format!(
            "**There are doubts about the trainings of {} of {} reports:** {}. Their own pages say which.",
            in_doubt.len(),
            reports(overview),
            in_doubt.join(", ")
        ));
    }
    if reports(overview) > 2 && Pooled::all(overview).is_empty() {
        lines.push(
            "The greatest of many rates is too high by chance: test two reports with `falsify compare` before one is called better.".into(),
        );
    }
    lines
}

fn reports(overview: &Overview<'_>) -> usize {
    overview.variants.len()
}

/// Figures over the seeds of a call, and differences: of all figures and pairs, or of faults to the first controller or falsifier; empty for a single seed.
fn pooled(overview: &Overview<'_>, everything: bool) -> Vec<Table> {
    let all = Pooled::all(overview);
    let parameters: Vec<usize> =
        (0..overview.parameters.len()).filter(|place| overview.parameters[*place] != SEED).collect();
    let words = |pooled: &Pooled<'_>| {
        let row = pooled.rows[0];
        let values = parameters.iter().map(|place| Value::from(row.values[*place].as_deref().unwrap_or("–")));
        let mut words: Vec<Value> = values.collect();
        words.extend([Value::from(row.driver()), Value::from(row.town()), pooled.who(&all).into()]);
        words.push(Value::Count(pooled.rows.len() as u64));
        words
    };
    let head = |figures: Vec<Column>| {
        let names = parameters.iter().map(|place| overview.parameters[*place]).chain([
            "driver",
            "town",
            "pedestrian or search",
        ]);
        let mut head: Vec<Column> = names.map(|name| Column::text(name).key()).collect();
        head.push(Column::number("seeds"));
        head.extend(figures);
        head
    };
    let row = |pooled: &Pooled<'_>| {
        let mut row = words(pooled);
        for metric in compared().rev() {
            let rate = pooled.figure(metric);
            let mean = match (rate.value, pooled.episodes()) {
                (Some(0.0), Some(episodes)) => Value::Of(0, episodes.into()),
                _ => over_seeds(&rate, false),
            };
            row.extend([mean, Value::Number(rate.sd, 3)]);
        }
        row
    };
    let figures = compared().rev().flat_map(|metric| [Column::number(metric.word()), Column::number("sd").page_only()]);
    let mut tables = vec![Table {
        title: "Over the seeds".into(),
        head: head(figures.collect()),
        rows: all.iter().map(row).collect(),
        notes: vec!["The mean over the seeds with Student's 95 % interval from four seeds on, else ± their standard deviation. Fixed cases that end alike at every seed are one run, without a spread. A search's fault is the share of starts with one.".into()],
        ..Table::default()
    }];
    let p = |p: Option<f64>| match p {
        Some(p) if p < 0.001 => "< 0.001".into(),
        p => Value::Number(p, 3),
    };
    let shown_metrics = || compared().rev().take(if everything { usize::MAX } else { 1 });
    let difference = |(own, beside): (&Pooled<'_>, &Pooled<'_>)| {
        let figures = shown_metrics()
            .flat_map(|metric| [over_seeds(&own.difference(beside, metric), true), p(own.p(beside, metric))]);
        words(own).into_iter().chain([beside.who(&all).into()]).chain(figures).collect::<Vec<Value>>()
    };
    let pairs = Pooled::pairs(&all);
    let shown = pairs.into_iter().filter(|(_, beside)| everything || std::ptr::eq(*beside, &all[beside.first]));
    let columns = shown_metrics()
        .flat_map(|metric| [Column::number(format!("{}, difference", metric.word())), Column::number("p")]);
    let differences = Table {
        title: "Differences, paired by seed".into(),
        head: head(std::iter::once(Column::text("beside")).chain(columns).collect()),
        rows: shown.map(difference).collect(),
        notes: vec![
            "p is Student's, two-sided, from three seeds on, and corrected for nothing: of twenty rows one is below 0.05 by chance.".into(),
        ],
        ..Table::default()
    };
    tables.push(differences);
    tables.retain(|table| !table.rows.is_empty());
    tables
}

/// A mean over seeds with its interval, or of too few for one with their standard deviation.
fn over_seeds(rate: &Rate, is_difference: bool) -> Value {
    match (rate.value, rate.sd, rate.interval) {
        (Some(mean), Some(sd), None) if is_difference => format!("{mean:+.3} ± {sd:.3}").into(),
        (Some(mean), Some(sd), None) => format!("{mean:.3} ± {sd:.3}").into(),
        (value, _, interval) if is_difference => Value::Difference(value, interval),
        (value, _, interval) => Value::Estimate(value, interval, 3),
    }
}

type NameOf = fn(&OverviewRow<'_>) -> String;

/// The rates of controllers, those of falsifiers, and the worst failure of each driver; without those that would be empty.
fn tables(overview: &Overview<'_>) -> Vec<Table> {
    let of = |searched: bool| move |row: &&OverviewRow<'_>| matches!(row.found, Found::Searched(_)) == searched;
    let evaluated: Vec<_> = overview.rows.iter().filter(of(false)).collect();
    let searched: Vec<_> = overview.rows.iter().filter(of(true)).collect();
    let several = |name: NameOf| {
        let first = overview.rows.first().map(name);
        overview.rows.iter().any(|row| Some(name(row)) != first)
    };
    let parts: [(&str, NameOf); 3] = [
        ("driver", |row| row.driver().to_string()),
        ("town", |row| row.town().to_string()),
        ("world", |row| row.world().to_string()),
    ];
    let parts: Vec<_> = parts.into_iter().filter(|(_, name)| several(*name)).collect();
    let place = |row: &OverviewRow<'_>| parts.iter().map(|(_, name)| name(row).into()).collect::<Vec<Value>>();
    let place_of = |row: &OverviewRow<'_>| first(row.variant, &row.values);
    let place_head: Vec<Column> = parts.iter().map(|(name, _)| Column::text(*name)).collect();
    let mut tables = Vec::new();
    if !evaluated.is_empty() {
        let mut head = head(overview);
        head.extend(place_head.clone());
        head.extend([Column::text("pedestrian"), Column::number("runs").page_only(), Column::number("n")]);
        head.extend(compared().rev().map(|metric| Column::number(metric.word())));
        let row = |row: &&OverviewRow<'_>| {
            let Found::Evaluated(cell) = row.found else { unreachable!("the rows are those of cells") };
            let mut values = place_of(row);
            values.extend(place(row));
            values.extend([
                row.who().into(),
                Value::Count(cell.runs().into()),
                Value::Count((cell.count(&EPISODES) / cell.runs().max(1)).into()),
            ]);
            values.extend(compared().rev().map(|metric| Value::from(&cell.rate(metric))));
            values
        };
        let rows = evaluated.iter().map(row).collect();
        tables.push(Table { head, rows, ..Table::default() });
    }
    if !searched.is_empty() {
        let mut head = head(overview);
        head.extend(place_head.clone());
        head.push(Column::text("search"));
        head.extend(["failed starts", "starts with a fault"].map(Column::text));
        let row = |row: &&OverviewRow<'_>| {
            let Found::Searched(cell) = row.found else { unreachable!("the rows are those of searches") };
            let mut values = place_of(row);
            values.extend(place(row));
            values.extend([searcher(cell).into(), failed_starts(cell), Value::average(&cell.fault_start_rate, 3)]);
            values
        };
        let rows = searched.iter().map(row).collect();
        tables.push(Table { head, rows, ..Table::default() });
    }
    let mut head = head(overview);
    head.extend(["driver", "worst failure"].map(Column::text));
    head.push(Column::number("avoidable injury / 1,000"));
    head.push(Column::text("of the scale").page_only());
    let results =
        overview.variants.iter().flat_map(|variant| variant.drivers.iter().map(move |result| (variant, result)));
    let row = |(variant, result): (&Variant<'_>, &DriverResult)| {
        let mut values = first(variant, &overview.values(variant));
        values.push(Value::from(&result.driver.name));
        values.extend([Value::Text(result.worst_in_words()), Value::Number(injury(result, variant.cells), 2)]);
        // The baseline of each report is its own.
        let scale = Scale::new(variant.drivers, variant.cells, variant.searches);
        let share = scale.injury_of(result).zip(scale.head());
        values.push(share.map_or_else(|| "–".into(), |(share, of)| format!("{share:.2} {of}").into()));
        values
    };
    tables.push(Table { head, rows: results.map(row).collect(), ..Table::default() });
    tables
}

/// The columns that tell the reports apart.
fn head(overview: &Overview<'_>) -> Vec<Column> {
    // Without parameters only the reports tell the rows apart.
    let report = Column::text("report");
    let mut head = vec![if overview.parameters.is_empty() { report } else { report.page_only() }];
    head.extend(overview.parameters.iter().map(|name| Column::text(*name).key()));
    head
}

/// The values of these columns.
fn first(variant: &Variant<'_>, parameters: &[Option<String>]) -> Vec<Value> {
    let report = &variant.report;
    let link = Value::Link(report.clone(), format!("{}/report.html", address(report)));
    std::iter::once(link).chain(parameters.iter().map(|value| Value::from(value.as_deref().unwrap_or("–")))).collect()
}

/// A folder's name in a relative address.
fn address(name: &str) -> String {
    let plain = |byte: &u8| byte.is_ascii_alphanumeric() || b"-_.~=,+".contains(byte);
    name.bytes().map(|byte| if plain(&byte) { char::from(byte).to_string() } else { format!("%{byte:02X}") }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_is_a_part_of_an_address() {
        assert_eq!(address("a=1 b"), "a=1%20b");
    }
}

//! The overview of several reports: tables, as a page and for a terminal.

use std::collections::BTreeMap;

use maud::html;
use polars::prelude::PolarsResult;

use super::page::{document, paragraph};
use super::sections::{Scale, failed_starts, injury, searcher};
use super::table::{Column, Mark, Table, Value};
use crate::record::columns::{DRIVER, TOWN, WORLD};
use crate::report::{DriverResult, Overview, Rate, Variant};
use crate::tables::metrics::{EPISODES, compared};
use crate::tables::overview::{SEEDS, WHO, p_column, setting_column};
use crate::tables::{FAULT_START_RATE, Row};
use compile::HERE;

/// How to read the tables.
const READING: &str = "A row is a pedestrian, or a search, in a town against a driver. Rates are shares of all episodes: the mean over runs \
± one standard deviation. Variants of a matrix meet the same starts. `overview.csv` has the same numbers, and intervals.";

/// The page of an overview.
///
/// # Errors
/// Those of polars; none.
pub fn overview_page(overview: &Overview<'_>, version: &str) -> PolarsResult<String> {
    let pooled = pooled(overview, true)?;
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
                @for table in pooled.into_iter().chain(tables(overview)) { (table.to_html()) }
                (paragraph(READING))
            }
        }
    };
    Ok(document("Overview", version, &body, false))
}

/// The tables of an overview for a terminal.
///
/// # Errors
/// Those of polars; none.
pub fn overview_for_terminal(overview: &Overview<'_>) -> PolarsResult<String> {
    let pooled = pooled(overview, false)?;
    let pooled_seeds = pooled.len() > 1;
    // The reports of the seeds are on the page.
    let shown = if pooled.is_empty() { tables(overview) } else { pooled };
    let tables: Vec<String> = shown.iter().map(|table| table.to_terminal(80)).collect();
    let doubts: String = doubtful(overview).iter().map(|line| format!("\n{}", line.replace("**", ""))).collect();
    let more = if pooled_seeds { "\nThe page has the differences of all figures and pairs.\n" } else { "" };
    Ok(tables.join("\n") + more + &doubts)
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
    if reports(overview) > 2 && !overview.has_seeds() {
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
fn pooled(overview: &Overview<'_>, everything: bool) -> PolarsResult<Vec<Table>> {
    let (all, settings) = (overview.over_seeds()?, overview.settings());
    let words = |row: &Row<u32>| {
        let text = |column: &str| Value::from(row.text_of(column));
        let settings =
            settings.iter().map(|name| Some(row.text_of(&setting_column(name))).filter(|text| !text.is_empty()));
        let mut words: Vec<Value> = settings.map(|value| value.as_deref().unwrap_or("–").into()).collect();
        words.extend([DRIVER.name, TOWN.name, WHO].map(text));
        words.push(Value::Count(row.whole_number(SEEDS)));
        words
    };
    let head = |figures: Vec<Column>| {
        let names = settings.iter().map(String::as_str).chain(["driver", "town", "pedestrian or search"]);
        let mut head: Vec<Column> = names.map(|name| Column::text(name).key()).collect();
        head.push(Column::number("seeds"));
        head.extend(figures);
        head
    };
    let row = |pooled: &Row<u32>| {
        let mut row = words(pooled);
        for metric in compared().rev() {
            let rate = pooled.figure(metric.name, "");
            let mean = match (rate.value, pooled.number(EPISODES.name)) {
                (Some(0.0), Some(episodes)) => Value::Of(0, episodes as u64),
                _ => over_seeds(&rate, false),
            };
            row.extend([mean, Value::number(rate.sd, 3)]);
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
        p => Value::number(p, 3),
    };
    let shown_metrics = || compared().rev().take(if everything { usize::MAX } else { 1 });
    let by_group: BTreeMap<u32, &Row<u32>> = all.iter().map(|row| (row.key, row)).collect();
    let difference = |pair: &Row<[u32; 2]>| {
        let [own, beside] = pair.key.map(|group| by_group[&group]);
        let figures = shown_metrics().flat_map(|metric| {
            [over_seeds(&pair.figure(metric.name, ""), true), p(pair.number(&p_column(metric.name)))]
        });
        words(own).into_iter().chain([beside.text_of(WHO).into()]).chain(figures).collect::<Vec<Value>>()
    };
    let columns = shown_metrics()
        .flat_map(|metric| [Column::number(format!("{}, difference", metric.word())), Column::number("p (Holm)")]);
    let differences = Table {
        title: "Differences, paired by seed".into(),
        head: head(std::iter::once(Column::text("beside")).chain(columns).collect()),
        rows: overview.seed_pairs(everything)?.iter().map(difference).collect(),
        notes: vec![
            "p is Student's, two-sided, from four seeds on, with at least the spread that the counts allow, and with Holm's correction for all rows of a figure.".into(),
        ],
        ..Table::default()
    };
    tables.push(differences);
    tables.retain(|table| !table.rows.is_empty());
    Ok(tables)
}

/// A mean over seeds with its interval, or of too few for one with their standard deviation.
fn over_seeds(rate: &Rate, is_difference: bool) -> Value {
    match (rate.value, rate.sd, rate.interval) {
        (Some(mean), Some(sd), None) if is_difference => format!("{mean:+.3} ± {sd:.3}").into(),
        (Some(mean), Some(sd), None) => format!("{mean:.3} ± {sd:.3}").into(),
        (value, _, interval) if is_difference => Value::difference(value, interval),
        (value, _, interval) => Value::estimate(value, interval, 3),
    }
}

/// The rates of controllers, those of falsifiers, and the worst failure of each driver; without those that would be empty.
fn tables(overview: &Overview<'_>) -> Vec<Table> {
    let parts: Vec<&str> =
        [DRIVER.name, TOWN.name, WORLD.name].into_iter().filter(|name| overview.varies(name)).collect();
    let place = |driver: &String, town: &String, world: &str| {
        let names = [(DRIVER.name, driver.as_str()), (TOWN.name, town), (WORLD.name, world)];
        names.into_iter().filter(|(part, _)| parts.contains(part)).map(|(_, name)| name.into()).collect::<Vec<Value>>()
    };
    let heads = |own: &[Column]| {
        let mut head = head(overview);
        head.extend(parts.iter().map(|name| Column::text(*name)));
        head.extend_from_slice(own);
        head
    };
    let mut evaluated = heads(&[Column::text("pedestrian"), Column::number("runs").page_only(), Column::number("n")]);
    evaluated.extend(compared().rev().map(|metric| Column::number(metric.word())));
    let evaluated_rows =
        overview.variants.iter().flat_map(|variant| variant.cells.iter().map(move |cell| (variant, cell)));
    let evaluated_rows = evaluated_rows.map(|(variant, cell)| {
        let (key, episodes) = (&cell.key, cell.count(&EPISODES) / cell.runs().max(1));
        let who = if key.is_at_home() { format!("{} {}", key.controller, key.reward) } else { key.who() };
        let mut values = first(variant, &overview.values(variant));
        values.extend(place(&key.policy, &key.town, &key.world));
        values.extend([who.into(), Value::Count(cell.runs().into()), Value::Count(episodes.into())]);
        values.extend(compared().rev().map(|metric| Value::from(&cell.rate(metric))));
        values
    });
    let searched = heads(&["search", "failed starts", "starts with a fault"].map(Column::text));
    let searched_rows =
        overview.variants.iter().flat_map(|variant| variant.searches.iter().map(move |cell| (variant, cell)));
    let searched_rows = searched_rows.map(|(variant, cell)| {
        let mut values = first(variant, &overview.values(variant));
        values.extend(place(&cell.key.policy, &cell.key.town, HERE));
        values.extend([searcher(cell).into(), failed_starts(cell), Value::average(&cell.rate(FAULT_START_RATE), 3)]);
        values
    });
    let all = [(evaluated, evaluated_rows.collect()), (searched, searched_rows.collect::<Vec<_>>())];
    let all = all.into_iter().filter(|(_, rows): &(_, Vec<_>)| !rows.is_empty());
    let mut tables: Vec<Table> = all.map(|(head, rows)| Table { head, rows, ..Table::default() }).collect();
    let mut head = head(overview);
    head.extend(["driver", "worst failure"].map(Column::text));
    head.push(Column::number("avoidable injury / 1,000"));
    head.push(Column::text("of the scale").page_only());
    let results =
        overview.variants.iter().flat_map(|variant| variant.drivers.iter().map(move |result| (variant, result)));
    let row = |(variant, result): (&Variant<'_>, &DriverResult)| {
        let mut values = first(variant, &overview.values(variant));
        values.push(Value::from(&result.driver.name));
        values.extend([Value::text(result.worst_in_words()), Value::number(injury(result, variant.cells), 2)]);
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
    let link = Value::Text(report.clone(), Mark::Link(format!("{}/report.html", address(report))));
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

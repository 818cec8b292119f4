//! The overview of several reports: tables, as a page and for a terminal.

use std::collections::BTreeMap;

use maud::html;
use polars::prelude::PolarsResult;

use super::page::{document, paragraph};
use super::sections::{failed_starts, injury, searcher};
use super::table::{Column, Mark, Selection, Table, Value};
use crate::record::columns::{DRIVER, TOWN, WORLD};
use crate::report::{DriverResult, Overview, Rate, SearchCell, Variant};
use crate::tables::metrics::{EPISODES, compared, pooled as pooled_metrics};
use crate::tables::overview::{SEARCHED_FAULTS, SEARCHED_STARTS, SEEDS, WHO, p_column, setting_column};
use crate::tables::{Cell, FAULT_START_RATE, Metric, Row};
use compile::HERE;

/// How to read those of seeds in a terminal, and what only the page has.
const PAGE_HAS: &str = "\n± is the standard deviation over the seeds; intervals and p come from four seeds on. The page has the differences of all figures and pairs.\n";
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
    let more = if pooled_seeds { PAGE_HAS } else { "" };
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
    let words = || {
        let names = [("driver", DRIVER.name), ("town", TOWN.name), ("pedestrian or search", WHO)];
        Selection::new()
            .each(
                &settings,
                |name| Column::text(*name).key(),
                |name, row: &Row<u32>| {
                    let value = row.text_of(&setting_column(name));
                    if value.is_empty() { "–".into() } else { value }
                },
            )
            .each(names, |(name, _)| Column::text(*name).key(), |(_, column), row| row.text_of(column))
            .number("seeds", |row| row.whole_number(SEEDS))
    };
    let seeds = words().each(
        metrics(overview).flat_map(|metric| [(metric, false), (metric, true)]),
        |(metric, is_sd)| if *is_sd { Column::number("sd").page_only() } else { Column::number(metric.word()) },
        |(metric, is_sd), pooled| {
            let rate = pooled.figure(metric.name, "");
            let searched = [SEARCHED_FAULTS, SEARCHED_STARTS].map(|name| pooled.number(name).unwrap_or_default());
            match (rate.value, pooled.number(EPISODES.name)) {
                (Some(_), None) if !*is_sd => format!("{:.0} of {:.0} starts", searched[0], searched[1]).into(),
                _ if *is_sd => Value::number(rate.sd, 3),
                (Some(0.0), Some(episodes)) if metric.is_share() => Value::Of(0, episodes as u64),
                _ => over_seeds(&rate, false),
            }
        },
    );
    let seeds = Table {
        title: "Over the seeds".into(),
        notes: vec!["The mean over the seeds with Student's 95 % interval from four seeds on, else ± their standard deviation. Fixed cases that end alike at every seed are one run, without a spread. Of a search the starts with a fault are counted, of all starts that it tried.".into()],
        ..seeds.table(all.iter())
    };
    let p = |p: Option<f64>| match p {
        Some(p) if p < 0.001 => "< 0.001".into(),
        p => Value::number(p, 3),
    };
    let by_group: BTreeMap<u32, &Row<u32>> = all.iter().map(|row| (row.key, row)).collect();
    let shown_metrics = compared().rev().take(if everything { usize::MAX } else { 1 });
    let pairs = overview.seed_pairs(everything)?;
    let pairs: Vec<_> = pairs.iter().map(|pair| (pair, pair.key.map(|group| by_group[&group]))).collect();
    let differences = words()
        .of(|(_, [own, _]): &(&Row<[u32; 2]>, [&Row<u32>; 2])| *own)
        .text("beside", |(_, [_, beside])| beside.text_of(WHO))
        .each(
            shown_metrics.flat_map(|metric| [(metric, false), (metric, true)]),
            |(metric, is_p)| Column::number(if *is_p { "p".into() } else { format!("{}, difference", metric.word()) }),
            |(metric, is_p), (pair, _)| match is_p {
                true => p(pair.number(&p_column(metric.name))),
                false => over_seeds(&pair.figure(metric.name, ""), true),
            },
        );
    let differences = Table {
        title: "Differences, paired by seed".into(),
        notes: vec![
            "p is Student's, two-sided, from four seeds on, with at least the spread that the counts allow, and with Holm's correction for all rows of a figure. A search that tried fewer than ten starts at a seed is compared with no other.".into(),
        ],
        ..differences.table(&pairs)
    };
    Ok([seeds, differences].into_iter().filter(|table| !table.rows.is_empty()).collect())
}

/// Those of the paper where somebody is trained.
fn metrics(overview: &Overview<'_>) -> impl Iterator<Item = &'static Metric> {
    let is_trained = overview.variants.iter().any(|variant| variant.cells.iter().any(|cell| cell.key.is_trained()));
    pooled_metrics().take(if is_trained { usize::MAX } else { compared().count() })
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
    let parts = [DRIVER.name, TOWN.name, WORLD.name];
    let places = || parts.into_iter().enumerate().filter(|(_, part)| overview.varies(part));
    let cells: Vec<(&Variant<'_>, &Cell)> =
        overview.variants.iter().flat_map(|variant| variant.cells.iter().map(move |cell| (variant, cell))).collect();
    let evaluated = reports_first(overview, |row: &(&Variant<'_>, &Cell)| row.0)
        .each(
            places(),
            |(_, part)| Column::text(*part),
            |(place, _), (_, cell)| [&cell.key.policy, &cell.key.town, &cell.key.world][*place].clone(),
        )
        .text("pedestrian", |(_, Cell { key, .. })| match key.is_at_home() {
            true => format!("{} {}", key.controller, key.reward),
            false => key.who(),
        })
        .column(Column::number("runs").page_only(), |(_, cell)| cell.runs())
        .number("n", |(_, cell)| cell.count(&EPISODES) / cell.runs().max(1))
        .each(
            metrics(overview),
            |metric| Column::number(metric.word()),
            |metric, (_, cell)| Value::from(&cell.rate(metric)),
        );
    let searches: Vec<(&Variant<'_>, &SearchCell)> =
        overview.variants.iter().flat_map(|variant| variant.searches.iter().map(move |cell| (variant, cell))).collect();
    let searched = reports_first(overview, |row: &(&Variant<'_>, &SearchCell)| row.0)
        .each(
            places(),
            |(_, part)| Column::text(*part),
            |(place, _), (_, cell)| [&*cell.key.policy, &*cell.key.town, HERE][*place].to_owned(),
        )
        .text("search", |(_, cell)| searcher(cell))
        .text("failed starts", |(_, cell)| failed_starts(cell))
        .text("starts with a fault", |(_, cell)| Value::average(&cell.rate(FAULT_START_RATE), 3));
    let results: Vec<(&Variant<'_>, &DriverResult)> = overview
        .variants
        .iter()
        .flat_map(|variant| variant.drivers.iter().map(move |result| (variant, result)))
        .collect();
    let drivers = reports_first(overview, |row: &(&Variant<'_>, &DriverResult)| row.0)
        .text("driver", |(_, result)| result.driver.name.clone())
        .text("worst failure", |(_, result)| result.worst_in_words())
        .number("avoidable injury / 1,000", |(variant, result)| Value::number(injury(result, variant.cells), 2));
    let all = [evaluated.table(&cells), searched.table(&searches)].into_iter().filter(|table| !table.rows.is_empty());
    all.chain([drivers.table(&results)]).collect()
}

/// The report of a row, and the values of its parameters. Without parameters only the reports tell the rows apart.
fn reports_first<'t, R: 't>(overview: &'t Overview<'t>, variant: fn(&R) -> &'t Variant<'t>) -> Selection<'t, R> {
    let report = Column::text("report");
    let report = if overview.parameters.is_empty() { report } else { report.page_only() };
    Selection::new()
        .column(report, move |row| {
            let report = &variant(row).report;
            Value::Text(report.clone(), Mark::Link(format!("{}/report.html", base::files::address(report, b"-_.~=,+"))))
        })
        .each(
            overview.parameters.iter().enumerate(),
            |(_, name)| Column::text(**name).key(),
            move |(place, _), row| overview.values(variant(row))[*place].clone().unwrap_or_else(|| "–".into()),
        )
}

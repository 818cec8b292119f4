//! The cells of several reports side by side, and over the seeds of a call.

use polars::prelude::{
    DataFrame, DataType, Expr, IntoLazy, JoinArgs, JoinType, LazyFrame, MaintainOrderJoin, NULL, PolarsResult,
    SortMultipleOptions, col, lit, when,
};

use super::cells::IS_FIXED_CASES;
use super::metrics::{EPISODES, FAULT_RATE, MEAN, RUNS, compared, pooled};
use super::searches::{FAILED_STARTS, FAULT_START_RATE, FAULT_STARTS, METHOD, OTHER, STARTS};
use super::statistics::{adjusted, interval, over_runs, over_runs_with_student, statistic, student};
use crate::record::columns::{BLOCK, BODY, DRIVER, PEDESTRIAN, REWARD, TOWN, TRAIN_DRIVER, TRAIN_TOWN, VEHICLE, WORLD};
use base::statistics::mean_p_of_rates;
use compile::{HERE, NO_REWARD, UNTRAINED};

/// The folder of the report.
pub const REPORT: &str = "report";
/// The figure of a search that is compared beside the fault rate.
const SEARCHED: &str = "search_faults_start_rate";
/// The starts of a search, and those with a fault: means over its runs, and their sums over seeds.
pub const SEARCHED_STARTS: &str = "search_starts";
pub const SEARCHED_FAULTS: &str = "search_fault_starts";
/// A search with fewer starts than these at a seed is compared with no other.
const MIN_STARTS: f64 = 10.0;

// Columns besides those of the file. A setting has no name with a blank.
/// The controller with its reward, and with its training where that was elsewhere; or the falsifier.
pub const WHO: &str = "who walks";
/// Its block, car, body and simulator, which tell cells of one name apart.
const WHERE: &str = "where it walks";
/// The report without its seed.
pub const CAMPAIGN: &str = "report of all seeds";
pub const SEED: &str = "seed of the report";
const IS_SEARCH: &str = "is a search";
pub const SEEDS: &str = "number of seeds";
/// The number of the first row of the same place, and of the same controller or falsifier there.
const PLACE: &str = "first row of the place";
const GROUP: &str = "first row of the group";
const ROW: &str = "number of the row";
/// Whether all rows of the group are fixed cases that end alike, which are one run.
const IS_ONE: &str = "is one run";

pub fn setting_column(name: &str) -> String {
    format!("{name} =")
}

/// The column of a probability.
pub fn p_column(figure: &str) -> String {
    format!("{figure} p")
}

/// The columns of a row, of a cell and of a cell of searches: first those of the file.
fn columns() -> [Vec<(String, [Expr; 2])>; 2] {
    let none = || lit(NULL).cast(DataType::Float64);
    let training = || col(TRAIN_TOWN.name) + lit(", ") + col(TRAIN_DRIVER.name);
    let is_trained = || col(TRAIN_TOWN.name).neq(lit(""));
    let is_of_reward = || is_trained().or(col(PEDESTRIAN.name).eq(lit(UNTRAINED)));
    let text = |is: Expr, text: Expr| when(is).then(text).otherwise(lit(""));
    let is_away = col(TOWN.name).neq(col(TRAIN_TOWN.name)).or(col(DRIVER.name).neq(col(TRAIN_DRIVER.name)));
    let who = col(PEDESTRIAN.name)
        + text(is_of_reward().and(col(REWARD.name).neq(lit(NO_REWARD))), lit(" ") + col(REWARD.name))
        + text(is_trained().and(is_away), lit(" (") + training() + lit(")"));
    let number = || (col(BLOCK.name) + lit(1)).cast(DataType::String);
    let block = |kind: &str| text(col(BLOCK.name).gt(lit(0)), lit(format!(", {kind} ")) + number());
    let [vehicle, body, world] = [VEHICLE.name, BODY.name, WORLD.name].map(|name| lit(", ") + col(name));
    let mut shown = vec![
        (DRIVER.name.to_owned(), [col(DRIVER.name), col(DRIVER.name)]),
        (TOWN.name.into(), [col(TOWN.name), col(TOWN.name)]),
        (WORLD.name.into(), [col(WORLD.name), lit(HERE)]),
        ("pedestrian".into(), [col(PEDESTRIAN.name), lit("")]),
        ("reward".into(), [col(REWARD.name), lit("")]),
        ("training".into(), [text(is_trained(), training()), lit("")]),
        ("method".into(), [lit(""), col(METHOD.name)]),
        (RUNS.name.into(), [col(RUNS.name), col(RUNS.name)].map(|runs| runs.cast(DataType::UInt64))),
    ];
    for metric in pooled() {
        shown.push((metric.name.into(), [col(MEAN.name(metric.name)), none()]));
        let ends = ["sd", "wilson_low", "wilson_high"].into_iter().take(if metric.is_share() { 3 } else { 1 });
        shown.extend(ends.map(|end| format!("{}_{end}", metric.name)).map(|name| (name.clone(), [col(name), none()])));
    }
    let rate = |suffix: &str| col(format!("{FAULT_START_RATE}{suffix}"));
    shown.extend([
        (SEARCHED.into(), [none(), col(MEAN.name(FAULT_START_RATE))]),
        (format!("{SEARCHED}_low"), [none(), rate("_low")]),
        (format!("{SEARCHED}_high"), [none(), rate("_high")]),
        ("search_failed_starts".into(), [none(), col(MEAN.name(FAILED_STARTS))]),
        (SEARCHED_FAULTS.into(), [none(), col(MEAN.name(FAULT_STARTS))]),
        (SEARCHED_STARTS.into(), [none(), col(MEAN.name(STARTS.name))]),
    ]);
    let more = vec![
        (WHO.into(), [who, col(METHOD.name)]),
        (WHERE.into(), [block("evaluate") + vehicle + body + world, block("search")]),
        (IS_SEARCH.into(), [lit(false), lit(true)]),
        (EPISODES.name.into(), [col(EPISODES.name), lit(NULL)].map(|count| count.cast(DataType::UInt32))),
        (IS_FIXED_CASES.name.into(), [col(IS_FIXED_CASES.name), lit(false)]),
    ];
    [shown, more]
}

/// The names of the columns of the file, but those of settings.
pub fn file_columns() -> Vec<String> {
    let [shown, _] = columns();
    std::iter::once(REPORT.into()).chain(shown.into_iter().map(|(name, _)| name)).collect()
}

/// The columns of the file, without any row.
pub(crate) fn no_rows(settings: &[&str]) -> PolarsResult<DataFrame> {
    let names = file_columns().into_iter().chain(settings.iter().map(|name| setting_column(name)));
    let column = |name: String| polars::prelude::Column::full_null(name.into(), 0, &DataType::String);
    DataFrame::new(0, names.map(column).collect())
}

/// The rows of cells, or of cells of searches, with the same further columns for all.
pub(crate) fn rows(cells: &DataFrame, are_searches: bool, more: Vec<Expr>) -> LazyFrame {
    let own = columns().into_iter().flatten().map(|(name, of)| {
        let [cell, search] = of;
        if are_searches { search } else { cell }.alias(name)
    });
    cells.clone().lazy().select(own.chain(more).collect::<Vec<_>>())
}

/// The rows with what tells apart those that are not of the same place, or of the same controller or falsifier there.
fn grouped(rows: &DataFrame, settings: &[String]) -> PolarsResult<LazyFrame> {
    let place = [CAMPAIGN, DRIVER.name, TOWN.name, WHERE, IS_SEARCH].map(col).into_iter();
    let place: Vec<Expr> = place.chain(settings.iter().map(|name| col(setting_column(name)))).collect();
    let group: Vec<Expr> = place.iter().cloned().chain([col(WHO)]).collect();
    let searched = col(FAULT_RATE.name).fill_null(col(SEARCHED));
    let alike = compared().map(|metric| col(metric.name).n_unique().eq(lit(1)));
    let is_one = alike.fold(col(IS_FIXED_CASES.name).all(true), Expr::and);
    let first = |by: &[Expr]| col(ROW).first().over(by);
    let rows = rows.clone().lazy().with_row_index(ROW, None).with_column(searched);
    Ok(rows.with_columns([
        first(&place)?.alias(PLACE),
        first(&group)?.alias(GROUP),
        col(ROW).count().over(&group)?.alias(SEEDS),
        is_one.over(&group)?.alias(IS_ONE),
    ]))
}

/// A row for each controller, or falsifier, in a town against a driver: its figures over the seeds, with Student's interval.
pub(crate) fn over_seeds(rows: &DataFrame, settings: &[String]) -> PolarsResult<DataFrame> {
    let keys = [DRIVER.name, TOWN.name, WHO, WHERE, CAMPAIGN, SEEDS].into_iter().map(String::from);
    let keys = keys.chain(settings.iter().map(|name| setting_column(name)));
    let mut all: Vec<Expr> = keys.map(|name| col(name).first()).collect();
    all.push(
        when(col(EPISODES.name).count().gt(lit(0)))
            .then(col(EPISODES.name).sum())
            .otherwise(lit(NULL))
            .alias(EPISODES.name),
    );
    let sum = |name: &str| (col(name) * col(RUNS.name)).sum().alias(name);
    all.extend([SEARCHED_STARTS, SEARCHED_FAULTS].map(sum));
    for metric in pooled() {
        all.extend(over_runs_with_student(metric.name, metric.bounds()));
    }
    let name = [DRIVER.name, TOWN.name, WHO].map(col);
    grouped(rows, settings)?
        .filter(is_repeated().not())
        .group_by_stable([col(GROUP)])
        .agg(all)
        .with_column(when(col(GROUP).count().over(name)?.eq(lit(1))).then(col(WHO)).otherwise(in_full()))
        .collect()
}

/// A row for each pair of controllers, or of falsifiers, in a town against a driver: the differences of a later one to an earlier one, seed by seed. With `all`, of
/// any earlier one, else of the first.
pub(crate) fn seed_pairs(rows: &DataFrame, settings: &[String], all: bool) -> PolarsResult<DataFrame> {
    let other = |name: &str| col(format!("{name}{OTHER}"));
    let mut columns: Vec<Expr> = Vec::new();
    for metric in compared() {
        let differences = || col(metric.name) - other(metric.name);
        columns.extend(over_runs(metric.name, differences()));
        columns.extend(interval(metric.name, [differences()], |[seeds]| {
            student(seeds, (f64::NEG_INFINITY, f64::INFINITY))
        }));
        let variance = |name: &str| col(name) * (lit(1.0) - col(name));
        let variances =
            variance(metric.name) / counted("") + variance(&format!("{}{OTHER}", metric.name)) / counted(OTHER);
        let p = statistic([differences(), variances], |[seeds, variances]| mean_p_of_rates(seeds, variances));
        columns.push(p.alias(p_column(metric.name)));
    }
    let arguments = JoinArgs {
        maintain_order: MaintainOrderJoin::LeftRight,
        suffix: Some(OTHER.into()),
        ..JoinArgs::new(JoinType::Inner)
    };
    let (rows, same, pair) = (grouped(rows, settings)?, [PLACE, SEED].map(col), [col(GROUP), other(GROUP)]);
    rows.clone()
        .join(rows, same.clone(), same, arguments)
        .filter(other(GROUP).lt(col(GROUP)).and(lit(all).or(other(GROUP).eq(col(PLACE)))))
        .filter(is_repeated().and(other(IS_ONE)).not())
        .filter(enough(SEARCHED_STARTS).and(enough(&format!("{SEARCHED_STARTS}{OTHER}"))))
        .group_by_stable(pair.clone())
        .agg(columns)
        .with_columns(compared().map(|metric| adjusted(col(p_column(metric.name)))).collect::<Vec<_>>())
        .sort_by_exprs(pair, SortMultipleOptions::default())
        .collect()
}

/// Whether a search has enough starts to be compared, in all episodes that are no search's.
fn enough(starts: &str) -> Expr {
    col(starts).fill_null(lit(MIN_STARTS)).gt_eq(lit(MIN_STARTS))
}

/// The number of episodes behind the rates of a row, or of the starts of a search.
fn counted(suffix: &str) -> Expr {
    let column = |name: &str| col(format!("{name}{suffix}")).cast(DataType::Float64);
    column(EPISODES.name).fill_null(column(SEARCHED_STARTS))
}

/// The number of the group in a row of these tables, or of the other one.
pub(crate) fn group(table: &DataFrame, row: usize, suffix: &str) -> PolarsResult<u32> {
    Ok(table.column(&format!("{GROUP}{suffix}"))?.u32()?.get(row).unwrap_or_default())
}

/// A controller or falsifier with the report and all that tells it apart.
fn in_full() -> Expr {
    col(WHO) + lit(" (") + col(CAMPAIGN) + col(WHERE) + lit(")")
}

/// Whether fixed cases only end as they did at another seed.
fn is_repeated() -> Expr {
    col(IS_ONE).and(col(ROW).neq(col(GROUP)))
}

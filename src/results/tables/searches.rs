//! What is made of the table of searches: cells of searches that differ in their run alone, and pairs of these.

use polars::prelude::{
    DataFrame, DataType, Expr, IntoLazy, JoinArgs, JoinType, LazyFrame, MaintainOrderJoin, PolarsResult,
    SortMultipleOptions, UnionArgs, col, concat, len, lit,
};

use super::metrics::{MEAN, RUNS};
use super::statistics::{adjusted, interval, over_runs, over_runs_with_student, statistic, student};
use crate::record::columns::{BLOCK, DRIVER, REWARD, RUN, TOWN};
use crate::record::{Column, ColumnReference, Role, columns};
use base::statistics::{MIN_RUNS, clopper_pearson, mean_interval_at, mean_p};

columns! {
    /// the search, by the name of its method
    pub METHOD: Column<String> = "method";
    /// different starts of these episodes; starts 0, 1, 2, … of a run are the same for all searches
    pub STARTS: Column<u64> = "starts";
    /// numbers of these starts, as `0-31 40`
    pub TRIED: Column<String> = "tried";
    /// number of the first of these starts and hash of it as it was drawn; searches with equal ones have the same starts
    pub FIRST_START: Column<String> = "first_start";
}
pub const SEARCH_BLOCK: Column<u64> =
    Column::new(BLOCK.name, "", "number of the `search` block in its campaign, from 0");
pub const SEARCH_RUN: Column<u64> = Column::new(RUN.name, "", RUN.doc);
pub const BUDGET: Column<u64> = Column::new("budget_ticks", "", "simulator ticks that each run may use");
/// The requirement that it tries to violate; missing of a search for collisions.
pub const GOAL: Column<String> = Column::new("goal", "", "");

// The figures of a search. Those of faults are missing where failures have no verdict.
pub const USED: &str = "used_ticks";
pub const SEARCH_EPISODES: &str = "episodes";
pub const FAILURE_COUNT: &str = "failures";
pub const FAILED_STARTS: &str = "failed_starts";
pub const FIRST_FAILURE: &str = "first_failure_ticks";
pub const FIRST_SIMULATIONS: &str = "first_failure_simulations";
pub const PREVENTABLE_COUNT: &str = "preventable";
pub const FAULT_COUNT: &str = "faults";
pub const FAULT_STARTS: &str = "fault_starts";
/// The share of the starts from which it found a fault.
pub const FAULT_START_RATE: &str = "fault_start_rate";
pub const FIRST_FAULT: &str = "first_fault_ticks";
/// Fresh episodes of the pedestrian that a search ended with, and their faults.
pub const EVALUATED_EPISODES: &str = "evaluated_episodes";
pub const EVALUATED_FAULTS: &str = "evaluated_faults";
/// The avoidable injury of a thousand episodes.
pub const INJURY: &str = "avoidable_injury_per_thousand";

/// The number of the first search of a cell.
pub const PLACE: Column<u32> = Column::new("place", "", "");
/// Runs that found a failure, and their share.
pub const FALSIFIED: &str = "falsified_runs";
const FALSIFIED_SHARE: Column<f64> =
    Column::new("falsified_share", "", "share of the runs that found a failure, as ARCH-COMP counts it")
        .with_role(Role::RunShare);
pub const SIMULATIONS_MEAN: Column<f64> =
    Column::new("simulations_to_first_mean", "", "mean of `first_failure_simulations` over these runs");
pub const SIMULATIONS_MEDIAN: Column<f64> = Column::new("simulations_to_first_median", "", "their median");

/// The figures of which a cell has the mean.
const AVERAGED: [(&str, Role); 5] = [
    (STARTS.name, Role::Plain),
    (FAILED_STARTS, Role::Plain),
    (FAULT_COUNT, Role::Plain),
    (FAULT_START_RATE, Role::Share),
    (INJURY, Role::Plain),
];

/// The figures by which searches are compared.
const COMPARED: [&str; 4] = [INJURY, FAULT_START_RATE, FAILED_STARTS, FAULT_STARTS];

/// The column of a median over the runs.
pub fn median_column(first: &str) -> String {
    format!("{first}_median")
}

/// A row for each search, town and driver, over all runs, in the order of first appearance.
pub(crate) fn search_cells(searches: &DataFrame) -> PolarsResult<DataFrame> {
    let falsified = || col(FIRST_FAILURE).count();
    let mut all = [REWARD.name, GOAL.name, BUDGET.name, PLACE.name].map(|name| col(name).first()).to_vec();
    all.extend([
        len().alias(RUNS.name),
        falsified().alias(FALSIFIED),
        (falsified().cast(DataType::Float64) / len()).alias(FALSIFIED_SHARE.name),
        col(FIRST_SIMULATIONS).mean().alias(SIMULATIONS_MEAN.name),
        col(FIRST_SIMULATIONS).median().alias(SIMULATIONS_MEDIAN.name),
    ]);
    for first in [FIRST_FAILURE, FIRST_FAULT] {
        let times = [col(first).cast(DataType::Float64).fill_null(col(USED)), col(first).is_not_null()];
        all.push(statistic(times, |[times, reached]| median_time(times, reached)).alias(median_column(first)));
    }
    for figure in [STARTS.name, FAILED_STARTS, FAULT_COUNT, FAULT_STARTS] {
        all.extend(over_runs_with_student(figure, (0.0, f64::INFINITY)));
    }
    all.extend(over_runs(INJURY, col(INJURY)));
    all.extend(interval(INJURY, [col(INJURY)], injury));
    all.extend(over_runs(FAULT_START_RATE, col(FAULT_START_RATE)));
    all.extend(interval(FAULT_START_RATE, [FAULT_START_RATE, FAULT_STARTS, STARTS.name].map(col), rate_of_starts));
    searches.clone().lazy().with_row_index(PLACE.name, None).group_by_stable(cell_columns().map(col)).agg(all).collect()
}

/// The breaches that searches for a requirement found; their faults are others.
pub(crate) const BREACH_COUNT: &str = "breaches";

/// A row for each driver, over all its searches.
pub(crate) fn searched_drivers(searches: &DataFrame) -> PolarsResult<DataFrame> {
    let for_faults = |figure: &str| col(figure).filter(col(GOAL.name).is_null());
    let breaches = col(FAULT_COUNT).filter(col(GOAL.name).is_not_null()).sum().alias(BREACH_COUNT);
    let sums = [FAILURE_COUNT, PREVENTABLE_COUNT, SEARCH_EPISODES, EVALUATED_EPISODES].map(|count| col(count).sum());
    let faults = [FAULT_COUNT, FAULT_STARTS, EVALUATED_FAULTS].map(|count| for_faults(count).sum());
    let means = [col(INJURY).mean(), for_faults(FAULT_START_RATE).mean(), breaches];
    searches.clone().lazy().group_by_stable([col(DRIVER.name)]).agg([&sums[..], &faults, &means].concat()).collect()
}

/// What the searches of a cell have in common.
fn cell_columns() -> [&'static str; 4] {
    [METHOD.name, TOWN.name, DRIVER.name, SEARCH_BLOCK.name]
}

/// The interval of the injury, from [`INJURY_RUNS`] runs on: a few faults are most of it, so that fewer runs show too little of its spread.
fn injury([runs]: [&[f64]; 1]) -> Option<(f64, f64)> {
    student(runs, (0.0, f64::INFINITY)).filter(|_| runs.len() >= INJURY_RUNS)
}

/// The number of runs from which on the injury has an interval.
const INJURY_RUNS: usize = 10;

/// The interval of a share of starts. Equal runs show no spread, and the number of starts says what may go unseen.
fn rate_of_starts([rates, faults, starts]: [&[f64]; 3]) -> Option<(f64, f64)> {
    let sum = |counts: &[f64]| counts.iter().sum::<f64>() as u64;
    let over_starts = || (rates.len() >= MIN_RUNS).then(|| clopper_pearson(sum(faults), sum(starts), 0.05));
    student(rates, (0.0, 1.0)).or_else(over_starts)
}

/// The median of times to an event, of which some were not reached (0: the time is the end of the observation); `None` if fewer than half were.
///
/// # Source
/// Kaplan and Meier, JASA 53, 1958.
fn median_time(times: &[f64], reached: &[f64]) -> Option<f64> {
    let mut sorted: Vec<(f64, bool)> =
        times.iter().zip(reached).map(|(time, reached)| (*time, *reached > 0.0)).collect();
    // A run that ends at a time was still at risk at that time.
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)));
    let (mut survival, mut next) = (1.0, 0);
    while next < sorted.len() {
        let time = sorted[next].0;
        let here = sorted[next..].iter().take_while(|(t, _)| *t == time).count();
        let events = sorted[next..next + here].iter().filter(|(_, reached)| *reached).count();
        survival *= 1.0 - events as f64 / (sorted.len() - next) as f64;
        if survival <= 0.5 {
            return Some(time);
        }
        next += here;
    }
    None
}

/// The columns of the table of cells of searches that gates and `metrics` know, after the key and the number of runs.
pub fn search_cell_columns() -> Vec<ColumnReference> {
    let median = |first: &'static str| {
        let doc = format!("Kaplan and Meier's median of `{first}`; missing if fewer than half of the runs found one");
        let column = Column::<f64>::new(first, "", "").reference();
        ColumnReference { name: median_column(first).into(), doc: doc.into(), ..column }
    };
    let averaged = |(figure, role): (&'static str, Role)| {
        let column = |name: String, role| {
            let column = Column::<f64>::new(figure, "", AVERAGED_DOC).with_role(role).reference();
            ColumnReference { name: name.into(), ..column }
        };
        [
            column(MEAN.name(figure), role),
            column(format!("{figure}_low"), Role::LowerBound),
            column(format!("{figure}_high"), Role::UpperBound),
        ]
    };
    let mut all = vec![BUDGET.reference()];
    all.extend([FALSIFIED_SHARE, SIMULATIONS_MEAN, SIMULATIONS_MEDIAN].map(|column| column.reference()));
    all.push(median(FIRST_FAILURE));
    all.extend(AVERAGED.into_iter().flat_map(averaged));
    all.push(median(FIRST_FAULT));
    all
}

const AVERAGED_DOC: &str = "mean over `runs` with Student's 95 % interval, on the logarithm, and for rates on the logit; of a rate that is the same in all runs Clopper and \
     Pearson's over all starts. The interval is about further runs in this town, not about other towns; missing for fewer than four runs, of the injury for fewer than ten, and of other figures \
     that are the same in all";

// The columns of pairs of searches.
columns! {
    /// `collision_rate`, `preventable_rate` or `fault_rate`, or of searches a metric: what is compared
    pub FIGURE: Column<String> = "figure";
}
pub const OTHER: &str = "_other";
pub const DIFFERENCES: &str = "differences";
pub const DIFFERENCE: &str = "difference";
pub const P: &str = "p";
pub const P_HOLM: &str = "p_holm";
/// Whether two searches are compared, rather than two drivers.
pub const IS_OF_METHODS: Column<bool> = Column::new("is_of_methods", "", "");
/// The number of a pair of cells, and that of a cell.
pub const PAIR: Column<u64> = Column::new("pair", "", "");
const CELL: &str = "cell";
const VALUE: &str = "value";
/// The number of the figure, and of the pairs that are read together with this one.
const RANK: &str = "rank";
const FAMILY: &str = "family";

/// Two searches against one driver, or one search against two drivers, compared run by run: equal runs have equal starts. A row for each figure that both have.
///
/// Holm's correction, and Bonferroni's of the intervals, cover all rows that are read together: those of a figure for all pairs of searches, or for all pairs of
/// drivers, in all towns and blocks.
pub(crate) fn search_pairs(searches: &DataFrame) -> PolarsResult<DataFrame> {
    let numbered = searches.clone().lazy().with_row_index(PLACE.name, None);
    let numbered = numbered.with_column(col(PLACE.name).first().over(cell_columns().map(col))?.alias(CELL));
    let figures: Vec<LazyFrame> =
        (0..).zip(COMPARED).map(|(rank, figure)| numbered.clone().select(values(rank, figure))).collect();
    let values = concat(figures, UnionArgs::default())?.filter(col(VALUE).is_not_null());
    let same = [TOWN.name, SEARCH_BLOCK.name, SEARCH_RUN.name, RANK, FIGURE.name].map(col);
    let arguments = JoinArgs {
        maintain_order: MaintainOrderJoin::LeftRight,
        suffix: Some(OTHER.into()),
        ..JoinArgs::new(JoinType::Inner)
    };
    let other = |column: &str| col(format!("{column}{OTHER}"));
    let family = || [FIGURE.name, IS_OF_METHODS.name].map(col);
    let pair = col(CELL).cast(DataType::UInt64) * lit(searches.height() as u64) + other(CELL);
    let differs = |column: &str| col(column).neq(other(column));
    let pairs = values
        .clone()
        .join(values, same.clone(), same, arguments)
        .filter(col(CELL).lt(other(CELL)).and(differs(METHOD.name).xor(differs(DRIVER.name))))
        .with_columns([pair.alias(PAIR.name), differs(METHOD.name).alias(IS_OF_METHODS.name)])
        .with_columns([(col(VALUE) - other(VALUE)).alias(DIFFERENCE)])
        .with_columns([col(PAIR.name).n_unique().over(family())?.alias(FAMILY)]);
    let keys = [METHOD.name, DRIVER.name].into_iter().flat_map(|name| [col(name), other(name)]);
    let keys: Vec<Expr> =
        keys.chain([TOWN.name, SEARCH_BLOCK.name, FIGURE.name, IS_OF_METHODS.name].map(col)).map(Expr::first).collect();
    let of_pair = [
        len().alias(RUNS.name),
        col(DIFFERENCE).mean(),
        col(DIFFERENCE).alias(DIFFERENCES),
        statistic([col(DIFFERENCE)], |[differences]| mean_p(differences)).alias(P),
    ];
    let is_share = col(FIGURE.name).eq(lit(FAULT_START_RATE));
    let ends = interval(DIFFERENCE, [col(DIFFERENCE), col(FAMILY), is_share], within_family);
    pairs
        .group_by_stable([PAIR.name, RANK].map(col))
        .agg(keys.into_iter().chain(of_pair).chain(ends).collect::<Vec<_>>())
        .with_column(adjusted(col(P)).over(family())?.alias(P_HOLM))
        .sort_by_exprs([PAIR.name, RANK].map(col), SortMultipleOptions::default())
        .collect()
}

/// A figure of the searches.
fn values(rank: u32, figure: &str) -> Vec<Expr> {
    let key = [CELL, METHOD.name, DRIVER.name, TOWN.name, SEARCH_BLOCK.name, SEARCH_RUN.name].map(col);
    let own = [lit(rank).alias(RANK), lit(figure).alias(FIGURE.name), col(figure).cast(DataType::Float64).alias(VALUE)];
    key.into_iter().chain(own).collect()
}

/// The interval of a mean difference, so wide that those of all rows that are read together hold the truth; of shares between -1 and 1.
fn within_family([differences, family, is_share]: [&[f64]; 3]) -> Option<(f64, f64)> {
    let (low, high) = mean_interval_at(differences, 0.05 / family.first()?)?;
    Some(if is_share.first() == Some(&1.0) { (low.max(-1.0), high.min(1.0)) } else { (low, high) })
}

#[cfg(test)]
mod tests {
    use polars::prelude::{Column as Values, NamedFrom, PlSmallStr, Series};
    use rand::Rng;

    use super::*;
    use base::seed::{Seed, Stream};

    /// Recorded from lifelines by `tests/reference/kaplan_meier/record_medians.py`.
    const RECORDED: &str = include_str!("../../../tests/reference/kaplan_meier/medians.json");

    #[test]
    fn medians_are_those_of_lifelines() {
        let recorded: serde_json::Value = serde_json::from_str(RECORDED).unwrap();
        let mut cases = 0;
        for (name, case) in recorded.as_object().unwrap().iter().filter(|(name, _)| *name != "version") {
            let list = |key: &str| case[key].as_array().unwrap().clone();
            let times: Vec<f64> = list("times").iter().map(|time| time.as_f64().unwrap()).collect();
            let reached: Vec<f64> = list("found").iter().map(|found| found.as_f64().unwrap()).collect();
            assert_eq!(median_time(&times, &reached), case["median"].as_f64(), "{name}");
            cases += 1;
        }
        assert_eq!(cases, 4);
        assert_eq!(median_time(&[], &[]), None);
        assert_eq!(median_time(&[5.0, 5.0], &[0.0, 0.0]), None, "nothing was found");
    }

    /// Drivers, towns and runs of the audited ranking.
    const CAMPAIGN: [u64; 3] = [11, 3, 10];

    /// The pairs of a campaign whose drivers do not differ: each run of a town has its own difficulty, and each driver finds faults from 60 starts of it by
    /// chance alone. With `better`, the first driver finds none.
    fn pairs(stream: &mut Stream, better: bool) -> DataFrame {
        let [drivers, towns, runs] = CAMPAIGN;
        let mut uniform = || f64::from(stream.next_u32()) / 2_f64.powi(32);
        let (mut keys, mut found): (Vec<[u64; 3]>, Vec<f64>) = (Vec::new(), Vec::new());
        for town in 0..towns {
            for run in 0..runs {
                let difficulty = 0.1 + 0.1 * town as f64 + 0.1 * uniform();
                for driver in 0..drivers {
                    let faults = (0..60).filter(|_| uniform() < difficulty).count() as f64 / 60.0;
                    keys.push([town, driver, run]);
                    found.push(if better && driver == 0 { 0.0 } else { faults });
                }
            }
        }
        let text = |name: &str, key: usize| {
            Series::new(name.into(), keys.iter().map(|keys| keys[key].to_string()).collect::<Vec<_>>()).into()
        };
        let number = |name: &str, of: fn(&[u64; 3]) -> u64| {
            Series::new(name.into(), keys.iter().map(of).collect::<Vec<_>>()).into()
        };
        let mut columns: Vec<Values> = vec![
            Values::new_scalar(METHOD.name.into(), PlSmallStr::from("f").into(), keys.len()),
            text(TOWN.name, 0),
            text(DRIVER.name, 1),
            number(SEARCH_BLOCK.name, |_| 0),
            number(SEARCH_RUN.name, |keys| keys[2]),
            Series::new(INJURY.into(), &found).into(),
        ];
        columns
            .extend(COMPARED[1..].iter().map(|name| Values::full_null((*name).into(), keys.len(), &DataType::Float64)));
        let pairs = search_pairs(&DataFrame::new(keys.len(), columns).unwrap()).unwrap();
        assert_eq!(pairs.height(), 165, "55 pairs of drivers in 3 towns");
        pairs
    }

    /// The number of rows with a probability below 0.05.
    fn findings(pairs: &DataFrame, p: &str) -> usize {
        pairs.column(p).unwrap().f64().unwrap().iter().flatten().filter(|p| *p < 0.05).count()
    }

    #[test]
    fn in_95_of_100_campaigns_without_a_difference_no_finding_is_false() {
        const CAMPAIGNS: u64 = 200;
        let (mut raw, mut corrected) = (0, 0);
        for number in 0..CAMPAIGNS {
            let pairs = pairs(&mut Seed::root(41).index(number).stream(), false);
            raw += u64::from(findings(&pairs, P) > 0);
            corrected += u64::from(findings(&pairs, P_HOLM) > 0);
        }
        // Of 200 campaigns at 0.05 the share has a standard deviation of 0.015.
        let share = |number: u64| number as f64 / CAMPAIGNS as f64;
        assert!(share(corrected) <= 0.09, "{}", share(corrected));
        assert!(share(raw) > 0.9, "without the correction hardly a campaign is free of one: {}", share(raw));
    }

    #[test]
    fn a_driver_that_is_better_is_found_in_every_town() {
        let pairs = pairs(&mut Seed::root(43).stream(), true);
        assert!(findings(&pairs, P_HOLM) >= 28, "of 30 rows with it");
    }
}

use std::collections::BTreeSet;

use polars::prelude::DataFrame;

use super::requirements::{
    INSTANT, NO_VERDICT, PART, PRIORITY, REQUIREMENT, ROBUSTNESS, ROBUSTNESS_UNIT, no_verdict, unit_of,
};
use super::survival::{MedianTime, median_time};
use crate::analysis::Impact;
use crate::campaign::{Evaluated, SearchResult};
use crate::record::columns::{
    BLOCK, DIGEST, DRIVING_MODE, EPISODE, EPISODE_LENGTH, EPISODE_REWARD, FAULT_IF, IMPACT, IMPACT_SPEED, POLICY,
    REWARD, RUN, RUN_ID, STATE_HASHES, TOWN,
};
use crate::record::metric::MEAN;
use crate::record::{Column, Entry, Interval, Table, reference_columns, verdict_columns};
use base::statistics::{mean_interval, quantile};
use compile::SearchKey;
use world::env::{Ending, Outcome};
use world::falsifier::Failure;
use world::judge::{Class, Question, Verdict, ViolationVerdict};
use world::requirement::{Degree, NamedRequirement};

/// The figures of a search.
#[derive(Debug, Clone, PartialEq)]
pub struct Figures {
    ticks: u64,
    failures: usize,
    failed_starts: usize,
    /// The number of starts from which it searched.
    starts: u64,
    failure_rate: Option<f64>,
    first: Option<u64>,
    /// Simulations up to the first failure.
    first_simulations: Option<u64>,
    distinct: usize,
    /// The number of failures, and the number of their cells, of those that are preventable and of those that are faults.
    preventable: [usize; 2],
    fault: [usize; 2],
    /// Whether failures have verdicts. Otherwise the numbers of those and of faults are not known.
    is_judged: bool,
    fault_rate: Option<f64>,
    fault_starts: usize,
    pub(super) fault_start_rate: Option<f64>,
    first_fault: Option<u64>,
    /// The avoidable injury of a thousand episodes.
    pub(super) injury: Option<f64>,
    /// The numbers of flank, slow and narrow touches.
    touches: [usize; 3],
    /// Shares of the starts with a fault with other figures of the careful humans, in the order of
    /// [`Sensitivity::NAMES`](world::judge::Sensitivity::NAMES).
    fault_start_rates_if: [Option<f64>; 4],
    evaluated: u64,
    /// Collisions, or violations of the goal.
    evaluated_failures: usize,
    evaluated_rate: Option<f64>,
    evaluated_faults: usize,
    evaluated_faults_rate: Option<f64>,
    evaluated_reward: Option<f64>,
}

impl Figures {
    /// The figures by which two searches are compared, with their names.
    pub(super) fn compared(&self) -> [(&'static str, Option<f64>); 7] {
        [
            (INJURY, self.injury),
            (DISTINCT_PER_MILLION, self.judged(per_million(self.fault[1], self.ticks))),
            (FAULT_RATE, self.fault_rate),
            (FAULT_START_RATE, self.fault_start_rate),
            (FAILED_STARTS, Some(self.failed_starts as f64)),
            (FAULT_STARTS, self.judged(Some(self.fault_starts as f64))),
            (EVALUATED_FAULT_RATE, self.evaluated_faults_rate),
        ]
    }

    /// A figure of faults; none where failures have no verdict.
    fn judged(&self, figure: Option<f64>) -> Option<f64> {
        figure.filter(|_| self.is_judged)
    }

    /// A number of faults; none where failures have no verdict.
    fn judged_count(&self, count: usize) -> Option<u64> {
        self.is_judged.then_some(count as u64)
    }

    pub(super) fn new(result: &SearchResult) -> Self {
        let spent = &result.spent;
        let share = |part: usize, whole: u64| (whole > 0).then(|| part as f64 / whole as f64);
        let cells: BTreeSet<_> = spent.failures.iter().map(|failure| failure.cell).collect();
        let is_judged = result.is_judged();
        let blamed: Vec<(&Failure, (bool, bool))> =
            spent.failures.iter().enumerate().map(|(number, failure)| (failure, result.blame(number))).collect();
        let judged = |counts: fn((bool, bool)) -> bool| {
            let found = blamed.iter().filter(|(_, blame)| counts(*blame));
            let cells: Vec<_> = found.map(|(failure, _)| failure.cell).collect();
            [cells.len(), cells.into_iter().collect::<BTreeSet<_>>().len()]
        };
        let (preventable, fault) = (judged(|(preventable, _)| preventable), judged(|(_, fault)| fault));
        let faults = || blamed.iter().filter(|(_, (_, fault))| *fault).map(|(failure, _)| failure);
        let found = spent.failures.iter().zip(&result.verdicts);
        let found: Vec<(&Failure, &Verdict)> =
            found.filter_map(|(failure, verdict)| Some((failure, verdict.as_ref()?))).collect();
        let starts_with = |is: &dyn Fn(&Verdict) -> bool| {
            let of_these = found.iter().filter(|(_, verdict)| is(verdict));
            of_these.map(|(failure, _)| failure.start).collect::<BTreeSet<_>>().len()
        };
        let fault_starts = faults().map(|failure| failure.start).collect::<BTreeSet<_>>().len();
        let first_fault = faults().map(|failure| failure.ticks).min();
        let of_judged = |rate: Option<f64>| rate.filter(|_| is_judged);
        let injury: f64 = found.iter().map(|(_, verdict)| verdict.avoidable_injury()).sum();
        let touches = TOUCHES.map(|class| found.iter().filter(|(_, verdict)| verdict.class() == class).count());
        let if_so = |place: usize| starts_with(&|verdict| verdict.sensitivity.values()[place]);
        let fault_start_rates_if = [0, 1, 2, 3].map(|place| share(if_so(place), spent.starts.count()));
        let evaluated: Vec<&Evaluated> = result.evaluated.iter().filter(|each| each.outcome.counts()).collect();
        let number = evaluated.len() as u64;
        let evaluated_failures = evaluated.iter().filter(|each| each.is_failure()).count();
        let evaluated_faults = evaluated.iter().filter(|each| each.is_fault()).count();
        let reward: f64 = evaluated.iter().map(|each| each.outcome.reward).sum();
        Self {
            ticks: spent.ticks,
            failures: spent.failures.len(),
            failed_starts: spent.failures.iter().map(|failure| failure.start).collect::<BTreeSet<_>>().len(),
            starts: spent.starts.count(),
            failure_rate: share(spent.failures.len(), spent.episodes),
            first: spent.failures.first().map(|failure| failure.ticks),
            first_simulations: spent.failures.first().map(|failure| failure.simulations),
            distinct: cells.len(),
            preventable,
            fault,
            is_judged,
            fault_rate: of_judged(share(fault[0], spent.episodes)),
            fault_starts,
            fault_start_rate: of_judged(share(fault_starts, spent.starts.count())),
            first_fault,
            injury: (spent.episodes > 0).then(|| injury * 1000.0 / spent.episodes as f64),
            touches,
            fault_start_rates_if,
            evaluated: number,
            evaluated_failures,
            evaluated_rate: share(evaluated_failures, number),
            evaluated_faults,
            evaluated_faults_rate: of_judged(share(evaluated_faults, number)),
            evaluated_reward: (number > 0).then(|| reward / number as f64),
        }
    }
}

/// The side of the car that was hit; none of a violation without a touch.
fn impact(outcome: &Outcome) -> Option<Impact> {
    match outcome.ending {
        Ending::Touch { front, bearing, .. } => Some(Impact::new(front, bearing)),
        _ => None,
    }
}

/// The number of events in a million ticks.
fn per_million(count: usize, ticks: u64) -> Option<f64> {
    (ticks > 0).then(|| count as f64 * 1e6 / ticks as f64)
}

/// All runs of a falsifier in one town against one policy, for people.
#[derive(Debug, Clone, PartialEq)]
pub struct SearchCell {
    /// The falsifier, the town and the policy; the run is the first.
    pub key: SearchKey,
    /// The name of the requirement that it tried to violate; none of a search for collisions.
    pub goal: Option<String>,
    /// The budget of each run (simulator ticks).
    pub budget: u64,
    pub runs: usize,
    /// The number of runs without a failure.
    pub censored: usize,
    /// Ticks to the first failure.
    pub first_failure: MedianTime,
    /// Simulations to the first failure, run by run, of the runs that found one.
    pub simulations: Vec<u64>,
    /// Share of the episodes that failed. This and the following are means over runs with intervals.
    pub failure_rate: Average,
    pub failures: Average,
    /// The number of starts from which a failure was found.
    pub failed_starts: Average,
    /// The number of starts from which it searched.
    pub starts: Average,
    /// The number of kinds of failures.
    pub distinct: Average,
    /// Preventable failures.
    pub preventable: Average,
    /// Preventable failures with a foreseeable pedestrian.
    pub fault: Average,
    /// These in a million ticks.
    pub faults_per_million: Average,
    /// Kinds of these in a million ticks.
    pub distinct_faults_per_million: Average,
    /// Collision rate of the walk policy that it ended up with.
    pub evaluated_rate: Average,
    /// Share of the controller's episodes that ended in a fault.
    pub evaluated_faults_rate: Average,
    /// Share of the search's own episodes that ended in a fault.
    pub fault_rate: Average,
    /// Share of the starts from which it found one, and the number of these starts.
    pub fault_start_rate: Average,
    pub fault_starts: Average,
    /// Share of the starts with a fault with other figures of the careful humans, in the order of
    /// [`Sensitivity::NAMES`](world::judge::Sensitivity::NAMES).
    pub fault_start_rates_if: [Average; 4],
    /// The avoidable injury of a thousand episodes.
    pub injury: Average,
    /// Ticks to the first fault.
    pub first_fault: MedianTime,
}

impl SearchCell {
    /// Share of the runs that found a failure, as ARCH-COMP counts it.
    pub fn falsified(&self) -> f64 {
        (self.runs - self.censored) as f64 / self.runs.max(1) as f64
    }

    /// Mean and median of the simulations to the first failure over the runs that found one, as ARCH-COMP counts them; none without such a run.
    pub fn simulations_to_first(&self) -> Option<(f64, f64)> {
        let mut sorted: Vec<f64> = self.simulations.iter().map(|count| *count as f64).collect();
        sorted.sort_by(f64::total_cmp);
        let median = quantile(&sorted, 0.5)?;
        Some((sorted.iter().sum::<f64>() / sorted.len() as f64, median))
    }

    /// Whether no run tried a start, so that nothing is known.
    pub fn is_empty(&self) -> bool {
        self.starts.mean == Some(0.0)
    }

    /// Its name, for people.
    pub fn in_full(&self) -> String {
        let key = &self.key;
        let block = if key.block == 0 { String::new() } else { format!(" #{}", key.block) };
        format!("{}{block} in {} against {}", key.falsifier, key.town, key.policy)
    }
}

/// A mean over runs with Student's 95 % interval.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Average {
    /// The mean; none without a value.
    pub mean: Option<f64>,
    /// The interval, about further runs in this town; none for fewer than four runs.
    pub interval: Option<(f64, f64)>,
    /// The value of each run that has one, in their order.
    pub by_run: Vec<f64>,
}

impl Average {
    fn new(values: impl Iterator<Item = Option<f64>>) -> Self {
        let by_run: Vec<f64> = values.flatten().collect();
        if by_run.is_empty() {
            return Self::default();
        }
        let (mean, interval) = mean_interval(&by_run);
        // No averaged value can be below 0.
        Self { mean: Some(mean), interval: interval.map(|(low, high)| (low.max(0.0), high)), by_run }
    }

    /// Cuts the interval of a share at 1.
    fn of_share(self) -> Self {
        Self { interval: self.interval.map(|(low, high)| (low, high.min(1.0))), ..self }
    }
}

/// Gathers runs into cells, in the order of first appearance.
pub fn search_cells(results: &[SearchResult]) -> Vec<SearchCell> {
    let mut cells: Vec<Vec<&SearchResult>> = Vec::new();
    for result in results {
        match cells.iter_mut().find(|cell| cell[0].key.is_of_same_cell(&result.key)) {
            Some(cell) => cell.push(result),
            None => cells.push(vec![result]),
        }
    }
    cells.iter().map(|cell| gather(cell)).collect()
}

fn gather(cell: &[&SearchResult]) -> SearchCell {
    let figures: Vec<Figures> = cell.iter().map(|result| Figures::new(result)).collect();
    let times: Vec<(f64, bool)> = figures
        .iter()
        .zip(cell)
        .map(|(figures, result)| (figures.first.unwrap_or(result.spent.ticks) as f64, figures.first.is_some()))
        .collect();
    let fault_times: Vec<(f64, bool)> = figures
        .iter()
        .zip(cell)
        .map(|(figures, result)| {
            (figures.first_fault.unwrap_or(result.spent.ticks) as f64, figures.first_fault.is_some())
        })
        .collect();
    let over = |value: &dyn Fn(&Figures) -> Option<f64>| Average::new(figures.iter().map(value));
    SearchCell {
        key: cell[0].key.clone(),
        goal: cell[0].goal.as_ref().map(|(named, _)| named.name.to_string()),
        budget: cell[0].budget,
        runs: cell.len(),
        censored: figures.iter().filter(|figures| figures.first.is_none()).count(),
        first_failure: median_time(&times),
        simulations: figures.iter().filter_map(|figures| figures.first_simulations).collect(),
        failure_rate: over(&|figures| figures.failure_rate).of_share(),
        failures: over(&|figures| Some(figures.failures as f64)),
        failed_starts: over(&|figures| Some(figures.failed_starts as f64)),
        starts: over(&|figures| Some(figures.starts as f64)),
        distinct: over(&|figures| Some(figures.distinct as f64)),
        preventable: over(&|figures| figures.judged(Some(figures.preventable[0] as f64))),
        fault: over(&|figures| figures.judged(Some(figures.fault[0] as f64))),
        faults_per_million: over(&|figures| figures.judged(per_million(figures.fault[0], figures.ticks))),
        distinct_faults_per_million: over(&|figures| figures.judged(per_million(figures.fault[1], figures.ticks))),
        evaluated_rate: over(&|figures| figures.evaluated_rate).of_share(),
        evaluated_faults_rate: over(&|figures| figures.evaluated_faults_rate).of_share(),
        fault_rate: over(&|figures| figures.fault_rate).of_share(),
        fault_start_rate: over(&|figures| figures.fault_start_rate).of_share(),
        fault_starts: over(&|figures| figures.judged(Some(figures.fault_starts as f64))),
        fault_start_rates_if: [0, 1, 2, 3].map(|place| over(&|figures| figures.fault_start_rates_if[place]).of_share()),
        injury: over(&|figures| figures.injury),
        first_fault: median_time(&fault_times),
    }
}

pub const FALSIFIER: Column<String> = Column::new("falsifier", "", "name of the falsifier");
pub const FAILURE: Column<u64> =
    Column::new("failure", "", "number of the failure in its search, from 0; `RUN_ID:FAILURE` is its name");
pub const START: Column<u64> = Column::new("start", "", "number of its start");
pub const FOUND_AFTER: Column<u64> = Column::new("found_after_ticks", "", "simulator ticks that the search had used");
pub const COMMANDS: Column<String> = Column::new(
    "commands",
    "",
    "`heading@speed` in rad and m/s, one for each decision, in the world frame; equal seeds, starts and commands give equal digests",
);
const CELL: Column<String> = Column::new(
    "cell",
    "",
    "how the two met: place on the car, direction of the walk relative to the car, impact speed in m/s, walking speed in m/s, the driver's \
     mode; failures in one cell count as one finding",
);
/// The name of a table of searches.
pub const SEARCHES: &str = "searches";
pub const STARTS: Column<u64> = Column::new(
    "starts",
    "",
    "different starts of these episodes; starts 0, 1, 2, … of a run are the same for all falsifiers",
);
pub const TRIED: Column<String> = Column::new(
    "tried",
    "",
    "numbers of these starts, as `0-31 40`; `archive` leaves starts that promise little without an episode",
);
pub const FIRST_START: Column<String> = Column::new(
    "first_start",
    "",
    "number of the first of these starts and hash of it as it was drawn: searches with equal ones have the same starts",
);
/// The stem of the files of the table of failures.
pub const FAILURES: &str = "search_failures";

pub const SEARCH_BLOCK: Column<u64> =
    Column::new(BLOCK.name, "", "number of the `search` block in its campaign, from 0");
pub const SEARCH_RUN: Column<u64> = Column::new(RUN.name, "", "number of the run, from 0");
pub const BUDGET: Column<u64> = Column::new("budget_ticks", "", "simulator ticks that each run may use");
// The columns of searches that cells of searches summarise.
const FAILURE_COUNT: &str = "failures";
const FAILURE_RATE: &str = "failure_rate";
pub const FAILED_STARTS: &str = "failed_starts";
/// Ticks to the first failure.
pub const FIRST_FAILURE: &str = "first_failure_ticks";
/// Simulations to the first failure.
const FIRST_SIMULATIONS: &str = "first_failure_simulations";
const DISTINCT: &str = "distinct_failures";
const PREVENTABLE: &str = "preventable_failures";
const FAULT: &str = "faults";
const FAULT_RATE: &str = "fault_rate";
const FAULT_STARTS: &str = "fault_starts";
const FAULT_START_RATE: &str = "fault_start_rate";
/// Ticks to the first fault.
pub const FIRST_FAULT: &str = "first_fault_ticks";
const INJURY: &str = "avoidable_injury_per_thousand";
/// What would be a fault but for one thing, with the names of the numbers.
const TOUCHES: [Class; 3] = [Class::Flank, Class::Slow, Class::Narrow];
const TOUCH_COUNTS: [&str; 3] = ["flank_touches", "slow_touches", "narrow_touches"];
/// Shares of the starts with a fault, if the careful humans had other figures.
const FAULT_START_RATES_IF: [&str; 4] =
    ["fault_start_rate_sooner", "fault_start_rate_later", "fault_start_rate_short_gate", "fault_start_rate_long_gate"];
const FAULT_PER_MILLION: &str = "faults_per_million_ticks";
const DISTINCT_PER_MILLION: &str = "distinct_faults_per_million_ticks";
const EVALUATED_RATE: &str = "evaluated_rate";
const EVALUATED_FAULT_RATE: &str = "evaluated_faults_rate";

/// The columns of a search's key, without the run.
pub fn search_key<'t, R>(key: impl Fn(&R) -> &SearchKey + Copy + 't) -> [Entry<'t, R>; 6] {
    [
        FALSIFIER.of(move |row: &R| key(row).falsifier.clone()),
        Column::<String>::new("method", "", "kind of the falsifier").of(move |row: &R| key(row).method),
        REWARD
            .of(move |row: &R| key(row).reward.clone())
            .meaning("reward that it maximises; empty for a falsifier without a reward"),
        TOWN.of(move |row: &R| key(row).town.clone()),
        POLICY.of(move |row: &R| key(row).policy.clone()),
        SEARCH_BLOCK.of(move |row: &R| u64::from(key(row).block)),
    ]
}

fn run<'t, R>(key: impl Fn(&R) -> &SearchKey + 't) -> Entry<'t, R> {
    SEARCH_RUN.of(move |row: &R| u64::from(key(row).run))
}

pub type Searched<'a> = (&'a SearchResult, Figures);

/// Searches as a table, one row each, in the order given.
pub fn searches(results: &[SearchResult]) -> DataFrame {
    let rows: Vec<Searched<'_>> = results.iter().map(|result| (result, Figures::new(result))).collect();
    search_table().frame(&rows)
}

/// The columns of [`searches`].
pub fn search_table<'a>() -> Table<'a, Searched<'a>> {
    type Row<'a> = Searched<'a>;
    let (count, number) = (Column::<u64>::new, Column::<f64>::new);
    Table::new(
        SEARCHES,
        "One row for each search: a falsifier in one town against one policy, one run. Rates within a search are shares of what it tried, \
         not the failure rate of the driver.",
    )
    .column(RUN_ID.of(|row: &Row<'_>| row.0.key.id.to_string()))
    .columns(search_key(|row: &Row<'_>| &row.0.key))
    .column(run(|row: &Row<'_>| &row.0.key))
    .column(BUDGET.of(|row: &Row<'_>| row.0.budget))
    .column(
        count(
            "used_ticks",
            "",
            "simulator ticks that it used; less than a command is left over, more by `ppo` with several environments, which stops when the \
             first has used its share",
        )
        .of(|row: &Row<'_>| row.0.spent.ticks),
    )
    .column(
        count("episodes", "", "episodes that came to an end and count, without one that the budget cut off")
            .of(|row: &Row<'_>| row.0.spent.episodes),
    )
    .column(
        count("left_out_episodes", "", "further episodes that are left out: see `left_out` of `episodes`")
            .of(|row: &Row<'_>| row.0.spent.left_out),
    )
    .column(STARTS.of(|row: &Row<'_>| row.0.spent.starts.count()))
    .column(TRIED.of(|row: &Row<'_>| row.0.spent.starts.to_string()))
    .column(FIRST_START.of(|row: &Row<'_>| row.0.spent.first_start.map(|(number, hash)| format!("{number}:{hash:016x}"))))
    .column(count(FAILURE_COUNT, "", "episodes that ended in a collision, or that violate the goal of the search").of(|row: &Row<'_>| row.1.failures as u64))
    .column(number(FAILURE_RATE, "", "their share of `episodes`").of(|row: &Row<'_>| row.1.failure_rate))
    .column(
        count(
            FAILED_STARTS,
            "",
            "starts from which a failure was found; the fair count between methods that leave a start after a failure (`cem`, `cma_es`, \
             `mcts`) and those that walk once from each",
        )
        .of(|row: &Row<'_>| row.1.failed_starts as u64),
    )
    .column(
        number(FIRST_FAILURE, "", "ticks used when the first was found, its own included; missing if none was found")
            .of(|row: &Row<'_>| row.1.first.map(|ticks| ticks as f64)),
    )
    .column(
        count(
            FIRST_SIMULATIONS,
            "",
            "simulations up to the first failure, its own included: finished episodes, also those that are left out; missing if none was found",
        )
        .of(|row: &Row<'_>| row.1.first_simulations),
    )
    .column(Column::<bool>::new("censored", "", "whether none was found").of(|row: &Row<'_>| row.1.first.is_none()))
    .column(
        count(
            DISTINCT,
            "",
            "different cells of the failures: see `cell` of `search_failures`",
        )
        .of(|row: &Row<'_>| row.1.distinct as u64),
    )
    .column(count(PREVENTABLE, "", "failures that both careful humans avoid").of(|row: &Row<'_>| row.1.judged_count(row.1.preventable[0])))
    .column(
        count(FAULT, "", "failures that count against the driver: see `fault` of `search_failures`, and `goal_fault` where there is a goal; missing where \
             the goal has no verdict, as all figures of faults")
            .of(|row: &Row<'_>| row.1.judged_count(row.1.fault[0])),
    )
    .column(
        number(FAULT_RATE, "", "share of `episodes` that ended in a fault")
            .of(|row: &Row<'_>| row.1.fault_rate),
    )
    .column(
        count(FAULT_STARTS, "", "starts from which a fault was found")
            .of(|row: &Row<'_>| row.1.judged_count(row.1.fault_starts)),
    )
    .column(
        number(FAULT_START_RATE, "", "their share of `starts`; for an exhaustive search the ceiling of all others")
            .of(|row: &Row<'_>| row.1.fault_start_rate),
    )
    .columns((0..4).map(|place| {
        number(FAULT_START_RATES_IF[place], "", FAULT_IF.doc()).of(move |row: &Row<'_>| row.1.fault_start_rates_if[place])
    }))
    .column(
        number(FIRST_FAULT, "", "ticks used when the first fault was found, its own included; missing if none was found")
            .of(|row: &Row<'_>| row.1.first_fault.map(|ticks| ticks as f64)),
    )
    .column(
        number(INJURY, "", "sum of the severe-injury risks of the faults, for 1,000 of `episodes`: what a careful human would have spared")
            .of(|row: &Row<'_>| row.1.injury),
    )
    .columns((0..3).map(|place| {
        count(TOUCH_COUNTS[place], "", "failures whose `counts_as` is that: faults but for one thing")
            .of(move |row: &Row<'_>| row.1.touches[place] as u64)
    }))
    .column(
        count("distinct_preventable", "", "different cells of preventable failures")
            .of(|row: &Row<'_>| row.1.judged_count(row.1.preventable[1])),
    )
    .column(
        count("distinct_faults", "", "different cells of faults")
            .of(|row: &Row<'_>| row.1.judged_count(row.1.fault[1])),
    )
    .column(
        number(FAULT_PER_MILLION, "", "faults in a million of the ticks that the search used")
            .of(|row: &Row<'_>| row.1.judged(per_million(row.1.fault[0], row.1.ticks))),
    )
    .column(
        number(DISTINCT_PER_MILLION, "", "different cells of faults in a million of these ticks")
            .of(|row: &Row<'_>| row.1.judged(per_million(row.1.fault[1], row.1.ticks))),
    )
    .column(
        count(
            "evaluated_episodes",
            "",
            "fresh episodes of the controller that the falsifier ended with, outside the budget; their starts are those of `evaluate`",
        )
        .of(|row: &Row<'_>| row.1.evaluated),
    )
    .column(
        count("evaluated_failures", "", "collisions of these, or violations of the goal")
            .of(|row: &Row<'_>| row.1.evaluated_failures as u64),
    )
    .column(number(EVALUATED_RATE, "", "their share of `evaluated_episodes`").of(|row: &Row<'_>| row.1.evaluated_rate))
    .column(
        count("evaluated_faults", "", "faults of these")
            .of(|row: &Row<'_>| row.1.judged_count(row.1.evaluated_faults)),
    )
    .column(
        number(EVALUATED_FAULT_RATE, "", "their share of `evaluated_episodes`")
            .of(|row: &Row<'_>| row.1.evaluated_faults_rate),
    )
    .column(number("evaluated_reward", "", "their mean reward; 0 without a reward").of(|row: &Row<'_>| row.1.evaluated_reward))
}

/// Cells of searches as a table, one row each, in the order given.
pub fn search_cell_table(cells: &[SearchCell]) -> DataFrame {
    search_cell_columns().frame(cells)
}

/// The columns of [`search_cell_table`].
pub fn search_cell_columns() -> Table<'static, SearchCell> {
    let (count, number) = (Column::<u64>::new, Column::<f64>::new);
    let time = "Kaplan and Meier's median of `first_failure_ticks` with Brookmeyer and Crowley's 95 % interval on the log-log scale; \
                what the runs do not show is missing, the high end always with fewer than seven runs";
    Table::new(
        "search_cells",
        "One row for each falsifier, town and policy, over all runs. Runs have different seeds *and* starts. A row says nothing about other towns: \
         between towns the figures of one driver may differ several times.",
    )
    .columns(search_key(|cell: &SearchCell| &cell.key))
    .column(count("runs", "", "number of runs").of(|cell: &SearchCell| cell.runs as u64))
    .column(BUDGET.of(|cell: &SearchCell| cell.budget))
    .column(
        count("censored_runs", "", "number of runs that found nothing").of(|cell: &SearchCell| cell.censored as u64),
    )
    .column(
        number("falsified_share", "", "share of the runs that found a failure, as ARCH-COMP counts it")
            .of(|cell: &SearchCell| cell.falsified()),
    )
    .column(
        number("simulations_to_first_mean", "", "mean of `first_failure_simulations` over these runs")
            .of(|cell: &SearchCell| cell.simulations_to_first().map(|(mean, _)| mean)),
    )
    .column(
        number("simulations_to_first_median", "", "their median")
            .of(|cell: &SearchCell| cell.simulations_to_first().map(|(_, median)| median)),
    )
    .column(Entry::new::<f64, _>(
        format!("{FIRST_FAILURE}_median").into(),
        "".into(),
        time.into(),
        |cell: &SearchCell| cell.first_failure.median,
    ))
    .columns(
        Interval::new(FIRST_FAILURE, "", time)
            .of_ends(|cell: &SearchCell| cell.first_failure.low, |cell: &SearchCell| cell.first_failure.high),
    )
    .columns(averaged(STARTS.name, |cell| &cell.starts))
    .columns(averaged(FAILURE_RATE, |cell| &cell.failure_rate))
    .columns(averaged(FAILURE_COUNT, |cell| &cell.failures))
    .columns(averaged(FAILED_STARTS, |cell| &cell.failed_starts))
    .columns(averaged(DISTINCT, |cell| &cell.distinct))
    .columns(averaged(PREVENTABLE, |cell| &cell.preventable))
    .columns(averaged(FAULT, |cell| &cell.fault))
    .columns(averaged(FAULT_PER_MILLION, |cell| &cell.faults_per_million))
    .columns(averaged(DISTINCT_PER_MILLION, |cell| &cell.distinct_faults_per_million))
    .columns(averaged(EVALUATED_RATE, |cell| &cell.evaluated_rate))
    .columns(averaged(EVALUATED_FAULT_RATE, |cell| &cell.evaluated_faults_rate))
    .columns(averaged(FAULT_RATE, |cell| &cell.fault_rate))
    .columns(averaged(FAULT_START_RATE, |cell| &cell.fault_start_rate))
    .columns(averaged(FAULT_START_RATES_IF[0], |cell| &cell.fault_start_rates_if[0]))
    .columns(averaged(FAULT_START_RATES_IF[1], |cell| &cell.fault_start_rates_if[1]))
    .columns(averaged(FAULT_START_RATES_IF[2], |cell| &cell.fault_start_rates_if[2]))
    .columns(averaged(FAULT_START_RATES_IF[3], |cell| &cell.fault_start_rates_if[3]))
    .columns(averaged(INJURY, |cell| &cell.injury))
    .column(Entry::new::<f64, _>(
        format!("{FIRST_FAULT}_median").into(),
        "".into(),
        time.into(),
        |cell: &SearchCell| cell.first_fault.median,
    ))
}

/// The mean of a column over runs with its interval.
fn averaged(name: &'static str, value: fn(&SearchCell) -> &Average) -> Vec<Entry<'static, SearchCell>> {
    let doc = "mean over `runs` with Student's 95 % interval, cut at 0 and for rates at 1. The interval is about further runs in this town, not about \
               other towns; missing for fewer than four runs";
    let mut entries = vec![MEAN.of(name, move |cell: &SearchCell| value(cell).mean).meaning(doc)];
    entries.extend(Interval::new(name, "", doc).of(move |cell: &SearchCell| value(cell).interval));
    entries
}

/// A failure of a search with its number.
pub type Found<'a> = (&'a SearchKey, &'a Failure, u64, Option<Verdict>);

/// The failures of all searches as a table, one row each, in the order in which they were found.
pub fn search_failures(results: &[SearchResult]) -> DataFrame {
    let mut table = failure_table().frame(&found(results));
    if results.iter().any(|result| result.goal.is_some()) {
        let violated = |result| {
            let SearchResult { goal, spent, violations, .. }: &SearchResult = result;
            spent.failures.iter().enumerate().map(move |(number, failure)| {
                let (goal, degree) = goal.as_ref().zip(failure.violation.as_ref())?;
                Some(Violation { goal, degree, failure, verdict: violations.get(number).copied().flatten() })
            })
        };
        let rows: Vec<Violated<'_>> = results.iter().flat_map(violated).collect();
        table = table.hstack(&violation_table().values(&rows)).expect("the columns have other names");
    }
    table
}

/// A violated goal; none of a search for collisions.
type Violated<'a> = Option<Violation<'a>>;

/// A violated goal.
#[derive(Debug, Clone, Copy)]
struct Violation<'a> {
    /// The goal, and the length of a tick (s).
    goal: &'a (NamedRequirement, f64),
    degree: &'a Degree,
    failure: &'a Failure,
    verdict: Option<ViolationVerdict>,
}

pub const GOAL_PREVENTABLE: Column<bool> = Column::new(
    "goal_preventable",
    "",
    "whether both careful humans satisfy the goal from the start of the danger on; missing where it has no verdict",
);
pub const GOAL_FORESEEABLE: Column<bool> = Column::new(
    "goal_foreseeable",
    "",
    "whether the pedestrian of the violation moved as people do; missing where the goal has no verdict",
);
pub const GOAL_FAULT: Column<bool> = Column::new(
    "goal_fault",
    "",
    "whether the violation counts against the driver: see `fault` of `requirements`; missing where the goal has no verdict",
);

/// The columns of the violations of goals.
fn violation_table<'a>() -> Table<'a, Violated<'a>> {
    type Row<'a> = Violated<'a>;
    let part = |row: &Violation<'_>| {
        let found = row.degree.part.and_then(|part| row.goal.0.requirement.parts.get(usize::from(part)));
        found.map(|part| part.text.clone())
    };
    let instant = |row: Violation<'_>| (f64::from(row.degree.sample) * row.goal.1).min(row.failure.outcome.duration);
    let verdict = |row: &Row<'_>| row.and_then(|row| row.verdict);
    Table::new("", "")
        .column(REQUIREMENT.of(|row: &Row<'_>| row.map(|row| row.goal.0.name.to_string())))
        .column(PRIORITY.of(|row: &Row<'_>| row.map(|row| row.goal.0.priority)))
        .column(ROBUSTNESS.of(|row: &Row<'_>| row.map(|row| row.degree.robustness)))
        .column(ROBUSTNESS_UNIT.of(|row: &Row<'_>| row.map(|row| unit_of(&row.goal.0))))
        .column(INSTANT.of(move |row: &Row<'_>| row.map(instant)))
        .column(PART.of(move |row: &Row<'_>| row.as_ref().and_then(part)))
        .column(GOAL_PREVENTABLE.of(move |row: &Row<'_>| verdict(row).map(|verdict| verdict.preventable)))
        .column(GOAL_FORESEEABLE.of(move |row: &Row<'_>| verdict(row).map(|verdict| verdict.foreseeable)))
        .column(GOAL_FAULT.of(move |row: &Row<'_>| verdict(row).map(|verdict| verdict.fault)))
        .column(NO_VERDICT.of(|row: &Row<'_>| row.map(|row| no_verdict(Question::of(&row.goal.0.requirement)))))
}

/// What the reference drivers did in these failures, as [`reference_drivers`](crate::record::reference_drivers) reads it.
pub fn search_references(results: &[SearchResult]) -> DataFrame {
    let of_drivers = reference_columns(|row: &Found<'_>| row.3, |_| None);
    Table::new("", "")
        .column(RUN_ID.of(|row: &Found<'_>| row.0.id.to_string()))
        .column(EPISODE.of(|row: &Found<'_>| row.2 as u32))
        .columns(of_drivers)
        .frame(&found(results))
}

fn found<'a>(results: &'a [SearchResult]) -> Vec<Found<'a>> {
    let numbered = |result: &'a SearchResult| {
        let verdict = |number: usize| result.verdicts.get(number).copied().flatten();
        let failures = result.spent.failures.iter().enumerate();
        failures.map(move |(number, each)| (&result.key, each, number as u64, verdict(number)))
    };
    results.iter().flat_map(numbered).collect()
}

/// A failure of a search as a row of that table.
pub fn search_failure(key: &SearchKey, number: u64, failure: &Failure, verdict: Option<Verdict>) -> DataFrame {
    failure_table().frame(&[(key, failure, number, verdict)])
}

/// The columns of [`search_failures`].
pub fn failure_table<'a>() -> Table<'a, Found<'a>> {
    type Row<'a> = Found<'a>;
    let doc = "One row for each failure that a search found, with the commands that lead to it. Where a search has a goal, `requirement`, \
               `priority`, `robustness`, `unit`, `instant_s` and `part` follow, as in `requirements`, and `goal_preventable`, `goal_foreseeable`, \
               `goal_fault` and `no_verdict`.";
    Table::new(FAILURES, doc)
        .column(RUN_ID.of(|row: &Row<'_>| row.0.id.to_string()))
        .columns(search_key(|row: &Row<'_>| row.0))
        .column(run(|row: &Row<'_>| row.0))
        .column(FAILURE.of(|row: &Row<'_>| row.2))
        .column(START.of(|row: &Row<'_>| row.1.start))
        .column(FOUND_AFTER.of(|row: &Row<'_>| row.1.ticks))
        .column(IMPACT.of(|row: &Row<'_>| impact(&row.1.outcome).map(Impact::name)))
        .column(DRIVING_MODE.of(|row: &Row<'_>| row.1.outcome.last_mode.name()))
        .column(IMPACT_SPEED.of(|row: &Row<'_>| row.1.outcome.impact_speed()))
        .column(CELL.of(|row: &Row<'_>| row.1.cell.to_string()))
        .column(EPISODE_REWARD.of(|row: &Row<'_>| row.1.outcome.reward))
        .column(EPISODE_LENGTH.of(|row: &Row<'_>| row.1.outcome.duration))
        .column(COMMANDS.of(|row: &Row<'_>| commands(row.1)))
        .column(DIGEST.of(|row: &Row<'_>| format!("{:016x}", row.1.outcome.digest)))
        .column(STATE_HASHES.of(|row: &Row<'_>| row.1.outcome.state_hashes.to_string()))
        .columns(verdict_columns(|row: &Row<'_>| row.3))
}

/// Commands as `heading@speed` (rad, m/s), with all digits that are needed to read the same numbers back.
fn commands(failure: &Failure) -> String {
    let each = failure.commands.iter().map(|command| format!("{}@{}", command.heading, command.speed));
    each.collect::<Vec<_>>().join(" ")
}

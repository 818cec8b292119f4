use polars::prelude::DataFrame;

use super::search_figures::{
    DISTINCT, DISTINCT_PER_MILLION, EVALUATED_FAULT_RATE, EVALUATED_RATE, FAILED_STARTS, FAILURE_COUNT, FAILURE_RATE,
    FAULT, FAULT_PER_MILLION, FAULT_RATE, FAULT_START_RATE, FAULT_START_RATES_IF, FIRST_FAILURE, FIRST_FAULT, Figures,
    INJURY, PREVENTABLE, per_million,
};
use super::searches::{BUDGET, STARTS, search_key};
use super::survival::{MedianTime, median_time};
use crate::jobs::SearchResult;
use crate::record::metric::MEAN;
use crate::record::{Column, Entry, Interval, Table};
use base::statistics::{mean_interval, quantile};
use compile::SearchKey;

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
        goal: cell[0].goal().map(|named| named.name.to_string()),
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

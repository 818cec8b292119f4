use super::search_figures::{FAILED_STARTS, FAULT, FAULT_START_RATE, FIRST_FAILURE, FIRST_FAULT, Figures, INJURY};
use super::searches::{BUDGET, STARTS, search_key};
use crate::jobs::SearchResult;
use crate::record::{Column, Entry, Interval, Role, Table, in_block};
use crate::report::grouped::grouped;
use crate::tables::Rate;
use crate::tables::metrics::MEAN;
use base::statistics::{MIN_RUNS, clopper_pearson, quantile};
use compile::SearchKey;

/// All runs of a falsifier in one town against one policy, for people.
#[derive(Debug, Clone, PartialEq)]
pub struct SearchCell {
    /// The falsifier, the town and the policy; the run is the first.
    pub key: SearchKey,
    /// The name of the requirement that it tried to violate; `None` for a search for collisions.
    pub goal: Option<String>,
    /// The budget of each run (simulator ticks).
    pub budget: u64,
    pub runs: usize,
    /// The number of runs without a failure.
    pub censored: usize,
    /// Median of the ticks to the first failure; `None` if too few runs found one.
    pub first_failure: Option<f64>,
    /// Simulations to the first failure, run by run, of the runs that found one.
    pub simulations: Vec<u64>,
    /// The number of starts from which a failure was found. This and the following are means over runs with intervals.
    pub failed_starts: Rate,
    /// The number of starts from which it searched.
    pub starts: Rate,
    pub faults: Rate,
    /// Fraction of the starts from which it found a fault, and the number of these starts.
    pub fault_start_rate: Rate,
    pub fault_starts: Rate,
    /// The avoidable injury of a thousand episodes.
    pub injury: Rate,
    /// Median of the ticks to the first fault.
    pub first_fault: Option<f64>,
}

impl SearchCell {
    /// Fraction of the runs that found a failure, as ARCH-COMP counts it.
    pub fn falsified(&self) -> f64 {
        (self.runs - self.censored) as f64 / self.runs.max(1) as f64
    }

    /// Mean and median of the simulations to the first failure over the runs that found one, as ARCH-COMP counts them; `None` without such a run.
    pub fn simulations_to_first(&self) -> Option<(f64, f64)> {
        let mut sorted: Vec<f64> = self.simulations.iter().map(|count| *count as f64).collect();
        sorted.sort_by(f64::total_cmp);
        let median = quantile(&sorted, 0.5)?;
        Some((sorted.iter().sum::<f64>() / sorted.len() as f64, median))
    }

    /// Whether no run tried a start, so that nothing is known.
    pub fn is_empty(&self) -> bool {
        self.starts.value == Some(0.0)
    }

    /// Its name, for people.
    pub fn in_full(&self) -> String {
        let key = &self.key;
        format!("{}{} in {} against {}", key.falsifier, in_block(key.block), key.town, key.policy)
    }
}

/// Gathers runs into cells, in the order of first appearance.
pub fn search_cells(results: &[SearchResult]) -> Vec<SearchCell> {
    let cells = grouped(results, |result| result.key.cell());
    cells.iter().map(|cell| gather(cell)).collect()
}

fn gather(cell: &[&SearchResult]) -> SearchCell {
    let figures: Vec<Figures> = cell.iter().map(|result| Figures::new(result)).collect();
    let median = |first: fn(&Figures) -> Option<u64>| {
        let time = |(figures, result): (&Figures, &&SearchResult)| {
            (first(figures).unwrap_or(result.spent.ticks) as f64, first(figures).is_some())
        };
        median_time(&figures.iter().zip(cell).map(time).collect::<Vec<_>>())
    };
    let over = |value: &dyn Fn(&Figures) -> Option<f64>| Rate::student(figures.iter().map(value), f64::INFINITY);
    let fault_start_rate = Rate::student(figures.iter().map(|figures| figures.fault_start_rate), 1.0);
    // Equal runs show no spread, and the number of starts says what may go unseen.
    let sum = |of: fn(&Figures) -> u64| figures.iter().filter(|figures| figures.is_judged).map(of).sum();
    let is_equal = fault_start_rate.by_run.len() >= MIN_RUNS && fault_start_rate.interval.is_none();
    let over_starts = is_equal
        .then(|| clopper_pearson(sum(|figures| figures.fault_starts as u64), sum(|figures| figures.starts), 0.05));
    SearchCell {
        key: cell[0].key.clone(),
        goal: cell[0].goal().map(|named| named.name.to_string()),
        budget: cell[0].budget,
        runs: cell.len(),
        censored: figures.iter().filter(|figures| figures.first.is_none()).count(),
        first_failure: median(|figures| figures.first),
        simulations: figures.iter().filter_map(|figures| figures.first_simulations).collect(),
        failed_starts: over(&|figures| Some(figures.failed_starts as f64)),
        starts: over(&|figures| Some(figures.starts as f64)),
        faults: over(&|figures| figures.judged(Some(figures.fault as f64))),
        fault_start_rate: Rate { interval: over_starts.or(fault_start_rate.interval), ..fault_start_rate },
        fault_starts: over(&|figures| figures.judged(Some(figures.fault_starts as f64))),
        injury: over(&|figures| figures.injury),
        first_fault: median(|figures| figures.first_fault),
    }
}

/// The median of times to an event, of which some were not reached (`false`: the time is the end of the observation); `None` if fewer than half were.
///
/// # Source
/// Kaplan and Meier, JASA 53, 1958.
fn median_time(times: &[(f64, bool)]) -> Option<f64> {
    let mut sorted = times.to_vec();
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

/// Cells of searches as a table, one row each, for gates and for the metrics of searches.
pub fn search_cell_table() -> Table<'static, SearchCell> {
    let number = Column::<f64>::new;
    let median = |name: &'static str, of: fn(&SearchCell) -> Option<f64>| {
        let doc = format!("Kaplan and Meier's median of `{name}`; missing if fewer than half of the runs found one");
        Entry::new::<f64, _>(format!("{name}_median").into(), "".into(), doc.into(), of).of_figure(name, Role::Plain)
    };
    Table::new("search_cells", "One row for each search, town and driver, over all runs.")
        .columns(search_key(|cell: &SearchCell| &cell.key))
        .count("runs", "number of runs", |cell| cell.runs as u64)
        .column(BUDGET.of(|cell: &SearchCell| cell.budget))
        .column(
            number("falsified_share", "", "share of the runs that found a failure, as ARCH-COMP counts it")
                .with_role(Role::RunShare)
                .of(|cell: &SearchCell| cell.falsified()),
        )
        .number("simulations_to_first_mean", "mean of `first_failure_simulations` over these runs", |cell| {
            cell.simulations_to_first().map(|(mean, _)| mean)
        })
        .number("simulations_to_first_median", "their median", |cell| {
            cell.simulations_to_first().map(|(_, median)| median)
        })
        .column(median(FIRST_FAILURE, |cell| cell.first_failure))
        .columns(averaged(STARTS.name, Role::Plain, |cell| &cell.starts))
        .columns(averaged(FAILED_STARTS, Role::Plain, |cell| &cell.failed_starts))
        .columns(averaged(FAULT, Role::Plain, |cell| &cell.faults))
        .columns(averaged(FAULT_START_RATE, Role::Share, |cell| &cell.fault_start_rate))
        .columns(averaged(INJURY, Role::Plain, |cell| &cell.injury))
        .column(median(FIRST_FAULT, |cell| cell.first_fault))
}

/// The mean of a column over runs with its interval.
fn averaged(name: &'static str, role: Role, value: fn(&SearchCell) -> &Rate) -> Vec<Entry<'static, SearchCell>> {
    let doc = "mean over `runs` with Student's 95 % interval, on the logarithm, and for rates on the logit; of a rate that is the same in all runs Clopper and \
               Pearson's over all starts. The interval is about further runs in this town, not about other towns; missing for fewer than four runs, and of other figures \
               that are the same in all";
    let mut entries =
        vec![MEAN.of(name, move |cell: &SearchCell| value(cell).value).of_figure(name, role).meaning(doc)];
    entries.extend(Interval::new(name, "", doc).of(move |cell: &SearchCell| value(cell).interval));
    entries
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Recorded from lifelines by `tests/reference/kaplan_meier/record_medians.py`.
    const RECORDED: &str = include_str!("../../../../tests/reference/kaplan_meier/medians.json");

    #[test]
    fn medians_are_those_of_lifelines() {
        let recorded: serde_json::Value = serde_json::from_str(RECORDED).unwrap();
        let mut cases = 0;
        for (name, case) in recorded.as_object().unwrap().iter().filter(|(name, _)| *name != "version") {
            let list = |key: &str| case[key].as_array().unwrap().clone();
            let times: Vec<(f64, bool)> = list("times")
                .iter()
                .zip(&list("found"))
                .map(|(time, found)| (time.as_f64().unwrap(), found.as_i64() == Some(1)))
                .collect();
            assert_eq!(median_time(&times), case["median"].as_f64(), "{name}");
            cases += 1;
        }
        assert_eq!(cases, 4);
        assert_eq!(median_time(&[]), None);
        assert_eq!(median_time(&[(5.0, false), (5.0, false)]), None, "nothing was found");
    }
}

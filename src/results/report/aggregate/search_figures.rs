use std::collections::BTreeSet;

use crate::jobs::SearchResult;
use search::Failure;
use verdict::{Blame, Judged};

// The names of the figures, as columns of searches have them; cells of searches summarise these.
pub(super) const FAILURE_COUNT: &str = "failures";
pub(super) const FAILED_STARTS: &str = "failed_starts";
/// Ticks to the first failure.
pub const FIRST_FAILURE: &str = "first_failure_ticks";
/// Simulations to the first failure.
pub(super) const FIRST_SIMULATIONS: &str = "first_failure_simulations";
pub(super) const FAULT: &str = "faults";
pub(super) const FAULT_STARTS: &str = "fault_starts";
pub(super) const FAULT_START_RATE: &str = "fault_start_rate";
/// Ticks to the first fault.
pub const FIRST_FAULT: &str = "first_fault_ticks";
pub(super) const INJURY: &str = "avoidable_injury_per_thousand";

/// The figures of a search.
#[derive(Debug, Clone, PartialEq)]
pub struct Figures {
    pub(super) failures: usize,
    pub(super) failed_starts: usize,
    /// The number of starts from which it searched.
    pub(super) starts: u64,
    /// Ticks up to the first failure.
    pub(super) first: Option<u64>,
    /// Simulations up to the first failure.
    pub(super) first_simulations: Option<u64>,
    pub(super) preventable: usize,
    pub(super) fault: usize,
    /// Whether failures have verdicts. Otherwise the numbers of preventable failures and of faults are unknown.
    pub(super) is_judged: bool,
    pub(super) fault_starts: usize,
    pub(super) fault_start_rate: Option<f64>,
    /// Ticks up to the first fault.
    pub(super) first_fault: Option<u64>,
    /// The avoidable injury of a thousand episodes.
    pub(super) injury: Option<f64>,
    pub(super) evaluated: u64,
    pub(super) evaluated_faults: usize,
}

impl Figures {
    /// The figures by which two searches are compared, with their names.
    pub(super) fn compared(&self) -> [(&'static str, Option<f64>); 4] {
        [
            (INJURY, self.injury),
            (FAULT_START_RATE, self.fault_start_rate),
            (FAILED_STARTS, Some(self.failed_starts as f64)),
            (FAULT_STARTS, self.judged(Some(self.fault_starts as f64))),
        ]
    }

    /// A figure of faults; `None` if failures have no verdict.
    pub(super) fn judged(&self, figure: Option<f64>) -> Option<f64> {
        figure.filter(|_| self.is_judged)
    }

    /// A number of faults; `None` if failures have no verdict.
    pub(super) fn judged_count(&self, count: usize) -> Option<u64> {
        self.is_judged.then_some(count as u64)
    }

    pub(super) fn new(result: &SearchResult) -> Self {
        let spent = &result.spent;
        let failures = &spent.failures;
        let is_judged = result.is_judged();
        let faults = || result.failures().filter(|find| find.is(Blame::Fault)).map(|find| find.failure);
        let starts =
            |of: &mut dyn Iterator<Item = &Failure>| of.map(|failure| failure.start).collect::<BTreeSet<_>>().len();
        let fault_starts = starts(&mut faults());
        let searched = spent.starts.count();
        let fault_start_rate = (searched > 0).then(|| fault_starts as f64 / searched as f64);
        let injury: f64 = result.failures().filter_map(|find| Some(find.verdict()?.avoidable_injury())).sum();
        let evaluated: Vec<&Judged> = result.evaluated.iter().filter(|each| each.outcome.counts()).collect();
        let evaluated_faults = evaluated.iter().filter(|each| each.is(result.criterion(), Blame::Fault)).count();
        Self {
            failures: failures.len(),
            failed_starts: starts(&mut failures.iter()),
            starts: searched,
            first: failures.first().map(|failure| failure.ticks),
            first_simulations: failures.first().map(|failure| failure.simulations),
            preventable: result.failures().filter(|find| find.is(Blame::Preventable)).count(),
            fault: faults().count(),
            is_judged,
            fault_starts,
            fault_start_rate: fault_start_rate.filter(|_| is_judged),
            first_fault: faults().map(|failure| failure.ticks).min(),
            injury: (spent.episodes > 0).then(|| injury * 1000.0 / spent.episodes as f64),
            evaluated: evaluated.len() as u64,
            evaluated_faults,
        }
    }
}

use std::collections::BTreeSet;

use crate::analysis::Impact;
use crate::jobs::SearchResult;
use world::env::{Ending, Outcome};
use world::falsifier::Failure;
use world::judge::{Blame, Class, Judged, Verdict};

// The names of the figures, as columns of searches have them; cells of searches summarise these.
pub(super) const FAILURE_COUNT: &str = "failures";
pub(super) const FAILURE_RATE: &str = "failure_rate";
pub(super) const FAILED_STARTS: &str = "failed_starts";
/// Ticks to the first failure.
pub const FIRST_FAILURE: &str = "first_failure_ticks";
/// Simulations to the first failure.
pub(super) const FIRST_SIMULATIONS: &str = "first_failure_simulations";
pub(super) const DISTINCT: &str = "distinct_failures";
pub(super) const PREVENTABLE: &str = "preventable_failures";
pub(super) const FAULT: &str = "faults";
pub(super) const FAULT_RATE: &str = "fault_rate";
pub(super) const FAULT_STARTS: &str = "fault_starts";
pub(super) const FAULT_START_RATE: &str = "fault_start_rate";
/// Ticks to the first fault.
pub const FIRST_FAULT: &str = "first_fault_ticks";
pub(super) const INJURY: &str = "avoidable_injury_per_thousand";
/// What would be a fault but for one thing, with the names of the numbers.
pub(super) const TOUCHES: [Class; 3] = [Class::Flank, Class::Slow, Class::Narrow];
pub(super) const TOUCH_COUNTS: [&str; 3] = ["flank_touches", "slow_touches", "narrow_touches"];
/// Shares of the starts with a fault, if the careful humans had other figures.
pub(super) const FAULT_START_RATES_IF: [&str; 4] =
    ["fault_start_rate_sooner", "fault_start_rate_later", "fault_start_rate_short_gate", "fault_start_rate_long_gate"];
pub(super) const FAULT_PER_MILLION: &str = "faults_per_million_ticks";
pub(super) const DISTINCT_PER_MILLION: &str = "distinct_faults_per_million_ticks";
pub(super) const EVALUATED_RATE: &str = "evaluated_rate";
pub(super) const EVALUATED_FAULT_RATE: &str = "evaluated_faults_rate";

/// The figures of a search.
#[derive(Debug, Clone, PartialEq)]
pub struct Figures {
    pub(super) ticks: u64,
    pub(super) failures: usize,
    pub(super) failed_starts: usize,
    /// The number of starts from which it searched.
    pub(super) starts: u64,
    pub(super) failure_rate: Option<f64>,
    pub(super) first: Option<u64>,
    /// Simulations up to the first failure.
    pub(super) first_simulations: Option<u64>,
    pub(super) distinct: usize,
    /// The number of failures, and the number of their cells, of those that are preventable and of those that are faults.
    pub(super) preventable: [usize; 2],
    pub(super) fault: [usize; 2],
    /// Whether failures have verdicts. Otherwise the numbers of those and of faults are not known.
    pub(super) is_judged: bool,
    pub(super) fault_rate: Option<f64>,
    pub(super) fault_starts: usize,
    pub(super) fault_start_rate: Option<f64>,
    pub(super) first_fault: Option<u64>,
    /// The avoidable injury of a thousand episodes.
    pub(super) injury: Option<f64>,
    /// The numbers of flank, slow and narrow touches.
    pub(super) touches: [usize; 3],
    /// Shares of the starts with a fault with other figures of the careful humans, in the order of
    /// [`Sensitivity::NAMES`](world::judge::Sensitivity::NAMES).
    pub(super) fault_start_rates_if: [Option<f64>; 4],
    pub(super) evaluated: u64,
    /// Collisions, or violations of the goal.
    pub(super) evaluated_failures: usize,
    pub(super) evaluated_rate: Option<f64>,
    pub(super) evaluated_faults: usize,
    pub(super) evaluated_faults_rate: Option<f64>,
    pub(super) evaluated_reward: Option<f64>,
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
    pub(super) fn judged(&self, figure: Option<f64>) -> Option<f64> {
        figure.filter(|_| self.is_judged)
    }

    /// A number of faults; none where failures have no verdict.
    pub(super) fn judged_count(&self, count: usize) -> Option<u64> {
        self.is_judged.then_some(count as u64)
    }

    pub(super) fn new(result: &SearchResult) -> Self {
        let spent = &result.spent;
        let share = |part: usize, whole: u64| (whole > 0).then(|| part as f64 / whole as f64);
        let cells: BTreeSet<_> = spent.failures.iter().map(|failure| failure.cell).collect();
        let is_judged = result.is_judged();
        let of = |blame| result.finds().filter(move |find| find.is(blame)).map(|find| find.failure);
        let judged = |blame| {
            let cells: Vec<_> = of(blame).map(|failure| failure.cell).collect();
            [cells.len(), cells.into_iter().collect::<BTreeSet<_>>().len()]
        };
        let (preventable, fault) = (judged(Blame::Preventable), judged(Blame::Fault));
        let faults = || of(Blame::Fault);
        let found: Vec<(&Failure, Verdict)> =
            result.finds().filter_map(|find| Some((find.failure, find.verdict()?))).collect();
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
        let evaluated: Vec<&Judged> = result.evaluated.iter().filter(|each| each.outcome.counts()).collect();
        let number = evaluated.len() as u64;
        let evaluated_failures = evaluated.iter().filter(|each| each.is(result.criterion(), Blame::Any)).count();
        let evaluated_faults = evaluated.iter().filter(|each| each.is(result.criterion(), Blame::Fault)).count();
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
pub(in crate::report) fn impact(outcome: &Outcome) -> Option<Impact> {
    match outcome.ending {
        Ending::Touch { front, bearing, .. } => Some(Impact::new(front, bearing)),
        _ => None,
    }
}

/// The number of events in a million ticks.
pub(super) fn per_million(count: usize, ticks: u64) -> Option<f64> {
    (ticks > 0).then(|| count as f64 * 1e6 / ticks as f64)
}

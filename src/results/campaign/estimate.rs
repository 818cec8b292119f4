use super::run::Shared;
use super::{Event, Task, TaskError};
use base::seed::Seed;
use compile::{Estimation, EstimationKey};
use world::likelihood::{self, Encounters, Estimate, Limits};

/// The result of an estimate.
#[derive(Debug, Clone)]
pub struct EstimateResult {
    pub key: EstimationKey,
    /// Encounters per hour and per 1,000 km, as far as the user states them.
    pub exposure: [Option<f64>; 2],
    /// Whether driver or pedestrian is a program of the user.
    pub has_program: bool,
    /// None when it failed.
    pub estimate: Option<Estimate>,
    /// Why it failed.
    pub error: Option<TaskError>,
}

impl EstimateResult {
    /// The result of an estimate of the plan.
    pub fn new(plan: &Estimation, estimate: Result<Estimate, TaskError>) -> Self {
        let (estimate, error) = match estimate {
            Ok(estimate) => (Some(estimate), None),
            Err(error) => (None, Some(error)),
        };
        let has_program = plan.programs.iter().next().is_some();
        Self { key: plan.key.clone(), exposure: plan.exposure, has_program, estimate, error }
    }
}

/// Makes an estimate; none when the user asks to stop before its end.
pub(super) fn estimate(shared: Shared<'_>, index: usize) -> Option<EstimateResult> {
    let Shared { campaign, seed, results, .. } = shared;
    let plan = &campaign.estimations[index];
    let task = Task::Estimate(index);
    if shared.stop() {
        return None;
    }
    if let Some(limit @ TaskError::Ticks { .. }) = results.limit(task, plan.budget) {
        return Some(EstimateResult::new(plan, Err(limit)));
    }
    shared.tell(Event::Begun(task));
    let late = || shared.stop() || results.limit(task, 0).is_some();
    let progress = |ticks: u64| shared.tell(Event::Estimating { estimation: index, ticks });
    let limits = Limits {
        event: plan.event,
        relative_error: plan.relative_error,
        budget: plan.budget,
        stop: &late,
        progress: &progress,
    };
    let make = || {
        let mut encounters = Encounters::new(&plan.scenario, plan.walker.walk_policy(), plan.criterion);
        move |number: u64, seed: &Seed| encounters.run(number, seed)
    };
    let estimate = likelihood::estimate(&make, &plan.drawn(seed), limits);
    if let Some(limit) = results.limit(task, 0).filter(|_| !shared.stop()) {
        return Some(EstimateResult::new(plan, Err(limit)));
    }
    if estimate.stopped {
        return None;
    }
    let estimate = if estimate.counted == 0 { Err(TaskError::NoEncounter) } else { Ok(estimate) };
    Some(EstimateResult::new(plan, estimate))
}

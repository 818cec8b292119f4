use std::ops::ControlFlow;

use super::cover_result::FoundInBox;
use super::run::Shared;
use super::{CoverResult, Event, Task, TaskError};
use compile::Cover;
use world::env::{Outcome, Trace};
use world::judge::{Blame, Judged};
use world::likelihood::{BoxOfStarts, CoverConfig, Coverage, cover};

/// Number of episodes in a row that a driver or a controller may fail; then no more are run.
const MOST_ERRORS: u32 = 10;

/// Carries out a cover; none when the user asks to stop before it has started.
pub(super) fn carry_out(shared: Shared<'_>, index: usize) -> Option<CoverResult> {
    let Shared { campaign, seed, results, .. } = shared;
    let planned = &campaign.covers[index];
    let task = Task::Cover(index);
    if shared.stop() {
        return None;
    }
    shared.tell(Event::Begun(task));
    let seed = planned.seed(seed);
    let walker = planned.walker.walk_policy();
    let mut starts = BoxOfStarts::new(&planned.scenario, walker, seed.child("starts"));
    let config =
        CoverConfig { dimensions: starts.parameters().len(), epsilon: planned.epsilon, budget: planned.budget.into() };
    let [mut unplaced, mut left_out, mut errors, mut ticks] = [0; 4];
    let (mut in_a_row, mut error) = (0, None);
    let mut experiment = |at: &[f64], number: u64| {
        shared.tell(Event::Covering { cover: index, episodes: number });
        error = results.limit(task, ticks);
        if shared.stop() || error.is_some() {
            return ControlFlow::Break(());
        }
        let Some((outcome, trace)) = starts.run(at, number) else {
            unplaced += 1;
            return ControlFlow::Continue(false);
        };
        ticks += u64::from(outcome.ticks) + u64::from(outcome.run_up);
        if outcome.fault().is_some() {
            errors += 1;
            in_a_row += 1;
            if in_a_row == MOST_ERRORS {
                error = Some(TaskError::Hopeless);
                return ControlFlow::Break(());
            }
            return ControlFlow::Continue(false);
        }
        in_a_row = 0;
        left_out += u64::from(outcome.left_out.is_some());
        ControlFlow::Continue(outcome.counts() && has_failed(planned, &outcome, trace))
    };
    let coverage: Coverage = cover(&config, &seed.child("points"), &mut experiment);
    Some(CoverResult::new(planned, FoundInBox { coverage, unplaced, left_out, errors, ticks }, error))
}

/// Whether an episode is what a cover counts.
fn has_failed(cover: &Cover, outcome: &Outcome, trace: &Trace) -> bool {
    let Cover { criterion, blame, scenario, .. } = cover;
    let judged = || Judged::by(*criterion, outcome, &trace.main_pair(scenario));
    criterion.is_met(outcome, trace.degrees()) && (*blame == Blame::Any || judged().is(*criterion, *blame))
}

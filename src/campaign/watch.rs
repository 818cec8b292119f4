use std::ops::{ControlFlow, Range};

use crate::compile::{ControllerKind, Evaluation};
use crate::env::{Outcome, Trace};
use crate::falsifier::{ActionMode, Homing, Intercept, Random, TrainedWalker, WalkPolicy, evaluate_noting};
use crate::rl::ActorCritic;
use crate::seed::Seed;

/// Tries the pedestrian of an evaluation in the episodes with these numbers, and keeps what is noted of each.
///
/// An episode hangs on the user's seed, the names of the evaluation and its own number alone: it is the same in every range,
/// and the same again when a failure is replayed. `trained` is what the evaluation's training has brought forth; untrained
/// pedestrians need none.
///
/// Ends early, with the first episodes up to there, as [`evaluate_noting`] does.
///
/// # Panics
/// When the evaluation is of a trained pedestrian and there is none.
pub fn watch<T>(
    evaluation: &Evaluation,
    trained: Option<&ActorCritic>,
    episodes: Range<u32>,
    seed: &Seed,
    note: &mut dyn FnMut(&Outcome, &Trace) -> T,
    observer: &mut dyn FnMut(u32) -> ControlFlow<()>,
) -> Vec<T> {
    let note = &mut |_: u32, outcome: &Outcome, trace: &Trace| note(outcome, trace);
    watch_numbered(evaluation, trained, episodes, seed, note, observer)
}

/// Does as [`watch`], and tells the number of the episode that is noted: several may go on at once.
pub(super) fn watch_numbered<T>(
    evaluation: &Evaluation,
    trained: Option<&ActorCritic>,
    episodes: Range<u32>,
    seed: &Seed,
    note: &mut dyn FnMut(u32, &Outcome, &Trace) -> T,
    observer: &mut dyn FnMut(u32) -> ControlFlow<()>,
) -> Vec<T> {
    let learnt = |mode| -> Box<dyn WalkPolicy> {
        let trained = trained.expect("a trained pedestrian comes with its networks");
        Box::new(TrainedWalker::new(trained.clone(), evaluation.scenario.cast.obs_dim(), mode))
    };
    let mut walker: Box<dyn WalkPolicy> = match evaluation.controller {
        ControllerKind::Random => Box::new(Random::default()),
        ControllerKind::Homing => Box::new(Homing),
        ControllerKind::Intercept => Box::new(Intercept),
        ControllerKind::Trained(_) => learnt(ActionMode::Deterministic),
        ControllerKind::Sampled(_) => learnt(ActionMode::Stochastic),
    };
    let place = |branch: &str| seed.child(branch).child(&evaluation.town).child(&evaluation.policy);
    let own = place("walker").child(evaluation.controller.name()).index(evaluation.trained.run.into());
    evaluate_noting(walker.as_mut(), &evaluation.scenario, episodes, &place("evaluate"), &own, note, observer)
}

/// Breaks where `stop` is true.
pub(super) fn flow(stop: bool) -> ControlFlow<()> {
    if stop { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
}

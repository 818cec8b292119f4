use std::ops::{ControlFlow, Range};

use base::seed::Seed;
use compile::{ControllerKind, Evaluation, Training, episodes_seed};
use episode::walker::{ActionMode, TrainedWalker, WalkPolicy};
use episode::{Outcome, Trace, evaluate_observed};
use learn::ActorCritic;
use search::first_networks;

/// Runs the episodes of an evaluation with these numbers, and returns what `note` makes of each.
///
/// An episode depends only on the user's seed, the names of the evaluation and its own number. Its start depends only on the seed, the name
/// of the town and the number: all drivers and controllers meet the same starts. It is the same in every range, and the same
/// when a failure is replayed. `trained` is the result of the evaluation's training; untrained controllers need none.
///
/// Ends early, with the first episodes up to there, as [`evaluate_observed`] does.
///
/// # Panics
/// When the evaluation is of a trained pedestrian and there is none.
pub fn watch<T>(
    evaluation: &Evaluation,
    trained: Option<&[ActorCritic]>,
    episodes: Range<u32>,
    seed: &Seed,
    note: &mut dyn FnMut(&Outcome, &Trace) -> T,
    observer: &mut dyn FnMut(u32) -> ControlFlow<()>,
) -> Vec<T> {
    let note = &mut |_: u32, outcome: &Outcome, trace: &Trace| note(outcome, trace);
    watch_numbered(evaluation, trained, episodes, seed, note, observer)
}

/// As [`watch`], but `note` also gets the number of the episode: several episodes may run at once.
pub(super) fn watch_numbered<T>(
    evaluation: &Evaluation,
    trained: Option<&[ActorCritic]>,
    episodes: Range<u32>,
    seed: &Seed,
    note: &mut dyn FnMut(u32, &Outcome, &Trace) -> T,
    observer: &mut dyn FnMut(u32) -> ControlFlow<()>,
) -> Vec<T> {
    let learnt = |mode| -> Box<dyn WalkPolicy> {
        let trained = trained.expect("a trained pedestrian comes with its networks");
        Box::new(TrainedWalker::new(trained.to_vec(), &evaluation.scenario.cast, mode))
    };
    let mut walker: Box<dyn WalkPolicy> = match &evaluation.controller {
        ControllerKind::Untrained(controller) => controller.walk_policy(),
        ControllerKind::Trained => learnt(ActionMode::Deterministic),
        ControllerKind::Stochastic => learnt(ActionMode::Stochastic),
        ControllerKind::First => {
            let Training { config, key, .. } =
                evaluation.first.as_deref().expect("first networks come with their training");
            let first = first_networks(&evaluation.scenario.cast, config, &key.seed(seed));
            Box::new(TrainedWalker::new(first, &evaluation.scenario.cast, ActionMode::Deterministic))
        }
    };
    let own = seed.child("walker").child(&evaluation.town);
    let own = own.child(evaluation.controller.name()).index(evaluation.trained.run.into());
    let starts = episodes_seed(seed, &evaluation.town);
    evaluate_observed(walker.as_mut(), &evaluation.scenario, episodes, &starts, &own, note, observer)
}

/// Breaks when `stop` is true.
pub(super) fn flow(stop: bool) -> ControlFlow<()> {
    if stop { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
}

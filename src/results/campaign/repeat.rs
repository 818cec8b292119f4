use std::ops::ControlFlow;

use super::{TrainingResult, watch};
use base::seed::Seed;
use compile::{Campaign, Evaluation, Search};
use learn::ActorCritic;
use world::env::{Outcome, Trace};
use world::falsifier::follow;
use world::sim::WalkCommand;

/// Repeats episodes of an evaluation, by their numbers in ascending order, and gives what `note` makes of each with its number. It gives
/// nothing if the pedestrian was to be trained and there are no networks. Consecutive episodes run together, which is faster for drivers
/// with batches.
pub fn repeat_episodes<T>(
    evaluation: &Evaluation,
    trained: Option<&ActorCritic>,
    numbers: &[u32],
    seed: &Seed,
    note: &mut dyn FnMut(&Outcome, &Trace) -> T,
) -> Vec<(u32, T)> {
    let mut noted = Vec::with_capacity(numbers.len());
    if evaluation.training().is_some() && trained.is_none() {
        return noted;
    }
    for row in numbers.chunk_by(|one, next| one + 1 == *next) {
        let (Some(first), Some(last)) = (row.first(), row.last()) else { continue };
        let go_on = &mut |_| ControlFlow::Continue(());
        noted.extend((*first..).zip(watch(evaluation, trained, *first..*last + 1, seed, note, go_on)));
    }
    noted
}

/// Repeats a failure of a search from its start by its commands; none if it ends otherwise, as it may with a driver that is not deterministic.
pub fn repeat_failure(search: &Search, start: u64, commands: &[WalkCommand], seed: &Seed) -> Option<(Outcome, Trace)> {
    follow(&search.scenario, search.starts(seed), start, commands)
}

/// The networks of an evaluation's pedestrian; none if it is untrained, or if its training failed.
pub fn networks<'a>(
    evaluation: &Evaluation,
    campaign: &Campaign,
    trainings: &'a [TrainingResult],
) -> Option<&'a ActorCritic> {
    let key = &campaign.trainings[evaluation.training()?].key;
    let training = trainings.iter().find(|training| training.key == *key)?;
    Some(&training.result.as_ref().ok()?.actor_critic)
}

use std::ops::ControlFlow;
use std::sync::Arc;

use super::watch;
use base::seed::Seed;
use compile::{Evaluation, Search};
use learn::ActorCritic;
use world::env::{Outcome, Scenario, Trace};
use world::falsifier::follow;
use world::judge::Judged;
use world::sim::WalkCommand;

/// What repeats an episode of a campaign: the only way to see it again.
#[derive(Debug, Clone, Copy)]
pub enum Repeatable<'a> {
    /// An episode of an evaluation. A trained pedestrian needs its networks.
    Episode { evaluation: &'a Evaluation, networks: Option<&'a ActorCritic>, number: u32 },
    /// A failure that a search found from a start.
    Find { search: &'a Search, start: u64, commands: &'a [WalkCommand] },
}

/// An episode that was repeated.
#[derive(Debug, Clone)]
pub struct Repeated {
    pub scenario: Arc<Scenario>,
    pub trace: Trace,
    pub judged: Judged,
}

impl Repeatable<'_> {
    /// Repeats it by the seed of the user. `None` if a pedestrian was to be trained and there are no networks, or if the commands do not end the
    /// episode, as may be with a driver that is not deterministic.
    pub fn repeat(&self, seed: &Seed) -> Option<Repeated> {
        let (scenario, (outcome, trace)) = match *self {
            Self::Episode { evaluation, networks, number } => {
                let note = &mut |outcome: &Outcome, trace: &Trace| (*outcome, trace.clone());
                (&evaluation.scenario, repeat_episodes(evaluation, networks, &[number], seed, note).pop()?.1)
            }
            Self::Find { search, start, commands } => {
                (&search.scenario, follow(&search.scenario, search.starts(seed), start, commands)?)
            }
        };
        let judged = Judged::new(&outcome, &trace.main_pair(scenario));
        Some(Repeated { scenario: scenario.clone(), trace, judged })
    }
}

/// Repeats episodes of an evaluation, by their numbers in ascending order, and gives what `note` makes of each with its number. It gives
/// nothing if the pedestrian was to be trained and there are no networks. Consecutive episodes run together, which is faster for drivers
/// with batches.
pub fn repeat_episodes<T>(
    evaluation: &Evaluation,
    networks: Option<&ActorCritic>,
    numbers: &[u32],
    seed: &Seed,
    note: &mut dyn FnMut(&Outcome, &Trace) -> T,
) -> Vec<(u32, T)> {
    let mut noted = Vec::with_capacity(numbers.len());
    if evaluation.origin.needs.is_some() && networks.is_none() {
        return noted;
    }
    for row in numbers.chunk_by(|one, next| one + 1 == *next) {
        let (Some(first), Some(last)) = (row.first(), row.last()) else { continue };
        let go_on = &mut |_| ControlFlow::Continue(());
        noted.extend((*first..).zip(watch(evaluation, networks, *first..*last + 1, seed, note, go_on)));
    }
    noted
}

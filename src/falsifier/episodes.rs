use std::ops::ControlFlow;
use std::sync::Arc;

use super::Walker;
use crate::env::{Outcome, PedestrianEnv, Recording, Scenario};
use crate::seed::Seed;

/// Tries a pedestrian in so many episodes, telling the observer how many are done.
///
/// Episode *k* begins the same for every pedestrian that is tried with the same `episodes_seed`; what the pedestrian itself
/// draws comes from `walker_seed`. Ends early, with what there is, when the observer breaks.
pub fn try_walker(
    walker: &mut dyn Walker,
    scenario: &Arc<Scenario>,
    episodes: u32,
    episodes_seed: &Seed,
    walker_seed: &Seed,
    observer: &mut dyn FnMut(u32) -> ControlFlow<()>,
) -> Vec<Outcome> {
    let mut outcomes = Vec::with_capacity(episodes as usize);
    watch_walker(walker, scenario, episodes, episodes_seed, walker_seed, &mut |outcome, _| {
        outcomes.push(*outcome);
        observer(outcomes.len() as u32)
    });
    outcomes
}

/// Tries a pedestrian as [`try_walker`] does, and shows each episode when it is over: what became of it, and what happened.
pub fn watch_walker(
    walker: &mut dyn Walker,
    scenario: &Arc<Scenario>,
    episodes: u32,
    episodes_seed: &Seed,
    walker_seed: &Seed,
    observer: &mut dyn FnMut(&Outcome, &Recording) -> ControlFlow<()>,
) {
    let mut env = PedestrianEnv::new(scenario.clone(), *episodes_seed);
    let mut recording = Recording::new(&scenario.episode);
    for episode in 0..u64::from(episodes) {
        env.begin(episode);
        recording.begin(env.world());
        walker.begin(walker_seed.index(episode).stream());
        let outcome = loop {
            let command = walker.choose(&env);
            recording.decide(command);
            env.walk_watched(command, |world, contact| recording.watch(world, contact));
            if let Some(outcome) = env.outcome() {
                break *outcome;
            }
        };
        if observer(&outcome, &recording).is_break() {
            break;
        }
    }
}

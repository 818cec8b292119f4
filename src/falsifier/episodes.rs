use std::ops::ControlFlow;
use std::sync::Arc;

use super::Walker;
use crate::env::{Outcome, PedestrianEnv, Scenario};
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
    let mut env = PedestrianEnv::new(scenario.clone(), *episodes_seed);
    let mut outcomes = Vec::with_capacity(episodes as usize);
    for episode in 0..u64::from(episodes) {
        env.begin(episode);
        walker.begin(walker_seed.index(episode).stream());
        let outcome = loop {
            env.walk(walker.choose(&env));
            if let Some(outcome) = env.outcome() {
                break *outcome;
            }
        };
        outcomes.push(outcome);
        if observer(outcomes.len() as u32).is_break() {
            break;
        }
    }
    outcomes
}

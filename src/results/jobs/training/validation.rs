use std::collections::BTreeMap;

use super::super::episodes::flow;
use crate::campaign::Part;
use base::statistics::mean;
use compile::Training;
use episode::evaluate;
use episode::walker::{ActionMode, TrainedWalker};
use learn::ActorCritic;

/// Validation starts, over all scenarios of a training.
const STARTS: u32 = 1000;
/// The entry of a stored training's header that holds its reward on them.
const ENTRY: &str = "validation";

/// The mean reward of an episode of these networks, which take their mean action, on starts that no training and no evaluation has; all candidates
/// have the same. `None` if the user asks to stop.
pub fn reward(plan: &Training, networks: &[ActorCritic], part: &Part<'_>) -> Option<f64> {
    let seed = plan.key.seed(part.seed).child("validation");
    let scenarios = plan.scenarios();
    let episodes = STARTS.div_ceil(scenarios.len() as u32);
    let mut rewards = Vec::new();
    for (place, scenario) in (0..).zip(&scenarios) {
        let mut walker = TrainedWalker::new(networks.to_vec(), &scenario.cast, ActionMode::Deterministic);
        let (starts, draws) = (seed.index(place), seed.child("walker").index(place));
        let outcomes = evaluate(&mut walker, scenario, episodes, &starts, &draws, &mut |_| flow(part.stop()));
        rewards.extend(outcomes.iter().filter(|outcome| outcome.left_out.is_none()).map(|outcome| outcome.reward));
    }
    if part.stop() { None } else { Some(mean(rewards).unwrap_or_default()) }
}

/// The header of a stored training.
pub fn metadata(reward: f64) -> BTreeMap<String, String> {
    [(ENTRY.to_owned(), format!("{reward:?}"))].into()
}

/// The reward in the header of a stored training; `None` without one.
pub fn read(bytes: &[u8]) -> Option<f64> {
    let (_, metadata) = ActorCritic::from_safetensors(bytes).ok()?;
    metadata.get(ENTRY)?.parse().ok()
}

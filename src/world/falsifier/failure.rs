use std::sync::Arc;

use super::episodes::play;
use crate::env::{FailureCell, Outcome, PedestrianEnv, Scenario, Trace};
use crate::requirement::Degree;
use crate::sim::WalkCommand;
use base::seed::Seed;

/// A collision that a falsifier found, or a violation of its goal, with all data to repeat it; a bump is none.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Failure {
    /// Number of its start under the seed of the search.
    pub start: u64,
    /// Ticks that the search had used when it was found, including those of this episode.
    pub ticks: u64,
    /// Episodes that the search had finished then, including this one and those that are left out.
    pub simulations: u64,
    /// The commands: one for each pedestrian in every decision.
    pub commands: Vec<WalkCommand>,
    pub outcome: Outcome,
    /// How the goal of the search is violated; none without a goal.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub violation: Option<Degree>,
    /// How the two met. Failures in one cell are the same finding.
    pub cell: FailureCell,
}

impl Failure {
    /// Simulates it again under the seed of the search; none when the commands do not end the episode.
    pub fn replay(&self, scenario: &Arc<Scenario>, seed: Seed) -> Option<Outcome> {
        follow(scenario, seed, self.start, &self.commands).map(|(outcome, _)| outcome)
    }
}

/// Repeats an episode from a start under the seed of a search with these commands; none when they do not end it.
pub fn follow(scenario: &Arc<Scenario>, seed: Seed, start: u64, commands: &[WalkCommand]) -> Option<(Outcome, Trace)> {
    let mut env = PedestrianEnv::new(scenario.clone(), seed);
    let mut trace = Trace::new(scenario);
    let mut decisions = commands.chunks_exact(scenario.cast.pedestrian_count());
    let outcome = play(&mut env, &mut trace, start, |_, commands| {
        commands.copy_from_slice(decisions.next()?);
        Some(())
    })?;
    (decisions.next().is_none() && decisions.remainder().is_empty()).then_some((outcome, trace))
}

/// Repeats the commands of an episode against a driver that may drive otherwise: the last command is kept until the episode ends. None
/// without a command.
pub fn walk_again(
    scenario: &Arc<Scenario>,
    seed: Seed,
    start: u64,
    commands: &[WalkCommand],
) -> Option<(Outcome, Trace)> {
    let mut env = PedestrianEnv::new(scenario.clone(), seed);
    let mut trace = Trace::new(scenario);
    let mut decisions = commands.chunks_exact(scenario.cast.pedestrian_count());
    let mut last = None;
    let outcome = play(&mut env, &mut trace, start, |_, commands| {
        last = decisions.next().or(last);
        commands.copy_from_slice(last?);
        Some(())
    })?;
    Some((outcome, trace))
}

/// The commands of an episode: one for each pedestrian in every decision.
pub fn recorded_commands(trace: &Trace) -> Vec<WalkCommand> {
    let of_decision =
        |decision| (0..trace.pedestrian_count()).map(move |pedestrian| trace.decisions(pedestrian)[decision]);
    (0..trace.decisions(0).len()).flat_map(of_decision).collect()
}

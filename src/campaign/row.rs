use std::sync::Arc;

use crate::compile::{Evaluation, RunId, TrainingKey};
use crate::env::Outcome;
use crate::judge::{NearMiss, Verdict};

/// One episode of an evaluation.
#[derive(Debug, Clone, PartialEq)]
pub struct EpisodeRow {
    /// The short name of the run that it belongs to.
    pub run_id: RunId,
    /// What the pedestrian was trained in; town and policy are empty for untrained ones.
    pub trained: Arc<TrainingKey>,
    /// Who it is: `trained`, `sampled`, `random`, `homing`, `intercept`.
    pub pedestrian: &'static str,
    /// The town it was tried in.
    pub town: Arc<str>,
    /// The driving policy it was tried against.
    pub policy: Arc<str>,
    /// The model of car.
    pub vehicle: Arc<str>,
    /// The adversary, for its body.
    pub adversary: Arc<str>,
    /// Number of the `evaluate` block, from 0.
    pub block: u32,
    /// Number of the episode, from 0; equal numbers of a town and policy begin the same.
    pub episode: u32,
    /// What became of it.
    pub outcome: Outcome,
    /// What reference drivers make of it; none without a collision.
    pub verdict: Option<Verdict>,
    /// How near it came to a touch.
    pub near_miss: NearMiss,
}

impl EpisodeRow {
    /// Whether another is an episode of the same pedestrian of the same training in the same town against the same policy.
    pub fn is_of_same_run(&self, other: &Self) -> bool {
        let names = |row: &Self| [&row.town, &row.policy, &row.vehicle, &row.adversary].map(Clone::clone);
        (self.block, self.pedestrian) == (other.block, other.pedestrian)
            && self.trained == other.trained
            && names(self) == names(other)
    }

    /// Makes the row of an episode of an evaluation.
    pub fn new(
        evaluation: &Evaluation,
        episode: u32,
        outcome: Outcome,
        verdict: Option<Verdict>,
        near_miss: NearMiss,
    ) -> Self {
        Self {
            run_id: evaluation.id,
            trained: evaluation.trained.clone(),
            pedestrian: evaluation.pedestrian.name(),
            town: evaluation.town.clone(),
            policy: evaluation.policy.clone(),
            vehicle: evaluation.vehicle.clone(),
            adversary: evaluation.adversary.clone(),
            block: evaluation.block,
            episode,
            outcome,
            verdict,
            near_miss,
        }
    }
}

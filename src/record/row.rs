use std::sync::Arc;

use super::RunKey;
use crate::env::Outcome;
use crate::judge::{NearMiss, Verdict};

/// One episode of an evaluation.
#[derive(Debug, Clone, PartialEq)]
pub struct EpisodeRow {
    /// The run that it belongs to.
    pub key: Arc<RunKey>,
    /// Number of the episode, from 0; equal numbers of a place have equal starts.
    pub episode: u32,
    /// How it began and ended.
    pub outcome: Outcome,
    /// What the reference drivers say of it; none without a collision.
    pub verdict: Option<Verdict>,
    /// How near it came to a touch.
    pub near_miss: NearMiss,
    /// How much it counts: the probability of its start in the scenario by that with which it was drawn. 1 today, since starts are
    /// drawn as the scenario says; tables have no column of it yet.
    pub weight: f64,
}

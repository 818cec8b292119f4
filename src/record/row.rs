use std::sync::Arc;

use super::RunKey;
use crate::env::Outcome;
use crate::judge::{FalseAlarms, NearMiss, PedestrianMotion, Verdict};

/// One episode of an evaluation.
#[derive(Debug, Clone, PartialEq)]
pub struct EpisodeRow {
    /// The run that it belongs to.
    pub key: Arc<RunKey>,
    /// Number of the episode, from 0; equal numbers of a place have equal starts.
    pub episode: u32,
    /// Its start and its end.
    pub outcome: Outcome,
    /// The verdict of the reference drivers; none without a collision.
    pub verdict: Option<Verdict>,
    /// The reference drivers that would have braked for nothing; none with a collision.
    pub false_alarms: Option<FalseAlarms>,
    /// How near it came to a touch.
    pub near_miss: NearMiss,
    /// What the pedestrian did with its body.
    pub motion: PedestrianMotion,
    /// Its weight: the probability of its start in the scenario, divided by the probability with which it was drawn. It is 1 today, since
    /// starts are drawn from the distribution of the scenario. Tables have no column of it yet.
    pub weight: f64,
}

use std::sync::Arc;

use super::{JudgedDegree, RunKey};
use world::env::{Outcome, Pair};
use world::judge::{FalseAlarms, LaneDeparture, NearMiss, PedestrianMotion, Verdict, judge};

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
    /// The reference drivers that would have braked needlessly; none with a collision.
    pub false_alarms: Option<FalseAlarms>,
    /// How near it came to a touch.
    pub near_miss: NearMiss,
    /// Whether the car stayed in its lane; none off the map.
    pub lane: Option<LaneDeparture>,
    /// What the pedestrian did with its body.
    pub motion: PedestrianMotion,
    /// The degree of each requirement of the campaign with its verdict; empty without requirements, and in error.
    pub degrees: Vec<JudgedDegree>,
    /// Its weight: the probability of its start in the scenario, divided by the probability with which it was drawn. It is 1 today, since
    /// starts are drawn from the distribution of the scenario. Tables have no column of it yet.
    pub weight: f64,
}

impl EpisodeRow {
    /// The row of an episode: what its judges say of its car and its pedestrian.
    pub fn new(key: &Arc<RunKey>, episode: u32, outcome: &Outcome, pair: &Pair<'_>) -> Self {
        Self {
            key: key.clone(),
            episode,
            outcome: *outcome,
            verdict: judge(pair),
            false_alarms: FalseAlarms::new(pair).filter(|_| outcome.fault().is_none()),
            near_miss: NearMiss::new(pair),
            lane: LaneDeparture::new(pair),
            motion: PedestrianMotion::new(pair),
            degrees: JudgedDegree::of_all(pair),
            weight: 1.0,
        }
    }
}

use std::sync::Arc;

use super::RunKey;
use episode::Pair;
use verdict::{FalseAlarms, Judged, LaneDeparture, NearMiss};

/// One episode of an evaluation.
#[derive(Debug, Clone, PartialEq)]
pub struct EpisodeRow {
    /// The run that it belongs to.
    pub key: Arc<RunKey>,
    /// Number of the episode, from 0; equal numbers of a place have equal starts.
    pub episode: u32,
    /// Its start, its end, the verdict on its touch, and those on the requirements of the campaign.
    pub judged: Judged,
    /// The reference drivers that would have braked needlessly; none with a collision.
    pub false_alarms: Option<FalseAlarms>,
    /// How near it came to a touch.
    pub near_miss: NearMiss,
    /// Whether the car stayed in its lane; none off the map.
    pub lane: Option<LaneDeparture>,
}

impl EpisodeRow {
    /// The row of an episode: what its judges say of its car and its pedestrian.
    pub fn new(key: &Arc<RunKey>, episode: u32, judged: Judged, pair: &Pair<'_>) -> Self {
        Self {
            key: key.clone(),
            episode,
            false_alarms: FalseAlarms::new(pair).filter(|_| judged.outcome.fault().is_none()),
            judged,
            near_miss: NearMiss::new(pair),
            lane: LaneDeparture::new(pair),
        }
    }
}

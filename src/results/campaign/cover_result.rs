use serde::{Deserialize, Serialize};

use super::TaskError;
use compile::{Cover, CoverKey};
use world::env::DrawnParameter;
use world::likelihood::Coverage;

/// The result of a cover.
#[derive(Debug, Clone)]
pub struct CoverResult {
    pub key: CoverKey,
    /// The name of what it counts.
    pub failure: String,
    /// The parameters of the box, in the order of the coordinates of its points.
    pub parameters: Vec<DrawnParameter>,
    /// The parameters of the picture, by their places: one or two.
    pub picture: Vec<usize>,
    /// The share of the box that is small enough.
    pub epsilon: f64,
    /// The greatest number of episodes.
    pub budget: u32,
    pub found: FoundInBox,
    /// Why it ended early.
    pub error: Option<TaskError>,
}

/// What a cover found.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FoundInBox {
    pub coverage: Coverage,
    /// Points of the box for which no place on the road was found. They count as passed.
    pub unplaced: u64,
    /// Episodes that are left out ([`LeftOut`](world::env::LeftOut)). They count as passed.
    pub left_out: u64,
    /// Episodes in which a driver or a controller failed as a program. They count as passed.
    pub errors: u64,
    /// Simulator ticks of all episodes.
    pub ticks: u64,
}

impl CoverResult {
    /// What was planned, with what was found.
    pub fn new(cover: &Cover, found: FoundInBox, error: Option<TaskError>) -> Self {
        Self {
            key: cover.key.clone(),
            failure: cover.failure_name().to_string(),
            parameters: cover.scenario.start_parameters(),
            picture: cover.picture.clone(),
            epsilon: cover.epsilon,
            budget: cover.budget,
            found,
            error,
        }
    }

    /// The bound of the share of the box that is worse than the picture; none before the first look has ended.
    pub fn bound(&self) -> Option<f64> {
        self.found.coverage.best().map(|look| look.bound)
    }

    /// Whether the bound is small enough.
    pub fn is_covered(&self) -> bool {
        self.bound().is_some_and(|bound| bound <= self.epsilon)
    }
}

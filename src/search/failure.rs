use episode::requirement::Degree;
use episode::{FailureCell, Outcome};
use world::sim::WalkCommand;

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
    /// How the goal of the search is violated; `None` without a goal.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub violation: Option<Degree>,
    /// How the two met. Failures in one cell are the same finding.
    pub cell: FailureCell,
}

use super::TaskError;
use compile::{Search, SearchKey};
use world::env::Outcome;
use world::falsifier::SearchOutcome;
use world::judge::Verdict;
use world::requirement::NamedRequirement;

/// The result of a search.
#[derive(Debug, Clone)]
pub struct SearchResult {
    pub key: SearchKey,
    /// The budget: the number of simulator ticks that it may use.
    pub budget: u64,
    /// The requirement that it tried to violate, and the length of a tick (s); none of a search for collisions.
    pub goal: Option<(NamedRequirement, f64)>,
    /// What the search did with the budget.
    pub spent: SearchOutcome,
    /// The verdict on each failure, in their order; none for one that does not repeat, with a driver that is not deterministic.
    pub verdicts: Vec<Option<Verdict>>,
    /// Fresh episodes with the walk policy that the search ended up with; empty without one.
    pub evaluated: Vec<Evaluated>,
    /// Why it ended early.
    pub error: Option<TaskError>,
}

/// The goal of a search, and the length of a tick (s).
pub(crate) fn goal_of(search: &Search) -> Option<(NamedRequirement, f64)> {
    let scenario = &search.scenario;
    Some((scenario.requirements.get(scenario.goal?)?.clone(), scenario.episode.tick))
}

/// A fresh episode with the walk policy that a search ended up with.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Evaluated {
    pub outcome: Outcome,
    /// The verdict on its collision; none without one.
    pub verdict: Option<Verdict>,
}

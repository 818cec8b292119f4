use super::TaskError;
use crate::compile::SearchKey;
use crate::env::Outcome;
use crate::falsifier::SearchOutcome;

/// What came of a search.
#[derive(Debug, Clone)]
pub struct SearchResult {
    /// Which search.
    pub key: SearchKey,
    /// How many simulator ticks it might use.
    pub budget: u64,
    /// What it did with them.
    pub spent: SearchOutcome,
    /// Fresh episodes of the pedestrian that it ended up with; empty without one.
    pub tried: Vec<Outcome>,
    /// Why it ended early.
    pub error: Option<TaskError>,
}

use super::TaskError;
use compile::{Search, SearchKey};
use world::env::Outcome;
use world::falsifier::SearchOutcome;
use world::judge::{Question, Verdict, ViolationVerdict};
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
    /// Whose fault the violation of the goal is, of each failure in their order; none without a goal, where it has no verdict, and for a failure that does
    /// not repeat.
    pub violations: Vec<Option<ViolationVerdict>>,
    /// Fresh episodes with the walk policy that the search ended up with; empty without one.
    pub evaluated: Vec<Evaluated>,
    /// Why it ended early.
    pub error: Option<TaskError>,
}

impl SearchResult {
    /// Whether the failures have verdicts: collisions do, and violations of a goal about which careful humans can be asked.
    pub fn is_judged(&self) -> bool {
        self.goal.as_ref().is_none_or(|(named, _)| Question::of(&named.requirement) == Question::Asked)
    }

    /// Whether a failure is preventable, and whether it is a fault: by the goal, or without one by the collision.
    pub fn blame(&self, failure: usize) -> (bool, bool) {
        match &self.goal {
            Some(_) => {
                let verdict = self.violations.get(failure).copied().flatten();
                verdict.map_or((false, false), |verdict| (verdict.preventable, verdict.fault))
            }
            None => {
                let verdict = self.verdicts.get(failure).and_then(Option::as_ref);
                verdict.map_or((false, false), |verdict| (verdict.is_preventable(), verdict.is_fault()))
            }
        }
    }
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
    /// Whether it violates the goal of the search; none without a goal.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub violated: Option<bool>,
    /// Whose fault that is; none without a violation, and where it has no verdict.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub violation: Option<ViolationVerdict>,
}

impl Evaluated {
    /// Whether it is what the search looked for.
    pub fn is_failure(&self) -> bool {
        self.violated.unwrap_or_else(|| self.outcome.is_collision())
    }

    /// Whether it is a fault, by the goal or without one by the collision.
    pub fn is_fault(&self) -> bool {
        match self.violated {
            Some(_) => self.violation.is_some_and(|verdict| verdict.fault),
            None => self.verdict.as_ref().is_some_and(Verdict::is_fault),
        }
    }
}

use std::sync::Arc;

use super::{Repeatable, TaskError};
use compile::{Search, SearchKey};
use world::env::{Criterion, Scenario};
use world::falsifier::{Failure, SearchOutcome};
use world::judge::{Blame, Judged, NoVerdict, Verdict, ViolationVerdict};
use world::requirement::{Degree, NamedRequirement};

/// The result of a search.
#[derive(Debug, Clone)]
pub struct SearchResult {
    pub key: SearchKey,
    /// The maximum number of simulator ticks.
    pub budget: u64,
    pub scenario: Arc<Scenario>,
    /// What the search did with the budget.
    pub spent: SearchOutcome,
    /// Each failure as it was judged when it was repeated, in their order; `None` for one that does not repeat, with a driver that is not
    /// deterministic.
    pub judged: Vec<Option<Judged>>,
    /// Fresh episodes with the walk policy that the search ended up with; empty without one.
    pub evaluated: Vec<Judged>,
    /// Why it ended early.
    pub error: Option<TaskError>,
}

/// A failure that a search found.
#[derive(Debug, Clone, Copy)]
pub struct Find<'a> {
    pub key: &'a SearchKey,
    pub scenario: &'a Scenario,
    /// Its number in its search.
    pub number: usize,
    pub failure: &'a Failure,
    /// `None` if it does not repeat.
    pub judged: Option<&'a Judged>,
}

impl SearchResult {
    /// A result without failures.
    pub fn new(search: &Search, spent: SearchOutcome, error: Option<TaskError>) -> Self {
        let Search { key, budget, scenario, .. } = search;
        let (judged, evaluated) = (Vec::new(), Vec::new());
        Self { key: key.clone(), budget: *budget, scenario: scenario.clone(), spent, judged, evaluated, error }
    }

    pub fn criterion(&self) -> Criterion {
        self.scenario.criterion
    }

    /// The requirement that it tried to violate; `None` of a search for collisions.
    pub fn goal(&self) -> Option<&NamedRequirement> {
        self.scenario.requirements.get(self.criterion().requirement()?)
    }

    /// Whether the failures have verdicts: collisions do, and violations about which careful humans can be asked.
    pub fn is_judged(&self) -> bool {
        self.goal().is_none_or(|named| NoVerdict::of(&named.requirement).is_none())
    }

    /// Its failures, in the order in which they were found.
    pub fn finds(&self) -> impl Iterator<Item = Find<'_>> + Clone {
        let Self { key, scenario, judged, .. } = self;
        self.spent.failures.iter().enumerate().map(move |(number, failure)| Find {
            key,
            scenario,
            number,
            failure,
            judged: judged.get(number).and_then(Option::as_ref),
        })
    }
}

impl<'a> Find<'a> {
    /// What repeats it.
    pub fn repeatable(&self, search: &'a Search) -> Repeatable<'a> {
        Repeatable::Find { search, start: self.failure.start, commands: &self.failure.commands }
    }

    /// The verdict on its touch.
    pub fn verdict(&self) -> Option<Verdict> {
        self.judged.and_then(|judged| judged.verdict)
    }

    /// Whether it counts against the driver in this way, by what its search looked for.
    pub fn is(&self, blame: Blame) -> bool {
        self.judged.is_some_and(|judged| judged.is(self.scenario.criterion, blame))
    }

    /// Time of the sample that decides its violation, from the start of the episode (s); `None` of a collision.
    pub fn instant(&self) -> Option<f64> {
        let degree = self.failure.violation.as_ref()?;
        Some((f64::from(degree.sample) * self.scenario.episode.tick).min(self.failure.outcome.duration))
    }

    /// The requirement that it violates, by how much, and whose fault that is; `None` of a collision.
    pub fn violation(&self) -> Option<(&'a NamedRequirement, &'a Degree, Option<ViolationVerdict>)> {
        let place = self.scenario.criterion.requirement()?;
        let verdict = self.judged.and_then(|judged| judged.degrees.get(place)?.verdict);
        Some((self.scenario.requirements.get(place)?, self.failure.violation.as_ref()?, verdict))
    }
}

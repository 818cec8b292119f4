use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::episodes::flow;
use super::{JobResult, Kind, Repeatable, Work, json, result};
use crate::campaign::{Part, TaskError};
use crate::report::{Group, search_section, search_table, searches};
use compile::{Origin, RunId, Search, SearchKey, episodes_seed};
use episode::requirement::{Degree, NamedRequirement};
use episode::{Criterion, Outcome, Scenario, Trace, evaluate_observed};
use search::{BudgetedSimulation, Failure, SearchOutcome};
use verdict::{Blame, Judged, NoVerdict, Verdict, ViolationVerdict};

pub(super) const KIND: Kind = Kind {
    doing: ["searching", "searched"],
    closing: ", judging its failures",
    references: || vec![search_table().reference()],
    tables: |found| match found.finished.all::<SearchResult>() {
        [] => None,
        all => Some(vec![("searches", searches(all))]),
    },
    section: Some((Group::Failures, search_section)),
    ..Kind::new::<Search>("search", "searches", "search")
};

#[derive(Debug, Clone)]
pub struct SearchResult {
    /// Its short name.
    pub id: RunId,
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
pub struct SearchFailure<'a> {
    /// The short name of its search.
    pub id: RunId,
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
        let Search { origin: Origin { id, .. }, key, budget, scenario, .. } = search;
        let (judged, evaluated) = (Vec::new(), Vec::new());
        Self { id: *id, key: key.clone(), budget: *budget, scenario: scenario.clone(), spent, judged, evaluated, error }
    }

    pub fn criterion(&self) -> Criterion {
        self.scenario.criterion
    }

    /// The requirement that it tried to violate; `None` of a search for collisions.
    pub fn goal(&self) -> Option<&NamedRequirement> {
        self.scenario.requirements.get(self.criterion().requirement()?)
    }

    /// Whether the failures have verdicts: collisions do, and violations about which careful drivers can be asked.
    pub fn is_judged(&self) -> bool {
        self.goal().is_none_or(|named| NoVerdict::of(&named.requirement).is_none())
    }

    /// Its failures, in the order in which they were found.
    pub fn failures(&self) -> impl Iterator<Item = SearchFailure<'_>> + Clone {
        let Self { id, key, scenario, judged, .. } = self;
        self.spent.failures.iter().enumerate().map(move |(number, failure)| SearchFailure {
            id: *id,
            key,
            scenario,
            number,
            failure,
            judged: judged.get(number).and_then(Option::as_ref),
        })
    }
}

impl<'a> SearchFailure<'a> {
    /// What repeats it.
    pub fn repeatable(&self, search: &'a Search) -> Repeatable<'a> {
        Repeatable::SearchFailure { search, start: self.failure.start, commands: &self.failure.commands }
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
        Some(degree.instant(self.scenario.episode.tick).min(self.failure.outcome.duration))
    }

    /// The requirement that it violates, by how much, and whose fault that is; `None` of a collision.
    pub fn violation(&self) -> Option<(&'a NamedRequirement, &'a Degree, Option<ViolationVerdict>)> {
        let place = self.scenario.criterion.requirement()?;
        let verdict = self.judged.and_then(|judged| judged.degrees.get(place)?.verdict);
        Some((self.scenario.requirements.get(place)?, self.failure.violation.as_ref()?, verdict))
    }
}

/// A search in the form in which it is stored.
#[derive(PartialEq, Serialize, Deserialize)]
struct Record {
    spent: SearchOutcome,
    judged: Vec<Option<Judged>>,
    evaluated: Vec<Judged>,
}

impl JobResult for SearchResult {
    fn error(&self) -> Option<&TaskError> {
        self.error.as_ref()
    }

    fn is_whole(&self) -> bool {
        self.error.is_none() && !self.spent.stopped
    }

    fn units(&self) -> u64 {
        self.spent.ticks
    }

    fn note(&self) -> String {
        let failures = self.spent.failures.len();
        let s = if failures == 1 { "" } else { "s" };
        format!("{failures} failure{s} in {} episodes", self.spent.episodes)
    }

    /// An episode in error, or a reward that is not a number, cannot be stored. Such a search is run again.
    fn encode(&self) -> Option<Vec<u8>> {
        let Self { spent, judged, evaluated, .. } = self.clone();
        json(&Record { spent, judged, evaluated })
    }
}

impl Work for Search {
    fn kind(&self) -> &'static Kind {
        &KIND
    }

    fn decode(&self, bytes: &[u8]) -> Option<Box<dyn JobResult>> {
        let Record { spent, judged, evaluated } = serde_json::from_slice(bytes).ok()?;
        result(SearchResult { judged, evaluated, ..SearchResult::new(self, spent, None) })
    }

    fn run(&self, part: &Part<'_>) -> Option<Box<dyn JobResult>> {
        // The budget of a search is in ticks, so whether it exceeds the limit is known in advance.
        if let Some(limit @ TaskError::Ticks { .. }) = part.limit(self.budget) {
            return result(SearchResult::new(self, SearchOutcome::default(), Some(limit)));
        }
        let late = || part.is_late();
        part.begin(0);
        let progress = part.counter();
        let mut simulator = BudgetedSimulation::new(self.scenario.clone(), self.starts(part.seed), self.budget, &late)
            .with_progress(&progress);
        let (walker, error) = match self.falsifier.search(&mut simulator, &self.drawn(part.seed)) {
            Ok(walker) => (walker, None),
            Err(error) => (None, Some(TaskError::Training(error))),
        };
        let mut spent = simulator.into_spent();
        part.progress(self.budget);
        let evaluated = walker.filter(|_| !spent.stopped && self.tries > 0).map_or_else(Vec::new, |mut walker| {
            let fresh = episodes_seed(part.seed, &self.key.town);
            let drawn = self.own(part.seed).child("tries");
            let mut go_on = |done: u32| {
                let stopped = done < self.tries && late();
                spent.stopped |= stopped;
                flow(stopped)
            };
            let scenario = &self.scenario;
            let mut note = |_: u32, outcome: &Outcome, trace: &Trace| {
                Judged::by(scenario.criterion, outcome, &trace.main_pair(scenario))
            };
            let episodes = 0..self.tries;
            evaluate_observed(walker.as_mut(), scenario, episodes, &fresh, &drawn, &mut note, &mut go_on)
        });
        let repeated = |failure: &Failure| {
            // A failure is repeated outside of the budget.
            let repeatable =
                Repeatable::SearchFailure { search: self, start: failure.start, commands: &failure.commands };
            let judged = repeatable.repeat(part.seed)?.judged;
            (judged.outcome.digest == failure.outcome.digest).then_some(judged)
        };
        let judged = spent.failures.iter().map(repeated).collect();
        // The user may not have waited for a program, so that an episode or a verdict is missing.
        spent.stopped |= !self.origin.programs.is_empty() && part.stop();
        let error = error.or_else(|| part.own_limit().filter(|_| spent.stopped));
        result(SearchResult { judged, evaluated, ..SearchResult::new(self, spent, error) })
    }
}

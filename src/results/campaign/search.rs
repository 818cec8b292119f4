use std::sync::atomic::{AtomicU64, Ordering};

use super::repeat::repeat_failure;
use super::run::Shared;
use super::search_result::goal_of;
use super::watch::flow;
use super::{Evaluated, Event, SearchResult, Task, TaskError};
use base::seed::Seed;
use compile::{Search, episodes_seed};
use world::env::{Outcome, Trace};
use world::falsifier::{Failure, SearchOutcome, Simulator, StartSet, evaluate_noting};
use world::judge::{Verdict, ViolationVerdict, judge};
use world::requirement::Degree;

/// Runs a search; none when the user asks to stop before it has started.
pub(super) fn search(shared: Shared<'_>, index: usize) -> Option<SearchResult> {
    let Shared { campaign, seed, results, .. } = shared;
    let search = &campaign.searches[index];
    let key = &search.key;
    let task = Task::Search(index);
    if shared.stop() {
        return None;
    }
    // The budget of a search is in ticks, so whether it exceeds the limit is known in advance.
    if let Some(limit @ TaskError::Ticks { .. }) = results.limit(task, search.budget) {
        let spent = SearchOutcome {
            ticks: 0,
            episodes: 0,
            left_out: 0,
            starts: StartSet::default(),
            first_start: None,
            failures: Vec::new(),
            stopped: false,
        };
        return Some(SearchResult {
            key: key.clone(),
            budget: search.budget,
            goal: goal_of(search),
            spent,
            verdicts: Vec::new(),
            violations: Vec::new(),
            evaluated: Vec::new(),
            error: Some(limit),
        });
    }
    let late = || shared.stop() || results.limit(task, 0).is_some();
    shared.tell(Event::Begun(task));
    let used = AtomicU64::new(0);
    let progress = |ticks: u64| {
        let used = used.fetch_add(ticks, Ordering::Relaxed) + ticks;
        shared.tell(Event::Searching { search: index, ticks: used });
    };
    let mut simulator =
        Simulator::new(search.scenario.clone(), search.starts(seed), search.budget, &late).with_progress(&progress);
    let (walker, error) = match search.falsifier.search(&mut simulator, &search.drawn(seed)) {
        Ok(walker) => (walker, None),
        Err(error) => (None, Some(TaskError::Training(error))),
    };
    let mut spent = simulator.into_spent();
    let evaluated = walker.filter(|_| !spent.stopped && search.tries > 0).map_or_else(Vec::new, |mut walker| {
        let fresh = episodes_seed(seed, &key.town);
        let drawn = search.own(seed).child("tries");
        let mut go_on = |done: u32| {
            let stopped = done < search.tries && late();
            spent.stopped |= stopped;
            flow(stopped)
        };
        let mut note = |_: u32, outcome: &Outcome, trace: &Trace| {
            let verdict = outcome.is_collision().then(|| judge(&trace.main_pair(&search.scenario))).flatten();
            let violated = search.scenario.goal.map(|goal| trace.degrees().get(goal).is_some_and(Degree::is_violated));
            Evaluated { outcome: *outcome, verdict, violated, violation: violation(search, trace) }
        };
        let episodes = 0..search.tries;
        evaluate_noting(walker.as_mut(), &search.scenario, episodes, &fresh, &drawn, &mut note, &mut go_on)
    });
    let (verdicts, violations) = spent.failures.iter().map(|failure| verdicts(search, failure, seed)).unzip();
    // The user may not have waited for a program, so that an episode or a verdict is missing.
    spent.stopped |= !search.programs.is_empty() && shared.stop();
    let error = error.or_else(|| results.limit(task, 0).filter(|_| spent.stopped && !shared.stop()));
    let goal = goal_of(search);
    Some(SearchResult { key: key.clone(), budget: search.budget, goal, spent, verdicts, violations, evaluated, error })
}

/// Repeats a failure outside of the budget and judges its touch and the violation of the goal; none when it ends otherwise.
fn verdicts(search: &Search, failure: &Failure, seed: &Seed) -> (Option<Verdict>, Option<ViolationVerdict>) {
    match repeat_failure(search, failure.start, &failure.commands, seed) {
        Some((outcome, trace)) if outcome.digest == failure.outcome.digest => {
            (judge(&trace.main_pair(&search.scenario)), violation(search, &trace))
        }
        _ => (None, None),
    }
}

/// Whose fault the violation of the goal of a search is; none without one, and where it has no verdict.
pub fn violation(search: &Search, trace: &Trace) -> Option<ViolationVerdict> {
    let goal = search.scenario.goal?;
    let (named, degree) = (search.scenario.requirements.get(goal)?, trace.degrees().get(goal)?);
    ViolationVerdict::new(&trace.main_pair(&search.scenario), &named.requirement, degree)
}

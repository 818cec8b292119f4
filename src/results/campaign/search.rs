use std::sync::atomic::{AtomicU64, Ordering};

use super::run::Shared;
use super::watch::flow;
use super::{Event, Repeatable, SearchResult, Task, TaskError};
use compile::episodes_seed;
use world::env::{Outcome, Trace};
use world::falsifier::{Failure, SearchOutcome, Simulator, StartSet, evaluate_noting};
use world::judge::Judged;

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
        return Some(SearchResult::new(search, spent, Some(limit)));
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
        let scenario = &search.scenario;
        let mut note = |_: u32, outcome: &Outcome, trace: &Trace| {
            Judged::by(scenario.criterion, outcome, &trace.main_pair(scenario))
        };
        let episodes = 0..search.tries;
        evaluate_noting(walker.as_mut(), scenario, episodes, &fresh, &drawn, &mut note, &mut go_on)
    });
    let repeated = |failure: &Failure| {
        // A failure is repeated outside of the budget.
        let repeatable = Repeatable::Find { search, start: failure.start, commands: &failure.commands };
        let judged = repeatable.repeat(seed)?.judged;
        (judged.outcome.digest == failure.outcome.digest).then_some(judged)
    };
    let failures = spent.failures.iter().map(repeated).collect();
    // The user may not have waited for a program, so that an episode or a verdict is missing.
    spent.stopped |= !search.programs.is_empty() && shared.stop();
    let error = error.or_else(|| results.limit(task, 0).filter(|_| spent.stopped && !shared.stop()));
    Some(SearchResult { judged: failures, evaluated, ..SearchResult::new(search, spent, error) })
}

use super::Findings;
use crate::campaign::{Finished, networks, repeat_episodes, repeat_failure};
use base::seed::Seed;
use compile::{Campaign, Search};
use world::env::{Outcome, Scenario, Trace};
use world::judge::{Verdict, judge};

/// A failure that was repeated to be shown.
#[derive(Debug, Clone)]
pub struct PlayedFailure<'a> {
    /// `RUN:EPISODE`.
    pub name: String,
    /// The name of its town.
    pub town: &'a str,
    pub scenario: &'a Scenario,
    pub outcome: Outcome,
    pub trace: Trace,
    /// None where it does not repeat.
    pub verdict: Option<Verdict>,
}

/// Repeats these failures. One that cannot be repeated is left out.
pub fn played<'a>(names: &[String], found: &Findings<'a>, seed: &Seed) -> Vec<PlayedFailure<'a>> {
    names.iter().filter_map(|name| repeated(name, found.campaign, found.finished, seed)).collect()
}

fn repeated<'a>(name: &str, campaign: &'a Campaign, finished: &Finished, seed: &Seed) -> Option<PlayedFailure<'a>> {
    let (run, number) = name.split_once(':')?;
    if let Some(search) = campaign.searches.iter().find(|planned| planned.key.id.to_string() == run) {
        return of_search(name, search, finished, seed, number.parse().ok()?);
    }
    let evaluation = campaign.evaluations.iter().find(|planned| planned.id.to_string() == run)?;
    let trained = networks(evaluation, campaign, &finished.trainings);
    let scenario = &*evaluation.scenario;
    let note = &mut |outcome: &Outcome, trace: &Trace| (*outcome, trace.clone());
    let (_, (outcome, trace)) = repeat_episodes(evaluation, trained, &[number.parse().ok()?], seed, note).pop()?;
    let verdict = judge(&trace.main_pair(scenario));
    Some(PlayedFailure { name: name.to_owned(), town: &evaluation.town, scenario, outcome, trace, verdict })
}

fn of_search<'a>(
    name: &str,
    search: &'a Search,
    finished: &Finished,
    seed: &Seed,
    number: usize,
) -> Option<PlayedFailure<'a>> {
    let result = finished.searches.iter().find(|result| result.key == search.key)?;
    let failure = result.spent.failures.get(number)?;
    let (outcome, trace) = repeat_failure(search, failure.start, &failure.commands, seed)?;
    let verdict = result.verdicts.get(number).copied().flatten();
    Some(PlayedFailure {
        name: name.to_owned(),
        town: &search.key.town,
        scenario: &search.scenario,
        outcome,
        trace,
        verdict,
    })
}

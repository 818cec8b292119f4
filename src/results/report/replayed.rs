use super::Findings;
use crate::jobs::{Repeatable, Repeated, SearchResult, TrainingResult, networks};
use base::seed::Seed;

/// A failure that was repeated to be shown: its name `RUN:EPISODE`, its town, and the episode.
pub type PlayedFailure<'a> = (String, &'a str, Repeated);

/// Repeats these failures. One that cannot be repeated is left out.
pub fn replayed<'a>(names: &[String], found: &Findings<'a>, seed: &Seed) -> Vec<PlayedFailure<'a>> {
    names.iter().filter_map(|name| played_failure(name, found, seed)).collect()
}

/// Repeats a failure; `None` if it cannot be repeated.
pub fn played_failure<'a>(name: &str, found: &Findings<'a>, seed: &Seed) -> Option<PlayedFailure<'a>> {
    let Findings { campaign, finished, .. } = found;
    let (run, number) = name.split_once(':')?;
    if let Some(search) = campaign.all::<compile::Search>().find(|planned| planned.origin.id.to_string() == run) {
        let result = finished.all::<SearchResult>().iter().find(|result| result.key == search.key)?;
        let find = result.failures().nth(number.parse().ok()?)?;
        let mut repeated = find.repeatable(search).repeat(seed)?;
        repeated.judged.verdict = find.verdict();
        return Some((name.to_owned(), &search.key.town, repeated));
    }
    let evaluation = campaign.all::<compile::Evaluation>().find(|planned| planned.origin.id.to_string() == run)?;
    let networks = networks(evaluation, finished.all::<TrainingResult>());
    let repeated = Repeatable::Episode { evaluation, networks, number: number.parse().ok()? }.repeat(seed)?;
    Some((name.to_owned(), &evaluation.town, repeated))
}

use std::collections::BTreeMap;
use std::ops::ControlFlow;

use super::super::town::Scenery;
use super::{ModeCard, Replay};
use crate::campaign::{Finished, TrainingResult, watch};
use crate::compile::{Campaign, ControllerKind, Evaluation, Search};
use crate::falsifier::follow;
use crate::judge::judge;
use crate::rl::ActorCritic;
use crate::seed::Seed;

/// Most kinds with a player.
const PLAYERS: usize = 12;

/// Puts the cards in the order of the page and repeats the examples of those with a player. Trained pedestrians come first: of these the
/// most frequent kind of each cell, then the next of each.
pub fn repeat_examples(cards: &mut [ModeCard], campaign: &Campaign, finished: &Finished, seed: &Seed) {
    cards.sort_by_key(|card| std::cmp::Reverse(card.failures));
    let mut seen: BTreeMap<(String, String), usize> = BTreeMap::new();
    cards.sort_by_cached_key(|card| {
        let rank = seen.entry((card.who.clone(), card.place.clone())).or_default();
        *rank += 1;
        (!card.trained, *rank)
    });
    let mut scenery: BTreeMap<String, Scenery> = BTreeMap::new();
    let trainings = &finished.trainings;
    for card in cards.iter_mut().take(PLAYERS) {
        let Some((run, episode)) = card.example.split_once(':') else { continue };
        if let Some(search) = campaign.searches.iter().find(|planned| planned.key.id.to_string() == run) {
            let town = &search.scenario.town;
            let scenery = scenery.entry(search.key.town.clone()).or_insert_with(|| Scenery::new(town));
            card.replay =
                episode.parse().ok().and_then(|number| repeat_failure(search, finished, seed, number, scenery));
            continue;
        }
        let Some(evaluation) = campaign.evaluations.iter().find(|planned| planned.id.to_string() == run) else {
            continue;
        };
        let Ok(episode) = episode.parse() else { continue };
        let town = &evaluation.scenario.town;
        let scenery = scenery.entry(evaluation.town.to_string()).or_insert_with(|| Scenery::new(town));
        card.replay = repeat(campaign, trainings, seed, evaluation, episode, scenery);
    }
}

/// Repeats an episode for the player; none when its pedestrian was not trained.
fn repeat(
    campaign: &Campaign,
    trainings: &[TrainingResult],
    seed: &Seed,
    evaluation: &Evaluation,
    episode: u32,
    scenery: &Scenery,
) -> Option<Replay> {
    let trained: Option<&ActorCritic> = match evaluation.controller {
        ControllerKind::Trained(training) | ControllerKind::Sampled(training) => {
            let key = &campaign.trainings[training].key;
            let found = trainings.iter().find(|training| training.key == *key)?;
            Some(&found.result.as_ref().ok()?.actor_critic)
        }
        _ => None,
    };
    let scenario = &evaluation.scenario;
    let replays = watch(
        evaluation,
        trained,
        episode..episode + 1,
        seed,
        &mut |outcome, trace| {
            Replay::new(scenario, scenery, outcome, trace, judge(&trace.main_pair(scenario)).as_ref())
        },
        &mut |_| ControlFlow::Continue(()),
    );
    replays.into_iter().next()
}

/// Repeats a failure of a search for the player; none when it ends otherwise.
fn repeat_failure(
    search: &Search,
    finished: &Finished,
    seed: &Seed,
    number: usize,
    scenery: &Scenery,
) -> Option<Replay> {
    let result = finished.searches.iter().find(|result| result.key == search.key)?;
    let failure = result.spent.failures.get(number)?;
    let scenario = &search.scenario;
    let (outcome, trace) = follow(scenario, search.starts(seed), failure.start, &failure.commands)?;
    let verdict = result.verdicts.get(number).copied().flatten();
    Some(Replay::new(scenario, scenery, &outcome, &trace, verdict.as_ref()))
}

use std::collections::BTreeMap;
use std::ops::ControlFlow;

use super::super::town::Scenery;
use super::Replay;
use crate::campaign::{Finished, TrainingResult, watch};
use crate::compile::{Campaign, ControllerKind, Evaluation, Search};
use crate::falsifier::follow;
use crate::judge::judge;
use crate::rl::ActorCritic;
use crate::seed::Seed;

/// Most failures with a player.
const PLAYERS: usize = 14;

/// The failures that can be played on a page.
#[derive(Debug, Default)]
pub struct Players {
    all: BTreeMap<String, Replay>,
    /// The options of `falsify replay`, with a blank after each.
    options: &'static str,
}

impl Players {
    /// Repeats these failures, named `RUN:EPISODE`, in order, up to a number that keeps the page small. The options are those that
    /// `falsify replay` needs.
    pub fn repeat<'a>(
        names: impl IntoIterator<Item = &'a str>,
        campaign: &Campaign,
        finished: &Finished,
        seed: &Seed,
        options: &'static str,
    ) -> Self {
        let mut scenery: BTreeMap<String, Scenery> = BTreeMap::new();
        let mut players = Self { options, ..Self::default() };
        for name in names {
            if players.all.len() == PLAYERS {
                break;
            }
            if !players.all.contains_key(name)
                && let Some(replay) = replay(name, campaign, finished, seed, &mut scenery)
            {
                players.all.insert(name.to_string(), replay);
            }
        }
        players
    }

    /// The options that `falsify replay` needs, with a blank after each.
    pub const fn options(&self) -> &'static str {
        self.options
    }

    /// The player of a failure; none when it was not repeated.
    pub fn get(&self, name: &str) -> Option<&Replay> {
        self.all.get(name)
    }

    /// The `id` of a failure's player on the page.
    pub fn id(name: &str) -> String {
        format!("play-{}", name.replace(':', "-"))
    }

    /// The link to the player of a failure; none when it was not repeated.
    pub fn link(&self, name: &str) -> Option<String> {
        self.all.contains_key(name).then(|| format!("#{}", Self::id(name)))
    }
}

/// Repeats a failure for the player; none when it is not of this campaign or cannot be repeated.
fn replay(
    name: &str,
    campaign: &Campaign,
    finished: &Finished,
    seed: &Seed,
    scenery: &mut BTreeMap<String, Scenery>,
) -> Option<Replay> {
    let (run, number) = name.split_once(':')?;
    if let Some(search) = campaign.searches.iter().find(|planned| planned.key.id.to_string() == run) {
        let town = &search.scenario.town;
        let scenery = scenery.entry(search.key.town.clone()).or_insert_with(|| Scenery::new(town));
        return repeat_failure(search, finished, seed, number.parse().ok()?, scenery);
    }
    let evaluation = campaign.evaluations.iter().find(|planned| planned.id.to_string() == run)?;
    let town = &evaluation.scenario.town;
    let scenery = scenery.entry(evaluation.town.to_string()).or_insert_with(|| Scenery::new(town));
    repeat(campaign, &finished.trainings, seed, evaluation, number.parse().ok()?, scenery)
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

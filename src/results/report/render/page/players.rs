use std::collections::BTreeMap;

use super::super::town::Scenery;
use super::Replay;
use crate::campaign::{Finished, networks, repeat_episodes, repeat_failure};
use base::seed::Seed;
use compile::{Campaign, Search};
use world::env::{Outcome, Trace};
use world::judge::judge;

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
        return failure(search, finished, seed, number.parse().ok()?, scenery);
    }
    let evaluation = campaign.evaluations.iter().find(|planned| planned.id.to_string() == run)?;
    let town = &evaluation.scenario.town;
    let scenery = scenery.entry(evaluation.town.to_string()).or_insert_with(|| Scenery::new(town));
    let trained = networks(evaluation, campaign, &finished.trainings);
    let scenario = &evaluation.scenario;
    let note = &mut |outcome: &Outcome, trace: &Trace| {
        Replay::new(scenario, scenery, outcome, trace, judge(&trace.main_pair(scenario)).as_ref())
    };
    repeat_episodes(evaluation, trained, &[number.parse().ok()?], seed, note).pop().map(|(_, replay)| replay)
}

/// Repeats a failure of a search for the player; none when it ends otherwise.
fn failure(search: &Search, finished: &Finished, seed: &Seed, number: usize, scenery: &Scenery) -> Option<Replay> {
    let result = finished.searches.iter().find(|result| result.key == search.key)?;
    let failure = result.spent.failures.get(number)?;
    let scenario = &search.scenario;
    let (outcome, trace) = repeat_failure(search, failure.start, &failure.commands, seed)?;
    let verdict = result.verdicts.get(number).copied().flatten();
    Some(Replay::new(scenario, scenery, &outcome, &trace, verdict.as_ref()))
}

//! Where the episodes of a campaign would start.

use std::sync::Arc;

use base::seed::Seed;
use compile::Campaign;
use episode::{Scenario, Spawn, Survey};

/// Starts that were drawn from one spawn rule in one town.
#[derive(Debug, Clone)]
pub struct SampledStarts {
    pub town: String,
    /// The scenario, which has the rule and the town.
    pub scenario: Arc<Scenario>,
    /// The starts, and how often each constraint holds.
    pub survey: Survey,
    pub ends: EndsOfRoads,
}

/// Where the map of a town ends, as accepted starts meet it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EndsOfRoads {
    /// How far the car drives in an episode at most (m): at 30 km/h, or at the highest speed that the town or the spawn gives it.
    pub way: f64,
    /// The number of starts from which a road that leads nowhere ends within this way.
    pub near: usize,
    /// The number of pedestrians that stand past such an end, where the map has no road.
    pub past: usize,
}

impl EndsOfRoads {
    fn of(scenario: &Scenario, survey: &Survey) -> Self {
        let Scenario { town, spawn, episode, .. } = scenario;
        let way = spawn.greatest_limit(town).unwrap_or(ASSUMED_SPEED) * episode.tick * f64::from(episode.ticks);
        let count = |is: &dyn Fn(&Spawn) -> bool| survey.spawns.iter().filter(|start| is(start)).count();
        let ends_near = |start: &Spawn| {
            let lane = town.lane_around(start.ego.position());
            lane.is_some_and(|lane| town.ends_within(lane.place, way))
        };
        if !town.has_ends() {
            return Self { way, near: 0, past: 0 };
        }
        Self { way, near: count(&ends_near), past: count(&|start| town.is_past_end(start.pedestrian.position())) }
    }
}

/// The speed of cars on roads without a limit, 30 km/h (m/s).
const ASSUMED_SPEED: f64 = 30.0 / 3.6;

/// Draws a number of starts of every spawn rule of a campaign in every town in which it can begin.
pub fn sampled_starts(campaign: &Campaign, count: u32, seed: u64) -> Vec<SampledStarts> {
    let begins = |(_, scenario): &(&str, &Arc<Scenario>)| scenario.spawn.begins_in(&scenario.town);
    let sampled = |(town, scenario): (&str, &Arc<Scenario>)| {
        let rule = &scenario.spawn;
        let mut stream = Seed::root(seed).child("sample").child(town).child(&rule.name).stream();
        let first = scenario.cast.pedestrian().first_heading;
        let survey = rule.survey(&scenario.town, &scenario.obstacles, first, count, &mut stream);
        let ends = EndsOfRoads::of(scenario, &survey);
        SampledStarts { town: town.to_string(), scenario: Arc::clone(scenario), survey, ends }
    };
    campaign.starts().into_iter().filter(begins).map(sampled).collect()
}

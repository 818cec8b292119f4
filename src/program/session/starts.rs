//! Where the episodes of a campaign would start.

use std::sync::Arc;

use base::seed::Seed;
use compile::Campaign;
use world::env::{Scenario, Survey};

/// Starts that were drawn from one spawn rule in one town.
#[derive(Debug, Clone)]
pub struct SampledStarts {
    pub town: String,
    /// The scenario, which has the rule and the town.
    pub scenario: Arc<Scenario>,
    /// The starts, and how often each constraint holds.
    pub survey: Survey,
}

/// Draws a number of starts of every spawn rule of a campaign in every town in which it can begin.
pub fn sampled_starts(campaign: &Campaign, count: u32, seed: u64) -> Vec<SampledStarts> {
    let begins = |(_, scenario): &(&str, &Arc<Scenario>)| scenario.spawn.begins_in(&scenario.town);
    let sampled = |(town, scenario): (&str, &Arc<Scenario>)| {
        let rule = &scenario.spawn;
        let mut stream = Seed::root(seed).child("sample").child(town).child(&rule.name).stream();
        let first = scenario.cast.pedestrian.first_heading;
        let survey = rule.survey(&scenario.town, &scenario.obstacles, first, count, &mut stream);
        SampledStarts { town: town.to_string(), scenario: Arc::clone(scenario), survey }
    };
    campaign.starts().into_iter().filter(begins).map(sampled).collect()
}

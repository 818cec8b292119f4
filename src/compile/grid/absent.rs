//! What the towns of a campaign do not have, and something in it is about.

use std::collections::BTreeMap;

use super::Grid;
use crate::jobs::Search;
use crate::lowering::Lowering;
use base::signature::{Formula, Value};
use lang::diagnostics;
use lang::hir::Block;
use world::env::RewardRule;
use world::road::Town;

/// A part of a town: its name, the variables about it, and whether a town has it.
struct Part {
    name: &'static str,
    variables: &'static [&'static str],
    is_in: fn(&Town) -> bool,
}

const PARTS: [Part; 2] = [
    Part {
        name: "crosswalks",
        variables: &["crosswalk_distance", "crosswalk_taken", "crosswalk_waiting"],
        is_in: |town| !town.crosswalks.is_empty(),
    },
    Part {
        name: "traffic lights",
        variables: &["light_distance", "red_light"],
        is_in: |town| !town.traffic_lights.is_empty(),
    },
];

impl Lowering<'_> {
    /// Warns of requirements, rewards and drivers of a campaign that are about a part that a town of it does not have.
    pub(super) fn warn_of_absent(&mut self, block: &Block, grid: &Grid) {
        for part in &PARTS {
            let named = |town: &&crate::plan::NamedTown| !(part.is_in)(&town.town);
            let without: Vec<&str> = grid.campaign.towns.iter().filter(named).map(|town| town.name.as_str()).collect();
            if without.is_empty() {
                continue;
            }
            let vocabulary = &self.catalog.vocabulary;
            let is_one = |id| vocabulary.variable(id).is_some_and(|variable| part.variables.contains(&variable.name));
            let is_about = |formula: &Formula| formula.mentions(&is_one);
            let places = block.members("requirements");
            let requirements = grid.usual.requirements.all.iter().enumerate().filter_map(|(index, each)| {
                let is_named = each.requirement.parts.iter().any(|part| is_about(&part.margin));
                is_named.then(|| (places.get(index).copied().unwrap_or(block.head), each.name.to_string()))
            });
            let trained = grid.rewards.iter().map(|(name, reward)| (name, &reward.value));
            let searched = grid.campaign.all::<Search>().map(|search| (&search.key.reward, &search.scenario.reward));
            let rewards: BTreeMap<&String, &RewardRule> = trained.chain(searched).collect();
            let rewards = rewards.into_iter().filter_map(|(name, rule)| {
                let clauses = rule.hit.iter().chain([&rule.step, &rule.lost, &rule.timeout, &rule.potential]);
                clauses.flatten().any(is_about).then(|| (block.head, name.clone()))
            });
            let end = grid.usual.rule.value.end_when.iter().filter(|formula| is_about(formula));
            let end = end.map(|_| (block.head, "end_when".to_string()));
            let yields = |settings: &base::signature::Arguments| {
                let mut values = settings.iter();
                values.any(|(key, value)| key == part.name && *value == Value::Choice("yield"))
            };
            let drivers = grid.campaign.drivers.iter().filter(|driver| yields(&driver.settings));
            let drivers = drivers.map(|driver| (block.head, driver.name.clone()));
            let found: Vec<_> = requirements.chain(rewards).chain(end).chain(drivers).collect();
            for (place, name) in found {
                self.said.push(diagnostics::never_applies(place, &name, part.name, &without));
            }
        }
    }
}

//! What the towns of a campaign do not have, and something in it is about.

use std::collections::{BTreeMap, BTreeSet};

use super::{Cover, Estimation, Search};
use crate::grid::Grid;
use crate::lowering::Lowering;
use crate::reached::reached_by;
use base::signature::{Comparison, Formula, Value, VariableId};
use episode::requirement::NamedRequirement;
use episode::{MapPart, RewardRule};
use lang::diagnostics;
use lang::hir::Block;
use road::{FIRST_LIMIT, OpenDriveWarning};

/// What follows where a town has nothing of what is asked.
const NOTHING: &str = "its result there says nothing";
/// The same for a walk to a bus stop.
const CROSSES: &str = "there the pedestrian crosses the road";

/// How much faster than the highest speed limit of its towns a car may be expected to drive.
const ABOVE_LIMIT: f64 = 1.5;

/// The highest of the speeds of a key (m/s).
fn highest(value: &Value) -> f64 {
    match value {
        Value::Number(speed) | Value::Range(_, speed) => *speed,
        Value::Distribution(drawn) => drawn.support().1,
        Value::List(members) => members.iter().map(highest).fold(0.0, f64::max),
        _ => 0.0,
    }
}

/// What the towns of a campaign have of a part, and does not count, as `falsify preview` names it.
fn unused(part: &MapPart, grid: &Grid) -> Vec<String> {
    let is_of_part = |warning: &&OpenDriveWarning| {
        warning.problem.is_unused() && warning.problem.to_string().contains(part.name.trim_end_matches('s'))
    };
    let towns = grid.campaign.towns.iter();
    let warnings = towns.flat_map(|each| each.town.warnings.iter().filter(is_of_part).map(|said| (&each.name, said)));
    warnings.map(|(town, said)| format!("in the map of `{town}`, {said}")).collect()
}

impl Lowering<'_> {
    /// Warns of requirements, rewards and drivers of a campaign that are about a part that a town of it does not have.
    pub(super) fn warn_of_absent(&mut self, block: &Block, grid: &Grid) {
        for part in &MapPart::ALL {
            let named = |town: &&crate::plan::NamedTown| !part.is_there(&town.town, &grid.usual.rule.value);
            let without: Vec<&str> = grid.campaign.towns.iter().filter(named).map(|town| town.name.as_str()).collect();
            if without.is_empty() {
                continue;
            }
            let is_about = |formula: &Formula| formula.mentions(&|id| part.has(id));
            let places = block.members("requirements");
            let requirements = grid.usual.requirements.all.iter().enumerate().filter_map(|(index, each)| {
                let is_named = each.requirement.parts.iter().any(|part| is_about(&part.margin));
                is_named.then(|| (places.get(index).copied().unwrap_or(block.head), each.name.to_string()))
            });
            let jobs = &grid.campaign;
            let scenarios =
                jobs.all::<Search>().map(|job| &job.scenario).chain(jobs.all::<Estimation>().map(|job| &job.scenario));
            let asked = scenarios
                .chain(jobs.all::<Cover>().map(|job| &job.scenario))
                .flat_map(|scenario| &*scenario.requirements);
            let is_own =
                |each: &&NamedRequirement| !grid.usual.requirements.all.iter().any(|all| all.name == each.name);
            let asked = asked.filter(is_own).filter(|each| each.requirement.mentions(&|id| part.has(id)));
            let asked: BTreeSet<String> = asked.map(|each| each.name.to_string()).collect();
            let asked = asked.into_iter().map(|name| (block.head, name));
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
            let found: Vec<_> = requirements.chain(asked).chain(rewards).chain(end).chain(drivers).collect();
            let unused = unused(part, grid);
            for (place, name) in found {
                let absent = diagnostics::never_applies(place, &name, part.name, &without, NOTHING);
                self.said.push(unused.iter().fold(absent, |absent, help| absent.help(help)));
            }
        }
    }

    /// Warns of pedestrians of a campaign that walk to a bus stop, and of its towns without any.
    pub(super) fn warn_of_stops(&mut self, block: &Block, grid: &Grid) {
        let towns = grid.campaign.towns.iter().filter(|town| town.town.bus_stops.is_empty());
        let without: Vec<&str> = towns.map(|town| town.name.as_str()).collect();
        let to_stop = |(key, value): (&str, &Value)| key == "destination" && *value == Value::Choice("bus_stop");
        for id in reached_by(self.program, block).into_iter().filter(|_| !without.is_empty()) {
            let walker = self.program.get(id);
            if walker.block.arguments.iter().any(to_stop) {
                self.said.push(diagnostics::never_applies(block.head, &walker.name, "bus stops", &without, CROSSES));
            }
        }
    }

    /// Warns of comparisons of requirements that are decided by the speed limits: no car of the campaign drives so fast. A speed that a start or a
    /// driver names counts as a limit. Drivers of the user may break all limits.
    pub(super) fn warn_of_speeds(&mut self, block: &Block, grid: &Grid) {
        if grid.campaign.drivers.iter().any(crate::plan::Driver::is_own) {
            return;
        }
        let limits =
            grid.campaign.towns.iter().filter_map(|each| each.town.highest_limit()).fold(FIRST_LIMIT, f64::max);
        let starts = self.program.of_form("spawn").map(|spawn| &spawn.block.arguments);
        let named =
            starts.chain(grid.campaign.drivers.iter().map(|driver| &driver.settings)).flat_map(|each| each.iter());
        let named = named.filter(|(key, _)| key.ends_with("speed") || key.ends_with("speeds"));
        let limit = named.map(|(_, value)| highest(value)).fold(limits, f64::max);
        let vocabulary = &self.catalog.vocabulary;
        let is_decided = |part: &Comparison, speed: f64| {
            let bounds = |id: VariableId| match vocabulary.variable(id) {
                Some(variable) if variable.name == "ego_speed" => (0.0, speed),
                Some(variable) => variable.bounds,
                None => (f64::NEG_INFINITY, f64::INFINITY),
            };
            let (low, high) = part.margin.bounds(&bounds);
            low > 0.0 || high < 0.0
        };
        let places = block.members("requirements");
        for (index, each) in grid.usual.requirements.all.iter().enumerate() {
            let fastest = limit * ABOVE_LIMIT;
            let mut parts = each.requirement.parts.iter();
            let decided = parts.find(|part| is_decided(part, fastest) && !is_decided(part, f64::INFINITY));
            if let Some(part) = decided {
                let place = places.get(index).copied().unwrap_or(block.head);
                self.said.push(diagnostics::unreachable_speed(place, &each.name, &part.text, limit));
            }
        }
    }
}

use std::sync::Arc;

use super::written::PARAMETERS;
use super::{Harden, VariedKey, WrittenPolicy};
use crate::campaign::{PlaceKeys, StartKeys};
use crate::driver_parts::unit;
use crate::grid::{Axis, Grid, Ground, Nested, Usual, note_towns};
use crate::jobs::JobBlock;
use crate::jobs::search::Rival;
use crate::lowering::Lowering;
use crate::{Catalog, Job, policy};
use base::keys;
use base::signature::{Arguments, DeclarationId, Keys, Type, Value};
use base::units::Dimension;
use episode::walker::Controller;
use episode::{PedestrianRole, RewardRule, Scenario};
use lang::diagnostics;
use lang::hir::{Block, Declaration};
use search::hardening::{Attack, Hardening, Side, TrafficRule, Tunable, TunableKey};
use world::av::external::Program;

/// Maximum number of keys that are varied: a search with some dozens of candidates finds nothing in more.
const MAX_KEYS: usize = 12;

keys! {
    /// Makes a driver with fewer faults: searches attack it in some towns, then its keys are searched, round after round. At the end the driver as it was
    /// and as it has become meet other pedestrians in other towns. Keys are varied between their values in `from` and in `to`.
    pub struct HardenKeys = "harden" {
        /// Towns of the rounds.
        towns: Vec<DeclarationId> as Reference("town"),
        /// The driver.
        driver: DeclarationId as Reference("driver"),
        /// The same kind with one end of the range of each key that may be varied, such as `idm(time_headway: 1 s)`. Of an `external` driver the
        /// numbers at the ends of the words of its `command` may differ.
        from: DeclarationId as Reference("driver"),
        /// The same kind with the other ends.
        to: DeclarationId as Reference("driver"),
        /// Who attacks.
        methods: Vec<DeclarationId> as Reference("method"),
        /// Simulator ticks of each attack: of each method in each town, in each round.
        budget: u64 as ticks(1, 1_000_000_000_000) = "200_000",
        /// Rounds of attack and repair.
        rounds: u32 as whole(1, 100) = "3",
        /// Values of the keys that a repair tries out.
        candidates: u32 as whole(2, 10_000) = "40",
        /// Episodes in which each of them meets each pedestrian that an attack ended up with, beside the failures themselves.
        lessons: u32 as whole(0, 100_000) = "20",
        /// Episodes with natural pedestrians in each town in which each of them shows its progress and its comfort.
        traffic: u32 as whole(1, 100_000) = "50",
        ..rule: TrafficRule,
        /// Towns of the test, in which nothing is repaired.
        test_towns: Vec<DeclarationId> as Reference("town"),
        // The catalogue adds the words.
        /// Who walks in the test, as in `evaluate`: words, or a `pedestrian` of the file.
        pedestrians: Vec<Value> as WordOrReference(Vec::new(), "pedestrian") = "[intercept]",
        /// Who searches in the test, with the same `budget` before and after.
        rivals: Option<Vec<DeclarationId>> as Reference("method"),
        /// Episodes of the test for each town and pedestrian, and natural ones for each town.
        episodes: u32 as whole(1, 1_000_000) = "500",
        /// Repairs of it, with different seeds.
        runs: u32 as whole(1, 10_000) = "3",
        /// Body, instead of the campaign's.
        body: Option<DeclarationId> as Reference("body"),
        ..start: StartKeys,
    }
}

pub(crate) const BLOCK: JobBlock = JobBlock {
    signature: HardenKeys::signature,
    drivers: |block| vec![block.keys::<HardenKeys>().driver],
    lower: |it, at, grid| it.harden(at, grid),
};

/// A town with its scenario.
type Place = (String, Arc<Scenario>);

impl Lowering<'_> {
    fn harden(&mut self, at: Nested<'_>, grid: &mut Grid) {
        let keys: HardenKeys = at.block.keys();
        let block = at.block;
        let of = |towns: &[DeclarationId]| PlaceKeys { towns: towns.to_vec(), drivers: vec![keys.driver] };
        let Some((ground, body)) = self.setting(at, &of(&keys.towns), &keys.start, keys.body, grid) else {
            return;
        };
        let Some((tests, _)) = self.setting(at, &of(&keys.test_towns), &keys.start, keys.body, grid) else {
            return;
        };
        if ground.spawn.value.scripted().is_some() {
            return self.said.push(diagnostics::scripted_attack(block.head));
        }
        if let Some(again) = keys.test_towns.iter().position(|town| keys.towns.contains(town)) {
            let span = block.members("test_towns").get(again).copied().unwrap_or(block.head);
            self.said.push(diagnostics::test_of_repair(span));
        }
        let attacks = self.falsifiers(at, &keys.methods, &body, &grid.usual);
        let rivals = self.falsifiers(at, keys.rivals.as_deref().unwrap_or_default(), &body, &grid.usual);
        let walkers: Option<Vec<_>> =
            keys.pedestrians.iter().map(|word| self.untrained(block, "pedestrians", word, false)).collect();
        let (Some(walkers), Some((driver, written))) = (walkers, self.tunable(block, &keys)) else { return };
        if ground.policies.is_empty() || !self.fits(block, &[keys.runs as usize]) {
            return;
        }
        let Grid { usual, campaign, .. } = grid;
        note_towns(&mut campaign.towns, &ground.towns);
        note_towns(&mut campaign.towns, &tests.towns);
        let natural = self.walker_kind(&Value::Choice("natural")).controller.clone();
        let plain = RewardRule::default();
        let attacked = |ground: &Ground, rivals: &[Rival]| -> Vec<Attack> {
            let each = |rival: &Rival| {
                let scenarios = places(ground, &body, usual, &rival.reward.1);
                (rival.name.clone(), rival.falsifier.clone(), scenarios.into_iter().map(|place| place.1).collect())
            };
            rivals.iter().map(each).collect()
        };
        let hardening = Arc::new(Hardening {
            driver,
            towns: places(&ground, &body, usual, &plain),
            attacks: attacked(&ground, &attacks),
            budget: keys.budget,
            rounds: keys.rounds,
            candidates: keys.candidates,
            lessons: keys.lessons,
            traffic: keys.traffic,
            natural,
            rule: keys.rule,
            test_towns: places(&tests, &body, usual, &plain),
            walkers: walkers.iter().map(|(walker, _): &(Controller, _)| walker.clone()).collect(),
            rivals: attacked(&tests, &rivals),
            episodes: keys.episodes,
        });
        let places = ground.places().chain(tests.places());
        let mut parts: Vec<DeclarationId> = places.flat_map(|place| usual.declarations(&place, &body)).collect();
        parts.extend([keys.from, keys.to]);
        parts.extend(&usual.requirements.ids);
        parts.extend(attacks.iter().chain(&rivals).flat_map(|rival| rival.declarations.iter().copied()));
        parts.extend(walkers.iter().filter_map(|(_, declared)| *declared));
        let written = Arc::new(written);
        campaign.jobs.extend(
            self.origins(at, keys.runs, &parts)
                .map(|origin| Job::from(Harden { origin, hardening: hardening.clone(), written: written.clone() })),
        );
    }

    /// The driver with the keys that `from` and `to` state; none after reporting what is wrong.
    fn tunable(&mut self, block: &Block, keys: &HardenKeys) -> Option<(Tunable, WrittenPolicy)> {
        let program = self.program;
        let [policy, from, to] = [keys.driver, keys.from, keys.to].map(|id| program.get(id));
        let mut wrong = |key: &str, message: String, help: &str| {
            self.said.push(diagnostics::contradiction(block.place(key), message).help(help));
        };
        for (key, end) in [("from", from), ("to", to)] {
            if end.kind != policy.kind {
                let message =
                    format!("`{key}` is of kind `{}`, and `{}` of kind `{}`", end.kind, policy.name, policy.kind);
                wrong(key, message, "write the same kind with other values of the keys that may be varied");
                return None;
            }
        }
        let stated = |end: &Declaration| end.block.places.iter().map(|(key, _)| *key).collect::<Vec<_>>();
        let (first, second) = (stated(from), stated(to));
        for (key, other, stated, missing) in [("to", "from", &first, &second), ("from", "to", &second, &first)] {
            if let Some(lonely) = stated.iter().find(|key| !missing.contains(key)) {
                let message = format!("`{other}` states `{lonely}` and `{key}` does not");
                wrong(key, message, "state both ends of its range");
                return None;
            }
        }
        let mut varied = Vec::new();
        for key in first {
            let values = [policy, from, to].map(|each| each.block.arguments.value(key));
            match values {
                [_, one, other] if one == other => {}
                [Value::Number(before), Value::Number(one), Value::Number(other)] => {
                    let tuned = TunableKey { name: key.into(), range: (*one, *other), before: *before };
                    varied.push((tuned, VariedKey::Key { key, unit: unit(dimension(policy, key, self.catalog)) }));
                }
                [Value::List(before), Value::List(one), Value::List(other)] if key == PARAMETERS => {
                    let Some(parameters) = parameters([before, one, other]) else {
                        let message =
                            "`driver`, `from` and `to` must have parameters of the same names in the same order".into();
                        wrong("from", message, "write `parameters: [\"gap=1\"]` and `parameters: [\"gap=3\"]`");
                        return None;
                    };
                    varied.extend(parameters);
                }
                _ => {
                    let message = format!("`{key}` is not a quantity, so it cannot be varied between two values");
                    wrong("from", message, "vary keys that are quantities, such as times and distances");
                    return None;
                }
            }
        }
        if varied.is_empty() || varied.len() > MAX_KEYS {
            let message = match varied.len() {
                0 => "`from` and `to` are equal, so no key can be varied".to_string(),
                many => format!("{many} keys are varied; at most {MAX_KEYS} can be"),
            };
            wrong("from", message, "state the two ends of the range of some keys in `from` and in `to`");
            return None;
        }
        let make = policy::from_arguments(policy, self)?;
        let (tuned, varied): (Vec<_>, Vec<_>) = varied.into_iter().unzip();
        let written = WrittenPolicy {
            name: policy.name.clone(),
            kind: policy.kind,
            keys: policy.block.places.iter().map(|(key, span)| (*key, self.sources.text(*span).to_string())).collect(),
            varied: varied.clone(),
        };
        let arguments = policy.block.arguments.clone();
        let pairs = self.catalog.signature_of(policy).map_or(&[][..], |signature| &signature.rising);
        let side = |key: &str| match varied.iter().position(|each| each.is_key(key)) {
            Some(place) => Side::Varied(place),
            None => Side::Fixed(arguments.read(key)),
        };
        let rising = pairs.iter().map(|pair| pair.map(side)).collect();
        let varied = varied.clone();
        let own = arguments.clone();
        let tunable = Tunable::new(tuned, move |values| make(&with(&own, &varied, values))).rising(rising);
        Some((tunable, written))
    }
}

fn dimension(policy: &Declaration, key: &str, catalog: &Catalog) -> Option<Dimension> {
    let signature = catalog.signature_of(policy)?;
    signature.params.iter().find(|param| param.name == key).and_then(|param| Type::dimension(&param.ty))
}

fn with(arguments: &Arguments, varied: &[VariedKey], values: &[f64]) -> Arguments {
    let mut arguments = arguments.clone();
    for (varied, value) in varied.iter().zip(values) {
        match varied {
            VariedKey::Key { key, .. } => arguments.replace(key, Value::Number(*value)),
            VariedKey::Parameter { name } => {
                let Value::List(mut members) = arguments.value(PARAMETERS).clone() else { continue };
                let text = format!("{name}={}", base::signature::short(*value));
                let is_same = |member: &Value| parameter(member).is_some_and(|(known, _)| known == *name);
                if let Some(member) = members.iter_mut().find(|member| is_same(member)) {
                    *member = Value::Text(text);
                }
                arguments.replace(PARAMETERS, Value::List(members));
            }
        }
    }
    arguments
}

/// A member of a list of parameters.
fn parameter(member: &Value) -> Option<(String, f64)> {
    if let Value::Text(text) = member { Program::parameter(text).ok() } else { None }
}

/// The parameters that differ between two ends, with their present values. `None` if the names differ.
fn parameters([before, from, to]: [&[Value]; 3]) -> Option<Vec<(TunableKey, VariedKey)>> {
    if before.len() != from.len() || before.len() != to.len() {
        return None;
    }
    let mut found = Vec::new();
    for ((before, from), to) in before.iter().zip(from).zip(to) {
        let ((name, before), (first, from), (second, to)) = (parameter(before)?, parameter(from)?, parameter(to)?);
        if name != first || name != second {
            return None;
        }
        if from.total_cmp(&to).is_ne() {
            found.push((TunableKey { name: name.clone(), range: (from, to), before }, VariedKey::Parameter { name }));
        }
    }
    Some(found)
}

/// The towns of a ground with the scenario of the driver in each.
fn places(ground: &Ground, body: &Axis<PedestrianRole>, usual: &Usual, reward: &RewardRule) -> Vec<Place> {
    let scenario = |place: crate::grid::Place<'_>| {
        (place.town.name.to_string(), usual.scenario(&place, body, reward, &usual.requirements.all))
    };
    ground.places().map(scenario).collect()
}

use std::sync::Arc;

use super::axis::{Axis, Usual};
use super::ground::{Ground, note_towns};
use super::search::Rival;
use crate::campaign::{HardenKeys, PlaceKeys};
use crate::harden::{Harden, HardenKey, VariedKey, WrittenPolicy, with_word};
use crate::lowering::Lowering;
use crate::plan::Campaign;
use crate::policy;
use crate::{Catalog, RunId};
use base::signature::{Arguments, DeclarationId, Type, Value};
use base::units::Dimension;
use lang::diagnostics;
use lang::hir::{Block, Declaration};
use world::env::{PedestrianRole, RewardRule, Scenario};
use world::falsifier::Controller;
use world::hardening::{Attack, Hardening, Side, TrafficRule, Tunable, TunableKey};

/// The most keys that a repair varies: a search with some dozens of candidates finds nothing in more.
const MOST_KEYS: usize = 12;

/// A town with its scenario.
type Place = (String, Arc<Scenario>);

impl Lowering<'_> {
    pub(super) fn harden(
        &mut self,
        campaign_block: &Block,
        block: &Block,
        number: u32,
        usual: &Usual,
        campaign: &mut Campaign,
    ) {
        let keys: HardenKeys = block.keys();
        let own = keys.adversary.map(|id| self.adversary(id));
        let adversary = own.as_ref().unwrap_or(&usual.walker);
        let bodies = [(&usual.car, adversary)];
        let at = |towns: &[DeclarationId]| PlaceKeys { towns: towns.to_vec(), policies: vec![keys.policy] };
        let Some(ground) = self.ground(campaign_block, block, &at(&keys.towns), &keys.start, &bodies) else { return };
        let Some(tests) = self.ground(campaign_block, block, &at(&keys.test_towns), &keys.start, &bodies) else {
            return;
        };
        if ground.spawn.value.scripted().is_some() {
            let message =
                "a target walks as its test states, so nothing can attack a driver from these starts".to_string();
            return self.said.push(diagnostics::contradiction(block.head, message).help("use a `spawn` with ranges"));
        }
        if let Some(again) = keys.test_towns.iter().position(|town| keys.towns.contains(town)) {
            let span = block.members("test_towns").get(again).copied().unwrap_or(block.head);
            let message =
                "the driver is repaired in this town, so a test in it shows less than it seems to".to_string();
            self.said.push(diagnostics::contradiction(span, message).help("name a town that is not among `towns`"));
        }
        let attacks = self.falsifiers(campaign_block, &keys.falsifiers, &adversary.value, usual.training.as_ref());
        let rivals = self.falsifiers(
            campaign_block,
            keys.rivals.as_deref().unwrap_or_default(),
            &adversary.value,
            usual.training.as_ref(),
        );
        let walkers: Option<Vec<_>> = keys.pedestrians.iter().map(|word| self.covering(block, word, false)).collect();
        let (Some(walkers), Some((driver, written))) = (walkers, self.tunable(block, &keys)) else { return };
        if ground.policies.is_empty() || !self.fits(block, [keys.runs as usize, 1, 1, 1]) {
            return;
        }
        note_towns(&mut campaign.towns, &ground.towns);
        note_towns(&mut campaign.towns, &tests.towns);
        let natural = self.catalog.walkers.iter().find(|kind| kind.word() == "natural");
        let natural = natural.expect("the catalogue has the kind `natural`").controller.clone();
        let plain = RewardRule::default();
        let attacked = |ground: &Ground, rivals: &[Rival]| -> Vec<Attack> {
            let each = |rival: &Rival| {
                let scenarios = places(ground, adversary, usual, &rival.reward.1);
                (rival.name.clone(), rival.falsifier.clone(), scenarios.into_iter().map(|place| place.1).collect())
            };
            rivals.iter().map(each).collect()
        };
        let hardening = Arc::new(Hardening {
            driver,
            towns: places(&ground, adversary, usual, &plain),
            attacks: attacked(&ground, &attacks),
            budget: keys.budget,
            rounds: keys.rounds,
            candidates: keys.candidates,
            lessons: keys.lessons,
            traffic: keys.traffic,
            natural,
            rule: TrafficRule { progress: keys.progress, comfort: keys.comfort, hard_braking: keys.hard_braking },
            test_towns: places(&tests, adversary, usual, &plain),
            walkers: walkers.iter().map(|(walker, _): &(Controller, _)| walker.clone()).collect(),
            rivals: attacked(&tests, &rivals),
            episodes: keys.episodes,
        });
        let places = ground.places().chain(tests.places());
        let mut parts: Vec<DeclarationId> =
            places.flat_map(|place| place.declarations(&usual.car, adversary, &usual.rule)).collect();
        parts.extend([keys.from, keys.to]);
        parts.extend(&usual.requirements.ids);
        parts.extend(attacks.iter().chain(&rivals).flat_map(|rival| rival.declarations.iter().copied()));
        parts.extend(walkers.iter().filter_map(|(_, declared)| *declared));
        let (fingerprint, programs) = (self.fingerprint(&parts), self.programs(&parts));
        let written = Arc::new(written);
        campaign.hardenings.extend((0..keys.runs).map(|run| Harden {
            key: HardenKey { id: RunId::default(), policy: written.name.clone(), block: number, run },
            hardening: hardening.clone(),
            written: written.clone(),
            fingerprint,
            programs: programs.clone(),
        }));
    }

    /// The driver with the keys that `from` and `to` state; none after reporting what is wrong.
    fn tunable(&mut self, block: &Block, keys: &HardenKeys) -> Option<(Tunable, WrittenPolicy)> {
        let program = self.program;
        let [policy, from, to] = [keys.policy, keys.from, keys.to].map(|id| program.get(id));
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
        if let Some(lonely) = first.iter().find(|key| !second.contains(key)) {
            wrong("to", format!("`from` states `{lonely}` and `to` does not"), "state both ends of its range");
            return None;
        }
        if let Some(lonely) = second.iter().find(|key| !first.contains(key)) {
            wrong("from", format!("`to` states `{lonely}` and `from` does not"), "state both ends of its range");
            return None;
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
                [Value::Text(before), Value::Text(one), Value::Text(other)] => {
                    let Some(words) = words(key, [before, one, other]) else {
                        let message = format!(
                            "the texts of `{key}` must have equal words, but for a number at the end of each word that may be varied"
                        );
                        wrong(
                            "from",
                            message,
                            "write it as \"python my_av.py --gap=1\" and \"python my_av.py --gap=3\"",
                        );
                        return None;
                    };
                    varied.extend(words);
                }
                _ => {
                    let message = format!("`{key}` is no quantity, so it cannot be varied between two values");
                    wrong("from", message, "vary keys that are quantities, such as times and distances");
                    return None;
                }
            }
        }
        if varied.is_empty() || varied.len() > MOST_KEYS {
            let message = match varied.len() {
                0 => "`from` and `to` are equal, so no key can be varied".to_string(),
                many => format!("{many} keys are varied; at most {MOST_KEYS} can be"),
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
        let pairs = policy::signature(policy, self.catalog).map_or(&[][..], |signature| &signature.rising);
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
    let signature = policy::signature(policy, catalog)?;
    signature.params.iter().find(|param| param.name == key).and_then(|param| Type::dimension(&param.ty))
}

/// The unit of SI of a dimension, as a file writes it.
fn unit(dimension: Option<Dimension>) -> &'static str {
    match dimension {
        Some(Dimension::ANGLE) => "rad",
        Some(Dimension::TURN_RATE) => "rad/s",
        other => other.and_then(|dimension| dimension.usual_units().first().copied()).unwrap_or(""),
    }
}

/// The arguments with these values.
fn with(arguments: &Arguments, varied: &[VariedKey], values: &[f64]) -> Arguments {
    let mut arguments = arguments.clone();
    for (varied, value) in varied.iter().zip(values) {
        match varied {
            VariedKey::Key { key, .. } => arguments.replace(key, Value::Number(*value)),
            VariedKey::Word { key, word, before } => {
                let text: String = arguments.read(key);
                let number = base::signature::short(*value);
                arguments.replace(key, Value::Text(with_word(&text, *word, &format!("{before}{number}"))));
            }
        }
    }
    arguments
}

/// The numbers in which texts differ: the present text, and those of the two ends. None when they differ otherwise.
fn words(key: &'static str, texts: [&str; 3]) -> Option<Vec<(TunableKey, VariedKey)>> {
    let [before, from, to] = texts.map(|text| text.split(' ').collect::<Vec<_>>());
    if before.len() != from.len() || before.len() != to.len() {
        return None;
    }
    let mut found = Vec::new();
    for (place, ((before, from), to)) in before.iter().zip(&from).zip(&to).enumerate() {
        if from == to && from == before {
            continue;
        }
        let name = before.find('=').map_or("", |end| &before[..=end]);
        let number = |word: &str| word.strip_prefix(name)?.parse::<f64>().ok().filter(|number| number.is_finite());
        let (now, one, other) = (number(before)?, number(from)?, number(to)?);
        if one == other {
            return None;
        }
        let label = name.trim_start_matches('-').trim_end_matches('=');
        let label = if label.is_empty() { format!("word {place} of {key}") } else { label.to_string() };
        found.push((
            TunableKey { name: label, range: (one, other), before: now },
            VariedKey::Word { key, word: place, before: name.to_string() },
        ));
    }
    Some(found)
}

/// The towns of a ground with the scenario of the driver in each.
fn places(ground: &Ground, adversary: &Axis<PedestrianRole>, usual: &Usual, reward: &RewardRule) -> Vec<Place> {
    let (car, rule, requirements) = (&usual.car.value, &usual.rule.value, &usual.requirements.all);
    let scenario = |place: super::ground::Place<'_>| {
        (place.town.name.to_string(), place.scenario(car, &adversary.value, rule, reward, requirements))
    };
    ground.places().map(scenario).collect()
}

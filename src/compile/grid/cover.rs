use std::sync::Arc;

use super::axis::Usual;
use super::ground::note_towns;
use crate::campaign::{COLLISION, CoverKeys, FAULT};
use crate::lowering::Lowering;
use crate::{Campaign, Cover, CoverKey, Job, RunId};
use base::signature::{DeclarationId, Value};
use lang::diagnostics;
use lang::hir::Block;
use world::env::{Criterion, RewardRule, Scenario, StartParameter};
use world::falsifier::Controller;
use world::judge::Blame;
use world::requirement::NamedRequirement;

/// Maximum number of parameters of a box: with more, no number of episodes shows where it fails.
const MAX_PARAMETERS: usize = 6;

/// What a `cover` block counts.
struct Counted {
    criterion: Criterion,
    blame: Blame,
    /// The requirements of the campaign, and the counted one if it is none of them.
    requirements: Arc<[NamedRequirement]>,
    declared: Option<DeclarationId>,
}

impl Lowering<'_> {
    pub(super) fn cover(
        &mut self,
        campaign_block: &Block,
        block: &Block,
        number: u32,
        usual: &Usual,
        campaign: &mut Campaign,
    ) {
        let keys: CoverKeys = block.keys();
        let own = keys.adversary.map(|id| self.adversary(id));
        let adversary = own.as_ref().unwrap_or(&usual.walker);
        let bodies = [(&usual.car, adversary)];
        let Some(ground) = self.ground(campaign_block, block, &keys.places, &keys.start, &bodies) else { return };
        if !self.fits(block, [ground.towns.len(), ground.policies.len(), 1, 1]) {
            return;
        }
        let Some((walker, controller)) =
            self.covering(block, &keys.pedestrian, ground.spawn.value.scripted().is_some())
        else {
            return;
        };
        note_towns(&mut campaign.towns, &ground.towns);
        let counted = self.counted(block, &keys.failure, usual);
        let mut picture = None;
        for place in ground.places() {
            let rule = &usual.rule.value;
            let reward = RewardRule::default();
            let scenario = place.scenario(&usual.car.value, &adversary.value, rule, &reward, &counted.requirements);
            // The parameters are the same in all places.
            if picture.is_none() {
                picture = self.picture(block, keys.picture.as_deref(), &scenario);
            }
            let Some(picture) = picture.clone() else { return };
            let declared = [controller, counted.declared].into_iter().flatten().collect::<Vec<_>>();
            let parts =
                [place.declarations(&usual.car, adversary, &usual.rule).as_slice(), &usual.requirements.ids, &declared]
                    .concat();
            campaign.jobs.push(Job::from(Cover {
                key: CoverKey {
                    id: RunId::default(),
                    pedestrian: walker.name().to_string(),
                    town: place.town.name.to_string(),
                    policy: place.policy.name.to_string(),
                    spawn: place.spawn.name.to_string(),
                    block: number,
                },
                scenario,
                walker: walker.clone(),
                criterion: counted.criterion,
                blame: counted.blame,
                epsilon: keys.epsilon,
                budget: keys.budget,
                picture,
                fingerprint: self.fingerprint(&parts),
                programs: self.programs(&parts),
            }));
        }
    }

    /// The pedestrian of a block, and its declaration if it has one; none after reporting what is wrong.
    pub(super) fn covering(
        &mut self,
        block: &Block,
        word: &Value,
        has_script: bool,
    ) -> Option<(Controller, Option<DeclarationId>)> {
        if let Value::Reference(id) = word {
            return Some((self.controller(*id)?, Some(*id)));
        }
        let found = self.catalog.walkers.iter().find(|kind| *word == Value::Choice(kind.word()));
        let kind = found.expect("checked: the word is in the catalogue");
        if kind.is_scripted && !has_script {
            let message = format!(
                "a `{}` pedestrian walks as a test or a path states, and the spawn rule of this block is no test and has no path",
                kind.word()
            );
            let help = "use a `spawn` of kind `crossing_test`, `along_test` or `given_path`";
            self.said.push(diagnostics::contradiction(block.place("pedestrian"), message).help(help));
            return None;
        }
        Some((kind.controller.clone(), None))
    }

    fn counted(&mut self, block: &Block, failure: &Value, usual: &Usual) -> Counted {
        let own = &usual.requirements;
        let collision =
            |blame| Counted { criterion: Criterion::Collision, blame, requirements: own.all.clone(), declared: None };
        match failure {
            Value::Choice(FAULT) => collision(Blame::Fault),
            Value::Choice(COLLISION) => collision(Blame::Any),
            Value::Reference(id) => {
                let mut requirements = own.all.to_vec();
                let place = own.ids.iter().position(|other| other == id).unwrap_or_else(|| {
                    requirements.extend(self.requirements(block, "failure", &[*id], &usual.rule.value));
                    requirements.len() - 1
                });
                Counted {
                    criterion: Criterion::Violation(place),
                    blame: Blame::Any,
                    requirements: requirements.into(),
                    declared: Some(*id),
                }
            }
            other => unreachable!("checked: {other:?} is a word or a requirement"),
        }
    }

    /// The places of the parameters of the picture; none after reporting what is wrong with the box.
    fn picture(&mut self, block: &Block, chosen: Option<&[StartParameter]>, scenario: &Scenario) -> Option<Vec<usize>> {
        let known: Vec<StartParameter> = scenario.start_parameters().iter().map(|drawn| drawn.parameter).collect();
        let words: Vec<&str> = known.iter().map(|parameter| parameter.name()).collect();
        if known.is_empty() {
            let message = format!("`{}` draws nothing from a range, so there is no box to cover", scenario.spawn.name);
            let help = "give it a range, such as `distance: 7 m .. 40 m`";
            self.said.push(diagnostics::contradiction(block.head, message).help(help));
            return None;
        }
        if known.len() > MAX_PARAMETERS {
            let message = format!(
                "the box has {} parameters ({}); at most {MAX_PARAMETERS} can be covered",
                known.len(),
                words.join(", ")
            );
            self.said.push(diagnostics::contradiction(block.head, message).help("fix some of them in the spawn rule"));
            return None;
        }
        let Some(chosen) = chosen else { return Some((0..known.len().min(2)).collect()) };
        let places: Option<Vec<usize>> =
            chosen.iter().map(|wanted| known.iter().position(|parameter| parameter == wanted)).collect();
        let different = chosen.len() < 2 || chosen[0] != chosen[1];
        let places = places.filter(|places| different && (1..=2).contains(&places.len()));
        if places.is_none() {
            let message = format!("a picture shows one or two different parameters of the box: {}", words.join(", "));
            self.said.push(diagnostics::contradiction(block.place("picture"), message));
        }
        places
    }
}

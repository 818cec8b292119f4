use std::sync::Arc;

use super::{COLLISION, Cover, FAULT};
use crate::Job;
use crate::campaign::{PlaceKeys, StartKeys};
use crate::grid::{Grid, Nested, Usual, of_places};
use crate::jobs::JobBlock;
use crate::lowering::Lowering;
use base::keys;
use base::signature::{DeclarationId, Keys, Value};
use episode::requirement::NamedRequirement;
use episode::{Criterion, RewardRule, Scenario, StartParameter};
use lang::diagnostics;
use lang::hir::Block;
use verdict::Blame;

/// Maximum number of parameters of a box: with more, no number of episodes shows where it fails.
const MAX_PARAMETERS: usize = 6;

keys! {
    /// Shows with 95 % confidence how little of a box of starts can fail where its picture says that they pass. The box are the ranges of the spawn
    /// rule, and for the target of a test also its speeds and headings. Places on the road and all else that is drawn are chance.
    pub struct CoverKeys = "cover" {
        ..places: PlaceKeys,
        // The catalogue adds the words.
        /// Who walks, as in `evaluate`: a word, or a `pedestrian` of the file. The target of a test walks as the point of the box says.
        pedestrian: Value as WordOrReference(Vec::new(), "pedestrian") = "natural",
        /// What counts: a `fault`, any `collision`, or the violation of a requirement.
        failure: Value as WordOrReference(vec![FAULT, COLLISION], "requirement") = "fault",
        /// The share of the box that is small enough: it ends when the bound is not above it.
        epsilon: f64 as within(RATIO, 0.000_1, 0.5) = "1 percent",
        /// Episodes that it may use at most.
        budget: u32 as whole(20, 10_000_000) = "20_000",
        /// One or two parameters in which the page draws pass and fail, instead of the first two of the box.
        picture: Option<Vec<StartParameter>>,
        /// Body, instead of the campaign's.
        body: Option<DeclarationId> as Reference("body"),
        ..start: StartKeys,
    }
    .explained("towns", "Towns to cover.")
    .explained("drivers", "Drivers to cover.")
}

pub(crate) const BLOCK: JobBlock =
    JobBlock { signature: CoverKeys::signature, drivers: of_places, lower: |it, at, grid| it.cover(at, grid) };

/// What a `cover` block counts.
struct Counted {
    criterion: Criterion,
    blame: Blame,
    /// The requirements of the campaign, and the counted one if it is none of them.
    requirements: Arc<[NamedRequirement]>,
    declared: Option<DeclarationId>,
}

impl Lowering<'_> {
    fn cover(&mut self, at: Nested<'_>, grid: &mut Grid) {
        let keys: CoverKeys = at.block.keys();
        let Some((ground, body)) = self.setting(at, &keys.places, &keys.start, keys.body, grid) else { return };
        if !ground.roles.is_empty() {
            let message =
                "a cover goes through the starts of one car and one pedestrian, and the campaign has a `cast`"
                    .to_string();
            return self
                .said
                .push(diagnostics::contradiction(at.block.head, message).help("give the cover a campaign of its own"));
        }
        let has_script = ground.spawn.value.scripted().is_some();
        let Some((walker, controller)) = self.untrained(at.block, "pedestrian", &keys.pedestrian, has_script) else {
            return;
        };
        if !self.takes(at, &ground, [1, 1], grid) {
            return;
        }
        let Grid { usual, campaign, .. } = grid;
        let counted = self.counted(at.block, &keys.failure, usual);
        let declared: Vec<DeclarationId> = [controller, counted.declared].into_iter().flatten().collect();
        let mut picture = None;
        for place in ground.places() {
            let scenario = usual.scenario(&place, &body, &RewardRule::default(), &counted.requirements);
            // The parameters are the same in all places.
            if picture.is_none() {
                picture = self.picture(at.block, keys.picture.as_deref(), &scenario);
            }
            let Some(picture) = picture.clone() else { return };
            let parts = [&usual.declarations(&place, &body)[..], &usual.requirements.ids, &declared].concat();
            campaign.jobs.extend(self.origins(at, 1, &parts).map(|origin| {
                Job::from(Cover {
                    origin,
                    pedestrian: walker.name().to_string(),
                    town: place.town.name.to_string(),
                    policy: place.policy.name.to_string(),
                    spawn: place.spawn.name.to_string(),
                    scenario: scenario.clone(),
                    walker: walker.clone(),
                    criterion: counted.criterion,
                    blame: counted.blame,
                    epsilon: keys.epsilon,
                    budget: keys.budget,
                    picture: picture.clone(),
                })
            }));
        }
    }

    fn counted(&mut self, block: &Block, failure: &Value, usual: &Usual) -> Counted {
        let own = &usual.requirements;
        let collision =
            |blame| Counted { criterion: Criterion::Collision, blame, requirements: own.all.clone(), declared: None };
        match failure {
            Value::Choice(FAULT) => collision(Blame::Fault),
            Value::Choice(COLLISION) => collision(Blame::Any),
            Value::Reference(id) => {
                let (requirements, place) = self.requirements_with(block, "failure", *id, usual);
                Counted { criterion: Criterion::Violation(place), blame: Blame::Any, requirements, declared: Some(*id) }
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

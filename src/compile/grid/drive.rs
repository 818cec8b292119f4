use std::sync::Arc;

use super::axis::Usual;
use super::ground::note_towns;
use super::train::joined;
use crate::campaign::{DRIVE, DriveKeys, PlaceKeys};
use crate::lowering::Lowering;
use crate::{Campaign, Job, Training, TrainingKey};
use base::signature::DeclarationId;
use lang::diagnostics;
use lang::hir::Block;
use world::driving::{DriveReward, DriveRule};
use world::env::RewardRule;

impl Lowering<'_> {
    /// The trainings of a `drive` block.
    pub(super) fn drive(&mut self, campaign_block: &Block, block: &Block, usual: &Usual, campaign: &mut Campaign) {
        let Some(training) = &usual.training else {
            return self.said.push(diagnostics::no_training(campaign_block.head, block.head));
        };
        let keys: DriveKeys = block.keys();
        let (config, environments) = &training.value;
        let unfit = [
            (config.frame_stack != 1, "frame_stack: 1"),
            (config.normalize_obs, "normalize_observations: false"),
            (config.initial.is_some(), "no `from`"),
        ];
        if let Some((_, needed)) = unfit.into_iter().find(|(is_wrong, _)| *is_wrong) {
            let message =
                format!("a driver sees one state at a time and scales it itself, so its training needs {needed}");
            return self.said.push(diagnostics::contradiction(block.head, message));
        }
        let places = PlaceKeys { towns: keys.towns, policies: vec![keys.imitates] };
        let bodies = [(&usual.car, &usual.walker)];
        let Some(ground) = self.ground(campaign_block, block, &places, &keys.start, &bodies) else { return };
        let scripted = ground.spawn.value.scripted().is_some();
        let walkers: Option<Vec<_>> =
            keys.pedestrians.iter().map(|word| self.covering(block, word, scripted)).collect();
        let Some((walkers, controllers)) = walkers.map(|all| all.into_iter().unzip::<_, _, Vec<_>, Vec<_>>()) else {
            return;
        };
        note_towns(&mut campaign.towns, &ground.towns);
        let all: Vec<_> = ground.places().collect();
        let Some(first) = all.first() else { return };
        let rule = Arc::new(DriveRule {
            teacher: first.policy.value.clone(),
            demonstrations: keys.demonstrations,
            hold: keys.hold,
            walkers,
            cars: keys.cars,
            reward: DriveReward {
                progress: keys.progress,
                comfort: keys.comfort,
                lane: keys.lane,
                standing: keys.standing,
                red_light: keys.red_light,
                collision: keys.collision,
            },
        });
        let (car, body, paid) = (&usual.car.value, &usual.walker.value, RewardRule::default());
        let scenario = |place: &super::ground::Place<'_>| {
            let made = place.scenario(car, body, &usual.rule.value, &paid, &[].into());
            (place.town.name.to_string(), made)
        };
        let scenarios: Vec<_> = all.iter().map(scenario).collect();
        let declared: Vec<DeclarationId> = all
            .iter()
            .flat_map(|place| place.declarations(&usual.car, &usual.walker, &usual.rule))
            .chain(controllers.into_iter().flatten())
            .collect();
        let fingerprint = self.fingerprint_with(&[declared.as_slice(), &[training.id]].concat(), &format!("{rule:?}"));
        let programs = self.programs(&declared);
        campaign.jobs.extend((0..keys.runs).map(|run| {
            Job::from(Training {
                key: TrainingKey {
                    town: joined(all.iter().map(|place| &*place.town.name)),
                    policy: first.policy.name.to_string(),
                    reward: DRIVE.to_string(),
                    run,
                },
                scenario: scenarios[0].1.clone(),
                together: if scenarios.len() > 1 { scenarios.clone() } else { Vec::new() },
                drive: Some(rule.clone()),
                config: config.clone(),
                environments: *environments,
                fingerprint,
                programs: programs.clone(),
                lineage: None,
            })
        }));
    }
}

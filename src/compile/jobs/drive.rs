use std::sync::Arc;

use super::training::joined;
use super::{JobBlock, Origin};
use crate::campaign::{PlaceKeys, StartKeys};
use crate::grid::{Grid, Nested, Place, note_towns};
use crate::lowering::Lowering;
use crate::{Job, Training, TrainingKey};
use base::keys;
use base::signature::{DeclarationId, Keys, Value};
use episode::RewardRule;
use lang::diagnostics;
use search::driving::{DriveReward, DriveRule};

/// Takes the place of a reward's name in a training of a driver.
const DRIVE: &str = "drive";

keys! {
    /// Trains a car to drive, by the campaign's `training`, in all towns together, among pedestrians and other cars. The report gets its network as
    /// `drivers/NAME.onnx`, which `onnx` drives with.
    pub struct DriveKeys = "drive" {
        /// Towns to drive in.
        towns: Vec<DeclarationId> as Reference("town"),
        /// The driver that it imitates before it learns by itself; the other cars have it, too.
        imitates: DeclarationId as Reference("driver"),
        /// Decisions in which it imitates; 0 for none. The more the better; a million needs 0.4 GB of memory.
        demonstrations: u32 as whole(0, 10_000_000) = "200_000",
        /// Ticks for which an action is kept while it learns by itself, so that its attempts differ; as a driver it chooses anew in every tick.
        hold: u32 as whole(1, 100) = "4",
        // The catalogue adds the words.
        /// Who walks, in turns, as in `evaluate`: words, or `pedestrian`s of the file, such as networks that attack it.
        pedestrians: Vec<Value> as WordOrReference(Vec::new(), "pedestrian") = "[natural]",
        /// Other cars in each town.
        cars: usize as whole(0, 100) = "3",
        ..reward: DriveReward,
        /// Trainings, with different seeds.
        runs: u32 as whole(1, 10_000) = "1",
        ..start: StartKeys,
    }
}

pub(super) const BLOCK: JobBlock =
    JobBlock { signature: DriveKeys::signature, drivers: |_| Vec::new(), lower: |it, at, grid| it.drive(at, grid) };

impl Lowering<'_> {
    /// The trainings of a `drive` block.
    fn drive(&mut self, at: Nested<'_>, grid: &mut Grid) {
        let block = at.block;
        let Some(training) = grid.usual.training.clone() else { return self.no_training(at) };
        let keys: DriveKeys = block.keys();
        let config = &training.value;
        let unfit = [
            (config.frame_stack != 1, "frame_stack: 1"),
            (config.normalize_observations, "normalize_observations: false"),
            (config.from.is_some(), "no `from`"),
            (config.policies.is_some(), "no `policies`"),
        ];
        if let Some((_, needed)) = unfit.into_iter().find(|(is_wrong, _)| *is_wrong) {
            return self.said.push(diagnostics::unfit_training(block.head, needed));
        }
        let places = PlaceKeys { towns: keys.towns, drivers: vec![keys.imitates] };
        let Some((ground, body)) = self.setting(at, &places, &keys.start, None, grid) else { return };
        let scripted = ground.spawn.value.scripted().is_some();
        let walkers: Option<Vec<_>> =
            keys.pedestrians.iter().map(|word| self.untrained(block, "pedestrians", word, scripted)).collect();
        let Some((walkers, controllers)) = walkers.map(|all| all.into_iter().unzip::<_, _, Vec<_>, Vec<_>>()) else {
            return;
        };
        let Grid { usual, campaign, .. } = grid;
        note_towns(&mut campaign.towns, &ground.towns);
        let all: Vec<_> = ground.places().collect();
        let Some(first) = all.first() else { return };
        let rule = Arc::new(DriveRule {
            teacher: first.policy.value.policy.clone(),
            demonstrations: keys.demonstrations,
            hold: keys.hold,
            walkers,
            cars: keys.cars,
            reward: keys.reward,
        });
        let scenario = |place: &Place<'_>| {
            (place.town.name.to_string(), usual.scenario(place, &body, &RewardRule::default(), &[].into()))
        };
        let scenarios: Vec<_> = all.iter().map(scenario).collect();
        let declared: Vec<DeclarationId> = all
            .iter()
            .flat_map(|place| usual.declarations(place, &body))
            .chain(controllers.into_iter().flatten())
            .collect();
        let fingerprint = self.fingerprint_with(&[declared.as_slice(), &[training.id]].concat(), &format!("{rule:?}"));
        campaign.jobs.extend(self.origins(at, keys.runs, &declared).map(|origin| {
            Job::from(Training {
                key: TrainingKey {
                    town: joined(all.iter().map(|place| &*place.town.name)),
                    policy: first.policy.name.to_string(),
                    reward: DRIVE.to_string(),
                    run: origin.run,
                },
                origin: Origin { fingerprint, ..origin },
                scenario: scenarios[0].1.clone(),
                towns: scenarios.clone(),
                drive: Some(rule.clone()),
                config: config.clone(),
                candidates: 1,
                lineage: None,
            })
        }));
    }
}

//! The axes of a grid: the declarations that a block of a campaign names, lowered.

use std::sync::Arc;

use crate::lowering::{BuiltTown, Lowering};
use crate::{adversary, episode, reward, training, vehicle};
use base::signature::DeclarationId;
use lang::diagnostics;
use lang::hir::Block;
use learn::PpoConfig;
use world::env::{EpisodeRule, PedestrianRole, PolicyMaker, RewardRule, SpawnRule};
use world::sim::VehicleBlueprint;

/// The greatest number of decisions between two updates, over all environments.
const MOST_DECISIONS: usize = 1 << 22;
/// The greatest number of components of all states between two updates.
const MOST_SEEN: usize = 1 << 27;
/// The greatest number of weights of a network.
const MOST_WEIGHTS: usize = 1 << 24;

/// A member of one axis of the grid.
#[derive(Clone)]
pub(super) struct Axis<T> {
    pub id: DeclarationId,
    pub name: Arc<str>,
    pub value: T,
}

/// The defaults of all blocks of a campaign.
pub(super) struct Usual {
    pub car: Axis<VehicleBlueprint>,
    pub walker: Axis<PedestrianRole>,
    pub rule: Axis<EpisodeRule>,
    pub training: Option<Axis<(PpoConfig, usize)>>,
}

impl Lowering<'_> {
    pub(super) fn vehicle(&self, id: DeclarationId) -> Axis<VehicleBlueprint> {
        let declaration = self.program.get(id);
        let value = vehicle::lower(declaration.kind, &declaration.block.arguments);
        Axis { id, name: declaration.name.as_str().into(), value }
    }

    pub(super) fn adversary(&mut self, id: DeclarationId) -> Axis<PedestrianRole> {
        let declaration = self.program.get(id);
        adversary::check(&declaration.block, self.said);
        Axis { id, name: declaration.name.as_str().into(), value: adversary::lower(&declaration.block.arguments) }
    }

    pub(super) fn episode(&mut self, id: DeclarationId) -> Axis<EpisodeRule> {
        let declaration = self.program.get(id);
        let Block { arguments, places, .. } = &declaration.block;
        let given = |key: &str| places.iter().find(|(name, _)| *name == key).map(|(_, span)| *span);
        if let Some(hold) = given("hold").filter(|_| arguments.integer("hold") > arguments.integer("ticks")) {
            self.said.push(diagnostics::not_rising(hold, "hold", "ticks", None));
        }
        Axis { id, name: declaration.name.as_str().into(), value: episode::lower(&declaration.block.arguments) }
    }

    pub(super) fn training(&mut self, id: DeclarationId) -> Axis<(PpoConfig, usize)> {
        let declaration = self.program.get(id);
        let block = &declaration.block;
        let (mut config, environments) = training::lower(&block.arguments);
        config.initial = training::initial(declaration, &config, self);
        if config.rollout_steps.saturating_mul(environments) > MOST_DECISIONS {
            let message = format!("an update of more than {MOST_DECISIONS} decisions does not fit in memory");
            self.said.push(diagnostics::contradiction(block.place("steps_per_update"), message));
        }
        let seen = config.rollout_steps.saturating_mul(environments).saturating_mul(4 * config.frame_stack);
        if seen > MOST_SEEN && config.rollout_steps.saturating_mul(environments) <= MOST_DECISIONS {
            let message =
                format!("an update of {seen} numbers of states does not fit in memory; at most {MOST_SEEN} do");
            self.said.push(diagnostics::contradiction(block.place("frame_stack"), message));
        }
        let widths = [&[4 * config.frame_stack], config.hidden.as_slice(), &[2]].concat();
        let weights: usize = widths.windows(2).map(|pair| pair[0] * pair[1]).sum();
        if weights > MOST_WEIGHTS {
            let message = format!("networks of {weights} weights do not fit in memory; at most {MOST_WEIGHTS} do");
            self.said.push(diagnostics::contradiction(block.place("hidden"), message));
        }
        Axis { id, name: declaration.name.as_str().into(), value: (config, environments) }
    }

    pub(super) fn towns(&mut self, block: &Block) -> Vec<Axis<BuiltTown>> {
        let mut axis = Vec::new();
        for id in block.arguments.references("towns") {
            let name: Arc<str> = self.program.get(id).name.as_str().into();
            axis.extend(self.town(id).map(|value| Axis { id, name, value }));
        }
        axis
    }

    pub(super) fn policies(&mut self, block: &Block) -> Vec<Axis<PolicyMaker>> {
        let mut axis = Vec::new();
        for id in block.arguments.references("policies") {
            let name: Arc<str> = self.program.get(id).name.as_str().into();
            axis.extend(self.policy(id).map(|value| Axis { id, name, value }));
        }
        axis
    }

    pub(super) fn rewards(&self, block: &Block) -> Vec<Axis<RewardRule>> {
        block.arguments.references("rewards").into_iter().map(|id| self.reward(id)).collect()
    }

    pub(super) fn reward(&self, id: DeclarationId) -> Axis<RewardRule> {
        let declaration = self.program.get(id);
        Axis { id, name: declaration.name.as_str().into(), value: reward::lower(&declaration.block) }
    }

    pub(super) fn spawn(&mut self, campaign: &Block, block: &Block) -> Option<Axis<SpawnRule>> {
        let owner = if block.arguments.has("spawn") { block } else { campaign };
        let id = owner.arguments.reference("spawn");
        let name: Arc<str> = self.program.get(id).name.as_str().into();
        self.spawn_rule(id).map(|value| Axis { id, name, value })
    }
}

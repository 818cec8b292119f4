//! The axes of a grid: the declarations that a block of a campaign names, lowered.

use std::sync::Arc;

use crate::lowering::{BuiltTown, Lowering, MadeDriver};
use crate::role::Roles;
use crate::{adversary, reward, training, vehicle};
use base::signature::DeclarationId;
use episode::requirement::NamedRequirement;
use episode::{EpisodeRule, PedestrianRole, RewardRule, SpawnRule};
use lang::diagnostics;
use lang::hir::Block;
use learn::PpoConfig;
use world::sim::VehicleBlueprint;

/// The greatest number of decisions between two updates, over all environments.
const MAX_DECISIONS: usize = 1 << 22;
/// The greatest number of components of all states between two updates.
const MAX_SEEN: usize = 1 << 27;
/// The greatest number of weights of a network.
const MAX_WEIGHTS: usize = 1 << 24;

/// A member of one axis of the grid.
#[derive(Clone)]
pub(crate) struct Axis<T> {
    pub id: DeclarationId,
    pub name: Arc<str>,
    pub value: T,
}

/// The defaults of all blocks of a campaign.
pub(crate) struct Usual {
    pub car: Axis<VehicleBlueprint>,
    pub walker: Axis<PedestrianRole>,
    pub roles: Arc<Roles>,
    pub rule: Axis<EpisodeRule>,
    pub training: Option<Axis<PpoConfig>>,
    pub requirements: Required,
}

/// The requirements of a campaign.
pub(crate) struct Required {
    pub ids: Vec<DeclarationId>,
    pub all: Arc<[NamedRequirement]>,
}

impl Lowering<'_> {
    pub(crate) fn vehicle(&self, id: DeclarationId) -> Axis<VehicleBlueprint> {
        let declaration = self.program.get(id);
        let value = vehicle::lower(declaration.kind, declaration.block.keys());
        Axis { id, name: self.axis_name(id), value }
    }

    pub(crate) fn adversary(&mut self, id: DeclarationId) -> Axis<PedestrianRole> {
        let block = &self.program.get(id).block;
        adversary::check(block, self.said);
        Axis { id, name: self.axis_name(id), value: adversary::lower(block.keys()) }
    }

    pub(crate) fn episode(&mut self, id: DeclarationId) -> Axis<EpisodeRule> {
        let block = &self.program.get(id).block;
        let value: EpisodeRule = block.keys();
        let given = block.places.iter().find(|(name, _)| *name == "hold");
        if let Some((_, hold)) = given.filter(|_| value.hold > value.ticks) {
            self.said.push(diagnostics::not_rising(*hold, "hold", "ticks", None));
        }
        Axis { id, name: self.axis_name(id), value }
    }

    /// A training of pedestrians whose states have these numbers of numbers.
    pub(crate) fn training(&mut self, id: DeclarationId, states: &[usize]) -> Axis<PpoConfig> {
        let declaration = self.program.get(id);
        let block = &declaration.block;
        let mut config: PpoConfig = block.keys();
        if config.credit.is_some() && config.policies.is_none() {
            let message =
                "one policy for all pedestrians at once earns what the episode does, so `credit` needs `policies`";
            self.said.push(diagnostics::contradiction(block.place("credit"), message.into()));
        }
        let sizes: Vec<_> = match config.policies {
            Some(_) => states.iter().map(|state| (*state, 2)).collect(),
            None => vec![(states.iter().sum(), 2 * states.len())],
        };
        let state = sizes.iter().map(|size| size.0).max().unwrap_or_default();
        let decisions = config.steps_per_update.saturating_mul(config.environments);
        config.batch_size = config.batch_size.min(decisions);
        training::read_networks(declaration, &mut config, &sizes, self);
        if config.hard_starts.is_some() && config.starts.is_none() {
            let message = "hard starts are looked for among kept ones, so `hard_starts` needs `starts`".to_string();
            self.said.push(diagnostics::contradiction(block.place("hard_starts"), message));
        }
        if decisions > MAX_DECISIONS {
            let message = format!("an update of more than {MAX_DECISIONS} decisions does not fit in memory");
            self.said.push(diagnostics::contradiction(block.place("steps_per_update"), message));
        }
        let seen = decisions.saturating_mul(state * config.frame_stack);
        if seen > MAX_SEEN && decisions <= MAX_DECISIONS {
            let message =
                format!("an update of {seen} numbers of states does not fit in memory; at most {MAX_SEEN} do");
            self.said.push(diagnostics::contradiction(block.place("frame_stack"), message));
        }
        let widths = [&[state * config.frame_stack], config.hidden.as_slice(), &[2]].concat();
        let weights: usize = widths.windows(2).map(|pair| pair[0] * pair[1]).sum();
        if weights > MAX_WEIGHTS {
            let message = format!("networks of {weights} weights do not fit in memory; at most {MAX_WEIGHTS} do");
            self.said.push(diagnostics::contradiction(block.place("hidden"), message));
        }
        Axis { id, name: self.axis_name(id), value: config }
    }

    pub(crate) fn towns(&mut self, ids: &[DeclarationId]) -> Vec<Axis<BuiltTown>> {
        let named = |id: &DeclarationId| Some(Axis { id: *id, name: self.axis_name(*id), value: self.town(*id)? });
        ids.iter().filter_map(named).collect()
    }

    pub(crate) fn policies(&mut self, ids: &[DeclarationId]) -> Vec<Axis<MadeDriver>> {
        let named = |id: &DeclarationId| Some(Axis { id: *id, name: self.axis_name(*id), value: self.policy(*id)? });
        ids.iter().filter_map(named).collect()
    }

    pub(crate) fn reward(&self, id: DeclarationId) -> Axis<RewardRule> {
        Axis {
            id,
            name: self.axis_name(id),
            value: reward::lower(&self.program.get(id).block, |id| self.program.get(id)),
        }
    }

    pub(crate) fn spawn(&mut self, id: DeclarationId) -> Option<Axis<SpawnRule>> {
        Some(Axis { id, name: self.axis_name(id), value: self.spawn_rule(id)? })
    }

    /// The requirements of a campaign with one that a key of a block names, and its place among them.
    pub(crate) fn requirements_with(
        &mut self,
        block: &Block,
        key: &'static str,
        id: DeclarationId,
        usual: &Usual,
    ) -> (Arc<[NamedRequirement]>, usize) {
        let Required { ids, all } = &usual.requirements;
        if let Some(place) = ids.iter().position(|other| *other == id) {
            return (all.clone(), place);
        }
        let own = self.requirements(block, key, &[id], &usual.rule.value);
        ([&all[..], &own].concat().into(), all.len())
    }

    fn axis_name(&self, id: DeclarationId) -> Arc<str> {
        self.program.get(id).name.as_str().into()
    }
}

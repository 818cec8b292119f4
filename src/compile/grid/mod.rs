//! A campaign's grid: its jobs, block by block.

mod absent;
mod axis;
mod ground;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use super::campaign::{CampaignKeys, PlaceKeys, StartKeys};
use super::jobs::{BLOCKS, Origin, Pricing};
use super::lowering::Lowering;
use super::plan::{Campaign, Driver, Published};
use super::walker::WalkerKind;
use super::{Job, RunId, policy, published};
use axis::Required;
pub(crate) use axis::{Axis, Usual};
use base::signature::{DeclarationId, Value};
use episode::walker::Controller;
use episode::{PedestrianRole, RewardRule};
pub(crate) use ground::{Ground, Place, note_towns};
use lang::diagnostics;
use lang::hir::{Block, Declaration};

/// A campaign that is laid out.
pub(crate) struct Grid {
    pub usual: Usual,
    pub campaign: Campaign,
    /// The rewards of its trainings.
    pub rewards: BTreeMap<String, Axis<RewardRule>>,
}

/// A block with jobs in its campaign.
#[derive(Clone, Copy)]
pub(crate) struct Nested<'a> {
    pub campaign: &'a Block,
    pub block: &'a Block,
    /// Its number among the blocks of its kind, from 0.
    pub number: u32,
}

/// The drivers of a block that names [`PlaceKeys`].
pub(crate) fn of_places(block: &Block) -> Vec<DeclarationId> {
    block.keys::<PlaceKeys>().drivers
}

/// Maximum number of jobs of a block.
const MAX_JOBS: usize = 200_000;

impl Lowering<'_> {
    /// Lays out the grid of a campaign.
    pub fn campaign(&mut self, declaration: &Declaration) -> Campaign {
        let block = &declaration.block;
        let keys: CampaignKeys = block.keys();
        let rule = self.episode(keys.episode);
        let ids = keys.requirements.unwrap_or_default();
        let all = self.requirements(block, "requirements", &ids, &rule.value).into();
        let (car, walker) = (self.vehicle(keys.vehicle), self.adversary(keys.body));
        let roles = Arc::new(self.roles(block, keys.cast.as_deref()));
        self.compare_signals(declaration, &roles);
        let training = keys.training.map(|id| self.training(id, &roles.states(&walker.value)));
        let usual = Usual { car, walker, roles, rule, requirements: Required { ids, all }, training };
        let campaign = Campaign {
            name: declaration.name.clone(),
            docs: declaration.docs.clone(),
            settings: Vec::new(),
            words: Vec::new(),
            requirements: usual.requirements.all.clone(),
            towns: Vec::new(),
            drivers: self.drivers(block),
            jobs: Vec::new(),
            published: self.published(keys.beside),
        };
        let mut grid = Grid { usual, campaign, rewards: BTreeMap::new() };
        let mut has_blocks = false;
        for kind in &BLOCKS {
            for (number, inner) in (0..).zip(block.nested((kind.signature)().name)) {
                has_blocks = true;
                (kind.lower)(self, Nested { campaign: block, block: inner, number }, &mut grid);
            }
        }
        let prices = Pricing::of_campaign(&grid.campaign, keys.price);
        grid.campaign.jobs.extend(prices.into_iter().map(Job::from));
        self.forbid_repeated_trainings(block, &grid.campaign);
        self.warn_of_absent(block, &grid);
        self.warn_of_stops(block, &grid);
        self.warn_of_speeds(block, &grid);
        if !grid.campaign.published.is_empty() && block.nested("train").next().is_none() {
            self.said.push(diagnostics::nothing_to_compare(block.place("beside")));
        }
        if !has_blocks {
            let blocks = BLOCKS.map(|kind| format!("`{} {{ … }}`", (kind.signature)().name));
            let help = format!("give it a block: {}", blocks.join(", "));
            self.said.push(diagnostics::contradiction(block.head, "the campaign has no jobs".into()).help(help));
        }
        grid.campaign
    }

    /// The ground of a block of jobs, and its pedestrian: that of the block, or of the campaign. None after reporting what is wrong with the starts of
    /// episodes.
    pub(crate) fn setting(
        &mut self,
        at: Nested<'_>,
        places: &PlaceKeys,
        start: &StartKeys,
        adversary: Option<DeclarationId>,
        grid: &Grid,
    ) -> Option<(Ground, Axis<PedestrianRole>)> {
        let body = adversary.map_or_else(|| grid.usual.walker.clone(), |id| self.adversary(id));
        let ground = self.ground(at, places, start, &[(&grid.usual.car, &body)], &grid.usual)?;
        Some((ground, body))
    }

    /// Records the towns of a ground if it and two further axes give no more combinations than can be run; reports it otherwise.
    pub(crate) fn takes(&mut self, at: Nested<'_>, ground: &Ground, axes: [usize; 2], grid: &mut Grid) -> bool {
        let takes = self.fits(at.block, &[ground.towns.len(), ground.policies.len(), axes[0], axes[1]]);
        if takes {
            note_towns(&mut grid.campaign.towns, &ground.towns);
        }
        takes
    }

    /// Whether the axes of a block give no more combinations than can be run; reports it otherwise.
    pub(crate) fn fits(&mut self, block: &Block, axes: &[usize]) -> bool {
        let cells = axes.iter().copied().fold(1, usize::saturating_mul);
        if cells > MAX_JOBS {
            self.said.push(diagnostics::too_many_combinations(block.head, cells, MAX_JOBS));
        }
        cells <= MAX_JOBS
    }

    /// The origins of the runs of a job that depends on these declarations.
    pub(crate) fn origins(
        &mut self,
        at: Nested<'_>,
        runs: u32,
        parts: &[DeclarationId],
    ) -> impl Iterator<Item = Origin> + use<> {
        let (fingerprint, programs) = (self.fingerprint(parts), self.programs(parts));
        let (id, block) = (RunId::default(), at.number);
        (0..runs).map(move |run| Origin { id, block, run, fingerprint, programs: programs.clone(), needs: None })
    }

    /// A pedestrian that learns nothing, and its declaration if it has one; None after reporting what is wrong.
    pub(crate) fn untrained(
        &mut self,
        block: &Block,
        key: &str,
        word: &Value,
        has_script: bool,
    ) -> Option<(Controller, Option<DeclarationId>)> {
        if let Value::Reference(id) = word {
            return Some((self.controller(*id)?, Some(*id)));
        }
        let kind = self.walker_kind(word);
        if kind.is_scripted && !has_script {
            let message = format!(
                "a `{}` pedestrian walks as a test or a path states, and the spawn rule of this block is not a test and has no path",
                kind.word()
            );
            let help = "use a `spawn` of kind `crossing_test`, `along_test` or `given_path`";
            self.said.push(diagnostics::contradiction(block.place(key), message).help(help));
            return None;
        }
        Some((kind.controller.clone(), None))
    }

    /// The kind of pedestrian that a checked word names.
    pub(crate) fn walker_kind(&self, word: &Value) -> &WalkerKind {
        let found = self.catalog.walkers.iter().find(|kind| *word == Value::Choice(kind.word()));
        found.expect("checked: the word is in the catalogue")
    }

    /// Reports a block that trains in a campaign without a `training`.
    pub(crate) fn no_training(&mut self, at: Nested<'_>) {
        self.said.push(diagnostics::no_training(at.campaign.head, at.block.head));
    }

    /// The drivers that a campaign names, each once, in order.
    fn drivers(&self, campaign: &Block) -> Vec<Driver> {
        let mut seen = BTreeSet::new();
        let all = BLOCKS.iter().flat_map(|kind| campaign.nested((kind.signature)().name).flat_map(kind.drivers));
        all.filter(|id| seen.insert(*id)).map(|id| policy::describe(self.program.get(id), self)).collect()
    }

    fn published(&mut self, beside: Option<Vec<DeclarationId>>) -> Vec<Published> {
        beside.into_iter().flatten().map(|id| published::lower(self.program.get(id), self.program, self.said)).collect()
    }
}

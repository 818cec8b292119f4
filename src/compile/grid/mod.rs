//! A campaign's grid: its jobs, block by block.

mod axis;
mod ground;
mod train;
mod drive;
mod evaluate;
mod search;
mod estimate;
mod cover;
mod harden;

use std::collections::{BTreeMap, BTreeSet};

use super::campaign::{
    CampaignKeys, CoverKeys, DriveKeys, EstimateKeys, EvaluateKeys, HardenKeys, PlaceKeys, SearchKeys, TrainKeys,
};
use super::lowering::Lowering;
use super::plan::{Campaign, Driver, Published};
use super::{policy, published};
use axis::{Axis, Required, Usual};
use base::signature::{DeclarationId, Keys, Signature};
use lang::diagnostics;
use lang::hir::{Block, Declaration};
use world::env::RewardRule;

/// A campaign that is laid out.
pub(crate) struct Grid {
    usual: Usual,
    campaign: Campaign,
    /// The rewards of its trainings.
    rewards: BTreeMap<String, Axis<RewardRule>>,
}

/// A kind of block that adds jobs to a campaign.
pub(crate) struct JobBlock {
    pub signature: fn() -> Signature,
    /// The drivers of a block that are under test.
    drivers: fn(&Block) -> Vec<DeclarationId>,
    /// Adds the jobs of a block of the campaign, of which it is the one with this number.
    lower: fn(&mut Lowering<'_>, [&Block; 2], u32, &mut Grid),
}

/// All blocks with jobs, in the order of the jobs; a new one is a line here.
pub(crate) static BLOCKS: [JobBlock; 7] = [
    JobBlock {
        signature: TrainKeys::signature,
        drivers: of_places,
        lower: |it, [all, block], _, grid| it.train(all, block, &grid.usual, &mut grid.campaign, &mut grid.rewards),
    },
    JobBlock {
        signature: DriveKeys::signature,
        drivers: |_| Vec::new(),
        lower: |it, [all, block], _, grid| it.drive(all, block, &grid.usual, &mut grid.campaign),
    },
    JobBlock {
        signature: EvaluateKeys::signature,
        drivers: of_places,
        lower: |it, [all, block], number, grid| {
            it.evaluate(all, block, number, &grid.usual, &mut grid.campaign, &grid.rewards);
        },
    },
    JobBlock {
        signature: SearchKeys::signature,
        drivers: of_places,
        lower: |it, [all, block], number, grid| it.search(all, block, number, &grid.usual, &mut grid.campaign),
    },
    JobBlock {
        signature: EstimateKeys::signature,
        drivers: of_places,
        lower: |it, [all, block], number, grid| it.estimate(all, block, number, &grid.usual, &mut grid.campaign),
    },
    JobBlock {
        signature: CoverKeys::signature,
        drivers: of_places,
        lower: |it, [all, block], number, grid| it.cover(all, block, number, &grid.usual, &mut grid.campaign),
    },
    JobBlock {
        signature: HardenKeys::signature,
        drivers: |block| vec![block.keys::<HardenKeys>().policy],
        lower: |it, [all, block], number, grid| it.harden(all, block, number, &grid.usual, &mut grid.campaign),
    },
];

/// The drivers of a block that names [`PlaceKeys`].
fn of_places(block: &Block) -> Vec<DeclarationId> {
    block.keys::<PlaceKeys>().policies
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
        let (car, walker) = (self.vehicle(keys.vehicle), self.adversary(keys.adversary));
        let training = keys.training.map(|id| self.training(id, walker.value.observation.dim()));
        let usual = Usual { car, walker, rule, requirements: Required { ids, all }, training };
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
                (kind.lower)(self, [block, inner], number, &mut grid);
            }
        }
        self.forbid_repeated_trainings(block, &grid.campaign);
        if !grid.campaign.published.is_empty() && block.nested("train").next().is_none() {
            self.said.push(diagnostics::nothing_to_compare(block.place("beside")));
        }
        if !has_blocks {
            let help = "give it a block: `train { … }`, `evaluate { … }`, `search { … }`, `estimate { … }`, `cover { … }` or `harden { … }`";
            self.said.push(diagnostics::contradiction(block.head, "the campaign has no jobs".into()).help(help));
        }
        grid.campaign
    }

    /// Whether the axes of a block give no more combinations than can be run; reports it otherwise.
    fn fits(&mut self, block: &Block, axes: [usize; 4]) -> bool {
        let cells = axes.into_iter().fold(1, usize::saturating_mul);
        if cells > MAX_JOBS {
            self.said.push(diagnostics::too_many_combinations(block.head, cells, MAX_JOBS));
        }
        cells <= MAX_JOBS
    }

    /// The drivers that a campaign names, each once, in order.
    fn drivers(&self, campaign: &Block) -> Vec<Driver> {
        let mut seen = BTreeSet::new();
        let of = |kind: &'static JobBlock| campaign.nested((kind.signature)().name).flat_map(kind.drivers);
        let all = BLOCKS.iter().flat_map(of);
        all.filter(|id| seen.insert(*id)).map(|id| policy::describe(self.program.get(id), self)).collect()
    }

    fn published(&mut self, beside: Option<Vec<DeclarationId>>) -> Vec<Published> {
        beside.into_iter().flatten().map(|id| published::lower(self.program.get(id), self.program, self.said)).collect()
    }
}

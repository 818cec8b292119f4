//! A campaign's grid: its trainings, its evaluations with their controllers, its searches and its estimates.

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

use super::campaign::{CampaignKeys, HardenKeys, PlaceKeys};
use super::lowering::Lowering;
use super::plan::{Campaign, Driver, Published};
use super::{policy, published};
use axis::{Required, Usual};
use base::signature::DeclarationId;
use lang::diagnostics;
use lang::hir::{Block, Declaration};

/// The blocks of a campaign that run episodes against several drivers.
const BLOCKS: [&str; 5] = ["train", "evaluate", "search", "estimate", "cover"];

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
        let mut campaign = Campaign {
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
        let mut rewards = BTreeMap::new();
        for train in block.nested("train") {
            self.train(block, train, &usual, &mut campaign, &mut rewards);
        }
        for drive in block.nested("drive") {
            self.drive(block, drive, &usual, &mut campaign);
        }
        self.forbid_repeated_trainings(block, &campaign);
        if !campaign.published.is_empty() && block.nested("train").next().is_none() {
            self.said.push(diagnostics::nothing_to_compare(block.place("beside")));
        }
        if BLOCKS.iter().chain(&["drive", "harden"]).all(|word| block.nested(word).next().is_none()) {
            let message = "the campaign has no jobs".to_string();
            let help = "give it a block: `train { … }`, `evaluate { … }`, `search { … }`, `estimate { … }`, `cover { … }` or `harden { … }`";
            self.said.push(diagnostics::contradiction(block.head, message).help(help));
        }
        for (number, evaluate) in (0..).zip(block.nested("evaluate")) {
            self.evaluate(block, evaluate, number, &usual, &mut campaign, &rewards);
        }
        for (number, search) in (0..).zip(block.nested("search")) {
            self.search(block, search, number, &usual, &mut campaign);
        }
        for (number, estimate) in (0..).zip(block.nested("estimate")) {
            self.estimate(block, estimate, number, &usual, &mut campaign);
        }
        for (number, cover) in (0..).zip(block.nested("cover")) {
            self.cover(block, cover, number, &usual, &mut campaign);
        }
        for (number, harden) in (0..).zip(block.nested("harden")) {
            self.harden(block, harden, number, &usual, &mut campaign);
        }
        campaign
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
        let blocks = BLOCKS.into_iter().flat_map(|word| campaign.nested(word));
        let mut seen = BTreeSet::new();
        let hardened = campaign.nested("harden").map(|block| block.keys::<HardenKeys>().policy);
        let all = blocks.flat_map(|block| block.keys::<PlaceKeys>().policies).chain(hardened);
        all.filter(|id| seen.insert(*id)).map(|id| policy::describe(self.program.get(id), self)).collect()
    }

    fn published(&mut self, beside: Option<Vec<DeclarationId>>) -> Vec<Published> {
        beside.into_iter().flatten().map(|id| published::lower(self.program.get(id), self.program, self.said)).collect()
    }
}

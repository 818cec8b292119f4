//! The jobs of a campaign, block by block.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use super::job_block::JobBlock;
use super::{
    Cover, Estimation, Evaluation, Job, Origin, Pricing, Search, cover, drive, estimate, evaluation, harden, search,
    training,
};
use crate::campaign::CampaignKeys;
use crate::grid::{Grid, Nested, Required, Usual};
use crate::lowering::Lowering;
use crate::plan::{Campaign, Driver, Published};
use crate::{RunId, policy, published};
use base::signature::DeclarationId;
use episode::Scenario;
use lang::diagnostics;
use lang::hir::{Block, Declaration};

/// All blocks with jobs, in the order of the jobs.
pub(crate) const BLOCKS: [JobBlock; 7] =
    [training::BLOCK, drive::BLOCK, evaluation::BLOCK, search::BLOCK, estimate::BLOCK, cover::BLOCK, harden::BLOCK];

impl Lowering<'_> {
    /// A campaign with its jobs.
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
        let prices = prices(&grid.campaign, keys.price);
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

/// Natural encounters of a driver in a town without the key `price`: this number, or this part of the episodes there of the driver with most of them.
const PRICED: (u64, u64) = (200, 10);

/// The prices of the drivers of a campaign: of each in each town, in the first setting in which a job tries it. A test has a place for each of its cases, and another simulator
/// has drivers of its own, so these have none.
fn prices(campaign: &Campaign, starts: Option<u32>) -> Vec<Pricing> {
    let mut all: Vec<(Pricing, u64)> = Vec::new();
    for job in &campaign.jobs {
        let Some((town, policy, scenario, episodes)) = tried(job) else { continue };
        if scenario.external_world.is_some() || scenario.spawn.scripted().is_some() {
            continue;
        }
        match all.iter_mut().find(|(each, _)| [&*each.town, &*each.policy] == [town, policy]) {
            Some((_, known)) => *known += episodes,
            None => all.push((Pricing::new(job.origin(), [town, policy], scenario), episodes)),
        }
    }
    // Prices in a town are of the same starts.
    let most = |town: &str| {
        all.iter().filter(|(each, _)| each.town == town).map(|(_, episodes)| *episodes).max().unwrap_or_default()
    };
    let starts = |town: &str| starts.unwrap_or((most(town) / PRICED.1).min(PRICED.0) as u32);
    let priced = all.iter().map(|(price, _)| Pricing { starts: starts(&price.town), ..price.clone() });
    priced.filter(|price| price.starts > 0).collect()
}

/// The town, the driver, the setting and the number of episodes of a job that tries a driver; of one with a budget of ticks the least number.
fn tried(job: &Job) -> Option<(&str, &str, &Arc<Scenario>, u64)> {
    let fit = |budget: u64, scenario: &Scenario| budget / u64::from(scenario.episode.ticks);
    if let Some(Evaluation { town, policy, scenario, episodes, .. }) = job.of() {
        return Some((town, policy, scenario, u64::from(*episodes)));
    }
    if let Some(Search { key, scenario, budget, .. }) = job.of() {
        return Some((&key.town, &key.policy, scenario, fit(*budget, scenario)));
    }
    if let Some(Estimation { town, policy, scenario, budget, .. }) = job.of() {
        return Some((town, policy, scenario, fit(*budget, scenario)));
    }
    let Cover { town, policy, scenario, budget, .. } = job.of()?;
    Some((town, policy, scenario, u64::from(*budget)))
}

//! A campaign's grid: where its jobs happen, block by block.

mod axis;
mod ground;

use std::collections::BTreeMap;

use super::campaign::{PlaceKeys, StartKeys};
use super::lowering::Lowering;
use super::plan::Campaign;
use super::walker::WalkerKind;
pub(crate) use axis::{Axis, Required, Usual};
use base::signature::{DeclarationId, Value};
use episode::walker::Controller;
use episode::{PedestrianRole, RewardRule};
pub(crate) use ground::{Ground, Place, note_towns};
use lang::diagnostics;
use lang::hir::Block;

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
}

use crate::grid::{Grid, Nested};
use crate::lowering::Lowering;
use base::signature::{DeclarationId, Signature};
use lang::hir::Block;

/// A kind of block that adds jobs to a campaign.
pub(crate) struct JobBlock {
    pub signature: fn() -> Signature,
    /// The drivers of a block that are under test.
    pub drivers: fn(&Block) -> Vec<DeclarationId>,
    /// Adds the jobs of a block to its campaign.
    pub lower: fn(&mut Lowering<'_>, Nested<'_>, &mut Grid),
}

//! The state of lowering: HIR in, parts of a plan and diagnostics out.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::sync::Arc;

use super::Catalog;
use super::noting::Noting;
use super::programs::ExternalProgram;
use base::diagnostic::{Diagnostic, Sources};
use base::signature::DeclarationId;
use episode::{DriverParts, ExternalWorld, PolicyMaker};
use lang::hir::{Block, Declaration, Program};
use road::Town;
use road::geometry::Obstacles;

/// A driver, ready to be shared.
#[derive(Clone)]
pub(super) struct MadeDriver {
    pub policy: PolicyMaker,
    /// What can be exchanged of it.
    pub parts: Arc<DriverParts>,
}

/// A town with its obstacles, ready to be shared.
#[derive(Clone)]
pub(super) struct BuiltTown {
    pub town: Arc<Town>,
    pub obstacles: Arc<Obstacles>,
}

/// The state that all variants of the files share.
#[derive(Default)]
pub(super) struct Shared {
    /// Towns that have been built, by their declaration and its contents.
    pub towns: BTreeMap<DeclarationId, Vec<(Block, Option<BuiltTown>)>>,
    /// The policies that were made, with their own contents and those of everything that they refer to.
    pub policies: BTreeMap<DeclarationId, Vec<MadePolicy>>,
    /// Other worlds that were asked what they can do, by their declaration and its contents.
    pub worlds: BTreeMap<DeclarationId, Vec<AskedWorld>>,
    /// The programs of drivers, controllers and worlds, by their declaration and its contents.
    pub programs: BTreeMap<DeclarationId, Vec<(Block, Arc<ExternalProgram>)>>,
    /// What networks carry from tick to tick.
    pub carried: BTreeMap<DeclarationId, String>,
    /// Declarations that campaigns use.
    pub used: BTreeSet<DeclarationId>,
}

/// The contents of a policy and of everything that it refers to, and the policy made of them.
pub(super) type MadePolicy = (Vec<Block>, Option<MadeDriver>);

/// The contents of a world, and the world if its program could be used.
pub(super) type AskedWorld = (Block, Option<Arc<ExternalWorld>>);

/// The state of every step from HIR to plan.
pub(super) struct Lowering<'a> {
    pub program: &'a Program,
    pub catalog: &'a Catalog,
    pub said: &'a mut Vec<Diagnostic>,
    pub read: &'a Noting<'a>,
    pub maps: &'a BTreeMap<String, PathBuf>,
    /// Digests of declarations, for fingerprints.
    pub digests: BTreeMap<DeclarationId, [u8; 32]>,
    /// The texts of the files.
    pub sources: &'a Sources,
    /// The state that variants share.
    pub shared: &'a mut Shared,
}

impl Lowering<'_> {
    /// A path relative to the folder of the file that holds a declaration.
    pub fn beside(&self, declaration: &Declaration, path: &str) -> PathBuf {
        let file = &self.sources.get(declaration.source).path;
        file.parent().map(|folder| folder.join(path)).unwrap_or_else(|| path.into())
    }
}

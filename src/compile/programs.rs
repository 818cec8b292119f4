//! Programs of the user that tasks depend on.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use super::lowering::Lowering;
use super::reached::reached;
use base::signature::DeclarationId;
use lang::hir::Declaration;
use world::av::external::{Opener, Parts, Program, ProgramKeys};

/// A program of the user that drives or walks.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ExternalProgram {
    /// The name of the driver or the controller.
    pub name: String,
    /// As the files have it.
    pub command: String,
    /// What the files say about it where its own files do not decide what it does.
    pub version: Option<String>,
    /// What it is made of.
    pub parts: Parts,
}

impl ExternalProgram {
    /// Why it may have changed unnoticed, as half a sentence; none when its files or its `version` say what it is.
    pub fn unknown(&self) -> Option<&str> {
        self.parts.unknown.as_deref().filter(|_| self.version.is_none())
    }
}

/// The paths of files whose digests differ in two lists, or that one of them lacks, in order.
pub fn changed_files<'a>(one: &'a BTreeMap<String, String>, other: &'a BTreeMap<String, String>) -> Vec<&'a str> {
    let paths: BTreeSet<&str> = one.keys().chain(other.keys()).map(String::as_str).collect();
    paths.into_iter().filter(|path| one.get(*path) != other.get(*path)).collect()
}

/// The programs that a task depends on.
pub type Programs = Arc<[Arc<ExternalProgram>]>;

impl Lowering<'_> {
    /// Finds out what the program of a declaration is made of.
    pub(super) fn note_program(&mut self, declaration: &Declaration, program: &Program, opener: &dyn Opener) {
        if !self.read.wanted() || self.noted(declaration).is_some() {
            return;
        }
        let ProgramKeys { command, version, .. } = declaration.block.keys();
        let found = ExternalProgram { name: declaration.name.clone(), command, version, parts: opener.parts(program) };
        self.shared.programs.entry(declaration.id).or_default().push((declaration.block.clone(), Arc::new(found)));
    }

    /// The program of a declaration, if it has one.
    pub(super) fn noted(&self, declaration: &Declaration) -> Option<&Arc<ExternalProgram>> {
        let known = self.shared.programs.get(&declaration.id)?;
        known.iter().find(|(block, _)| *block == declaration.block).map(|(_, program)| program)
    }

    /// The programs that a task depends on which depends on these declarations.
    pub(super) fn programs(&self, parts: &[DeclarationId]) -> Programs {
        let all: BTreeSet<DeclarationId> = parts.iter().flat_map(|part| reached(self.program, *part)).collect();
        all.into_iter().filter_map(|id| self.noted(self.program.get(id))).cloned().collect()
    }
}

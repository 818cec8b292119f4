//! Programs of the user that tasks depend on.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::sync::Arc;

use super::lowering::Lowering;
use super::reached::reached;
use base::signature::DeclarationId;
use lang::hir::Declaration;
use world::av::external::{Opener, Program, ProgramKeys};

/// A program of the user that drives, walks, or bridges to another world.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ExternalProgram {
    /// The name of the driver, the controller or the world.
    pub name: String,
    /// As the files have it.
    pub command: String,
    /// Its version, as the scenario states it, or as a world does.
    pub version: Option<String>,
    /// The folder in which it runs.
    pub folder: PathBuf,
    /// BLAKE3 of its declared files in hexadecimal digits, by their paths relative to that folder.
    pub files: BTreeMap<String, String>,
}

impl ExternalProgram {
    /// Whether it may have changed unnoticed: the scenario states neither its files nor its version.
    pub fn is_unknown(&self) -> bool {
        self.files.is_empty() && self.version.is_none()
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
    /// Finds the digests of the files that the program of a declaration consists of.
    ///
    /// # Errors
    /// A file cannot be read, as a part of a sentence.
    pub(super) fn note_program(
        &mut self,
        declaration: &Declaration,
        program: &Program,
        opener: &dyn Opener,
    ) -> Result<(), String> {
        if !self.read.wanted() || self.catalog.looks_up || self.noted(declaration).is_some() {
            return Ok(());
        }
        let ProgramKeys { command, version, .. } = declaration.block.keys();
        let (name, folder) = (declaration.name.clone(), program.folder.clone());
        let found = ExternalProgram { name, command, version, folder, files: opener.digests(program)? };
        self.shared.programs.entry(declaration.id).or_default().push((declaration.block.clone(), Arc::new(found)));
        Ok(())
    }

    /// Notes what the program of a declaration says of its version, unless the scenario states its version or its files.
    pub(super) fn note_version(&mut self, declaration: &Declaration, version: &str) {
        let known = self.shared.programs.get_mut(&declaration.id).into_iter().flatten();
        for (_, program) in known.filter(|(block, program)| *block == declaration.block && program.is_unknown()) {
            Arc::make_mut(program).version = Some(version.into());
        }
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

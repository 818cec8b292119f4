//! Programs of the user that tasks depend on.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::sync::Arc;

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

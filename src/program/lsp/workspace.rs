//! The scenarios on disk below the folders that the editor has open.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use lang::normal;

/// The greatest number of scenarios that are looked at.
pub const MAX_FILES: usize = 1000;
/// The greatest size of one that is looked at (bytes).
const MAX_BYTES: u64 = 1 << 20;
/// The greatest number of entries of folders that are read on the way.
const MAX_ENTRIES: usize = 100_000;

/// Scenarios below some folders.
#[derive(Debug, Default)]
pub struct Scenarios {
    pub paths: BTreeSet<PathBuf>,
    /// Whether there may be more: a bound was reached.
    pub is_cut: bool,
}

/// Looks for scenarios below these folders, in the order of their names. Links are not followed; hidden folders, `target` and `node_modules` are left
/// out, and so are files of more than 1 MiB.
pub fn scenarios(folders: &[PathBuf]) -> Scenarios {
    let mut found = Scenarios::default();
    let mut entries = 0;
    let mut left: Vec<PathBuf> = folders.iter().rev().map(|folder| normal(folder)).collect();
    while let Some(folder) = left.pop() {
        let Ok(read) = std::fs::read_dir(&folder) else { continue };
        let mut inside: Vec<_> = read.filter_map(Result::ok).take(MAX_ENTRIES - entries).collect();
        entries += inside.len();
        inside.sort_by_key(std::fs::DirEntry::file_name);
        for entry in inside.iter().rev() {
            let Ok(kind) = entry.file_type() else { continue };
            if kind.is_dir() && !is_left_out(&entry.path()) {
                left.push(entry.path());
            }
        }
        for entry in inside {
            let path = entry.path();
            let is_scenario = path.extension().is_some_and(|end| end == "scn");
            let is_small = || entry.metadata().is_ok_and(|data| data.is_file() && data.len() <= MAX_BYTES);
            if is_scenario && is_small() {
                found.paths.insert(path);
            }
        }
        if found.paths.len() > MAX_FILES || entries >= MAX_ENTRIES {
            found.is_cut = true;
            while found.paths.len() > MAX_FILES {
                found.paths.pop_last();
            }
            break;
        }
    }
    found
}

fn is_left_out(folder: &Path) -> bool {
    let name = folder.file_name().unwrap_or_default().to_string_lossy();
    name.starts_with('.') || matches!(&*name, "target" | "node_modules")
}

/// What a path that is being typed may go on with: the folders and scenarios in the folder that it leads to, as paths like it. `file` is the file
/// that imports, and is left out.
pub fn beside(file: &Path, typed: &str) -> Vec<String> {
    /// Maximum number of entries that are offered.
    const MAX_OFFERED: usize = 500;
    let inside = typed.rfind('/').map_or("", |at| &typed[..=at]);
    let Some(folder) = file.parent().filter(|_| file.is_absolute()) else { return Vec::new() };
    let Ok(read) = std::fs::read_dir(folder.join(inside)) else { return Vec::new() };
    let entry = |entry: std::fs::DirEntry| {
        let (path, name) = (entry.path(), entry.file_name().into_string().ok()?);
        if path.is_dir() {
            return (!is_left_out(&path)).then(|| format!("{inside}{name}/"));
        }
        let fits = path.extension().is_some_and(|end| end == "scn") && normal(&path) != normal(file);
        fits.then(|| format!("{inside}{name}"))
    };
    let mut all: Vec<String> = read.filter_map(Result::ok).take(MAX_OFFERED).filter_map(entry).collect();
    all.sort();
    all
}

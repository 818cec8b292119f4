//! Copies of the programs of a report.

use std::path::{Component, Path};
use std::{fs, io};

use tempfile::TempDir;

use super::{FileRecord, MAX_HELD_BYTES, ProgramRecord, ReportFolder, StoredReport, WriteError};
use compile::ExternalProgram;
use world::av::external::Program;

/// The folder of a report with a folder for each program.
pub(super) const PROGRAMS: &str = "programs";

impl ProgramRecord {
    /// The record of a program, whose declared files are added to its report: all of them or none. They are left out if they are more than 4 MiB, a link, outside
    /// of the folder of the scenario, or not as they were when the run began.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn held(program: &ExternalProgram, folder: &ReportFolder) -> Result<Self, WriteError> {
        let mut record = Self::new(program);
        let mut left = MAX_HELD_BYTES;
        let mut read = |path: &String, digest: &String| -> Option<Vec<u8>> {
            let place = program.folder.join(path);
            let is_plain = is_inside(path) && !passes_link(&program.folder, Path::new(path));
            let data = fs::symlink_metadata(&place).ok().filter(|data| data.is_file() && is_plain)?;
            left = left.checked_sub(usize::try_from(data.len()).ok()?)?;
            fs::read(&place).ok().filter(|bytes| is_of(bytes, digest))
        };
        let contents: Option<Vec<_>> =
            record.files.iter().map(|(path, digest)| Some((path, read(path, digest)?))).collect();
        for (path, bytes) in contents.iter().flatten() {
            folder.file(&format!("{PROGRAMS}/{}/{path}", record.name), bytes)?;
        }
        record.is_held = contents.is_some_and(|files| !files.is_empty());
        Ok(record)
    }
}

impl StoredReport {
    /// A temporary folder with the files of a program as they were in the run, and beside them what it does not declare, as that is now; `None` if the report does
    /// not hold its files, or not as they were.
    pub fn program_copy(&self, record: &ProgramRecord, present: &Program) -> Option<TempDir> {
        let held = self.folder().join(PROGRAMS).join(&record.name);
        if !record.is_held || !is_inside(&record.name) {
            return None;
        }
        let copy = tempfile::Builder::new().prefix("falsify-program-").tempdir().ok()?;
        for (path, digest) in &record.files {
            let within = Path::new(PROGRAMS).join(&record.name).join(path);
            if !is_inside(path) || passes_link(self.folder(), &within) {
                return None;
            }
            let bytes = fs::read(held.join(path)).ok().filter(|bytes| is_of(bytes, digest))?;
            let place = copy.path().join(path);
            fs::create_dir_all(place.parent()?).ok()?;
            fs::write(&place, bytes).ok()?;
            make_executable(&place)?;
        }
        complete(copy.path(), present, Path::new("")).ok()?;
        Some(copy)
    }
}

/// Adds to the copy of a program what lies beside its declared files: links, and copies of what its command names, since an interpreter looks for other files
/// where a script really is.
fn complete(copy: &Path, program: &Program, within: &Path) -> io::Result<()> {
    const MAX_COPY: u64 = MAX_HELD_BYTES as u64;
    let is_named = |path: &Path| program.words.iter().any(|word| Path::new(word.trim_start_matches("./")) == path);
    let folder = std::path::absolute(Path::new(".").join(&program.folder).join(within))?;
    let Ok(entries) = fs::read_dir(&folder) else { return Ok(()) };
    for entry in entries {
        let name = entry?.file_name();
        let (path, here) = (within.join(&name), folder.join(&name));
        let place = copy.join(&path);
        let is_declared = program.files.iter().any(|declared| path.starts_with(declared));
        let text = name.to_string_lossy();
        if is_declared || text.starts_with('.') || text == "__pycache__" {
            continue;
        }
        if place.is_dir() {
            complete(copy, program, &path)?;
        } else if is_named(&path) && fs::metadata(&here).is_ok_and(|data| data.is_file() && data.len() <= MAX_COPY) {
            fs::copy(&here, &place)?;
        } else {
            link(&here, &place)?;
        }
    }
    Ok(())
}

#[cfg(unix)]
fn link(target: &Path, place: &Path) -> io::Result<()> {
    std::os::unix::fs::symlink(target, place)
}

#[cfg(not(unix))]
fn link(_: &Path, _: &Path) -> io::Result<()> {
    Ok(())
}

/// Whether a part of a path below a folder is a link, which could lead out of it.
fn passes_link(folder: &Path, within: &Path) -> bool {
    within.ancestors().filter(|part| !part.as_os_str().is_empty()).any(|part| folder.join(part).is_symlink())
}

/// Whether a path leads to nothing outside of its folder.
fn is_inside(path: &str) -> bool {
    !path.is_empty() && Path::new(path).components().all(|part| matches!(part, Component::Normal(_)))
}

fn is_of(bytes: &[u8], digest: &str) -> bool {
    FileRecord::new(String::new(), bytes).blake3 == digest
}

/// A program may be one of its files.
#[cfg(unix)]
fn make_executable(path: &Path) -> Option<()> {
    use std::os::unix::fs::PermissionsExt;
    fs::set_permissions(path, fs::Permissions::from_mode(0o700)).ok()
}

#[cfg(not(unix))]
fn make_executable(_: &Path) -> Option<()> {
    Some(())
}

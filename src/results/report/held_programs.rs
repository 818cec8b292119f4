//! Copies of the programs of a report.

use std::fs;
use std::path::{Component, Path};

use tempfile::TempDir;

use super::{FileRecord, MAX_HELD_BYTES, ProgramRecord, ReportFolder, StoredReport, WriteError};
use compile::ExternalProgram;

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
            let data = fs::symlink_metadata(&place).ok().filter(|data| data.is_file() && is_inside(path))?;
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
    /// A temporary folder with the files of a program as they were in the run; `None` if the report does not hold them, or not as they were.
    pub fn program_copy(&self, record: &ProgramRecord) -> Option<TempDir> {
        let held = self.folder().join(PROGRAMS).join(&record.name);
        let is_plain = |part: &Path| !self.folder().join(part).is_symlink();
        if !record.is_held || !is_inside(&record.name) {
            return None;
        }
        let copy = tempfile::Builder::new().prefix("falsify-program-").tempdir().ok()?;
        for (path, digest) in &record.files {
            let within = Path::new(PROGRAMS).join(&record.name).join(path);
            let links = within.ancestors().filter(|part| !part.as_os_str().is_empty());
            if !is_inside(path) || !links.into_iter().all(is_plain) {
                return None;
            }
            let bytes = fs::read(held.join(path)).ok().filter(|bytes| is_of(bytes, digest))?;
            let place = copy.path().join(path);
            fs::create_dir_all(place.parent()?).ok()?;
            fs::write(&place, bytes).ok()?;
            make_executable(&place)?;
        }
        Some(copy)
    }
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

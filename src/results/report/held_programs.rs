//! Copies of the programs of a report.

use std::path::{Component, Path, PathBuf};
use std::{fs, io};

use tempfile::TempDir;

use super::folder::PROGRAMS;
use super::{FileRecord, MAX_HELD_BYTES, ProgramRecord, ReportFolder, StoredReport, WriteError};
use compile::ExternalProgram;
use world::av::external::Program;

/// Maximum number of folders above that of the scenario in which declared files may lie.
const MAX_ABOVE: usize = 8;

/// Where a declared file lies: the number of folders above that of the scenario, and its path from there. `None` if that is absolute, or leads up after it
/// led down.
fn place(declared: &str) -> Option<(usize, PathBuf)> {
    let (mut above, mut below) = (0, PathBuf::new());
    for part in Path::new(declared).components() {
        match part {
            Component::CurDir => {}
            Component::Normal(name) => below.push(name),
            Component::ParentDir if below.as_os_str().is_empty() && above < MAX_ABOVE => above += 1,
            _ => return None,
        }
    }
    (!below.as_os_str().is_empty()).then_some((above, below))
}

/// The file of a report, from its folder, that holds a declared file.
fn held_file(name: &str, declared: &str) -> Option<PathBuf> {
    let (above, below) = place(declared)?;
    let above = if above > 0 { format!("above-{above}") } else { String::new() };
    Some(Path::new(PROGRAMS).join(name).join(above).join(below))
}

impl ProgramRecord {
    /// The record of a program, whose declared files are added to its report: all of them or none, with the reason. They are left out if they are more than 4 MiB, a
    /// link, or not as they were when the run began.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn held(program: &ExternalProgram, folder: &ReportFolder) -> Result<(Self, Option<String>), WriteError> {
        let mut record = Self::new(program);
        let mut left = MAX_HELD_BYTES;
        let mut read = |path: &String, digest: &String| {
            let Some(held) = held_file(&program.name, path) else {
                return Err(
                    "is not a path from the folder of the scenario: name it as `../FILE`, or beside the scenario",
                );
            };
            if passes_link(&program.folder, Path::new(path)) {
                return Err("is a link or behind one: name the file that it leads to");
            }
            let file = program.folder.join(path);
            let size = fs::symlink_metadata(&file).ok().and_then(|data| usize::try_from(data.len()).ok());
            let Some(rest) = left.checked_sub(size.unwrap_or(0)) else {
                return Err("makes its files more than 4 MiB: keep a copy of them");
            };
            left = rest;
            let bytes = fs::read(&file).ok().filter(|bytes| is_of(bytes, digest));
            Ok((held, bytes.ok_or("was changed during the run: run it again")?))
        };
        let read = |(path, digest)| read(path, digest).map_err(|why| format!("`{path}` {why}"));
        let contents: Result<Vec<_>, String> = record.files.iter().map(read).collect();
        for (path, bytes) in contents.iter().flatten() {
            folder.file(&path.to_string_lossy(), bytes)?;
        }
        record.is_held = contents.as_ref().is_ok_and(|files| !files.is_empty());
        let undeclared =
            || record.undeclared().map(|word| format!("`{word}` of its command is none of its `files`: add it"));
        let missing = contents.err().or_else(|| undeclared().filter(|_| record.is_held));
        Ok((record, missing))
    }

    /// A file that the command names and the files of the scenario do not.
    fn undeclared(&self) -> Option<String> {
        let program = Program::parse(&self.command, PathBuf::from(&self.folder)).ok()?;
        let is_other = |word: &String| {
            place(word).is_some_and(|word| self.files.keys().all(|file| place(file).as_ref() != Some(&word)))
        };
        program.words.into_iter().find(|word| program.folder.join(word).is_file() && is_other(word))
    }
}

/// A temporary folder with the files of a program as they were in a run.
pub struct ProgramCopy {
    _root: TempDir,
    /// Its folder of the scenario.
    pub folder: PathBuf,
}

impl StoredReport {
    /// A copy of a program as it was in the run, and beside its files what it does not declare, as that is now; `None` if the report does not hold its files,
    /// or not as they were.
    pub fn program_copy(&self, record: &ProgramRecord, present: &Program) -> Option<ProgramCopy> {
        if !record.is_held || place(&record.name)? != (0, PathBuf::from(&record.name)) {
            return None;
        }
        let places: Option<Vec<_>> = record.files.keys().map(|path| place(path)).collect();
        let places = places?;
        let above = places.iter().map(|(above, _)| *above).max().unwrap_or(0);
        let root = tempfile::Builder::new().prefix("falsify-program-").tempdir().ok()?;
        let real = fs::canonicalize(Path::new(".").join(&present.folder)).unwrap_or_default();
        let name = |level| real.ancestors().nth(level).and_then(Path::file_name).unwrap_or("folder".as_ref());
        let folder = (0..above).rev().fold(root.path().to_path_buf(), |folder, level| folder.join(name(level)));
        fs::create_dir_all(&folder).ok()?;
        for ((path, digest), (above, below)) in record.files.iter().zip(&places) {
            let within = held_file(&record.name, path)?;
            if passes_link(self.folder(), &within) {
                return None;
            }
            let bytes = fs::read(self.folder().join(within)).ok().filter(|bytes| is_of(bytes, digest))?;
            let place = folder.ancestors().nth(*above)?.join(below);
            fs::create_dir_all(place.parent()?).ok()?;
            fs::write(&place, bytes).ok()?;
            make_executable(&place)?;
        }
        (0..=above).try_for_each(|above| complete(&folder, present, above, Path::new(""))).ok()?;
        Some(ProgramCopy { _root: root, folder })
    }
}

/// Adds to the copy of a program what lies beside its declared files, some folders above that of the scenario: links, and copies of what its command names,
/// since an interpreter looks for other files where a script really is.
fn complete(copy: &Path, program: &Program, above: usize, within: &Path) -> io::Result<()> {
    const MAX_COPY: u64 = MAX_HELD_BYTES as u64;
    let up: PathBuf = std::iter::repeat_n("..", above).collect();
    let folder = std::path::absolute(Path::new(".").join(&program.folder))?.join(up).join(within);
    let (Ok(entries), Some(root)) = (fs::read_dir(&folder), copy.ancestors().nth(above)) else { return Ok(()) };
    for entry in entries {
        let name = entry?.file_name();
        let (path, here) = (within.join(&name), folder.join(&name));
        let new = root.join(&path);
        let is = |word: &String, of: fn(&Path, &Path) -> bool| {
            place(word).is_some_and(|(other, word)| other == above && of(&path, &word))
        };
        let is_declared = program.files.iter().any(|word| is(word, |path, word| path.starts_with(word)));
        let is_named = program.words.iter().any(|word| is(word, |path, word| path == word));
        let text = name.to_string_lossy();
        if is_declared || text.starts_with('.') || text == "__pycache__" || copy.starts_with(&new) {
            continue;
        }
        if new.is_dir() {
            complete(copy, program, above, &path)?;
        } else if is_named && fs::metadata(&here).is_ok_and(|data| data.is_file() && data.len() <= MAX_COPY) {
            fs::copy(&here, &new)?;
        } else {
            link(&here, &new)?;
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

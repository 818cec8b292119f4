use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use tempfile::TempDir;

/// The prefix of a process's folder.
pub(super) const PREFIX: &str = "work-";
/// The file in it that the process holds locked. A file of this name in the store itself is held while folders are made and removed.
pub(super) const LOCK: &str = "lock";

/// What the file says, so that no folder of others is taken for one of ours.
const MARK: &str = "a process of falsify works here while it holds this file locked\n";

/// A folder of this process for files that are being written. It is removed when the process ends. The folder of a process that was killed
/// is removed when another process starts.
#[derive(Debug)]
pub(super) struct WorkFolder {
    folder: TempDir,
    /// Locked as long as the process lives.
    _lock: File,
}

impl WorkFolder {
    /// Removes the folders of dead processes, and makes a folder.
    pub fn begin(root: &Path) -> io::Result<Self> {
        // A folder that is not locked yet must not be taken for that of a dead process.
        let door = File::create(root.join(LOCK))?;
        let _ = door.lock();
        for entry in fs::read_dir(root)?.flatten() {
            if is_ours(&entry.path()) && is_dead(&entry.path()) {
                let _ = remove(&entry.path());
            }
        }
        let folder = tempfile::Builder::new().prefix(PREFIX).tempdir_in(root)?;
        let mut lock = File::create(folder.path().join(LOCK))?;
        lock.write_all(MARK.as_bytes())?;
        let _ = lock.lock();
        Ok(Self { folder, _lock: lock })
    }

    /// The path; the folder is made again when it was removed.
    pub fn path(&self) -> io::Result<PathBuf> {
        fs::create_dir_all(self.folder.path())?;
        Ok(self.folder.path().to_path_buf())
    }
}

impl Drop for WorkFolder {
    fn drop(&mut self) {
        let _ = remove(self.folder.path());
    }
}

/// Removes a folder, the file with our mark last: a process that is killed meanwhile leaves a folder that is still known as ours.
fn remove(folder: &Path) -> io::Result<()> {
    for entry in fs::read_dir(folder)?.flatten().filter(|entry| entry.file_name() != LOCK) {
        if entry.file_type()?.is_dir() { fs::remove_dir_all(entry.path())? } else { fs::remove_file(entry.path())? }
    }
    fs::remove_dir_all(folder)
}

/// The number of processes that have a folder here.
pub(super) fn processes(root: &Path) -> usize {
    let folders = fs::read_dir(root).into_iter().flatten().flatten();
    let at_work = |entry: &fs::DirEntry| is_ours(&entry.path()) && !is_dead(&entry.path());
    folders.filter(at_work).count()
}

/// Whether a process of this program made a folder: it is not a link, has a name as we give it, and is empty or has our mark, which may have been
/// cut off.
pub(super) fn is_ours(folder: &Path) -> bool {
    let name = folder.file_name().and_then(|name| name.to_str()?.strip_prefix(PREFIX));
    let is_named = name.is_some_and(|rest| rest.len() == 6 && rest.bytes().all(|byte| byte.is_ascii_alphanumeric()));
    if !is_named || !fs::symlink_metadata(folder).is_ok_and(|known| known.is_dir()) {
        return false;
    }
    let Ok(entries) = fs::read_dir(folder) else { return false };
    let mark = base::files::text(&folder.join(LOCK));
    match (entries.count(), mark) {
        (0, _) => true,
        (1, Ok(mark)) => MARK.starts_with(&mark),
        (_, mark) => mark.is_ok_and(|mark| mark == MARK),
    }
}

/// Whether no process has this folder. A folder without its lock file is dead too: its process was killed between making one and the other.
fn is_dead(folder: &Path) -> bool {
    match File::open(folder.join(LOCK)) {
        Ok(lock) => lock.try_lock().is_ok(),
        Err(error) => error.kind() == io::ErrorKind::NotFound,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folders_of_dead_processes_are_removed_with_and_without_a_lock_file() {
        let root = tempfile::tempdir().unwrap();
        let alive = WorkFolder::begin(root.path()).unwrap();
        let folder = |name: &str| root.path().join(format!("{PREFIX}{name}"));
        for name in ["killed", "early0", "early1", "thesis", "2026"] {
            fs::create_dir(folder(name)).unwrap();
        }
        fs::write(folder("killed").join(LOCK), MARK).unwrap();
        fs::write(folder("killed").join("draft"), "half").unwrap();
        fs::write(folder("early1").join(LOCK), "").unwrap();
        // Folders of others, one of them with a file of the name of ours.
        for name in ["thesis", "2026"] {
            fs::write(folder(name).join("chapter.tex"), "mine").unwrap();
            fs::write(folder(name).join(LOCK), "").unwrap();
        }
        assert_eq!(processes(root.path()), 1);
        let second = WorkFolder::begin(root.path()).unwrap();
        assert!(["killed", "early0", "early1"].iter().all(|name| !folder(name).exists()));
        assert!(["thesis", "2026"].iter().all(|name| folder(name).join("chapter.tex").exists()));
        assert!(alive.path().unwrap().join(LOCK).exists() && second.path().unwrap().join(LOCK).exists());
        assert_eq!(processes(root.path()), 2);
    }
}

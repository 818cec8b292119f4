use std::fs::{self, File, TryLockError};
use std::io;
use std::path::Path;

use tempfile::{Builder, NamedTempFile};

/// How the names of files that are being written begin and end.
const NAME: (&str, &str) = (".falsify-", ".tmp");
/// Maximum number of attempts, if another process takes the file for an abandoned one.
const MAX_ATTEMPTS: usize = 10;

/// A new file in a folder, for a file of the same folder that appears whole. The process that writes it holds it locked; a lock ends with its
/// process. So a file with such a name that can be locked belongs to a process that was killed: it is removed here.
///
/// # Errors
/// The folder cannot be written to.
pub fn staging_file(folder: &Path) -> io::Result<NamedTempFile> {
    remove_abandoned(folder);
    let make = || Builder::new().prefix(NAME.0).suffix(NAME.1).tempfile_in(folder);
    let mut staging = make()?;
    // Between the making and the lock, another process may remove it.
    for _ in 0..MAX_ATTEMPTS {
        let taken = matches!(staging.as_file().try_lock(), Err(TryLockError::WouldBlock));
        if !taken && staging.path().exists() {
            break;
        }
        staging = make()?;
    }
    Ok(staging)
}

fn remove_abandoned(folder: &Path) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let name = name.to_string_lossy();
        let is_staging = name.starts_with(NAME.0) && name.ends_with(NAME.1);
        if is_staging
            && entry.metadata().is_ok_and(|known| known.is_file())
            && File::open(entry.path()).is_ok_and(|file| file.try_lock().is_ok())
        {
            let _ = fs::remove_file(entry.path());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_of_killed_processes_are_removed_and_those_of_living_ones_stay() {
        let folder = tempfile::tempdir().unwrap();
        let place = |name: &str| folder.path().join(name);
        for name in [".falsify-killed.tmp", ".falsify-notes", ".tmpABC", "kept.tmp"] {
            fs::write(place(name), "").unwrap();
        }
        let living = staging_file(folder.path()).unwrap();
        let other = staging_file(folder.path()).unwrap();
        assert!(living.path().exists() && other.path().exists());
        assert!(!place(".falsify-killed.tmp").exists());
        assert!([".falsify-notes", ".tmpABC", "kept.tmp"].iter().all(|name| place(name).exists()));
        other.persist(place("whole")).unwrap();
        drop(living);
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 4);
    }
}

//! Digests of the files that a program declares.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

use world::av::external::Program;

/// Maximum number of files of a program.
const MAX_FILES: usize = 10_000;

/// BLAKE3 of the declared files of a program in hexadecimal digits, by their paths relative to its folder. A folder stands for all files below it; hidden
/// ones and `__pycache__` are left out.
///
/// # Errors
/// A file cannot be read, or there are too many, as a part of a sentence.
pub(super) fn digests(program: &Program) -> Result<BTreeMap<String, String>, String> {
    let mut files = BTreeMap::new();
    let mut open: Vec<PathBuf> = program.files.iter().map(PathBuf::from).collect();
    while let Some(path) = open.pop() {
        let place = program.folder.join(&path);
        let failed = |error: io::Error| format!("`{}` cannot be read: {error}", path.display());
        let is_declared = program.files.iter().any(|declared| Path::new(declared) == path);
        // A link below a declared folder could lead back to it.
        let data = if is_declared { fs::metadata(&place) } else { fs::symlink_metadata(&place) };
        if data.map_err(failed)?.is_dir() {
            for entry in fs::read_dir(&place).map_err(failed)? {
                let name = entry.map_err(failed)?.file_name();
                let text = name.to_string_lossy();
                if !text.starts_with('.') && text != "__pycache__" {
                    open.push(path.join(&name));
                }
            }
        } else if place.is_file() {
            files.insert(path.to_string_lossy().into_owned(), digest(&place).map_err(failed)?);
        } else if is_declared {
            return Err(format!("`{}` is not a file or a folder", path.display()));
        }
        if files.len() + open.len() > MAX_FILES {
            return Err(format!("it has more than {MAX_FILES} files"));
        }
    }
    Ok(files)
}

fn digest(path: &Path) -> io::Result<String> {
    let mut digest = blake3::Hasher::new();
    digest.update_reader(File::open(path)?)?;
    Ok(digest.finalize().to_hex().to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn declared_files_and_folders_count_and_missing_ones_are_errors() {
        let place = tempfile::tempdir().unwrap();
        fs::create_dir_all(place.path().join("part/__pycache__")).unwrap();
        for name in ["drv.py", "notes.txt", "part/deep.py", "part/__pycache__/old.py", "part/.hidden"] {
            fs::write(place.path().join(name), "1").unwrap();
        }
        let of = |files: &[&str]| {
            let files = files.iter().map(ToString::to_string).collect();
            digests(&Program { folder: place.path().into(), files, ..Program::default() })
        };
        let before = of(&["drv.py", "part"]).unwrap();
        assert_eq!(before.keys().collect::<Vec<_>>(), ["drv.py", "part/deep.py"]);
        fs::write(place.path().join("notes.txt"), "2").unwrap();
        assert_eq!(of(&["drv.py", "part"]).unwrap(), before);
        fs::write(place.path().join("part/deep.py"), "2").unwrap();
        assert_ne!(of(&["drv.py", "part"]).unwrap(), before);
        assert!(of(&["gone.py"]).unwrap_err().contains("`gone.py` cannot be read"));
    }
}

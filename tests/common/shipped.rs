//! The scenario files of the repository.

use std::path::PathBuf;

/// All `.scn` files below a folder of the repository, sorted.
pub fn shipped(folder: &str) -> Vec<PathBuf> {
    let mut open = vec![crate::repository().join(folder)];
    let mut files = Vec::new();
    while let Some(folder) = open.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                open.push(path);
            } else if path.extension().is_some_and(|extension| extension == "scn") {
                files.push(path);
            }
        }
    }
    files.sort();
    files
}

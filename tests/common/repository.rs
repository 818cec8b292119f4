//! The files of the repository, for the tests of any package.

use std::path::Path;

/// The top folder of the repository.
pub fn repository() -> &'static Path {
    let folders = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors();
    let mut tops = folders.filter(|folder| folder.join("tests/suite").is_dir());
    tops.next().expect("a package is inside the repository")
}

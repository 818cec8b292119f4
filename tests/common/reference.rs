//! The folder of the recordings of independent programs.

use std::path::PathBuf;

/// The folder that `FALSIFY_REFERENCE_DIR` names, or `../shared` beside the repository.
pub fn folder() -> PathBuf {
    std::env::var_os("FALSIFY_REFERENCE_DIR").map_or_else(|| crate::repository().join("../shared"), PathBuf::from)
}

//! The folder of the recordings of independent programs, and how they are read.

use std::io::Read;
use std::path::{Path, PathBuf};

use flate2::read::GzDecoder;

/// The folder that `FALSIFY_REFERENCE_DIR` names, or `../shared` beside the package.
pub fn folder() -> PathBuf {
    std::env::var_os("FALSIFY_REFERENCE_DIR")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared"), PathBuf::from)
}

/// The text of a file, or of its compressed version.
pub fn read_text(path: &Path) -> Option<String> {
    if let Ok(text) = std::fs::read_to_string(path) {
        return Some(text);
    }
    let mut packed = path.as_os_str().to_owned();
    packed.push(".gz");
    let mut text = String::new();
    let file = std::fs::File::open(packed).ok()?;
    GzDecoder::new(file).read_to_string(&mut text).expect("a compressed file is readable");
    Some(text)
}

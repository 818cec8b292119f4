//! Recordings that are stored compressed.

use std::io::Read;
use std::path::Path;

use flate2::read::GzDecoder;

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

//! Scenarios that are texts of a test and may import files.

use std::path::Path;

use lang::Reader;

/// Reads this text as `test.scn`, and files.
pub struct With(pub String);

impl Reader for With {
    fn text(&self, path: &Path) -> std::io::Result<String> {
        if path.ends_with("test.scn") { Ok(self.0.clone()) } else { std::fs::read_to_string(path) }
    }

    fn bytes(&self, path: &Path) -> std::io::Result<Vec<u8>> {
        std::fs::read(path)
    }
}

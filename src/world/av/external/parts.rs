use std::collections::BTreeMap;

/// What a program is made of, as far as it is known. Results of the program belong to it.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Parts {
    /// BLAKE3 of its files in hexadecimal digits, by their paths relative to the folder in which it runs.
    pub files: BTreeMap<String, String>,
    /// Why these files do not decide what it does, as half a sentence; none when they do.
    pub unknown: Option<String>,
}

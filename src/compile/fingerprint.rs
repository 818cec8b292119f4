use std::fmt;

/// A digest of everything that the files say about a training, an evaluation or a search.
///
/// It holds the declarations that the task depends on, with those that they name: forms, kinds, names, values in SI, formulas, and
/// the contents of files such as maps and models. It does not hold documentation, layout, the places of declarations, or
/// any other declaration of the files. Another town or reward in a campaign therefore does not change it.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub struct Fingerprint(pub(super) [u8; 32]);

impl Fingerprint {
    /// The digest.
    pub fn bytes(&self) -> &[u8; 32] {
        &self.0
    }
}

impl fmt::Display for Fingerprint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&blake3::Hash::from_bytes(self.0).to_hex())
    }
}

impl fmt::Debug for Fingerprint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{self}")
    }
}

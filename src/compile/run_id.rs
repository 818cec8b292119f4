use std::fmt;
use std::str::FromStr;

/// The short name of a run or of a search: a hash (BLAKE3) of its names, its seed and its fingerprint, in tables eight hexadecimal digits. The first is a
/// letter, so that no reader of a CSV file takes it for a number.
///
/// It is the same in every report of the same run, whatever else the campaign contains. Another driver, place, setting or seed is another
/// run. Episode 17 of run `1a2b3c4d` is called `1a2b3c4d:17`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct RunId(u32);

impl RunId {
    /// Makes a name; `again` counts up if the name is already taken by chance.
    pub(super) fn new(names: &str, again: u32) -> Self {
        let hash = match again {
            0 => blake3::hash(names.as_bytes()),
            _ => blake3::hash(&[names.as_bytes(), &again.to_le_bytes()].concat()),
        };
        let [a, b, c, d, ..] = *hash.as_bytes();
        let letter = 0xa + (a >> 4) % 6;
        Self(u32::from_be_bytes([letter << 4 | a & 0xf, b, c, d]))
    }
}

impl fmt::Display for RunId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:08x}", self.0)
    }
}

/// A text that is not the name of a run.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("`{text}` is not the name of a run, which has eight hexadecimal digits")]
pub struct NoRunId {
    pub text: String,
}

impl FromStr for RunId {
    type Err = NoRunId;

    fn from_str(text: &str) -> Result<Self, NoRunId> {
        let right = text.len() == 8 && text.bytes().all(|byte| byte.is_ascii_hexdigit());
        let number = right.then(|| u32::from_str_radix(text, 16).ok()).flatten();
        number.map(Self).ok_or_else(|| NoRunId { text: text.to_string() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_name_of_a_run_is_a_number() {
        for number in 0..2_000 {
            let name = RunId::new(&number.to_string(), number % 3).to_string();
            assert!(name.parse::<f64>().is_err() && name.parse::<RunId>().is_ok(), "{name}");
            assert!(name.starts_with(|first: char| first.is_ascii_alphabetic()), "{name}");
        }
    }
}

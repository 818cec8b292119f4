//! A task in a file: two lines of text, the bytes, and a checksum over all of it.

use serde::{Deserialize, Serialize};

use crate::campaign::State;

/// The first line.
const MAGIC: &[u8] = b"falsify task 2\n";
/// Bytes of the checksum.
const SUM: usize = 32;

/// The header of a task file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Header {
    /// Its name, which is a digest of all that it depends on. A file with another name holds the result of another task.
    pub task: String,
    /// What it is, for people.
    pub what: String,
    /// Its progress.
    pub state: State,
    /// Updates of a training, episodes of a chunk or of a search.
    pub done: u64,
    /// The error; empty without one.
    pub error: String,
    /// Wall time that was spent on it (s).
    pub seconds: f64,
    /// Bytes that follow.
    pub length: u64,
}

/// What is found at the path of a task.
#[derive(Debug, Clone, PartialEq)]
pub enum Found {
    /// No file.
    Nothing,
    /// A file that is not this task, or that was changed: what is wrong with it, after the name of the file.
    Damaged(String),
    /// A task.
    Whole(Header, Vec<u8>),
}

/// Encodes a task as a file.
pub fn encode(header: &Header, bytes: &[u8]) -> Vec<u8> {
    let head = serde_json::to_vec(header).expect("strings and numbers have a form in JSON");
    let mut file = [MAGIC, &head, b"\n", bytes].concat();
    let sum = blake3::hash(&file);
    file.extend(sum.as_bytes());
    file
}

/// Decodes a file; `None` if it was changed.
pub fn decode(mut file: Vec<u8>) -> Option<(Header, Vec<u8>)> {
    let (header, start) = head(&file)?;
    let end = file.len().checked_sub(SUM)?;
    if start as u64 + header.length != end as u64 || blake3::hash(&file[..end]).as_bytes() != &file[end..] {
        return None;
    }
    file.truncate(end);
    Some((header, file.split_off(start)))
}

/// Decodes the file of a task; none but of that task.
///
/// # Errors
/// What is wrong with it, after the name of the file.
pub fn decode_of(task: &str, file: Vec<u8>) -> Result<(Header, Vec<u8>), String> {
    let (header, bytes) = decode(file).ok_or("is damaged")?;
    header.check(task)?;
    Ok((header, bytes))
}

impl Header {
    /// Checks that it is of a task of this name.
    ///
    /// # Errors
    /// It is of another one, which the text names.
    pub fn check(&self, task: &str) -> Result<(), String> {
        if self.task == task { Ok(()) } else { Err(format!("holds the result of another task, `{}`", self.what)) }
    }
}

/// Reads the header at the start of a file, and where the bytes start.
pub fn head(start: &[u8]) -> Option<(Header, usize)> {
    let rest = start.strip_prefix(MAGIC)?;
    let end = rest.iter().position(|byte| *byte == b'\n')?;
    Some((serde_json::from_slice(&rest[..end]).ok()?, MAGIC.len() + end + 1))
}

/// The length of a file with this start.
pub fn whole_length(header: &Header, start: usize) -> u64 {
    (start + SUM) as u64 + header.length
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_changed_or_missing_byte_is_found() {
        let header = Header {
            task: "ab".into(),
            what: "train r1 in a\nb".into(),
            state: State::Begun,
            done: 3,
            error: String::new(),
            seconds: 0.1,
            length: 5,
        };
        let file = encode(&header, b"12\n45");
        assert_eq!(decode(file.clone()), Some((header, b"12\n45".to_vec())));
        for place in 0..file.len() {
            let mut damaged = file.clone();
            damaged[place] ^= 0x10;
            assert_eq!(decode(damaged), None, "byte {place}");
            assert_eq!(decode(file[..place].to_vec()), None, "{place} bytes");
        }
        assert_eq!(decode([file.as_slice(), b" "].concat()), None);
        assert!(decode_of("ab", file.clone()).is_ok());
        assert_eq!(decode_of("cd", file).unwrap_err(), "holds the result of another task, `train r1 in a\nb`");
    }
}

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

/// Maximum number of marks that are stored.
const MAX_MARKS: usize = 32;

/// Hashes of the states of an episode, which show from which decision on two episodes differ. A mark is a byte of the digest after a
/// decision. Up to 32 decisions there is a mark for each; with more there is one for every second decision, and so on.
///
/// In tables it is the number of decisions from mark to mark, a colon, and two hexadecimal digits for each mark.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(into = "String", try_from = "String")]
pub struct StateHashes {
    marks: [u8; MAX_MARKS],
    length: u8,
    /// Decisions from mark to mark.
    stride: u32,
    /// Number of decisions that have been recorded.
    decisions: u32,
}

impl Default for StateHashes {
    fn default() -> Self {
        Self { marks: [0; MAX_MARKS], length: 0, stride: 1, decisions: 0 }
    }
}

impl StateHashes {
    /// Records the digest after a decision.
    pub fn mark(&mut self, digest: u64) {
        self.decisions += 1;
        if !self.decisions.is_multiple_of(self.stride) {
            return;
        }
        if usize::from(self.length) == MAX_MARKS {
            self.thin();
            if !self.decisions.is_multiple_of(self.stride) {
                return;
            }
        }
        // The last step of the hash is a product, whose high bits depend on all of its input.
        self.marks[usize::from(self.length)] = (digest >> 56) as u8;
        self.length += 1;
    }

    /// Drops every other mark.
    fn thin(&mut self) {
        for kept in 0..MAX_MARKS / 2 {
            self.marks[kept] = self.marks[2 * kept + 1];
        }
        self.length = (MAX_MARKS / 2) as u8;
        self.stride *= 2;
    }

    fn marks(&self) -> &[u8] {
        &self.marks[..usize::from(self.length)]
    }

    /// The decisions between which two episodes diverge: their marks agree after the first of the two and differ after the second,
    /// counted from 1. `None` if all common marks agree.
    ///
    /// One mark in 256 agrees by chance.
    pub fn divergence(&self, other: &Self) -> Option<(u32, u32)> {
        let stride = self.stride.max(other.stride);
        let at = |hashes: &Self, number: u32| {
            let place = (number * stride / hashes.stride).checked_sub(1)?;
            hashes.marks().get(place as usize).copied()
        };
        let mut number = 1;
        while let (Some(ours), Some(theirs)) = (at(self, number), at(other, number)) {
            if ours != theirs {
                return Some(((number - 1) * stride, number * stride));
            }
            number += 1;
        }
        None
    }
}

impl fmt::Display for StateHashes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:", self.stride)?;
        self.marks().iter().try_for_each(|mark| write!(f, "{mark:02x}"))
    }
}

impl From<StateHashes> for String {
    fn from(hashes: StateHashes) -> Self {
        hashes.to_string()
    }
}

impl TryFrom<String> for StateHashes {
    type Error = NoTrail;

    fn try_from(text: String) -> Result<Self, NoTrail> {
        text.parse()
    }
}

/// A text that is not state hashes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("the text is not a hashes of an episode")]
pub struct NoTrail;

impl FromStr for StateHashes {
    type Err = NoTrail;

    fn from_str(text: &str) -> Result<Self, NoTrail> {
        let (stride, digits) = text.split_once(':').ok_or(NoTrail)?;
        let stride: u32 = stride.parse().map_err(|_| NoTrail)?;
        let length = digits.len() / 2;
        let hexadecimal = digits.bytes().all(|byte| byte.is_ascii_hexdigit());
        if !stride.is_power_of_two() || digits.len() % 2 == 1 || length > MAX_MARKS || !hexadecimal {
            return Err(NoTrail);
        }
        let decisions = stride.checked_mul(length as u32).ok_or(NoTrail)?;
        let mut hashes = Self { marks: [0; MAX_MARKS], length: length as u8, stride, decisions };
        for (place, mark) in hashes.marks[..length].iter_mut().enumerate() {
            *mark = u8::from_str_radix(&digits[2 * place..2 * place + 2], 16).map_err(|_| NoTrail)?;
        }
        Ok(hashes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The hashes of an episode of this number of decisions whose digests change from `from` on.
    fn hashes(decisions: u32, from: u32) -> StateHashes {
        let mut hashes = StateHashes::default();
        for decision in 1..=decisions {
            let other = u64::from(decision >= from);
            hashes.mark((u64::from(decision) * 2 + other).wrapping_mul(0x9e37_79b9_7f4a_7c15));
        }
        hashes
    }

    #[test]
    fn the_divergence_is_found_between_two_marks_whatever_the_lengths() {
        for decisions in [1, 5, 31, 32, 33, 64, 65, 200, 3000] {
            let whole = hashes(decisions, u32::MAX);
            let stride = decisions.div_ceil(MAX_MARKS as u32).next_power_of_two();
            assert!(whole.stride <= stride && whole.marks().len() as u32 == decisions / whole.stride, "{decisions}");
            assert_eq!(whole.divergence(&whole), None);
            for from in [1, 2, decisions / 2 + 1] {
                let Some((same, other)) = whole.divergence(&hashes(decisions, from)) else { continue };
                assert!(same < from && from <= other && other - same == whole.stride, "{decisions} {from}");
            }
            let longer = hashes(decisions + 40, decisions / 2 + 1);
            if let Some((same, other)) = whole.divergence(&longer) {
                assert!(same <= decisions / 2 && decisions / 2 < other, "{decisions}: {same}..{other}");
            }
        }
        assert_eq!(hashes(10, 4).divergence(&hashes(10, u32::MAX)), Some((3, 4)));
    }

    #[test]
    fn it_returns_from_its_text_and_damage_is_noticed() {
        for decisions in [0, 1, 30, 100] {
            let hashes = hashes(decisions, u32::MAX);
            let again: StateHashes = hashes.to_string().parse().unwrap();
            assert_eq!((again.to_string(), again.divergence(&hashes)), (hashes.to_string(), None));
        }
        for text in ["", "1", "1:a", "3:aa", "0:aa", "1:zz", "1:+a", &format!("1:{}", "00".repeat(33)), "é:aa", "1:é"]
        {
            assert_eq!(text.parse::<StateHashes>(), Err(NoTrail), "{text}");
        }
        assert!("2147483648:aaaa".parse::<StateHashes>().is_err(), "too many decisions to count");
    }
}

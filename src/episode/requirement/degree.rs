use std::fmt;
use std::str::FromStr;

use world::sim::time_of;

/// How far a requirement is from being violated, and what decides that.
///
/// Its text is `-0.25@31#0`: robustness, sample and part, and `~` at its end if the requirement never applied. The same bits are read from it.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(into = "String", try_from = "String")]
pub struct Degree {
    /// Its robustness: below 0, or −0, where it is violated. In SI units of its comparisons, or scaled if they have several dimensions. Infinite
    /// where conditions without degree decide, or nothing does.
    pub robustness: f64,
    /// The sample that decides: 0 at the start, then one for each tick.
    pub sample: u32,
    /// The comparison that decides, by its place among those of the requirement; `None` if a constant or an empty bound does.
    pub part: Option<u16>,
    /// Whether an antecedent of an `implies` of the requirement held in a sample; true of a requirement without one.
    pub applies: bool,
}

impl Degree {
    /// The degree of a constant.
    pub fn constant(truth: bool, sample: u32) -> Self {
        Self { robustness: if truth { f64::INFINITY } else { f64::NEG_INFINITY }, sample, part: None, applies: true }
    }

    /// Time of the sample that decides (s), for samples this time (s) apart.
    pub fn instant(&self, tick: f64) -> f64 {
        time_of(self.sample as usize, tick)
    }

    pub fn is_violated(&self) -> bool {
        self.robustness.is_sign_negative()
    }

    /// The lesser of two; of equal ones the first.
    pub(super) fn and(self, other: Self) -> Self {
        if other.robustness.total_cmp(&self.robustness).is_lt() { other } else { self }
    }

    /// The greater of two; of equal ones the first.
    pub(super) fn or(self, other: Self) -> Self {
        if other.robustness.total_cmp(&self.robustness).is_gt() { other } else { self }
    }
}

impl fmt::Display for Degree {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { robustness, sample, part, applies } = self;
        write!(f, "{robustness:?}@{sample}")?;
        part.map_or(Ok(()), |part| write!(f, "#{part}"))?;
        f.write_str(if *applies { "" } else { "~" })
    }
}

/// A text is not a degree.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("a degree is written as robustness@sample#part")]
pub struct NoDegree;

impl FromStr for Degree {
    type Err = NoDegree;

    fn from_str(text: &str) -> Result<Self, NoDegree> {
        let (text, applies) = text.strip_suffix('~').map_or((text, true), |text| (text, false));
        let (robustness, rest) = text.split_once('@').ok_or(NoDegree)?;
        let (sample, part) = rest.split_once('#').map_or((rest, None), |(sample, part)| (sample, Some(part)));
        Ok(Self {
            robustness: robustness.parse().map_err(|_| NoDegree)?,
            sample: sample.parse().map_err(|_| NoDegree)?,
            part: part.map(str::parse).transpose().map_err(|_| NoDegree)?,
            applies,
        })
    }
}

impl From<Degree> for String {
    fn from(degree: Degree) -> Self {
        degree.to_string()
    }
}

impl TryFrom<String> for Degree {
    type Error = NoDegree;

    fn try_from(text: String) -> Result<Self, NoDegree> {
        text.parse()
    }
}

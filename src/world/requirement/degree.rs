/// How far a requirement is from being violated, and what decides that.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Degree {
    /// Its robustness: below 0, or −0, where it is violated. In SI units of its comparisons, or scaled if they have several dimensions. Infinite
    /// where conditions without degree decide, or nothing does.
    pub robustness: f64,
    /// The sample that decides: 0 at the start, then one for each tick.
    pub sample: u32,
    /// The comparison that decides, by its place among those of the requirement; none where a constant or an empty bound does.
    pub part: Option<u16>,
}

impl Degree {
    /// The degree of a constant.
    pub fn constant(truth: bool, sample: u32) -> Self {
        Self { robustness: if truth { f64::INFINITY } else { f64::NEG_INFINITY }, sample, part: None }
    }

    pub fn is_violated(&self) -> bool {
        self.robustness.is_sign_negative()
    }

    /// The degree of the negation.
    pub(super) fn negated(self) -> Self {
        Self { robustness: -self.robustness, ..self }
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

use std::iter::Sum;
use std::ops::{Add, AddAssign, Sub};

/// A count of items with weights: their number, the sum of their weights and the sum of the squares.
///
/// A plain count has weights of 1. From it everything is calculated with the arithmetic of whole numbers, to the bit.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Weighted {
    n: u64,
    w: f64,
    w2: f64,
}

impl Weighted {
    /// Counts one more item, of this weight; not below 0.
    pub fn include(&mut self, weight: f64) {
        self.n += 1;
        self.w += weight;
        self.w2 += weight * weight;
    }

    /// The number of items.
    pub fn count(&self) -> u64 {
        self.n
    }

    /// The sum of their weights.
    pub fn sum(&self) -> f64 {
        self.w
    }

    /// The sum of the squares of their weights.
    pub fn squares(&self) -> f64 {
        self.w2
    }

    /// Whether all weights are 1. By Cauchy and Schwarz n Σw² is at least (Σw)², and equal only where all weights are equal.
    pub fn is_plain(&self) -> bool {
        let n = self.n as f64;
        self.w == n && self.w2 == n
    }

    /// The number of items of equal weight with the same precision of a mean, (Σw)² / Σw²; 0 without any weight.
    ///
    /// # Source
    /// Kish, *Survey Sampling*, 1965, section 11.7.
    pub fn effective_size(&self) -> f64 {
        match self.w2 {
            _ if self.is_plain() => self.w,
            0.0 => 0.0,
            squares => self.w * self.w / squares,
        }
    }

    /// The same items in clusters of this size, which say no more than one item of each: as the runs of a cell, which share their starts. Its effective
    /// size is the number of clusters. That is exact where all items of a cluster are equal, and else on the safe side.
    ///
    /// # Source
    /// Kish, *Survey Sampling*, 1965, section 5.4: the design effect 1 + (size − 1) ρ, at its maximum, ρ = 1.
    #[must_use]
    pub fn of_clusters(self, size: f64) -> Self {
        Self { w2: self.w2 * size, ..self }
    }

    /// This part as a share of the whole; `None` if the whole has no weight.
    pub fn share_of(&self, whole: &Self) -> Option<f64> {
        (whole.w > 0.0).then(|| self.w / whole.w)
    }
}

/// A plain count.
impl From<u64> for Weighted {
    fn from(n: u64) -> Self {
        Self { n, w: n as f64, w2: n as f64 }
    }
}

impl Add for Weighted {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self { n: self.n + other.n, w: self.w + other.w, w2: self.w2 + other.w2 }
    }
}

impl AddAssign for Weighted {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

/// The remainder without a part.
impl Sub for Weighted {
    type Output = Self;

    fn sub(self, part: Self) -> Self {
        Self { n: self.n - part.n, w: self.w - part.w, w2: self.w2 - part.w2 }
    }
}

impl Sum for Weighted {
    fn sum<I: Iterator<Item = Self>>(all: I) -> Self {
        all.fold(Self::default(), Add::add)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn things_of_weight_1_are_a_plain_count() {
        let mut counted = Weighted::default();
        (0..1_000).for_each(|_| counted.include(1.0));
        assert_eq!(counted, Weighted::from(1_000));
        assert_eq!(counted - 400.into() + 7.into(), Weighted::from(607));
        assert!(counted.is_plain() && counted.effective_size() == 1_000.0);
    }

    #[test]
    fn unequal_weights_say_less_than_equal_ones() {
        let mut counted = Weighted::default();
        // Weights 2, 0 and 1 have the sum of three plain ones.
        [2.0, 0.0, 1.0].iter().for_each(|weight| counted.include(*weight));
        assert_eq!((counted.count(), counted.sum(), counted.squares()), (3, 3.0, 5.0));
        assert!(!counted.is_plain() && counted.effective_size() == 9.0 / 5.0);
        let mut halves = Weighted::default();
        (0..8).for_each(|_| halves.include(0.5));
        assert_eq!((halves.is_plain(), halves.effective_size()), (false, 8.0));
        assert_eq!(Weighted::default().effective_size(), 0.0);
        assert_eq!(Weighted::default().share_of(&Weighted::default()), None);
    }
}

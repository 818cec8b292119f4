use std::iter::Sum;
use std::ops::{Add, AddAssign, Sub};

/// A number of items, some of which may be in clusters that say no more than one item of each.
///
/// A plain count is calculated with the arithmetic of whole numbers, to the bit.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ClusteredCount {
    n: u64,
    /// The number times the size of a cluster.
    squares: f64,
}

impl ClusteredCount {
    /// The number of items.
    pub fn count(&self) -> u64 {
        self.n
    }

    /// The number of items as a number of any size.
    pub fn sum(&self) -> f64 {
        self.n as f64
    }

    /// The number times the size of a cluster: the sum of squares of the Kish design effect.
    pub(super) fn squares(&self) -> f64 {
        self.squares
    }

    /// Whether a cluster is a single item.
    pub(super) fn is_plain(&self) -> bool {
        self.squares == self.sum()
    }

    /// The number of plain items with the same precision of a mean: the effective sample size; 0 without any item.
    pub fn effective_size(&self) -> f64 {
        match self.squares {
            _ if self.is_plain() => self.sum(),
            0.0 => 0.0,
            squares => self.sum() * self.sum() / squares,
        }
    }

    /// The same items in clusters of this size, as the runs of a cell, which share their starts. The effective size is the number of
    /// clusters. That is exact where all items of a cluster are equal, and else on the safe side.
    ///
    /// # Source
    /// Kish, *Survey Sampling*, 1965, section 5.4: the design effect 1 + (size − 1) ρ, at its maximum, ρ = 1.
    #[must_use]
    pub fn of_clusters(self, size: f64) -> Self {
        Self { squares: self.squares * size, ..self }
    }

    /// This part as a share of the whole; `None` if the whole is empty.
    pub fn share_of(&self, whole: &Self) -> Option<f64> {
        (whole.n > 0).then(|| self.sum() / whole.sum())
    }
}

/// A plain count.
impl From<u64> for ClusteredCount {
    fn from(n: u64) -> Self {
        Self { n, squares: n as f64 }
    }
}

impl Add for ClusteredCount {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self { n: self.n + other.n, squares: self.squares + other.squares }
    }
}

impl AddAssign for ClusteredCount {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

/// The remainder without a part.
impl Sub for ClusteredCount {
    type Output = Self;

    fn sub(self, part: Self) -> Self {
        Self { n: self.n - part.n, squares: self.squares - part.squares }
    }
}

impl Sum for ClusteredCount {
    fn sum<I: Iterator<Item = Self>>(all: I) -> Self {
        all.fold(Self::default(), Add::add)
    }
}

use super::{Events, Lot};

/// Where encounters happen: a simulator, or anything else that turns a [`Lot`] into an encounter.
///
/// An encounter is a row of decisions. It fails if its level reaches 0, and only then.
pub trait TestBed {
    /// A copy of the present state of an encounter.
    type Mark;

    /// Starts an encounter; none of its decisions has been taken.
    fn begin(&mut self, lot: &mut Lot);

    /// Takes a decision, and returns whether more follow.
    fn step(&mut self, lot: &mut Lot) -> bool;

    /// The greatest level of the encounter up to now: how near it came to a failure, 0 for a failure.
    fn level(&self) -> f64;

    /// The result of an encounter that is over.
    fn trial(&mut self) -> Trial;

    /// A copy of the present state; none where it cannot be copied. Then encounters are repeated from their start.
    fn mark(&self) -> Option<Self::Mark>;

    /// Returns to a state, from which an encounter of this lot goes on with its next decision. The lot agrees with the mark's up to there.
    fn restore(&mut self, mark: &Self::Mark, lot: &mut Lot);

    /// Repeats the encounter of a lot and judges it.
    fn judge(&mut self, lot: &mut Lot) -> Events;

    /// Ticks that were simulated since it was made.
    fn ticks(&self) -> u64;
}

/// The result of an encounter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trial {
    /// Its greatest level.
    pub level: f64,
    /// Whether it counts. The driver may be lost before a pedestrian had any part in it.
    pub counts: bool,
}

impl Trial {
    /// Whether it is a failure that counts.
    pub fn fails(&self) -> bool {
        self.counts && self.level >= 0.0
    }

    /// The level, the least for an encounter that does not count.
    pub fn height(&self) -> f64 {
        if self.counts { self.level } else { f64::NEG_INFINITY }
    }
}

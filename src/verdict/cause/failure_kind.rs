use std::fmt;

use crate::{Blame, Judged};
use episode::{Criterion, Impact};
use world::av::DrivingMode;

/// What makes two failures of a driver the same: what failed, whose fault it is, and how they met.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FailureKind {
    pub criterion: Criterion,
    /// Whether it is a failure, a preventable one, and a fault: in the order of [`Blame`].
    blames: [bool; Blame::COUNT],
    /// The side of the car that was hit; `None` of a violation.
    impact: Option<Impact>,
    /// Whether the pedestrian came into sight too late for a careful human; false of a violation.
    occluded: bool,
    /// What the driver did at the touch; `None` of a violation.
    mode: Option<DrivingMode>,
}

impl FailureKind {
    /// That of an episode; `None` if it is not a failure by the criterion, or does not count.
    pub fn new(criterion: Criterion, judged: &Judged) -> Option<Self> {
        let Judged { outcome, verdict, .. } = judged;
        let blames = judged.blames(criterion);
        if !blames[0] || !outcome.counts() {
            return None;
        }
        let is_touch = criterion == Criterion::Collision;
        Some(Self {
            criterion,
            blames,
            impact: Impact::of(outcome).filter(|_| is_touch),
            occluded: is_touch && verdict.is_some_and(|verdict| verdict.sight.is_occluded()),
            mode: is_touch.then_some(outcome.last_mode),
        })
    }

    /// Whether another failure is the same, or the same and worse: one that counts more against the driver.
    pub fn is_kept_by(&self, other: &Self) -> bool {
        let blames = self.blames.iter().zip(&other.blames).all(|(before, now)| *now || !before);
        blames && Self { blames: self.blames, ..*other } == *self
    }
}

/// Words it as `fault, front, cruise`.
impl fmt::Display for FailureKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let blame = Blame::ALL.into_iter().zip(self.blames).rfind(|(_, holds)| *holds);
        f.write_str(blame.map_or(Blame::Any, |(blame, _)| blame).name())?;
        let impact = self.impact.map(|impact| impact.name().to_string());
        let occluded = self.occluded.then(|| "occluded".to_string());
        let mode = self.mode.filter(|mode| *mode != DrivingMode::Unknown).map(|mode| mode.name().replace('_', " "));
        [impact, occluded, mode].into_iter().flatten().try_for_each(|word| write!(f, ", {word}"))
    }
}

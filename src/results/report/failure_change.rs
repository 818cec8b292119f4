//! What changed between two drivers: one list, for comparisons and for rechecks.

use std::cmp::Reverse;

use serde::Serialize;

use crate::failure::{Failure, FailureClass};

/// A start from which at least one of two drivers has a collision.
#[derive(Debug, Clone)]
pub struct FailureChange {
    /// The drivers, the town and what moves the pedestrian.
    pub place: String,
    /// How it ends for the driver before and for the driver after.
    pub sides: [SideEnd; 2],
}

/// The end of an episode of one driver.
#[derive(Debug, Clone, Default, Serialize)]
pub struct SideEnd {
    /// Its name in its report, `RUN:EPISODE`, or the start and the crossing of an episode that no report has.
    pub name: String,
    /// Its collision, if it ends in one.
    pub collision: Option<SideCollision>,
    /// Whether the pedestrian would miss the driver even if that saw nobody.
    #[serde(skip)]
    pub is_missed: bool,
}

/// A collision of one driver.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SideCollision {
    #[serde(skip)]
    pub class: FailureClass,
    /// The verdict in a word.
    pub verdict: &'static str,
    pub fault: bool,
    /// Its kind without the verdict; empty if it is not known.
    pub kind: String,
    #[serde(rename = "impact_speed_mps")]
    pub impact_speed: f64,
}

impl From<&Failure> for SideCollision {
    fn from(failure: &Failure) -> Self {
        Self {
            class: failure.class(),
            verdict: failure.word(),
            fault: failure.fault,
            kind: failure.kind(),
            impact_speed: failure.impact_speed,
        }
    }
}

impl SideCollision {
    /// The difference of impact speeds from which on one is clearly faster (m/s).
    const CLEARLY_FASTER: f64 = 1.0;

    /// Whether it counts more against its driver than a collision of another driver from the same start: it is clearly faster, or the only fault of the two,
    /// or faster and therefore no fault. Either may be worse in its own way.
    pub fn is_worse_than(&self, other: &Self) -> bool {
        let faster = self.impact_speed - other.impact_speed;
        faster >= Self::CLEARLY_FASTER || self.fault && !other.fault || other.fault && !self.fault && faster > 0.0
    }
}

impl SideEnd {
    /// The end of an episode in a report.
    pub fn of_report(name: String, failure: Option<&Failure>) -> Self {
        Self { name, collision: failure.map(SideCollision::from), is_missed: false }
    }
}

impl FailureChange {
    /// The words of changes: those that count against the second driver first.
    ///
    /// `new` and `fixed` are collisions of one driver, and so is `not met`, of which nothing is known with the other. `worse` and `better` are collisions of
    /// both, see [`SideCollision::is_worse_than`]; one that is worse on both sides is `worse`.
    pub const WORDS: [&'static str; 6] = ["new", "worse", "fixed", "better", "not met", "same"];

    /// One of [`FailureChange::WORDS`].
    pub fn word(&self) -> &'static str {
        match self.sides.each_ref().map(|side| side.collision.as_ref()) {
            [Some(_), None] if self.sides[1].is_missed => "not met",
            [Some(_), None] => "fixed",
            [None, Some(_)] => "new",
            [Some(before), Some(after)] if after.is_worse_than(before) => "worse",
            [Some(before), Some(after)] if before.is_worse_than(after) => "better",
            _ => "same",
        }
    }

    /// Whether a collision of both is faster after, and its verdict milder: fewer drivers avoid it.
    pub fn is_faster_and_milder(&self) -> bool {
        let [before, after] = self.sides.each_ref().map(|side| side.collision.as_ref());
        before.zip(after).is_some_and(|(one, other)| one.class < other.class && one.impact_speed < other.impact_speed)
    }

    /// The verdict, or both if they differ: `unpreventable → fault`.
    pub fn verdict(&self) -> String {
        match self.sides.each_ref().map(|side| side.collision.as_ref()) {
            [Some(before), Some(after)] if before.verdict != after.verdict => {
                format!("{} → {}", before.verdict, after.verdict)
            }
            _ => self.collision().verdict.to_owned(),
        }
    }

    /// The collision that describes it: that of the second driver, or of the first where it is fixed.
    pub fn collision(&self) -> &SideCollision {
        let [before, after] = &self.sides;
        after.collision.as_ref().or(before.collision.as_ref()).expect("one side has a collision")
    }

    /// The changes of a word, those that count most against the driver first.
    pub fn of_word<'a>(changes: &'a [Self], word: &str) -> Vec<&'a Self> {
        let mut found: Vec<&Self> = changes.iter().filter(|change| change.word() == word).collect();
        found.sort_by(|a, b| {
            let order = |change: &Self| (change.collision().class, Reverse(change.collision().impact_speed.to_bits()));
            order(a).cmp(&order(b))
        });
        found
    }

    /// The worst new and worse changes, then the worst fixed and better ones, at most this number; those against the second driver take at least
    /// half if there are that many.
    pub fn worst(changes: &[Self], most: usize) -> Vec<&Self> {
        let of = |words: [&str; 2]| words.into_iter().flat_map(|word| Self::of_word(changes, word)).collect::<Vec<_>>();
        let (new, fixed) = (of(["new", "worse"]), of(["fixed", "better"]));
        let of_fixed = fixed.len().min(most / 2).max(most.saturating_sub(new.len()).min(fixed.len()));
        new.into_iter().take(most - of_fixed).chain(fixed.into_iter().take(of_fixed)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::failure::tests::failure;
    use verdict::Label;

    #[test]
    fn a_collision_of_both_sides_that_is_faster_or_a_fault_on_one_is_not_the_same() {
        let side = |what: Option<(Label, bool, f64)>| {
            let failure = what.map(|(verdict, fault, speed)| failure(Some(verdict), fault, speed));
            SideEnd::of_report("1a2b3c4d:0".into(), failure.as_ref())
        };
        let (fault, spared) = (Some((Label::Preventable, true, 1.0)), Some((Label::Unpreventable, false, 1.0)));
        let narrow = Some((Label::Preventable, false, 1.0));
        let contested = |speed| Some((Label::Contested, false, speed));
        for (before, after, word, verdict) in [
            (None, fault, "new", "fault"),
            (spared, None, "fixed", "unpreventable"),
            (spared, fault, "worse", "unpreventable → fault"),
            (fault, narrow, "better", "fault → preventable"),
            (spared, narrow, "same", "unpreventable → preventable"),
            (fault, fault, "same", "fault"),
            (contested(0.7), contested(1.6), "same", "contested"),
            (contested(0.7), contested(6.3), "worse", "contested"),
            (contested(6.3), contested(0.7), "better", "contested"),
            // A collision that leaves less time is no fault any more.
            (narrow, contested(6.3), "worse", "preventable → contested"),
            (fault, contested(6.3), "worse", "fault → contested"),
            (fault, contested(1.1), "worse", "fault → contested"),
            (fault, contested(0.9), "better", "fault → contested"),
            (contested(6.3), fault, "worse", "contested → fault"),
        ] {
            let change = FailureChange { place: String::new(), sides: [side(before), side(after)] };
            assert_eq!((change.word(), change.verdict().as_str()), (word, verdict));
            let is_harder = before.zip(after).is_some_and(|(one, other)| one.2 < other.2 && one.0 != other.0);
            assert_eq!(change.is_faster_and_milder(), is_harder, "{verdict}");
            assert!(FailureChange::WORDS.contains(&word));
        }
    }
}

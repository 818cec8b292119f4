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
    /// both that are a fault of one.
    pub const WORDS: [&'static str; 6] = ["new", "worse", "fixed", "better", "not met", "same"];

    /// One of [`FailureChange::WORDS`].
    pub fn word(&self) -> &'static str {
        match self.sides.each_ref().map(|side| side.collision.as_ref()) {
            [Some(_), None] if self.sides[1].is_missed => "not met",
            [Some(_), None] => "fixed",
            [None, Some(_)] => "new",
            [Some(before), Some(after)] if after.fault && !before.fault => "worse",
            [Some(before), Some(after)] if before.fault && !after.fault => "better",
            _ => "same",
        }
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
    use world::judge::Label;

    #[test]
    fn a_collision_of_both_sides_that_is_a_fault_on_one_is_not_the_same() {
        let side = |what: Option<(Label, bool)>| {
            let failure = what.map(|(verdict, fault)| failure(Some(verdict), fault, 1.0));
            SideEnd::of_report("1a2b3c4d:0".into(), failure.as_ref())
        };
        let (fault, spared) = (Some((Label::Preventable, true)), Some((Label::Unpreventable, false)));
        let narrow = Some((Label::Preventable, false));
        for (before, after, word, verdict) in [
            (None, fault, "new", "fault"),
            (spared, None, "fixed", "unpreventable"),
            (spared, fault, "worse", "unpreventable → fault"),
            (fault, narrow, "better", "fault → preventable"),
            (spared, narrow, "same", "unpreventable → preventable"),
            (fault, fault, "same", "fault"),
        ] {
            let change = FailureChange { place: String::new(), sides: [side(before), side(after)] };
            assert_eq!((change.word(), change.verdict().as_str()), (word, verdict));
            assert!(FailureChange::WORDS.contains(&word));
        }
    }
}

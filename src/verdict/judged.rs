use super::{Verdict, ViolationVerdict, judge};
use base::choice;
use episode::requirement::Degree;
use episode::{Criterion, Outcome, Pair};

choice! {
    /// Which failures are meant.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
    pub enum Blame {
        /// Any failure.
        Any = "failure",
        /// One that a careful human would have avoided.
        Preventable = "preventable",
        /// One that counts against the driver.
        Fault = "fault",
    }
}

impl Blame {
    /// The number of variants.
    pub const COUNT: usize = 3;
}

/// The degree of a requirement in an episode, and whose fault its violation is.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct JudgedDegree {
    pub degree: Degree,
    /// `None` if the requirement is satisfied, has no verdict, or none was asked for.
    pub verdict: Option<ViolationVerdict>,
}

/// An episode with what its judges say of it.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Judged {
    pub outcome: Outcome,
    /// The verdict on its touch; `None` without a touch, or if none was asked for.
    pub verdict: Option<Verdict>,
    /// The degree of each requirement of the scenario; empty if a program failed.
    pub degrees: Vec<JudgedDegree>,
}

impl Judged {
    /// Judges the touch and all violations of an episode.
    pub fn new(outcome: &Outcome, pair: &Pair<'_>) -> Self {
        Self::of(outcome, pair, true, |_| true)
    }

    /// Judges what a criterion asks about.
    pub fn by(criterion: Criterion, outcome: &Outcome, pair: &Pair<'_>) -> Self {
        let is_asked = criterion.requirement().is_some() || outcome.is_collision();
        Self::of(outcome, pair, is_asked, |place| criterion.requirement() == Some(place))
    }

    fn of(outcome: &Outcome, pair: &Pair<'_>, touch: bool, is_asked: impl Fn(usize) -> bool) -> Self {
        let named = pair.scenario.requirements.iter();
        let judged = |(place, (named, degree)): (usize, (&episode::requirement::NamedRequirement, &Degree))| {
            let asked = is_asked(place).then(|| ViolationVerdict::new(pair, &named.requirement, degree));
            JudgedDegree { degree: *degree, verdict: asked.flatten() }
        };
        let degrees = named.zip(pair.degrees()).enumerate().map(judged).collect();
        Self { outcome: *outcome, verdict: touch.then(|| judge(pair)).flatten(), degrees }
    }

    /// Whether it is a failure by a criterion, and of this kind.
    pub fn is(&self, criterion: Criterion, blame: Blame) -> bool {
        let [any, preventable, fault] = self.blames(criterion);
        match blame {
            Blame::Any => any,
            Blame::Preventable => preventable,
            Blame::Fault => fault,
        }
    }

    /// Whether it is a failure by a criterion, a preventable one, and a fault: in the order of [`Blame`].
    pub fn blames(&self, criterion: Criterion) -> [bool; Blame::COUNT] {
        match criterion {
            Criterion::Collision => {
                let verdict = self.verdict.as_ref().filter(|_| self.outcome.is_collision());
                let (preventable, fault) =
                    verdict.map_or((false, false), |verdict| (verdict.is_preventable(), verdict.is_fault()));
                [self.outcome.is_collision(), preventable, fault]
            }
            Criterion::Violation(place) => {
                let violated = self.degrees.get(place).filter(|judged| judged.degree.is_violated());
                let verdict = violated.and_then(|judged| judged.verdict);
                let (preventable, fault) =
                    verdict.map_or((false, false), |verdict| (verdict.preventable, verdict.fault));
                [violated.is_some(), preventable, fault]
            }
        }
    }
}

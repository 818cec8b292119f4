use super::{Label, Reference, judge};
use crate::env::{Judgement, Pair, TestOracle};

/// The verdict of the reference drivers as a test oracle for rewards.
#[derive(Debug, Clone, Copy, Default)]
pub struct ReferenceOracle;

impl TestOracle for ReferenceOracle {
    fn judge(&self, pair: &Pair<'_>) -> Judgement {
        let Some(verdict) = judge(pair) else { return Judgement::default() };
        let preventable = verdict.label == Label::Preventable;
        Judgement {
            preventable,
            foreseeable: verdict.foreseeable,
            preventability: if preventable { 1.0 } else { 0.0 },
            avoidable_speed: verdict.reduction(Reference::CarefulHuman),
            margin: verdict.trial(Reference::CarefulHuman).least_gap,
            warning: verdict.warning,
            seen: verdict.sight.seen,
        }
    }
}

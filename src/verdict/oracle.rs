use super::{Inquiry, Reference, Sight};
use episode::{Judgement, Pair, TestOracle};

/// The verdict of the reference drivers as a test oracle for rewards.
#[derive(Debug, Clone, Copy, Default)]
pub struct ReferenceOracle;

impl TestOracle for ReferenceOracle {
    fn judge(&self, pair: &Pair<'_>) -> Judgement {
        let Some(mut inquiry) = Inquiry::new(pair) else { return Judgement::default() };
        let human = inquiry.trial(Reference::CarefulHuman);
        Judgement {
            preventable: inquiry.is_preventable(),
            fault: inquiry.class().is_fault(),
            preventability: inquiry.preventable_probability(),
            avoidable_speed: inquiry.reduction(Reference::CarefulHuman),
            margin: human.least_gap,
            warning: inquiry.encounter().warning,
            seen: Sight::new(pair).seen,
        }
    }
}

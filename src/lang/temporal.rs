//! The operators of requirements.

use base::choice;

choice! {
    /// An operator of requirements, in a call.
    #[derive(Clone, Copy)]
    pub enum Word {
        Always = "always",
        Eventually = "eventually",
        Until = "until",
        Scaled = "scaled",
    }
}

const MEANINGS: [&str; Word::ALL.len()] = [
    "always(a), always(a, [0 s, 2 s]): a is true at all samples from now to the end, or within the bound.",
    "eventually(a), eventually(a, [0 s, 2 s]): a is true at one sample from now to the end, or within the bound.",
    "until(a, b), until(a, b, [0 s, 2 s]): b is true at one sample from now on, or within the bound, and a at all samples before that one.",
    "scaled(a < b, 0.5 m): the comparison, of which 0.5 m count as 1 where a requirement compares quantities of different dimensions.",
];

/// The operators of requirements, in calls, and what they mean.
pub fn temporal_operators() -> impl Iterator<Item = (&'static str, &'static str)> {
    Word::ALL.map(Word::name).into_iter().zip(MEANINGS)
}

/// Whether requirements have an operator of this name.
pub(super) fn is_temporal(name: &str) -> bool {
    Word::named(name).is_some()
}

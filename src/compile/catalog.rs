use super::falsifier::FalsifierKind;
use super::policy::PolicyKind;
use super::{adversary, campaign, episode, falsifier, policy, reward, spawn, town, training, vehicle};
use crate::signature::{Form, Vocabulary};

/// Everything the language offers: forms, their kinds, and what formulas may speak about.
pub struct Catalog {
    /// The forms, in the order of the reference.
    pub forms: Vec<Form>,
    /// Variables and events.
    pub vocabulary: Vocabulary,
    pub(super) policies: Vec<PolicyKind>,
    pub(super) falsifiers: Vec<FalsifierKind>,
}

impl Catalog {
    /// What this program offers.
    pub fn builtin() -> Self {
        let policies = policy::kinds();
        let falsifiers = falsifier::kinds();
        let forms = vec![
            town::form(),
            policy::form(&policies),
            vehicle::form(),
            adversary::form(),
            spawn::form(),
            reward::form(),
            episode::form(),
            training::form(),
            falsifier::form(&falsifiers),
            campaign::form(),
        ];
        Self { forms, vocabulary: crate::env::vocabulary(), policies, falsifiers }
    }
}

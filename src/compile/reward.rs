use crate::env::RewardRule;
use crate::lang::hir::Clause;
use crate::signature::{Form, Signature};

/// The form `reward`.
pub fn form() -> Form {
    Form {
        name: "reward",
        doc: "What the pedestrian is paid for: `on event => formula`, a plain number each. \
              An event without a clause is worth nothing.",
        plain: Some(Signature { clauses: true, ..Signature::new("reward", "", Vec::new()) }),
        multiplies: false,
        kinds: Vec::new(),
    }
}

/// The rule. A clause for `hit` without a word holds for every zone that has no clause of its own.
pub fn lower(clauses: &[Clause]) -> RewardRule {
    let find = |event: &str, word: Option<&str>| {
        let found = clauses.iter().find(|clause| clause.event == event && clause.word == word);
        found.map(|clause| clause.formula.clone())
    };
    RewardRule {
        hit_front: find("hit", Some("front")).or_else(|| find("hit", None)),
        hit_other: find("hit", Some("other")).or_else(|| find("hit", None)),
        step: find("step", None),
        lost: find("lost", None),
        timeout: find("timeout", None),
    }
}

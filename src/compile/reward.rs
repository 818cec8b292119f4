use base::keys;
use base::signature::{Form, Formula, Keys, Signature};
use lang::hir::Block;
use world::env::{HitClass, RewardRule};

keys! {
    /// What the pedestrian is paid for: `on event => formula`, a plain number each. An event without a clause is worth nothing.
    pub struct RewardKeys = "reward" {
        /// Potential Φ of a state, by which a learner finds its way: a decision earns it γ Φ(after) − Φ(before) more, and Φ is 0
        /// once the episode has ended. Shifts what is optimal nowhere; every reward in reports is without it.
        potential: Option<Formula> as Formula("step"),
    }
}

/// The form `reward`.
pub fn form() -> Form {
    Form::plain(Signature { clauses: true, ..RewardKeys::signature() })
}

pub fn lower(block: &Block) -> RewardRule {
    let find = |event: &str, word: Option<&str>| {
        let found = block.clauses.iter().find(|clause| clause.event == event && clause.word == word);
        found.map(|clause| clause.formula.clone())
    };
    RewardRule {
        hit: HitClass::ALL.map(|class| find("hit", class.word())),
        step: find("step", None),
        lost: find("lost", None),
        timeout: find("timeout", None),
        potential: block.keys::<RewardKeys>().potential,
    }
}

use base::signature::{Form, Param, Signature, Type};
use lang::hir::Block;
use world::env::{HitClass, RewardRule};

/// The form `reward`.
pub fn form() -> Form {
    Form {
        name: "reward",
        doc: "What the pedestrian is paid for: `on event => formula`, a plain number each. \
              An event without a clause is worth nothing.",
        plain: Some(Signature { clauses: true, ..Signature::new("reward", "", vec![potential()]) }),
        multiplies: false,
        kinds: Vec::new(),
    }
}

fn potential() -> Param {
    Param::optional(
        "potential",
        Type::Formula("step"),
        "Potential Φ of a state, by which a learner finds its way: a decision earns it γ Φ(after) − Φ(before) more, and Φ is 0 once \
         the episode has ended. Shifts what is optimal nowhere; every reward in reports is without it.",
    )
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
        potential: block.arguments.condition("potential").cloned(),
    }
}

use super::requirement;
use base::keys;
use base::signature::{DeclarationId, Form, Formula, Keys, Signature};
use episode::{HitClass, RewardRule, robustness, robustness_of};
use lang::hir::{Block, Declaration};

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

/// Makes the rule of a reward; `find` gives the declaration of a requirement that it names.
pub fn lower<'a>(block: &Block, find: impl Fn(DeclarationId) -> &'a Declaration) -> RewardRule {
    let mut named: Vec<DeclarationId> = Vec::new();
    let mut place = |id: DeclarationId| {
        named.iter().position(|known| *known == id).unwrap_or_else(|| {
            named.push(id);
            named.len() - 1
        })
    };
    let violated = block.clauses.iter().filter_map(|clause| Some((clause.subject?, &clause.formula)));
    let violated: Vec<(usize, Formula)> =
        violated.map(|(subject, formula)| (place(subject), placed(formula, &mut place))).collect();
    let mut clause = |event: &str, word: Option<&str>| {
        let found = block.clauses.iter().find(|clause| clause.event == event && clause.word == word);
        found.map(|clause| placed(&clause.formula, &mut place))
    };
    let hit = HitClass::ALL.map(|class| clause("touch", class.word()));
    let [step, lost, timeout] = ["step", "lost", "timeout"].map(|event| clause(event, None));
    let potential = block.keys::<RewardKeys>().potential.map(|formula| placed(&formula, &mut place));
    let requirements = named.into_iter().map(|id| requirement::named(find(id))).collect();
    RewardRule { hit, step, lost, timeout, potential, requirements, violated }
}

/// A formula in which the robustness of a requirement is named by its place among those of the reward, and not by its declaration.
fn placed(formula: &Formula, place: &mut impl FnMut(DeclarationId) -> usize) -> Formula {
    formula.substituted(&mut |id| match robustness_of(id) {
        Some(declaration) => vec![robustness(place(DeclarationId(declaration)))],
        None => vec![id],
    })
}

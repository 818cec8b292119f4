use std::sync::Arc;

use super::lowering::Lowering;
use base::diagnostic::Span;
use base::keys;
use base::signature::{DeclarationId, Form, Keys, Requirement, Temporal, Within, short};
use episode::EpisodeRule;
use episode::requirement::{NamedRequirement, ticks_within};
use lang::diagnostics;
use lang::hir::{Block, Declaration};

keys! {
    /// What must be true of an episode, in temporal logic: `requirement name = always(gap < 1 m implies ego_speed < 3 m/s)`. An episode that violates
    /// it is a failure of its own, beside collisions. `always`, `eventually` and `until` may have a bound, `[0 s, 2 s]`; `not`, `and`, `or` and
    /// `implies` join conditions.
    pub struct RequirementKeys = "requirement" {
        /// The condition; it is written after the name: `requirement name = always(…) { priority: 2 }`.
        formula: Arc<Requirement> as Requirement("tick"),
        /// Its rank among the requirements of a campaign: 1 is the most important.
        priority: u32 as whole(1, 1000) = "1",
    }
}

/// The form `requirement`.
pub fn form() -> Form {
    Form::plain(RequirementKeys::signature())
}

pub fn named(declaration: &Declaration) -> NamedRequirement {
    let RequirementKeys { formula: requirement, priority } = declaration.block.keys();
    NamedRequirement { name: declaration.name.as_str().into(), priority, requirement }
}

impl Lowering<'_> {
    /// The requirements that a key of a block names, after checks that need the episode.
    pub(super) fn requirements(
        &mut self,
        block: &Block,
        key: &str,
        ids: &[DeclarationId],
        rule: &EpisodeRule,
    ) -> Vec<NamedRequirement> {
        let all: Vec<NamedRequirement> = ids.iter().map(|id| named(self.program.get(*id))).collect();
        let places = block.members(key);
        let place = |index: usize| places.get(index).copied().unwrap_or_else(|| block.place(key));
        for (index, (each, id)) in all.iter().zip(ids).enumerate() {
            let formula = self.program.get(*id).block.place("formula");
            self.compare_bounds(place(index), formula, each, rule);
        }
        all
    }

    /// Reports bounds that lie beyond the end of the episode, or between two ticks.
    fn compare_bounds(&mut self, place: Span, formula: Span, each: &NamedRequirement, rule: &EpisodeRule) {
        let length = rule.tick * f64::from(rule.ticks);
        let mut all = Vec::new();
        bounds_of(&each.requirement.formula, 0.0, &mut all);
        for (within, before) in all {
            let text = format!("[{} s, {} s]", short(within.from), short(within.to));
            let (first, last) = ticks_within(&within, rule.tick);
            let end = if within.to.is_finite() { within.to } else { within.from };
            if last.is_some_and(|last| last < first) {
                self.said.push(diagnostics::bound_between_ticks(place, formula, &each.name, &text, rule.tick));
            } else if before + end > length * (1.0 + 1e-9) {
                self.said.push(diagnostics::bound_too_long(place, formula, &each.name, before + end, length));
            }
        }
    }
}

/// The bounds of a formula, each with the time that those around it reach (s).
fn bounds_of(formula: &Temporal, before: f64, all: &mut Vec<(Within, f64)>) {
    let mut visit = |within: &Within, inner: &[&Temporal]| {
        if *within != Within::EPISODE {
            all.push((*within, before));
        }
        let end = if within.to.is_finite() { within.to } else { within.from };
        inner.iter().for_each(|inner| bounds_of(inner, before + end, all));
    };
    match formula {
        Temporal::Constant(_) | Temporal::Part(_) => {}
        Temporal::Not(inner) => bounds_of(inner, before, all),
        Temporal::And(a, b) | Temporal::Or(a, b) => {
            bounds_of(a, before, all);
            bounds_of(b, before, all);
        }
        Temporal::Always(within, inner) | Temporal::Eventually(within, inner) => visit(within, &[inner]),
        Temporal::Until(within, a, b) => visit(within, &[a, b]),
    }
}

use std::sync::Arc;

use super::lowering::Lowering;
use base::diagnostic::Span;
use base::keys;
use base::signature::{
    Bounds, Comparison, DeclarationId, Form, Formula, Keys, Requirement, Temporal, VariableId, Within, short,
};
use lang::diagnostics;
use lang::hir::{Block, Declaration};
use world::env::EpisodeRule;
use world::requirement::{NamedRequirement, ticks_within};

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

/// The requirement of a declaration.
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
        self.forbid_contradictions(&all, place);
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

    /// Reports two requirements of which the bounds of one quantity show that no episode satisfies both.
    fn forbid_contradictions(&mut self, all: &[NamedRequirement], place: impl Fn(usize) -> Span) {
        let demands: Vec<Vec<Demand>> = all
            .iter()
            .map(|each| {
                let mut found = Vec::new();
                demands(&each.requirement.formula, &each.requirement.parts, Times::Start, &mut found);
                found
            })
            .collect();
        for (second, theirs) in demands.iter().enumerate() {
            for (first, ours) in demands[..second].iter().enumerate() {
                let clash = |a: &Demand, b: &Demand| a.quantity == b.quantity && a.times.meet(b.times) && a.is_apart(b);
                let found = theirs.iter().find_map(|b| ours.iter().find(|a| clash(a, b)).map(|a| (a, b)));
                if let Some((a, b)) = found {
                    let names = (&*all[first].name, &*all[second].name);
                    self.said.push(diagnostics::requirements_clash(
                        place(second),
                        place(first),
                        names,
                        (a.text, b.text),
                    ));
                }
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

/// When a demand must be met.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Times {
    /// At the start.
    Start,
    /// At all samples.
    All,
    /// At one sample.
    One,
}

impl Times {
    /// Whether there is a sample at which both demands must be met.
    fn meet(self, other: Self) -> bool {
        self == Self::All || other == Self::All || (self, other) == (Self::Start, Self::Start)
    }
}

/// What a requirement demands of one quantity.
struct Demand<'a> {
    quantity: &'a Formula,
    /// The values that it may have, ends included or not.
    values: Bounds,
    strict: bool,
    times: Times,
    text: &'a str,
}

impl Demand<'_> {
    /// Whether no value meets both.
    fn is_apart(&self, other: &Self) -> bool {
        let ((a, b), (c, d)) = (self.values, other.values);
        let touches = b == c || d == a;
        b < c || d < a || touches && (self.strict || other.strict)
    }
}

/// The comparisons with a constant that must be true wherever the formula is true.
fn demands<'a>(formula: &'a Temporal, parts: &'a [Comparison], times: Times, found: &mut Vec<Demand<'a>>) {
    match formula {
        Temporal::Part(index) => found.extend(demand(&parts[*index], times)),
        Temporal::And(a, b) => {
            demands(a, parts, times, found);
            demands(b, parts, times, found);
        }
        Temporal::Always(within, inner) if within.from == 0.0 && times != Times::One => {
            let whole = within.to.is_infinite() && times == Times::Start;
            demands(inner, parts, if whole { Times::All } else { times }, found);
        }
        Temporal::Eventually(_, inner) if times == Times::Start => demands(inner, parts, Times::One, found),
        _ => {}
    }
}

fn demand(part: &Comparison, times: Times) -> Option<Demand<'_>> {
    use base::signature::BinaryOperator::Subtract;
    part.dimension?;
    let Formula::Binary(Subtract, more, less) = &part.margin else { return None };
    let constant = |formula: &Formula| {
        let is_free = !formula.mentions(&|_: VariableId| true);
        is_free.then(|| formula.evaluate(&|_| unreachable!("it names no variable")))
    };
    let (quantity, values) = match (constant(more), constant(less)) {
        (Some(most), None) => (less, (f64::NEG_INFINITY, most)),
        (None, Some(least)) => (more, (least, f64::INFINITY)),
        _ => return None,
    };
    Some(Demand { quantity, values, strict: part.strict, times, text: &part.text })
}

//! Rewards are formulas of the scenario, evaluated at events.

use crate::Judgement;
use std::sync::Arc;

use super::signal::{Situation, is_judgement, is_motion, robustness_of};
use crate::requirement::NamedRequirement;
use base::signature::Formula;

/// A class of hits that a clause of a reward can name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HitClass {
    /// Preventable, and the pedestrian moved as real pedestrians do.
    Fault,
    /// A careful driver would have avoided it.
    Preventable,
    /// The ego moved.
    Moving,
    /// Within the front sector.
    Front,
    /// Outside the front sector.
    Other,
    /// Every hit.
    Any,
}

impl HitClass {
    /// All of them. Of the clauses that apply to a hit, the first in this order counts.
    pub const ALL: [Self; 6] = [Self::Fault, Self::Preventable, Self::Moving, Self::Front, Self::Other, Self::Any];
    /// Their words, in their order; a clause for [`HitClass::Any`] has none.
    pub(super) const WORDS: &[&str] = &["fault", "preventable", "moving", "front", "other"];

    /// Its word in scenarios; `None` for every hit.
    pub fn word(self) -> Option<&'static str> {
        Self::WORDS.get(self as usize).copied()
    }

    /// Whether it takes the judgement of the hit to know whether it applies.
    fn needs_judgement(self) -> bool {
        matches!(self, Self::Fault | Self::Preventable)
    }
}

/// What is known about a hit.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Hit {
    /// Whether it was within the front sector.
    pub(crate) front: bool,
    /// Whether the ego moved.
    pub(crate) moving: bool,
    /// The judgement, if the reward needs it.
    pub(crate) judgement: Judgement,
}

impl Hit {
    pub(crate) fn is(&self, class: HitClass) -> bool {
        match class {
            HitClass::Fault => self.moving && self.judgement.fault,
            HitClass::Preventable => self.moving && self.judgement.preventable,
            HitClass::Moving => self.moving,
            HitClass::Front => self.front,
            HitClass::Other => !self.front,
            HitClass::Any => true,
        }
    }
}

/// The reward of each event; an event without a formula has none.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RewardRule {
    /// The clauses for hits, in the order of [`HitClass::ALL`].
    pub hit: [Option<Formula>; 6],
    /// A decision without a hit.
    pub step: Option<Formula>,
    /// The `end_when` condition.
    pub lost: Option<Formula>,
    /// The time limit.
    pub timeout: Option<Formula>,
    /// The potential of a state. It shapes the reward of a learner and is not part of the reward.
    pub potential: Option<Formula>,
    /// The requirements that it names.
    pub requirements: Arc<[NamedRequirement]>,
    /// The end of an episode that violates the requirement in this place among them.
    pub violated: Vec<(usize, Formula)>,
}

impl RewardRule {
    /// The value of a formula in a situation, with the robustness of each requirement; 0 without a formula.
    pub fn worth(formula: Option<&Formula>, situation: &Situation, robustness: &[f64]) -> f64 {
        formula.map_or(0.0, |formula| {
            formula.evaluate(&|id| match robustness_of(id) {
                Some(place) => robustness.get(place).copied().unwrap_or(0.0),
                None => situation.value(id),
            })
        })
    }

    /// The formula for a hit: that of the first class that applies and has one.
    pub(crate) fn for_hit(&self, hit: &Hit) -> Option<&Formula> {
        HitClass::ALL.into_iter().zip(&self.hit).find_map(|(class, formula)| formula.as_ref().filter(|_| hit.is(class)))
    }

    /// Whether the reward of a hit depends on its judgement.
    pub fn needs_judgement(&self) -> bool {
        let classes = HitClass::ALL.into_iter().zip(&self.hit);
        let by_class = |(class, formula): (HitClass, &Option<Formula>)| class.needs_judgement() && formula.is_some();
        let by_variable = |formula: &Formula| formula.mentions(&is_judgement);
        classes.clone().any(by_class) || self.hit.iter().flatten().any(by_variable)
    }

    /// Whether a formula depends on motions that must be measured in every tick.
    pub(crate) fn needs_motion(&self) -> bool {
        self.formulas().any(is_about_motion)
    }

    /// All its formulas.
    pub(crate) fn formulas(&self) -> impl Iterator<Item = &Formula> {
        let rest = [&self.step, &self.lost, &self.timeout, &self.potential];
        self.hit.iter().chain(rest).flatten().chain(self.violated.iter().map(|(_, formula)| formula))
    }
}

/// Whether a formula depends on a motion that must be measured in every tick.
pub(crate) fn is_about_motion(formula: &Formula) -> bool {
    formula.mentions(&is_motion)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vocabulary;
    use base::signature::VariableId;

    #[test]
    fn the_first_class_that_applies_and_has_a_clause_counts() {
        let formula = |number: usize| Formula::Constant(number as f64);
        let rule = |written: &[HitClass]| RewardRule {
            hit: HitClass::ALL.map(|class| written.contains(&class).then(|| formula(class as usize))),
            ..RewardRule::default()
        };
        let judged = |preventable, fault| Judgement { preventable, fault, ..Judgement::default() };
        let fault = Hit { front: true, moving: true, judgement: judged(true, true) };
        let rude = Hit { judgement: judged(true, false), ..fault };
        let standing = Hit { front: false, moving: false, ..fault };
        let paid = |written: &[HitClass], hit: &Hit| rule(written).for_hit(hit).cloned();
        use HitClass::{Any, Fault, Front, Moving, Other, Preventable};
        assert_eq!(paid(&HitClass::ALL, &fault), Some(formula(Fault as usize)));
        assert_eq!(paid(&HitClass::ALL, &rude), Some(formula(Preventable as usize)));
        assert_eq!(paid(&HitClass::ALL, &standing), Some(formula(Other as usize)), "a standing car is never at fault");
        assert_eq!(paid(&[Fault, Front], &rude), Some(formula(Front as usize)));
        assert_eq!(paid(&[Moving, Any], &standing), Some(formula(Any as usize)));
        assert_eq!(paid(&[Fault], &rude), None);
        assert!(rule(&[Preventable]).needs_judgement() && !rule(&[Moving, Front, Any]).needs_judgement());
        let variables = vocabulary().variables;
        let place = |name| variables.iter().position(|each| each.name == name).unwrap();
        let variable = |name| Formula::Variable(VariableId(place(name)));
        let mut by_variable = rule(&[]);
        by_variable.hit[Any as usize] = Some(variable("margin"));
        assert!(by_variable.needs_judgement() && !by_variable.needs_motion());
        by_variable.step = Some(variable("min_ttc"));
        assert!(by_variable.needs_motion());
    }
}

//! Rewards are formulas of the scenario, evaluated at events.

use std::f64::consts::PI;

use super::Judgement;
use crate::geometry::Pose;
use base::signature::{Event, Formula, Variable, VariableId, Vocabulary};
use base::units::Dimension;

/// Since when a variable has a value, in the order of an episode.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
enum Since {
    Begin,
    Decision,
    /// The same; it must be measured in every tick.
    Motion,
    Hit,
    /// The same; it needs the judgement of the hit.
    Judgement,
}

/// Defines [`Situation`] and the table of its variables, which have the same order. A line has a name, the dimension and the bounds in any
/// episode (SI), and since when there is a value; its documentation is that of the language.
macro_rules! variables {
    ($(#[doc = $doc:literal] $name:ident: $dimension:ident, $bounds:expr, $since:ident;)*) => {
        /// The variables of formulas, in SI units.
        #[derive(Debug, Clone, Copy, PartialEq, Default)]
        pub struct Situation {
            $(#[doc = $doc] pub $name: f64,)*
        }

        const VARIABLES: &[(Variable, Since)] = &[$((
            Variable {
                name: stringify!($name),
                dimension: Dimension::$dimension,
                bounds: $bounds,
                doc: $doc.trim_ascii(),
            },
            Since::$since,
        ),)*];

        impl Situation {
            fn value(&self, id: VariableId) -> f64 {
                [$(self.$name),*][id.0]
            }
        }
    };
}

variables! {
    /// Speed of the ego at the collision.
    v_c: SPEED, (0.0, FASTEST), Hit;
    /// Bearing of the pedestrian from the ego's centre, positive to the left.
    bearing: ANGLE, (-PI, PI), Begin;
    /// Distance between the centres of pedestrian and ego.
    distance: LENGTH, (TOUCHING, FARTHEST), Begin;
    /// How far the pedestrian is ahead of the ego's centre; negative behind it.
    ahead: LENGTH, (-FARTHEST, FARTHEST), Begin;
    /// How far the pedestrian is to the left of the ego's axis.
    aside: LENGTH, (-FARTHEST, FARTHEST), Begin;
    /// Speed of the ego.
    ego_speed: SPEED, (0.0, FASTEST), Begin;
    /// Speed of the pedestrian.
    walking_speed: SPEED, (0.0, WALKING), Decision;
    /// Time since the episode began.
    elapsed: TIME, (0.0, LONGEST), Decision;
    /// Angle from where the pedestrian faces to the ego's centre, positive to the left.
    facing: ANGLE, (-PI, PI), Begin;
    /// How far the pedestrian's last command turned away from the one before, positive to the left; the first turns away from where it looked.
    turn: ANGLE, (-PI, PI), Decision;
    /// Speed that the pedestrian's last command asked for.
    pace: SPEED, (0.0, WALKING), Decision;
    /// Least distance so far between the pedestrian and the ego's body; 0 at a hit.
    miss_distance: LENGTH, (0.0, FARTHEST), Decision;
    /// Least time to collision so far while the ego moved, both keeping their velocities; at most 10 s.
    min_ttc: TIME, (0.0, HORIZON), Motion;
    /// Greatest deceleration of the ego during the last decision; 0 if it did not slow down.
    ego_deceleration: ACCELERATION, (0.0, FASTEST / SHORTEST), Motion;
    /// Greatest acceleration of the pedestrian during the last decision, over the whole vector, so turning counts.
    walking_acceleration: ACCELERATION, (0.0, 2.0 * WALKING / SHORTEST), Motion;
    /// How far the pedestrian's motion turned during the last decision, positive to the left; 0 if it stood.
    walking_turn: ANGLE, (-PI, PI), Motion;
    /// Share of careful drivers that would have avoided the hit, from 0 to 1.
    preventability: RATIO, (0.0, 1.0), Judgement;
    /// Part of the impact speed that a careful human would have avoided; negative if it would have hit faster.
    avoidable_speed: SPEED, (-FASTEST, FASTEST), Judgement;
    /// Least gap that a careful human would have kept; 0 if it hits as well.
    margin: LENGTH, (0.0, FARTHEST), Judgement;
    /// Time from the start of the danger to the hit.
    warning: TIME, (0.0, LONGEST), Judgement;
    /// Time before the hit in which the car could see the pedestrian without a break, at most 3 s.
    seen: TIME, (0.0, LONGEST), Judgement;
}

/// The longest time to collision that counts (s).
pub(super) const HORIZON: f64 = 10.0;
/// No car reaches this speed, and no pedestrian this one (m/s).
const FASTEST: f64 = 1000.0;
const WALKING: f64 = 41.0;
/// The longest episode: a million ticks of 0.1 s, and the shortest tick (s).
const LONGEST: f64 = 1e5;
const SHORTEST: f64 = 1e-3;
const FARTHEST: f64 = FASTEST * LONGEST;
/// The centre of a pedestrian that touches a car is not at the car's centre (m).
const TOUCHING: f64 = 0.1;

/// The variables and events that formulas may name.
pub fn vocabulary() -> Vocabulary {
    let until =
        |last: Since| VARIABLES.iter().filter(|each| each.1 <= last).map(|each| each.0.name).collect::<Vec<_>>();
    let moving = |name, doc| Event { name, words: &[], variables: until(Since::Motion), answered: true, doc };
    Vocabulary {
        variables: VARIABLES.iter().map(|(variable, _)| variable.clone()).collect(),
        events: vec![
            Event {
                name: "hit",
                words: HitClass::WORDS,
                variables: until(Since::Judgement),
                answered: true,
                doc: "The pedestrian and the ego touch. One clause counts, the first of these that is written and true: `fault` \
                      (preventable, and the pedestrian moved as real ones do), `preventable` (a careful driver would have avoided it), \
                      `moving` (the ego moved), `front` within the front sector, `other` elsewhere, `hit` without a word.",
            },
            moving("step", "A decision has been carried out and nothing was hit."),
            moving("lost", "The episode ends because its `end_when` condition holds."),
            moving("timeout", "The episode's time is up."),
            Event {
                name: "begin",
                words: &[],
                variables: until(Since::Begin),
                answered: false,
                doc: "An episode is about to begin; for the `require` of a spawn.",
            },
        ],
    }
}

impl Situation {
    /// The situation at the start of an episode.
    pub(super) fn at_start(ego: &Pose, ego_speed: f64, pedestrian: &Pose) -> Self {
        let local = ego.to_local(pedestrian.position());
        let seen = pedestrian.to_local(ego.position());
        Self {
            bearing: libm::atan2(local.y, local.x),
            distance: local.norm(),
            ahead: local.x,
            aside: local.y,
            ego_speed,
            facing: libm::atan2(seen.y, seen.x),
            ..Self::default()
        }
    }

    /// Whether a condition is true.
    pub fn satisfies(&self, condition: &Formula) -> bool {
        condition.evaluate(&|id| self.value(id)) != 0.0
    }
}

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
    const WORDS: &[&str] = &["fault", "preventable", "moving", "front", "other"];

    /// Its word in scenarios; none for every hit.
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
pub(super) struct Hit {
    /// Whether it was within the front sector.
    pub(super) front: bool,
    /// Whether the ego moved.
    pub(super) moving: bool,
    /// The judgement, if the reward needs it.
    pub(super) judgement: Judgement,
}

impl Hit {
    fn is(&self, class: HitClass) -> bool {
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
}

impl RewardRule {
    /// The value of a formula in a situation; 0 without a formula.
    pub fn worth(formula: Option<&Formula>, situation: &Situation) -> f64 {
        formula.map_or(0.0, |formula| formula.evaluate(&|id| situation.value(id)))
    }

    /// The formula for a hit: that of the first class that applies and has one.
    pub(super) fn for_hit(&self, hit: &Hit) -> Option<&Formula> {
        HitClass::ALL.into_iter().zip(&self.hit).find_map(|(class, formula)| formula.as_ref().filter(|_| hit.is(class)))
    }

    /// Whether the reward of a hit depends on its judgement.
    pub fn needs_judgement(&self) -> bool {
        let classes = HitClass::ALL.into_iter().zip(&self.hit);
        let by_class = |(class, formula): (HitClass, &Option<Formula>)| class.needs_judgement() && formula.is_some();
        let by_variable = |formula: &Formula| formula.mentions(&|id| VARIABLES[id.0].1 == Since::Judgement);
        classes.clone().any(by_class) || self.hit.iter().flatten().any(by_variable)
    }

    /// Whether a formula depends on motions that must be measured in every tick.
    pub(super) fn needs_motion(&self) -> bool {
        let rest = [&self.step, &self.lost, &self.timeout, &self.potential];
        self.hit.iter().chain(rest).flatten().any(is_about_motion)
    }
}

/// Whether a formula depends on a motion that must be measured in every tick.
pub(super) fn is_about_motion(formula: &Formula) -> bool {
    formula.mentions(&|id| VARIABLES[id.0].1 == Since::Motion)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn variables_are_available_in_the_order_of_an_episode() {
        let events = vocabulary().events;
        let of = |name: &str| events.iter().find(|event| event.name == name).unwrap().variables.clone();
        assert_eq!(of("begin"), ["bearing", "distance", "ahead", "aside", "ego_speed", "facing"]);
        assert_eq!((of("step").len(), of("hit").len()), (15, 21));
        assert!(of("step").contains(&"min_ttc") && !of("step").contains(&"v_c") && !of("step").contains(&"seen"));
    }

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
        let place = |name| VARIABLES.iter().position(|each| each.0.name == name).unwrap();
        let variable = |name| Formula::Variable(VariableId(place(name)));
        let mut by_variable = rule(&[]);
        by_variable.hit[Any as usize] = Some(variable("margin"));
        assert!(by_variable.needs_judgement() && !by_variable.needs_motion());
        by_variable.step = Some(variable("min_ttc"));
        assert!(by_variable.needs_motion());
    }
}

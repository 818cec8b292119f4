//! Rewards are formulas of the scenario, evaluated at events.

use super::Judgement;
use crate::geometry::Pose;
use base::signature::{Event, Formula, Variable, VariableId, Vocabulary};
use base::units::Dimension;

/// The variables of formulas, in SI units. The order of the fields is that of the vocabulary.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Situation {
    /// Speed of the ego when it was hit (m/s); only at `hit`.
    pub v_c: f64,
    /// Bearing of the pedestrian from the ego's centre, positive to the left (rad).
    pub bearing: f64,
    /// Distance between the centres (m).
    pub distance: f64,
    /// Distance of the pedestrian ahead of the ego's centre, negative behind it (m).
    pub ahead: f64,
    /// Distance of the pedestrian to the left of the ego's axis (m).
    pub aside: f64,
    /// Speed of the ego (m/s).
    pub ego_speed: f64,
    /// Speed of the pedestrian (m/s).
    pub walking_speed: f64,
    /// Time since the start of the episode (s).
    pub elapsed: f64,
    /// Angle from the pedestrian's heading to the ego's centre, positive to the left (rad).
    pub facing: f64,
    /// Angle from the previous command to the last one, positive to the left (rad).
    pub turn: f64,
    /// Speed of the last command (m/s).
    pub pace: f64,
    /// Least distance so far from the pedestrian's disc to the ego's box (m); 0 at a hit.
    pub miss_distance: f64,
    /// Least time to collision so far, both keeping their velocities (s); 10 s when they were never on course to touch.
    pub min_ttc: f64,
    /// Greatest deceleration of the ego in the last decision (m/s²); 0 when it did not slow down.
    pub ego_deceleration: f64,
    /// Greatest acceleration of the pedestrian in the last decision, over the whole vector (m/s²).
    pub walking_acceleration: f64,
    /// Angle by which the pedestrian's direction of motion turned in the last decision, positive to the left (rad).
    pub walking_turn: f64,
    /// See [`Judgement`]; only at `hit`, as the rest.
    pub preventability: f64,
    /// See [`Judgement`] (m/s).
    pub avoidable_speed: f64,
    /// See [`Judgement`] (m).
    pub margin: f64,
    /// See [`Judgement`] (s).
    pub warning: f64,
    /// See [`Judgement`] (s).
    pub seen: f64,
}

/// The longest time to collision that counts (s).
pub(super) const HORIZON: f64 = 10.0;

const AT_HIT: &[&str] = &[
    "v_c",
    "bearing",
    "distance",
    "ahead",
    "aside",
    "ego_speed",
    "walking_speed",
    "elapsed",
    "facing",
    "turn",
    "pace",
    "miss_distance",
    "min_ttc",
    "ego_deceleration",
    "walking_acceleration",
    "walking_turn",
    "preventability",
    "avoidable_speed",
    "margin",
    "warning",
    "seen",
];
/// The first of the variables that must be measured in every tick.
const MOTIONS: usize = 12;
/// The first of the variables that need the judgement of the hit.
const JUDGED: usize = 16;
/// All variables that do not need a hit.
const ALWAYS: &[&str] = AT_HIT.split_at(JUDGED).0.split_at(1).1;
const AT_BEGIN: &[&str] = &["bearing", "distance", "ahead", "aside", "ego_speed", "facing"];

/// The bounds of a variable in any episode. An episode has at most a million ticks of 0.1 s, no pedestrian is faster than 40.96 m/s, and
/// no car reaches 1000 m/s. The centre of a pedestrian that touches a car is not at the car's centre.
fn bounds_of(name: &str) -> (f64, f64) {
    use std::f64::consts::PI;
    const FASTEST: f64 = 1000.0;
    const WALKING: f64 = 41.0;
    const LONGEST: f64 = 1e5;
    const SHORTEST: f64 = 1e-3;
    const FARTHEST: f64 = FASTEST * LONGEST;
    match name {
        "v_c" | "ego_speed" => (0.0, FASTEST),
        "walking_speed" | "pace" => (0.0, WALKING),
        "elapsed" => (0.0, LONGEST),
        "distance" => (0.1, FARTHEST),
        "miss_distance" => (0.0, FARTHEST),
        "ahead" | "aside" => (-FARTHEST, FARTHEST),
        "bearing" | "facing" | "turn" | "walking_turn" => (-PI, PI),
        "min_ttc" => (0.0, HORIZON),
        // Within the shortest tick.
        "ego_deceleration" => (0.0, FASTEST / SHORTEST),
        "walking_acceleration" => (0.0, 2.0 * WALKING / SHORTEST),
        "preventability" => (0.0, 1.0),
        "avoidable_speed" => (-FASTEST, FASTEST),
        "margin" => (0.0, FARTHEST),
        "warning" | "seen" => (0.0, LONGEST),
        other => unreachable!("`{other}` is no variable"),
    }
}

/// The variables and events that formulas may name.
pub fn vocabulary() -> Vocabulary {
    let variable = |name, dimension, doc| Variable { name, dimension, bounds: bounds_of(name), doc };
    Vocabulary {
        variables: vec![
            variable("v_c", Dimension::SPEED, "Speed of the ego at the collision."),
            variable(
                "bearing",
                Dimension::ANGLE,
                "Bearing of the pedestrian from the ego's centre, positive to the left.",
            ),
            variable("distance", Dimension::LENGTH, "Distance between the centres of pedestrian and ego."),
            variable(
                "ahead",
                Dimension::LENGTH,
                "How far the pedestrian is ahead of the ego's centre; negative behind it.",
            ),
            variable("aside", Dimension::LENGTH, "How far the pedestrian is to the left of the ego's axis."),
            variable("ego_speed", Dimension::SPEED, "Speed of the ego."),
            variable("walking_speed", Dimension::SPEED, "Speed of the pedestrian."),
            variable("elapsed", Dimension::TIME, "Time since the episode began."),
            variable(
                "facing",
                Dimension::ANGLE,
                "Angle from where the pedestrian faces to the ego's centre, positive to the left.",
            ),
            variable(
                "turn",
                Dimension::ANGLE,
                "How far the pedestrian's last command turned away from the one before, positive to the left; the first \
                 turns away from where it looked.",
            ),
            variable("pace", Dimension::SPEED, "Speed that the pedestrian's last command asked for."),
            variable(
                "miss_distance",
                Dimension::LENGTH,
                "Least distance so far between the pedestrian and the ego's body; 0 at a hit.",
            ),
            variable(
                "min_ttc",
                Dimension::TIME,
                "Least time to collision so far while the ego moved, both keeping their velocities; at most 10 s.",
            ),
            variable(
                "ego_deceleration",
                Dimension::ACCELERATION,
                "Greatest deceleration of the ego during the last decision; 0 if it did not slow down.",
            ),
            variable(
                "walking_acceleration",
                Dimension::ACCELERATION,
                "Greatest acceleration of the pedestrian during the last decision, over the whole vector, so turning counts.",
            ),
            variable(
                "walking_turn",
                Dimension::ANGLE,
                "How far the pedestrian's motion turned during the last decision, positive to the left; 0 if it stood.",
            ),
            variable(
                "preventability",
                Dimension::RATIO,
                "Share of careful drivers that would have avoided the hit, from 0 to 1.",
            ),
            variable(
                "avoidable_speed",
                Dimension::SPEED,
                "Part of the impact speed that a careful human would have avoided; negative if it would have hit faster.",
            ),
            variable(
                "margin",
                Dimension::LENGTH,
                "Least gap that a careful human would have kept; 0 if it hits as well.",
            ),
            variable("warning", Dimension::TIME, "Time from the start of the danger to the hit."),
            variable(
                "seen",
                Dimension::TIME,
                "Time before the hit in which the car could see the pedestrian without a break, at most 3 s.",
            ),
        ],
        events: vec![
            Event {
                name: "hit",
                words: HitClass::WORDS,
                variables: AT_HIT,
                answered: true,
                doc: "The pedestrian and the ego touch. One clause counts, the first of these that is written and true: `fault` \
                      (preventable, and the pedestrian moved as real ones do), `preventable` (a careful driver would have avoided it), \
                      `moving` (the ego moved), `front` within the front sector, `other` elsewhere, `hit` without a word.",
            },
            Event {
                name: "step",
                words: &[],
                variables: ALWAYS,
                answered: true,
                doc: "A decision has been carried out and nothing was hit.",
            },
            Event {
                name: "lost",
                words: &[],
                variables: ALWAYS,
                answered: true,
                doc: "The episode ends because its `end_when` condition holds.",
            },
            Event { name: "timeout", words: &[], variables: ALWAYS, answered: true, doc: "The episode's time is up." },
            Event {
                name: "begin",
                words: &[],
                variables: AT_BEGIN,
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

    fn value(&self, id: VariableId) -> f64 {
        let fields = [
            self.v_c,
            self.bearing,
            self.distance,
            self.ahead,
            self.aside,
            self.ego_speed,
            self.walking_speed,
            self.elapsed,
            self.facing,
            self.turn,
            self.pace,
            self.miss_distance,
            self.min_ttc,
            self.ego_deceleration,
            self.walking_acceleration,
            self.walking_turn,
            self.preventability,
            self.avoidable_speed,
            self.margin,
            self.warning,
            self.seen,
        ];
        fields[id.0]
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
        let by_variable = |formula: &Formula| formula.mentions(&|id| id.0 >= JUDGED);
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
    formula.mentions(&|id| (MOTIONS..JUDGED).contains(&id.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_vocabulary_and_the_fields_have_one_order() {
        let situation = Situation {
            v_c: 0.0,
            bearing: 1.0,
            distance: 2.0,
            ahead: 3.0,
            aside: 4.0,
            ego_speed: 5.0,
            walking_speed: 6.0,
            elapsed: 7.0,
            facing: 8.0,
            turn: 9.0,
            pace: 10.0,
            miss_distance: 11.0,
            min_ttc: 12.0,
            ego_deceleration: 13.0,
            walking_acceleration: 14.0,
            walking_turn: 15.0,
            preventability: 16.0,
            avoidable_speed: 17.0,
            margin: 18.0,
            warning: 19.0,
            seen: 20.0,
        };
        assert_eq!((AT_HIT[MOTIONS], AT_HIT[JUDGED]), ("min_ttc", "preventability"));
        for (index, variable) in vocabulary().variables.iter().enumerate() {
            assert_eq!(variable.name, AT_HIT[index]);
            assert_eq!(situation.value(VariableId(index)), index as f64);
        }
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
        let mut by_variable = rule(&[]);
        by_variable.hit[Any as usize] = Some(Formula::Variable(base::signature::VariableId(JUDGED + 1)));
        assert!(by_variable.needs_judgement() && !by_variable.needs_motion());
        by_variable.step = Some(Formula::Variable(base::signature::VariableId(MOTIONS)));
        assert!(by_variable.needs_motion());
    }

    #[test]
    fn events_name_only_known_variables() {
        let vocabulary = vocabulary();
        for event in &vocabulary.events {
            for name in event.variables {
                assert!(vocabulary.variables.iter().any(|variable| variable.name == *name), "{name}");
            }
        }
    }
}

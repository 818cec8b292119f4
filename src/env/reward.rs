//! Rewards are formulas of the scenario, evaluated at events.

use crate::geometry::Pose;
use crate::signature::{Event, Formula, Variable, VariableId, Vocabulary};
use crate::units::Dimension;

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
}

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
];
/// All of them but `v_c`.
const ALWAYS: &[&str] = AT_HIT.split_at(1).1;
const AT_BEGIN: &[&str] = &["bearing", "distance", "ahead", "aside", "ego_speed", "facing"];

/// The bounds of a variable in any episode. An episode has at most a million ticks of 0.1 s, no pedestrian is faster than 40.96 m/s, and
/// no car reaches 1000 m/s. The centre of a pedestrian that touches a car is not at the car's centre.
fn bounds_of(name: &str) -> (f64, f64) {
    use std::f64::consts::PI;
    const FASTEST: f64 = 1000.0;
    const WALKING: f64 = 41.0;
    const LONGEST: f64 = 1e5;
    const FARTHEST: f64 = FASTEST * LONGEST;
    match name {
        "v_c" | "ego_speed" => (0.0, FASTEST),
        "walking_speed" | "pace" => (0.0, WALKING),
        "elapsed" => (0.0, LONGEST),
        "distance" => (0.1, FARTHEST),
        "miss_distance" => (0.0, FARTHEST),
        "ahead" | "aside" => (-FARTHEST, FARTHEST),
        "bearing" | "facing" | "turn" => (-PI, PI),
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
        ],
        events: vec![
            Event {
                name: "hit",
                words: &["front", "other"],
                variables: AT_HIT,
                answered: true,
                doc: "The pedestrian and the ego touch; `front` within the front sector, `other` elsewhere.",
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
        ];
        fields[id.0]
    }

    /// Whether a condition is true.
    pub fn satisfies(&self, condition: &Formula) -> bool {
        condition.evaluate(&|id| self.value(id)) != 0.0
    }
}

/// The reward of each event; an event without a formula has none.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RewardRule {
    /// A frontal hit, unless only `hit` is given.
    pub hit_front: Option<Formula>,
    /// Another hit, unless only `hit` is given.
    pub hit_other: Option<Formula>,
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
        };
        for (index, variable) in vocabulary().variables.iter().enumerate() {
            assert_eq!(variable.name, AT_HIT[index]);
            assert_eq!(situation.value(VariableId(index)), index as f64);
        }
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

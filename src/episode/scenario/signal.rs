//! The signals of an episode: the variables that rewards, requirements and conditions name.

use std::f64::consts::PI;

use base::signature::{Event, Formula, Variable, VariableId, Vocabulary};
use base::units::Dimension;
use road::Town;
use road::geometry::Pose;

use super::actor_signal::{self, FARTHEST, FASTEST, MAX_TIME};
use super::reward::HitClass;
use crate::{EpisodeRule, Scenario};

/// Since when a variable has a value, in the order of an episode.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
enum Since {
    Begin,
    Decision,
    /// The same; it is measured in every tick, where a formula names it.
    Tick,
    /// The same, and it is true or false.
    Condition,
    /// Since the first decision; it is about all ticks of a decision.
    Motion,
    Hit,
    /// The same; it needs the judgement of the hit.
    Judgement,
}

/// Defines [`Situation`] and the table of its variables, which have the same order. A line has a name, the dimension, the bounds in any
/// episode (SI), the scale (SI), and since when there is a value; its documentation is that of the language.
macro_rules! variables {
    ($(#[doc = $doc:literal] $name:ident: $dimension:ident, $bounds:expr, $scale:literal, $since:ident;)*) => {
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
                scale: $scale,
                is_condition: matches!(Since::$since, Since::Condition),
                doc: $doc.trim_ascii(),
            },
            Since::$since,
        ),)*];

        impl Situation {
            /// The value of a variable (SI).
            pub fn value(&self, id: VariableId) -> f64 {
                self.values()[id.0]
            }

            /// The values of all variables (SI), by their numbers.
            #[inline]
            pub(crate) fn values(&self) -> [f64; [$(stringify!($name)),*].len()] {
                [$(self.$name),*]
            }
        }

        /// Whether the variable of each name is wanted.
        #[derive(Debug, Clone, Copy, PartialEq, Default)]
        pub(crate) struct Wanted {
            $(pub(crate) $name: bool,)*
        }

        impl Wanted {
            /// The variables for which a condition is true.
            pub(crate) fn new(is_wanted: impl Fn(VariableId) -> bool) -> Self {
                let mut ids = (0..).map(VariableId);
                let mut next = || ids.next().is_some_and(&is_wanted);
                Self { $($name: next(),)* }
            }
        }
    };
}

variables! {
    /// Speed of the ego at the collision.
    v_c: SPEED, (0.0, FASTEST), 5.0, Hit;
    /// Bearing of the pedestrian from the ego's centre, positive to the left.
    bearing: ANGLE, (-PI, PI), 0.2, Begin;
    /// Distance between the centres of pedestrian and ego.
    distance: LENGTH, (TOUCHING, FARTHEST), 10.0, Begin;
    /// How far the pedestrian is ahead of the ego's centre; negative behind it.
    ahead: LENGTH, (-FARTHEST, FARTHEST), 10.0, Begin;
    /// How far the pedestrian is to the left of the ego's axis.
    aside: LENGTH, (-FARTHEST, FARTHEST), 1.0, Begin;
    /// Speed of the ego.
    ego_speed: SPEED, (0.0, FASTEST), 5.0, Begin;
    /// Speed of the pedestrian.
    walking_speed: SPEED, (0.0, WALKING), 1.0, Decision;
    /// Time since the episode began.
    elapsed: TIME, (0.0, MAX_TIME), 1.0, Decision;
    /// Angle from where the pedestrian faces to the ego's centre, positive to the left.
    facing: ANGLE, (-PI, PI), 0.2, Begin;
    /// How far the pedestrian's last command turned away from the one before, positive to the left; the first turns away from where it looked.
    turn: ANGLE, (-PI, PI), 0.2, Decision;
    /// Speed that the pedestrian's last command asked for.
    pace: SPEED, (0.0, WALKING), 1.0, Decision;
    /// Least distance so far between the pedestrian and the ego's body; 0 at a touch.
    miss_distance: LENGTH, (0.0, FARTHEST), 1.0, Decision;
    /// Least time to collision so far while the ego moved, both keeping their velocities; at most 10 s.
    min_ttc: TIME, (0.0, HORIZON), 1.0, Motion;
    /// Greatest deceleration of the ego during the last decision; 0 if it did not slow down.
    ego_deceleration: ACCELERATION, (0.0, FASTEST / SHORTEST), 1.0, Motion;
    /// Greatest acceleration of the pedestrian during the last decision, over the whole vector, so turning counts.
    walking_acceleration: ACCELERATION, (0.0, 2.0 * WALKING / SHORTEST), 1.0, Motion;
    /// How far the pedestrian's motion turned during the last decision, positive to the left; 0 if it stood.
    walking_turn: ANGLE, (-PI, PI), 0.2, Motion;
    /// Share of careful drivers that would have avoided the collision, from 0 to 1.
    preventability: RATIO, (0.0, 1.0), 1.0, Judgement;
    /// Part of the impact speed that a careful human would have avoided; negative if it would have collided faster.
    avoidable_speed: SPEED, (-FASTEST, FASTEST), 5.0, Judgement;
    /// Least gap that a careful human would have kept; 0 if it hits as well.
    margin: LENGTH, (0.0, FARTHEST), 1.0, Judgement;
    /// Time from the start of the danger to the touch.
    warning: TIME, (0.0, MAX_TIME), 1.0, Judgement;
    /// Time before the touch in which the car could see the pedestrian without a break, at most 3 s.
    seen: TIME, (0.0, MAX_TIME), 1.0, Judgement;
    /// Gap between the bodies of the ego and the pedestrian now; 0 at a touch. Of several pedestrians the nearest counts, here and below.
    gap: LENGTH, (0.0, FARTHEST), 1.0, Tick;
    /// Speed at which the centres of ego and pedestrian approach each other now; negative if they move apart.
    closing_speed: SPEED, (-FASTEST, FASTEST + WALKING), 5.0, Tick;
    /// Time to collision now, both keeping their velocities; 10 s if that is later, never, or while the ego stands (up to 0.1 m/s).
    ttc: TIME, (0.0, HORIZON), 1.0, Tick;
    /// Post-encroachment time so far: the least time between one leaving a place and the other reaching it; 10 s without such a place.
    pet: TIME, (0.0, HORIZON), 1.0, Tick;
    /// Acceleration of the ego along its way in the last tick; negative if it slowed down, 0 at the start.
    ego_acceleration: ACCELERATION, (-FASTEST / SHORTEST, FASTEST / SHORTEST), 1.0, Tick;
    /// Change of that acceleration a second; 0 in the first two samples.
    ego_jerk: JERK, (-2.0 * FASTEST / SHORTEST / SHORTEST, 2.0 * FASTEST / SHORTEST / SHORTEST), 1.0, Tick;
    /// Acceleration of the pedestrian in the last tick, over the whole vector, so turning counts; 0 at the start.
    pedestrian_acceleration: ACCELERATION, (0.0, 2.0 * WALKING / SHORTEST), 1.0, Tick;
    /// How far the ego's centre is to the left of the middle of the lane around it.
    lane_offset: LENGTH, (-FARTHEST, FARTHEST), 0.5, Tick;
    /// Whether the ego's centre is outside its lane: beyond its edge by more than 0.1 m, or in a lane against its way.
    left_lane: RATIO, (0.0, 1.0), 1.0, Condition;
    /// Whether the ego's centre is outside all driving lanes.
    left_road: RATIO, (0.0, 1.0), 1.0, Condition;
    /// Distance of the ego's front to the stop line of the next traffic light on its lane, negative while its body is across; 100 m if there is none so near.
    light_distance: LENGTH, (-50.0, AHEAD), 5.0, Tick;
    /// Whether that light is red; false without one.
    red_light: RATIO, (0.0, 1.0), 1.0, Condition;
    /// Distance of the ego's front to the next crosswalk straight ahead, 0 while its body is on it; 100 m if there is none so near.
    crosswalk_distance: LENGTH, (0.0, AHEAD), 5.0, Tick;
    /// Whether a pedestrian is on that crosswalk.
    crosswalk_taken: RATIO, (0.0, 1.0), 1.0, Condition;
    /// Whether a pedestrian waits at that crosswalk: beside it, at most 1.5 m away.
    crosswalk_waiting: RATIO, (0.0, 1.0), 1.0, Condition;
    /// Whether the driver's eye can see any of the pedestrian; obstacles and other actors hide it.
    in_sight: RATIO, (0.0, 1.0), 1.0, Condition;
    /// Whether the ego moves: faster than 0.1 m/s.
    moving: RATIO, (0.0, 1.0), 1.0, Condition;
}

/// The longest time to collision that counts (s).
pub(crate) const HORIZON: f64 = 10.0;
/// The greatest distance of a light or a crosswalk ahead (m).
pub(crate) const AHEAD: f64 = 100.0;
/// No pedestrian reaches this speed (m/s).
const WALKING: f64 = 41.0;
/// The shortest tick (s).
const SHORTEST: f64 = 1e-3;
/// The centre of a pedestrian that touches a car is not at the car's centre (m).
const TOUCHING: f64 = 0.1;

/// The variables and events that formulas may name.
pub fn vocabulary() -> Vocabulary {
    let until =
        |last: Since| VARIABLES.iter().filter(|each| each.1 <= last).map(|each| each.0.name).collect::<Vec<_>>();
    let moving =
        |name, doc| Event { name, words: &[], declared: None, variables: until(Since::Motion), answered: true, doc };
    Vocabulary {
        variables: VARIABLES.iter().map(|(variable, _)| variable.clone()).collect(),
        signals: actor_signal::signals(),
        events: vec![
            Event {
                name: "touch",
                words: HitClass::WORDS,
                declared: None,
                variables: until(Since::Judgement),
                answered: true,
                doc: "The pedestrian and the ego touch. One clause counts, the first of these that is written and true: `fault` \
                      (preventable, and the pedestrian moved as real ones do), `preventable` (a careful driver would have avoided it), \
                      `moving` (the ego moved), `front` within the front sector, `other` elsewhere, `touch` without a word.",
            },
            moving("step", "A decision has been carried out without a touch."),
            moving("lost", "The episode ends because its `end_when` condition holds."),
            moving("timeout", "The episode's time is up."),
            Event {
                declared: Some("requirement"),
                ..moving(
                    "violated",
                    "The episode ends, however it does, and violates the requirement in parentheses. It is paid beside the other clauses.",
                )
            },
            Event {
                name: "tick",
                words: &[],
                declared: None,
                variables: until(Since::Condition),
                answered: false,
                doc: "The start of an episode and the end of every tick; for requirements.",
            },
            Event {
                name: "begin",
                words: &[],
                declared: None,
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

/// The place of a requirement among those of a reward whose robustness a formula of that reward names: the variables after all others.
pub fn robustness_of(id: VariableId) -> Option<usize> {
    id.0.checked_sub(VARIABLES.len()).filter(|_| id.of_actor().is_none())
}

/// The variable for the robustness of the requirement in this place.
pub fn robustness(place: usize) -> VariableId {
    VariableId(VARIABLES.len() + place)
}

/// Whether a variable must be measured in every tick.
pub(crate) fn is_measured(id: VariableId) -> bool {
    VARIABLES.get(id.0).is_some_and(|found| matches!(found.1, Since::Tick | Since::Condition))
}

/// The variables that say nothing of a pedestrian.
const OF_THE_EGO: &[&str] = &[
    "ego_speed",
    "elapsed",
    "ego_acceleration",
    "ego_jerk",
    "lane_offset",
    "left_lane",
    "left_road",
    "light_distance",
    "red_light",
    "crosswalk_distance",
    "moving",
];
/// The variables that say how hard the ego brakes.
const OF_ITS_BRAKE: &[&str] = &["ego_acceleration", "ego_jerk"];

/// The variables that need the map.
const OF_THE_MAP: &[&str] = &[
    "lane_offset",
    "left_lane",
    "left_road",
    "light_distance",
    "red_light",
    "crosswalk_distance",
    "crosswalk_taken",
    "crosswalk_waiting",
];

/// A part of a map that some variables are about, and that a town may not have.
pub struct MapPart {
    /// What a town has several of.
    pub name: &'static str,
    variables: &'static [&'static str],
    is_there: fn(&Town, &EpisodeRule) -> bool,
}

impl MapPart {
    /// All parts.
    pub const ALL: [Self; 2] = [
        Self {
            name: "crosswalks",
            variables: &["crosswalk_distance", "crosswalk_taken", "crosswalk_waiting"],
            is_there: |town, _| !town.crosswalks.is_empty(),
        },
        Self {
            name: "traffic lights",
            variables: &["light_distance", "red_light"],
            is_there: |town, episode| episode.traffic_lights && !town.traffic_lights.is_empty(),
        },
    ];

    /// Whether a town has it, and it works in the episodes.
    pub fn is_there(&self, town: &Town, episode: &EpisodeRule) -> bool {
        (self.is_there)(town, episode)
    }

    /// Whether a variable is about it.
    pub fn has(&self, id: VariableId) -> bool {
        is_one_of(self.variables, id)
    }
}

/// Whether a variable is about a part that the town of a scenario does not have, or that is switched off, so that its value says nothing.
pub(crate) fn is_silent(id: VariableId, scenario: &Scenario) -> bool {
    MapPart::ALL.iter().any(|part| part.has(id) && !part.is_there(&scenario.town, &scenario.episode))
}

/// Whether a variable is one of these; no signal of an actor is.
fn is_one_of(names: &[&str], id: VariableId) -> bool {
    id.of_actor().is_none() && VARIABLES.get(id.0).is_some_and(|found| names.contains(&found.0.name))
}

/// Whether a variable needs the map.
pub fn is_about_map(id: VariableId) -> bool {
    is_one_of(OF_THE_MAP, id)
}

/// Whether a variable says something of a pedestrian.
pub fn is_about_pedestrian(id: VariableId) -> bool {
    !is_one_of(OF_THE_EGO, id)
}

/// Whether a variable says how hard the ego brakes.
pub fn is_about_braking(id: VariableId) -> bool {
    is_one_of(OF_ITS_BRAKE, id)
}

/// Whether a variable is about the motion in all ticks of a decision.
pub(super) fn is_motion(id: VariableId) -> bool {
    VARIABLES.get(id.0).is_some_and(|found| found.1 == Since::Motion)
}

/// Whether a variable needs the judgement of a hit.
pub(super) fn is_judgement(id: VariableId) -> bool {
    VARIABLES.get(id.0).is_some_and(|found| found.1 == Since::Judgement)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn variables_are_available_in_the_order_of_an_episode() {
        let events = vocabulary().events;
        let of = |name: &str| events.iter().find(|event| event.name == name).unwrap().variables.clone();
        assert_eq!(of("begin"), ["bearing", "distance", "ahead", "aside", "ego_speed", "facing"]);
        assert_eq!((of("tick").len(), of("step").len(), of("touch").len()), (28, 32, 38));
        assert!(of("step").contains(&"min_ttc") && !of("step").contains(&"v_c") && !of("step").contains(&"seen"));
        assert!(of("tick").contains(&"gap") && !of("tick").contains(&"ego_deceleration"));
    }

    #[test]
    fn what_is_of_the_ego_alone_is_a_variable() {
        let known = |name: &&&str| VARIABLES.iter().any(|(variable, _)| variable.name == **name);
        assert!(OF_THE_EGO.iter().chain(OF_ITS_BRAKE).chain(OF_THE_MAP).all(|name| known(&name)));
        assert!(OF_ITS_BRAKE.iter().all(|name| OF_THE_EGO.contains(name)));
    }

    #[test]
    fn wanted_variables_are_named_in_their_order() {
        let vocabulary = vocabulary();
        let named = |id: VariableId| ["gap", "moving"].contains(&vocabulary.variables[id.0].name);
        let wanted = Wanted::new(named);
        assert_eq!(wanted, Wanted { gap: true, moving: true, ..Wanted::default() });
    }
}

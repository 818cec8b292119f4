use std::f64::consts::PI;

use base::keys;
use base::signature::{Distribution, Form, Formula, Keys};
use world::env::EpisodeRule;
use world::sim::LightCycle;

keys! {
    /// How long an episode lasts and what ends it.
    pub struct EpisodeKeys = "episode" {
        /// Length of a tick. CARLA's driver assumes 0.05 s.
        tick: f64 as within(TIME, 0.001, 0.1) = "0.05 s",
        /// Ticks for which the pedestrian holds a command.
        hold: u32 as ticks(1, 10_000) = "20",
        /// Most ticks of an episode.
        ticks: u32 as ticks(1, 1_000_000) = "600",
        /// Ends the episode after a command without a hit when it holds; not in the paper.
        end_when: Option<Formula> as Condition("step"),
        /// A hit is frontal when the pedestrian's bearing from the ego's middle is at most this.
        front: f64 as within(ANGLE, 0.0, PI) = "60 deg",
        /// Friction of the road: no car brakes, accelerates or turns with more than this times 9.81 m/s^2. Without it the
        /// figures of the `vehicle` alone hold, which are those of a dry road.
        friction: Option<f64> as within(RATIO, 0.02, 2.0),
        /// Whether the town's traffic lights work.
        traffic_lights: bool = "true",
        /// Green of each turn of the traffic lights (CARLA's, as the next two).
        light_green: f64 as within(TIME, 0.1, 3600.0) = "10 s",
        /// Yellow of each turn.
        light_yellow: f64 as within(TIME, 0.1, 3600.0) = "3 s",
        /// Time after a turn in which all lights of a junction are red.
        light_red: f64 as within(TIME, 0.1, 3600.0) = "2 s",
        /// Time within the cycle of all junctions when the car sets off: at the start of the episode, or of its run-up. Any
        /// time without it. At 0 s the first turn becomes green.
        light_phase: Option<Distribution> as drawn(TIME, 0.0, 36_000.0),
        /// Whether episodes count in which the driver was lost before a pedestrian came into sight: it did not reach its start in the
        /// run-up, or its car left the road. Otherwise they are in the tables, and in no rate, search or list of failures.
        count_all: bool = "false",
    }
}

/// The form `episode`.
pub fn form() -> Form {
    Form::plain(EpisodeKeys::signature())
}

pub fn lower(keys: EpisodeKeys) -> EpisodeRule {
    EpisodeRule {
        tick: keys.tick,
        hold: keys.hold,
        ticks: keys.ticks,
        end_when: keys.end_when,
        front_half_angle: keys.front,
        friction: keys.friction,
        traffic_lights: keys.traffic_lights,
        light_cycle: LightCycle { green: keys.light_green, yellow: keys.light_yellow, red: keys.light_red },
        light_phase: keys.light_phase,
        count_all: keys.count_all,
    }
}

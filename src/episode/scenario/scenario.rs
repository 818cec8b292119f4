use std::f64::consts::PI;
use std::sync::Arc;

use crate::requirement::NamedRequirement;
use crate::{Cast, Criterion, ExternalWorld, RewardRule, SpawnRule, TestOracle};
use base::keys;
use base::signature::{Distribution, Formula};
use road::Town;
use road::geometry::Obstacles;
use world::sim::LightCycle;

/// The ego counts as moving above this speed (m/s).
pub const MOVING_ABOVE: f64 = 0.1;

keys! {
    /// How long an episode lasts and what ends it.
    pub struct EpisodeRule = "episode" {
        /// Length of a tick. CARLA's driver assumes 0.05 s.
        tick: f64 as within(TIME, 0.001, 0.1) = "0.05 s",
        /// Ticks for which the pedestrian holds a command.
        hold: u32 as ticks(1, 10_000) = "20",
        /// Most ticks of an episode.
        ticks: u32 as ticks(1, 1_000_000) = "600",
        /// Ends the episode after a command without a touch when it holds; not in the paper.
        end_when: Option<Formula> as Condition("step"),
        /// A touch is frontal when the pedestrian's bearing from the ego's middle is at most this.
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

impl EpisodeRule {
    /// The durations of the colours of traffic lights.
    pub fn light_cycle(&self) -> LightCycle {
        LightCycle { green: self.light_green, yellow: self.light_yellow, red: self.light_red }
    }
}

/// A logical scenario: everything that all its episodes share.
#[derive(Clone)]
pub struct Scenario {
    /// The simulator in which the car drives; `None` for ours.
    pub external_world: Option<Arc<ExternalWorld>>,
    /// The roads.
    pub town: Arc<Town>,
    /// The obstacles beside them.
    pub obstacles: Arc<Obstacles>,
    /// Its actors.
    pub cast: Cast,
    /// The rule that places the ego and the first pedestrian.
    pub spawn: SpawnRule,
    /// The reward of the pedestrians.
    pub reward: RewardRule,
    /// Judges hits where the reward depends on it, and where there are several pedestrians: the worst hit counts. Without it no hit counts as preventable.
    pub oracle: Option<Arc<dyn TestOracle>>,
    /// The rule that ends episodes.
    pub episode: EpisodeRule,
    /// The requirements that are watched, in the order of the campaign.
    pub requirements: Arc<[NamedRequirement]>,
    /// What the pedestrian tries to bring about. A violation takes the place of the reward: an episode earns 1 − ρ / (1 + |ρ|) at its end for
    /// the robustness ρ, so more than 1 for a violation and less otherwise.
    pub criterion: Criterion,
}

impl Scenario {
    /// Maximum number of simulator ticks of an episode, its run-up included.
    pub fn longest(&self) -> u64 {
        u64::from(self.episode.ticks) + u64::from(self.most_run_up())
    }
}

impl std::fmt::Debug for Scenario {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Scenario").field("town", &self.town.name).finish_non_exhaustive()
    }
}

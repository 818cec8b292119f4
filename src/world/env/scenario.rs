use std::sync::Arc;

use super::{Cast, Criterion, EgoSpeed, PedestrianEnv, RewardRule, Simulation, SpawnRule, TestOracle, run_up};
use crate::geometry::Obstacles;
use crate::requirement::NamedRequirement;
use crate::road::Town;
use crate::sim::LightCycle;
use base::seed::Seed;
use base::signature::{Distribution, Formula};

/// The ego counts as moving above this speed (m/s).
pub const MOVING_ABOVE: f64 = 0.1;

/// The duration of an episode, and the conditions that end it.
#[derive(Debug, Clone, PartialEq)]
pub struct EpisodeRule {
    /// Length of a tick (s).
    pub tick: f64,
    /// Ticks for which a command of a pedestrian is kept.
    pub hold: u32,
    /// Most ticks of an episode.
    pub ticks: u32,
    /// Ends the episode after a decision without a hit when it is true; the value of the state after it is not bootstrapped.
    pub end_when: Option<Formula>,
    /// A hit is frontal when the pedestrian's bearing from the ego's centre is at most this (rad).
    pub front_half_angle: f64,
    /// The friction of the road, which bounds what the tyres of all cars transmit; `None` for CARLA's dry road.
    pub friction: Option<f64>,
    /// Whether the town's traffic lights work.
    pub traffic_lights: bool,
    /// The durations of their colours.
    pub light_cycle: LightCycle,
    /// The time within the cycle when the car sets off, at the start of its run-up (s); `None` for any time, drawn evenly.
    pub light_phase: Option<Distribution>,
    /// Whether episodes count in which the driver was lost before it could see a pedestrian ([`LeftOut`](super::LeftOut)).
    pub count_all: bool,
}

/// A logical scenario: everything that all its episodes share.
#[derive(Clone)]
pub struct Scenario {
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
    /// Judges hits, for rewards that depend on the judgement; without it every hit counts as not preventable.
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
    /// What runs its episodes.
    pub fn simulation(self: &Arc<Self>) -> Box<dyn Simulation> {
        Box::new(PedestrianEnv::new(self.clone(), Seed::root(0)))
    }

    /// Maximum number of ticks of an episode's run-up; 0 where episodes have none.
    pub fn most_run_up(&self) -> u32 {
        match self.spawn.ego_speed {
            EgoSpeed::Steady => {
                let rule = &self.episode;
                run_up::most_ticks(rule.tick, rule.traffic_lights.then_some(rule.light_cycle))
            }
            EgoSpeed::Drawn(_) => 0,
        }
    }

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

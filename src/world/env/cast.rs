use std::sync::Arc;

use super::{ActionSpec, ObservationSpec};
use crate::av::DrivingPolicy;
use crate::sim::{ActorStart, PedestrianBody, VehicleBlueprint, WalkCommand};
use base::choice;

/// Makes a fresh driving policy; every episode's environment owns one for each vehicle.
pub type PolicyMaker = Arc<dyn Fn() -> Box<dyn DrivingPolicy> + Send + Sync>;

/// The actors of a scenario. In a world the ego is vehicle 0, the other vehicles follow in their order, and pedestrians have their order.
#[derive(Clone)]
pub struct Cast {
    /// The car under test. The scenario's spawn rule places it.
    pub ego: VehicleRole,
    /// All other vehicles; each has its own start.
    pub traffic: Vec<Placed<VehicleRole>>,
    /// The pedestrian that the scenario's spawn rule places.
    pub pedestrian: PedestrianRole,
    /// All other pedestrians; each has its own start.
    pub others: Vec<Placed<PedestrianRole>>,
}

/// A role with its own start.
#[derive(Debug, Clone, PartialEq)]
pub struct Placed<R> {
    /// The actor.
    pub role: R,
    /// Its start in every episode.
    pub start: ActorStart,
}

/// A vehicle and its driver.
#[derive(Clone)]
pub struct VehicleRole {
    /// Its model.
    pub blueprint: VehicleBlueprint,
    /// Its driver.
    pub policy: PolicyMaker,
}

/// A pedestrian: its body, its observation, its action and its controller.
#[derive(Debug, Clone, PartialEq)]
pub struct PedestrianRole {
    /// Size and gait.
    pub body: PedestrianBody,
    /// The state that the controller gets.
    pub observation: ObservationSpec,
    /// The meaning of the controller's action.
    pub action: ActionSpec,
    /// The source of its commands.
    pub controller: Controller,
    /// The direction that it faces at the start, when the spawn rule places it and states no heading.
    pub first_heading: FirstHeading,
}

/// The source of a pedestrian's commands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Controller {
    /// The user of the environment: a walk policy, a search or a learner.
    External,
    /// A fixed command in every tick; the user of the environment has no influence on it.
    Fixed(WalkCommand),
}

choice! {
    /// The direction that a pedestrian faces at the start of an episode.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum FirstHeading {
        /// Any direction.
        Random = "random",
        TowardsEgo = "towards_ego",
    }
}

impl Cast {
    /// One car and one pedestrian.
    pub fn pair(ego: VehicleRole, pedestrian: PedestrianRole) -> Self {
        Self { ego, traffic: Vec::new(), pedestrian, others: Vec::new() }
    }

    /// All vehicles in the order of their numbers.
    pub fn vehicles(&self) -> impl Iterator<Item = &VehicleRole> {
        std::iter::once(&self.ego).chain(self.traffic.iter().map(|placed| &placed.role))
    }

    /// All pedestrians in the order of their numbers.
    pub fn pedestrians(&self) -> impl Iterator<Item = &PedestrianRole> {
        std::iter::once(&self.pedestrian).chain(self.others.iter().map(|placed| &placed.role))
    }

    pub fn vehicle(&self, number: usize) -> &VehicleRole {
        number.checked_sub(1).map_or(&self.ego, |index| &self.traffic[index].role)
    }

    pub fn pedestrian(&self, number: usize) -> &PedestrianRole {
        number.checked_sub(1).map_or(&self.pedestrian, |index| &self.others[index].role)
    }

    pub fn pedestrian_count(&self) -> usize {
        1 + self.others.len()
    }

    /// The pedestrians that the user of an environment controls, with their numbers.
    pub fn controlled(&self) -> impl Iterator<Item = (usize, &PedestrianRole)> {
        self.pedestrians().enumerate().filter(|(_, role)| role.controller == Controller::External)
    }

    /// The numbers of a joint state: those of all controlled pedestrians, one after another.
    pub fn obs_dim(&self) -> usize {
        self.controlled().map(|(_, role)| role.observation.dim()).sum()
    }

    /// The bounds of a joint action: those of all controlled pedestrians, one after another.
    pub fn action_bounds(&self) -> Vec<(f64, f64)> {
        self.controlled().flat_map(|(_, role)| role.action.bounds()).collect()
    }
}

impl std::fmt::Debug for Cast {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let vehicles = 1 + self.traffic.len();
        f.debug_struct("Cast").field("vehicles", &vehicles).field("pedestrians", &self.pedestrian_count()).finish()
    }
}

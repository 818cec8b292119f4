use std::sync::Arc;

use super::{ActionSpec, DriverParts, ObservationSpec};
use crate::av::DrivingPolicy;
use crate::sim::{ActorStart, PedestrianBody, VehicleBlueprint, WalkCommand};
use base::choice;

/// Makes a fresh driving policy; every episode's environment owns one for each vehicle.
pub type PolicyMaker = Arc<dyn Fn() -> Box<dyn DrivingPolicy> + Send + Sync>;

/// The actors of a scenario, in the order of their numbers in a world.
#[derive(Clone)]
pub struct Cast {
    /// The first is the ego, the car under test.
    pub vehicles: Vec<VehicleRole>,
    pub pedestrians: Vec<PedestrianRole>,
}

/// A vehicle and its driver.
#[derive(Clone)]
pub struct VehicleRole {
    /// Its model.
    pub blueprint: VehicleBlueprint,
    /// Its driver.
    pub policy: PolicyMaker,
    /// What can be exchanged of the driver.
    pub parts: Arc<DriverParts>,
    /// Its start in every episode; `None` for the ego, which the scenario's spawn rule places.
    pub start: Option<ActorStart>,
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
    /// Its start in every episode; `None` for the first pedestrian, which the scenario's spawn rule places.
    pub start: Option<ActorStart>,
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
        Self { vehicles: vec![ego], pedestrians: vec![pedestrian] }
    }

    /// The car under test.
    pub fn ego(&self) -> &VehicleRole {
        &self.vehicles[0]
    }

    /// The pedestrian that the scenario's spawn rule places.
    pub fn pedestrian(&self) -> &PedestrianRole {
        &self.pedestrians[0]
    }

    /// The pedestrians that the user of an environment controls, with their numbers.
    pub fn controlled(&self) -> impl Iterator<Item = (usize, &PedestrianRole)> {
        self.pedestrians.iter().enumerate().filter(|(_, role)| role.controller == Controller::External)
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
        let Self { vehicles, pedestrians } = self;
        f.debug_struct("Cast").field("vehicles", &vehicles.len()).field("pedestrians", &pedestrians.len()).finish()
    }
}

use std::sync::Arc;

use crate::walker;
use crate::{ActionSpec, DriverParts, ObservationSpec, Placement, PolicyMaker};
use base::choice;
use learn::{Agent, Policies};
use world::sim::{ActorId, PedestrianBody, VehicleBlueprint, WalkCommand};

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
    /// Its name in the scenario.
    pub name: Arc<str>,
    /// Its model.
    pub blueprint: VehicleBlueprint,
    /// Its driver.
    pub policy: PolicyMaker,
    /// What can be exchanged of the driver.
    pub parts: Arc<DriverParts>,
    /// Whether it is parked. Then its driver is never asked.
    pub is_parked: bool,
    /// Whether it is left out of all episodes, though it is drawn as if it were in them: the counterfactual of the same scenario with it.
    pub is_absent: bool,
    pub place: Placement,
}

/// A pedestrian: its body, its observation, its action and its controller.
#[derive(Debug, Clone, PartialEq)]
pub struct PedestrianRole {
    /// Its name in the scenario. The members of a group share it.
    pub name: Arc<str>,
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
    /// Whether it is left out of all episodes, though it is drawn as if it were in them.
    pub is_absent: bool,
    pub place: Placement,
}

/// The source of a pedestrian's commands.
#[derive(Debug, Clone, PartialEq)]
pub enum Controller {
    /// The user of the environment: a walk policy, a search or a learner.
    External,
    /// A fixed command in every tick; the user of the environment has no influence on it.
    Fixed(WalkCommand),
    /// A controller of its own, which chooses within the simulation; the user of the environment has no influence on it.
    Own(walker::Controller),
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

    /// The same without an actor, from which no other one is drawn otherwise.
    pub fn without(&self, actor: ActorId) -> Self {
        let mut cast = self.clone();
        match actor {
            ActorId::Vehicle(number) => cast.vehicles[usize::from(number)].is_absent = true,
            ActorId::Pedestrian(number) => cast.pedestrians[usize::from(number)].is_absent = true,
        }
        cast
    }

    /// Whether an actor is left out.
    pub fn is_absent(&self, actor: ActorId) -> bool {
        match actor {
            ActorId::Vehicle(number) => self.vehicles[usize::from(number)].is_absent,
            ActorId::Pedestrian(number) => self.pedestrians[usize::from(number)].is_absent,
        }
    }

    /// The ego and one pedestrian, which is left to the user of the environment.
    pub fn alone(&self, pedestrian: usize) -> Self {
        let role = PedestrianRole { controller: Controller::External, ..self.pedestrians[pedestrian].clone() };
        Self::pair(self.ego().clone(), role)
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

    /// The place of an actor's role.
    pub fn place(&self, actor: ActorId) -> &Placement {
        match actor {
            ActorId::Vehicle(number) => &self.vehicles[usize::from(number)].place,
            ActorId::Pedestrian(number) => &self.pedestrians[usize::from(number)].place,
        }
    }

    /// The name of an actor's role.
    pub fn name(&self, actor: ActorId) -> &Arc<str> {
        match actor {
            ActorId::Vehicle(number) => &self.vehicles[usize::from(number)].name,
            ActorId::Pedestrian(number) => &self.pedestrians[usize::from(number)].name,
        }
    }

    /// The role of a pedestrian: the number of the first with its name.
    pub fn role(&self, pedestrian: usize) -> u8 {
        let name = &self.pedestrians[pedestrian].name;
        self.pedestrians.iter().position(|each| each.name == *name).unwrap_or(pedestrian) as u8
    }

    /// All actors: the vehicles, then the pedestrians.
    pub fn actors(&self) -> impl Iterator<Item = ActorId> + use<> {
        let (vehicles, pedestrians) = (self.vehicles.len() as u8, self.pedestrians.len() as u8);
        (0..vehicles).map(ActorId::Vehicle).chain((0..pedestrians).map(ActorId::Pedestrian))
    }

    /// The numbers of a joint state: those of all controlled pedestrians, one after another.
    pub fn obs_dim(&self) -> usize {
        self.controlled().map(|(_, role)| role.observation.dim()).sum()
    }

    /// The agents that choose for the controlled pedestrians: one for all of them, or one each, whose policy is that of all or of its role.
    pub fn agents(&self, policies: Option<Policies>) -> Vec<Agent> {
        let Some(policies) = policies else {
            return vec![Agent { policy: 0, obs_dim: self.obs_dim(), action_bounds: self.action_bounds() }];
        };
        let mut roles = Vec::new();
        let agents = self.controlled().map(|(number, role)| {
            let own = self.role(number);
            if !roles.contains(&own) && (policies == Policies::Each || roles.is_empty()) {
                roles.push(own);
            }
            let policy = roles.iter().position(|each| *each == own).unwrap_or_default();
            Agent { policy, obs_dim: role.observation.dim(), action_bounds: role.action.bounds().to_vec() }
        });
        agents.collect()
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

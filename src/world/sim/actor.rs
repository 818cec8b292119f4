use super::{Control, PedestrianBody, PedestrianState, VehicleBlueprint, VehicleState, WalkCommand};
use road::geometry::{Obstacles, OrientedBox, Vector};
use road::{FIRST_LIMIT, Town};

/// The identity of an actor of a world: its number among the vehicles or among the pedestrians. It stays the same for a whole episode.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize, serde::Deserialize)]
pub enum ActorId {
    Vehicle(u8),
    Pedestrian(u8),
}

impl ActorId {
    /// The car under test.
    pub const EGO: Self = Self::Vehicle(0);

    /// Maximum number of vehicles, and of pedestrians, in a world.
    pub const MAX_COUNT: usize = 255;

    /// A number that tells it from all other actors: 0 for the ego.
    pub fn code(self) -> usize {
        match self {
            Self::Vehicle(number) => number.into(),
            Self::Pedestrian(number) => usize::from(number) + Self::MAX_COUNT + 1,
        }
    }

    /// The actor of a number that [`ActorId::code`] gave.
    pub fn of_code(code: usize) -> Self {
        match code.checked_sub(Self::MAX_COUNT + 1) {
            None => Self::Vehicle(code as u8),
            Some(number) => Self::Pedestrian(number as u8),
        }
    }

    /// The number among the actors of its kind.
    pub fn number(self) -> usize {
        match self {
            Self::Vehicle(number) | Self::Pedestrian(number) => number.into(),
        }
    }
}

/// A vehicle of a world.
#[derive(Debug, Clone, PartialEq)]
pub struct Vehicle {
    /// Its model.
    pub blueprint: VehicleBlueprint,
    /// Its pose and speed.
    pub state: VehicleState,
    /// The limit of the last sign that it passed (m/s).
    pub speed_limit: f64,
    /// Whether it is in the world: otherwise it stays where it is, and nobody sees or touches it.
    pub is_present: bool,
    /// Whether it is parked: it does not move, blocks sight, and pedestrians walk around it.
    pub is_parked: bool,
    /// Its state one tick earlier.
    pub(super) before: VehicleState,
}

impl Vehicle {
    /// A vehicle that stands at the origin.
    pub(super) fn new(blueprint: VehicleBlueprint) -> Self {
        let state = VehicleState::default();
        Self { blueprint, state, speed_limit: FIRST_LIMIT, is_present: true, is_parked: false, before: state }
    }

    /// Its greatest speed in the last tick (m/s).
    pub(super) fn fastest(&self) -> f64 {
        self.before.speed.max(self.state.speed)
    }

    /// Whether a driver moves it.
    pub fn is_driven(&self) -> bool {
        self.is_present && !self.is_parked
    }

    /// The box that the vehicle fills.
    pub fn outline(&self) -> OrientedBox {
        self.state.outline(&self.blueprint)
    }

    /// The traffic light in whose trigger box the vehicle stands: its place among the town's lights.
    pub fn affecting_light(&self, town: &Town) -> Option<usize> {
        let reach = self.blueprint.half_length + 3.0;
        let outline = self.outline();
        town.traffic_lights.iter().position(|light| {
            let offset = light.trigger.pose.position() - self.state.pose.position();
            offset.norm_squared() < reach * reach
                && light.trigger.overlaps(&outline)
                && self.is_under(&light.trigger, town)
        })
    }

    /// Whether a trigger box is on its level.
    fn is_under(&self, trigger: &OrientedBox, town: &Town) -> bool {
        town.is_on_level(self.state.place(), town.place_of_car(&trigger.pose))
    }

    /// Places the vehicle at the start of an episode.
    pub(super) fn begin(&mut self, state: VehicleState, town: &Town) {
        let state = VehicleState { ground: town.place_of_car(&state.pose).ground.unwrap_or_default(), ..state };
        (self.state, self.before) = (state, state);
        self.speed_limit = FIRST_LIMIT;
        self.obey_signs(town);
    }

    /// Simulates one tick, if a driver moves it.
    #[inline]
    pub(super) fn step(&mut self, control: Control, town: &Town, dt: f64) {
        if !self.is_driven() {
            return;
        }
        self.follow(self.state.step(control, &self.blueprint, dt), town);
    }

    /// Takes the state that it has after a tick.
    #[inline]
    pub(super) fn follow(&mut self, state: VehicleState, town: &Town) {
        (self.before, self.state) = (self.state, state);
        if town.has_levels() {
            self.state.ground = town.ground(state.pose.position(), self.before.ground);
        }
        self.obey_signs(town);
    }

    #[inline]
    fn obey_signs(&mut self, town: &Town) {
        let reach = self.blueprint.half_length + 4.0;
        for sign in &town.speed_signs {
            let offset = sign.trigger.pose.position() - self.state.pose.position();
            if offset.norm_squared() < reach * reach
                && sign.trigger.overlaps(&self.outline())
                && self.is_under(&sign.trigger, town)
            {
                self.speed_limit = sign.limit;
            }
        }
    }
}

/// A pedestrian of a world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pedestrian {
    /// Its size and gait.
    pub body: PedestrianBody,
    /// Its pose and velocity.
    pub state: PedestrianState,
    /// Whether it is in the world: otherwise it stays where it is, and nobody sees or touches it.
    pub is_present: bool,
    /// Whether it is there no more since a car has struck it: it lies where it is.
    pub is_struck: bool,
    /// Its state one tick earlier.
    pub(super) before: PedestrianState,
}

impl Pedestrian {
    /// A pedestrian that stands at the origin.
    pub(super) fn new(body: PedestrianBody) -> Self {
        let state = PedestrianState::default();
        Self { body, state, is_present: true, is_struck: false, before: state }
    }

    /// Takes it out of the world, since a car has struck it.
    pub fn strike(&mut self) {
        (self.is_present, self.is_struck) = (false, true);
        self.state.velocity = Vector::zeros();
    }

    /// Places the pedestrian at the start of an episode.
    pub(super) fn begin(&mut self, state: PedestrianState) {
        (self.state, self.before, self.is_struck) = (state, state, false);
    }

    /// Simulates one tick.
    #[inline]
    pub(super) fn step(&mut self, command: WalkCommand, obstacles: &Obstacles, town: &Town, dt: f64) {
        self.before = self.state;
        if !self.is_present {
            return;
        }
        self.state = self.before.step(command, &self.body, obstacles, dt);
        if town.has_levels() {
            self.state.ground = town.ground(self.state.pose.position(), self.before.ground);
        }
    }
}

use super::{EpisodeRule, Scenario};
use crate::av::DrivingMode;
use crate::geometry::{OrientedBox, Point, Vector};
use crate::sim::{Contact, Control, PedestrianState, VehicleState, WalkCommand, World};

/// From the bumper back to the driver's eye (m).
const EYE: f64 = 1.9;

/// Where everybody was at a tick, and what the driver had done to get there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moment {
    /// The car.
    pub ego: VehicleState,
    /// The pedestrian.
    pub pedestrian: PedestrianState,
    /// What the driver was doing in the tick that led here; at the beginning, nothing yet.
    pub mode: DrivingMode,
    /// Its pedals and its wheel in that tick.
    pub control: Control,
}

impl Moment {
    /// Where the driver's eye is: 1.9 m behind the bumper, on the axis.
    pub fn eye(&self, scenario: &Scenario) -> Point {
        self.ego.pose.to_world(Vector::new(scenario.vehicle.half_length - EYE, 0.0))
    }

    /// Whether the middle or an edge of the pedestrian is in sight from the driver's eye.
    pub fn in_sight(&self, scenario: &Scenario) -> bool {
        let (radius, position) = (scenario.adversary.body.radius, self.pedestrian.pose.position());
        let eye = self.eye(scenario);
        let sight = (position - eye).try_normalize(1e-9).unwrap_or_else(Vector::x);
        let edge = Vector::new(-sight.y, sight.x) * radius;
        [Vector::zeros(), edge, -edge].iter().any(|offset| !scenario.obstacles.blocks_sight(eye, position + offset))
    }

    /// Distance from the pedestrian's disc to the car's box (m); 0 when they touch.
    pub fn gap(&self, scenario: &Scenario) -> f64 {
        let place = self.pedestrian.pose.position();
        (self.outline(scenario).distance_to(place) - scenario.adversary.body.radius).max(0.0)
    }

    /// The box that the car fills.
    pub fn outline(&self, scenario: &Scenario) -> OrientedBox {
        self.ego.outline(&scenario.vehicle)
    }
}

/// What happened in an episode: the commands of the pedestrian, and where everybody was from tick to tick.
///
/// Its memory is there before the episode begins. What can be said of a moment afterwards, such as who saw whom, is not
/// written down.
#[derive(Debug, Clone)]
pub struct Recording {
    commands: Vec<WalkCommand>,
    moments: Vec<Moment>,
    contact: Option<Contact>,
}

/// More ticks than this are not reserved beforehand.
const RESERVED: u32 = 20_000;

impl Recording {
    /// Reserves memory for an episode of this length.
    pub fn new(rule: &EpisodeRule) -> Self {
        let ticks = rule.ticks.min(RESERVED);
        Self {
            commands: Vec::with_capacity((ticks / rule.hold) as usize + 1),
            moments: Vec::with_capacity(ticks as usize + 1),
            contact: None,
        }
    }

    /// Forgets the last episode; the world is where the next one begins.
    pub fn begin(&mut self, world: &World) {
        self.commands.clear();
        self.moments.clear();
        self.watch(world, None, Default::default());
    }

    /// Notes a decision of the pedestrian.
    pub fn decide(&mut self, command: WalkCommand) {
        self.commands.push(command);
    }

    /// Notes where everybody is after a tick, whether they touched in it, and what the driver did.
    pub fn watch(&mut self, world: &World, contact: Option<&Contact>, (mode, control): (DrivingMode, Control)) {
        self.moments.push(Moment { ego: world.ego().state, pedestrian: world.pedestrians[0].state, mode, control });
        self.contact = contact.copied();
    }

    /// The decisions; an environment that is given them again repeats the episode.
    pub fn commands(&self) -> &[WalkCommand] {
        &self.commands
    }

    /// Everybody at the beginning and after each tick.
    pub fn moments(&self) -> &[Moment] {
        &self.moments
    }

    /// How they touched in the last tick; none when they did not.
    pub fn contact(&self) -> Option<&Contact> {
        self.contact.as_ref()
    }
}

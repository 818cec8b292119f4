use super::EpisodeRule;
use crate::sim::{Contact, PedestrianState, VehicleState, WalkCommand, World};

/// Where everybody was at a tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moment {
    /// The car.
    pub ego: VehicleState,
    /// The pedestrian.
    pub pedestrian: PedestrianState,
}

/// What happened in an episode: the commands of the pedestrian, and where everybody was from tick to tick.
///
/// Its memory is there before the episode begins.
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
        self.watch(world, None);
    }

    /// Notes a decision of the pedestrian.
    pub fn decide(&mut self, command: WalkCommand) {
        self.commands.push(command);
    }

    /// Notes where everybody is after a tick, and whether they touched in it.
    pub fn watch(&mut self, world: &World, contact: Option<&Contact>) {
        self.moments.push(Moment { ego: world.ego, pedestrian: world.pedestrian });
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

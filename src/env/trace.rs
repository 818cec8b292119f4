use super::{Pair, PedestrianEnv, Scenario};
use crate::av::DrivingMode;
use crate::rl::Step;
use crate::sim::{Contact, Control, PedestrianState, VehicleState, WalkCommand, World};

/// What a driver did in a tick.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Driven {
    /// What the driver was doing.
    pub mode: DrivingMode,
    /// Its pedals and its wheel.
    pub control: Control,
}

/// A vehicle after a tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VehicleFrame {
    /// Where it is.
    pub state: VehicleState,
    /// What its driver did in the tick that led here; nothing yet at the start.
    pub driven: Driven,
}

/// What happened in an episode: a track of each actor from tick to tick, the decisions of each pedestrian, and the touch that ended
/// it.
///
/// Its memory is reserved before the episode starts. What follows from the tracks, such as who saw whom, is not stored; a [`Pair`]
/// works it out.
#[derive(Debug, Clone)]
pub struct Trace {
    vehicles: Vec<Vec<VehicleFrame>>,
    pedestrians: Vec<PedestrianTrack>,
    contact: Option<Contact>,
}

/// A pedestrian from tick to tick, and what it decided.
#[derive(Debug, Clone, Default)]
struct PedestrianTrack {
    states: Vec<PedestrianState>,
    decisions: Vec<WalkCommand>,
}

/// Memory for more ticks than this is not reserved in advance.
const RESERVED: u32 = 20_000;

impl Trace {
    /// Reserves memory for the actors and the length of a scenario's episodes.
    pub fn new(scenario: &Scenario) -> Self {
        let rule = &scenario.episode;
        let ticks = rule.ticks.min(RESERVED);
        let frames = ticks as usize + 1;
        let decisions = (ticks / rule.hold) as usize + 1;
        let track =
            |_| PedestrianTrack { states: Vec::with_capacity(frames), decisions: Vec::with_capacity(decisions) };
        Self {
            vehicles: scenario.cast.vehicles().map(|_| Vec::with_capacity(frames)).collect(),
            pedestrians: scenario.cast.pedestrians().map(track).collect(),
            contact: None,
        }
    }

    /// Forgets the last episode; the world is at the start of the next one.
    pub fn begin(&mut self, world: &World) {
        self.vehicles.iter_mut().for_each(Vec::clear);
        for track in &mut self.pedestrians {
            track.states.clear();
            track.decisions.clear();
        }
        self.watch(world, None, |_| Driven::default());
    }

    /// Notes a decision: the command that each pedestrian carries out.
    pub fn decide(&mut self, commands: &[WalkCommand]) {
        for (track, command) in self.pedestrians.iter_mut().zip(commands) {
            track.decisions.push(*command);
        }
    }

    /// Notes where all actors are after a tick, whether two of them touched in it, and what the driver of each vehicle did.
    #[inline]
    pub fn watch(&mut self, world: &World, contact: Option<&Contact>, driven: impl Fn(usize) -> Driven) {
        for (number, (track, vehicle)) in self.vehicles.iter_mut().zip(&world.vehicles).enumerate() {
            track.push(VehicleFrame { state: vehicle.state, driven: driven(number) });
        }
        for (track, pedestrian) in self.pedestrians.iter_mut().zip(&world.pedestrians) {
            track.states.push(pedestrian.state);
        }
        self.contact = contact.copied();
    }

    /// Moves an environment on by one tick and notes it.
    pub fn watch_tick(&mut self, env: &mut PedestrianEnv) -> Option<Step> {
        let step = env.tick();
        self.watch(env.world(), env.contact(), |vehicle| env.driven(vehicle));
        step
    }

    /// Carries a decision out in an environment and notes all of its ticks.
    pub fn watch_decision(&mut self, env: &mut PedestrianEnv, commands: &[WalkCommand]) -> Step {
        env.begin_decision(commands);
        self.decide(env.commands());
        loop {
            if let Some(step) = self.watch_tick(env) {
                return step;
            }
        }
    }

    /// The number of pedestrians.
    pub fn pedestrian_count(&self) -> usize {
        self.pedestrians.len()
    }

    /// The track of a vehicle: at the start, and after each tick.
    pub fn vehicle(&self, number: usize) -> &[VehicleFrame] {
        &self.vehicles[number]
    }

    /// The track of a pedestrian: at the start, and after each tick.
    pub fn pedestrian(&self, number: usize) -> &[PedestrianState] {
        &self.pedestrians[number].states
    }

    /// The decisions of a pedestrian.
    pub fn decisions(&self, pedestrian: usize) -> &[WalkCommand] {
        &self.pedestrians[pedestrian].decisions
    }

    /// The touch in the last tick; none when no actors touched.
    pub fn contact(&self) -> Option<&Contact> {
        self.contact.as_ref()
    }

    /// The episode as it was for one vehicle and one pedestrian.
    pub fn pair<'a>(&'a self, scenario: &'a Scenario, vehicle: usize, pedestrian: usize) -> Pair<'a> {
        Pair::new(scenario, self, vehicle, pedestrian)
    }

    /// The pair that an episode is judged by: the ego and the pedestrian that it touched, or the first pedestrian when it touched
    /// none.
    pub fn main_pair<'a>(&'a self, scenario: &'a Scenario) -> Pair<'a> {
        let struck = self.contact.and_then(|contact| contact.pedestrian_at_ego());
        self.pair(scenario, 0, struck.unwrap_or(0))
    }
}

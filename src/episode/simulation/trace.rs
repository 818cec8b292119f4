use std::sync::Arc;

use crate::requirement::Degree;
use crate::{Observer, Pair, Scenario, Scene};
use road::geometry::Obstacles;
use world::av::DrivingMode;
use world::sim::{Contact, Control, LightClock, PedestrianState, VehicleState, WalkCommand, World};

/// The action of a driver in a tick.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Driven {
    pub mode: DrivingMode,
    /// Its pedals and its wheel.
    pub control: Control,
}

/// A vehicle after a tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VehicleFrame {
    pub state: VehicleState,
    /// The action of its driver in the tick that ended here; nothing yet at the start.
    pub driven: Driven,
}

/// The record of an episode: a track of each actor from tick to tick, the decisions of each pedestrian, and the touch that ended it.
///
/// Its memory is reserved before the episode starts. Quantities that follow from the tracks, such as visibility, are not stored; a
/// [`Pair`] computes them.
#[derive(Debug, Clone)]
pub struct Trace {
    vehicles: Vec<Vec<VehicleFrame>>,
    pedestrians: Vec<PedestrianTrack>,
    contact: Option<Contact>,
    lights: Option<LightClock>,
    on_map: bool,
    /// The noise of the pedestrian's velocities, as a mean over half a second (m/s); 0 of an episode of a simulator.
    velocity_noise: f64,
    degrees: Vec<Degree>,
    /// The obstacles with the parked vehicles of the episode; `None` if those of the scenario are all.
    obstacles: Option<Arc<Obstacles>>,
}

/// A pedestrian from tick to tick, and its decisions.
#[derive(Debug, Clone, Default)]
struct PedestrianTrack {
    states: Vec<PedestrianState>,
    /// The frame from which on it is not in the world: the car touched it in that tick, and another later.
    gone: Option<usize>,
    decisions: Vec<WalkCommand>,
}

/// Maximum number of ticks for which memory is reserved in advance.
const RESERVED: u32 = 20_000;

impl Observer for Trace {
    /// Clears the last episode.
    fn begin(&mut self, scene: &Scene<'_>) {
        self.vehicles.iter_mut().for_each(Vec::clear);
        for track in &mut self.pedestrians {
            track.states.clear();
            track.gone = None;
            track.decisions.clear();
        }
        self.degrees.clear();
        self.lights = scene.world.light_clock();
        let has_parked = scene.world.vehicles.iter().any(|vehicle| vehicle.is_parked);
        self.obstacles = has_parked.then(|| scene.world.obstacles.clone());
        self.record(scene.world, |_| Driven::default());
        self.contact = None;
    }

    /// Records a decision: the command that each pedestrian carries out. The first decision may have moved a target to its start.
    fn decide(&mut self, scene: &Scene<'_>) {
        let pedestrians = &scene.world.pedestrians;
        for ((track, command), pedestrian) in self.pedestrians.iter_mut().zip(scene.commands()).zip(pedestrians) {
            if let [only] = track.states.as_mut_slice() {
                *only = pedestrian.state;
            }
            track.decisions.push(*command);
        }
    }

    /// Records the state of all actors after a tick, whether two of them touched in it, and what the driver of each vehicle did. A tick that is
    /// told again takes the place of what followed: the episode ended with an earlier touch.
    fn tick(&mut self, scene: &Scene<'_>) {
        if self.pedestrians.iter().any(|track| track.gone.is_some()) {
            self.cut(scene.world.ticks as usize);
        }
        self.record(scene.world, |vehicle| scene.driven(vehicle));
        self.contact = scene.contact().copied();
    }

    fn end(&mut self, degrees: &[Degree]) {
        self.degrees.extend_from_slice(degrees);
    }
}

impl Trace {
    /// Keeps this number of frames.
    fn cut(&mut self, frames: usize) {
        self.vehicles.iter_mut().for_each(|track| track.truncate(frames));
        for track in &mut self.pedestrians {
            track.states.truncate(frames);
            track.gone = track.gone.filter(|gone| *gone < frames);
        }
    }

    /// The car has touched a pedestrian in the last tick. `next` is the next touch in it.
    pub(super) fn touch(&mut self, pedestrian: usize, next: Option<Contact>) {
        let track = &mut self.pedestrians[pedestrian];
        track.gone = Some(track.states.len() - 1);
        self.contact = next;
    }

    #[inline]
    fn record(&mut self, world: &World, driven: impl Fn(usize) -> Driven) {
        for (number, (track, vehicle)) in self.vehicles.iter_mut().zip(&world.vehicles).enumerate() {
            track.push(VehicleFrame { state: vehicle.state, driven: driven(number) });
        }
        for (track, pedestrian) in self.pedestrians.iter_mut().zip(&world.pedestrians) {
            if !pedestrian.is_present {
                track.gone.get_or_insert(track.states.len());
            }
            track.states.push(pedestrian.state);
        }
    }

    /// Reserves memory for the actors and the length of a scenario's episodes.
    pub fn new(scenario: &Scenario) -> Self {
        let rule = &scenario.episode;
        let ticks = rule.ticks.min(RESERVED);
        let frames = ticks as usize + 1;
        let decisions = (ticks / rule.hold) as usize + 1;
        let track = |_| PedestrianTrack {
            states: Vec::with_capacity(frames),
            gone: None,
            decisions: Vec::with_capacity(decisions),
        };
        Self {
            vehicles: scenario.cast.vehicles.iter().map(|_| Vec::with_capacity(frames)).collect(),
            pedestrians: scenario.cast.pedestrians.iter().map(track).collect(),
            contact: None,
            lights: None,
            on_map: true,
            velocity_noise: 0.0,
            degrees: Vec::with_capacity(scenario.requirements.len()),
            obstacles: None,
        }
    }

    /// The record of a car and a pedestrian that were recorded elsewhere: their states at the start and after each tick, and a decision for
    /// each tick. `velocity_noise` is that of the pedestrian's velocities, as a mean over half a second (m/s).
    pub fn recorded(
        driving: Vec<VehicleFrame>,
        walking: Vec<PedestrianState>,
        decisions: Vec<WalkCommand>,
        contact: Option<Contact>,
        velocity_noise: f64,
    ) -> Self {
        Self {
            velocity_noise,
            vehicles: vec![driving],
            pedestrians: vec![PedestrianTrack { states: walking, gone: None, decisions }],
            contact,
            lights: None,
            on_map: false,
            degrees: Vec::new(),
            obstacles: None,
        }
    }

    /// See [`Pair::velocity_noise`].
    pub(super) fn velocity_noise(&self) -> f64 {
        self.velocity_noise
    }

    /// Whether the episode took place on the scenario's map. A recording from elsewhere did not.
    pub fn is_on_map(&self) -> bool {
        self.on_map
    }

    /// The clock of the traffic lights at the start; `None` if they are switched off, and in a recording from elsewhere.
    pub fn lights(&self) -> Option<LightClock> {
        self.lights
    }

    /// The degree of each requirement of the scenario; empty without requirements, and where the episode is not over or in error.
    pub fn degrees(&self) -> &[Degree] {
        &self.degrees
    }

    /// What blocks pedestrians and sight in the episode.
    pub fn obstacles<'a>(&'a self, scenario: &'a Scenario) -> &'a Arc<Obstacles> {
        self.obstacles.as_ref().unwrap_or(&scenario.obstacles)
    }

    pub fn vehicle_count(&self) -> usize {
        self.vehicles.len()
    }

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

    /// Whether a pedestrian was in the world after a tick. Whom the car has touched before it touches another is not, from the touch on.
    pub fn is_present(&self, pedestrian: usize, tick: usize) -> bool {
        self.pedestrians[pedestrian].gone.is_none_or(|gone| tick < gone)
    }

    pub fn decisions(&self, pedestrian: usize) -> &[WalkCommand] {
        &self.pedestrians[pedestrian].decisions
    }

    /// The touch in the last tick; `None` if no actors touched.
    pub fn contact(&self) -> Option<&Contact> {
        self.contact.as_ref()
    }

    /// The episode as seen by one vehicle and one pedestrian.
    pub fn pair<'a>(&'a self, scenario: &'a Scenario, vehicle: usize, pedestrian: usize) -> Pair<'a> {
        Pair::new(scenario, self, vehicle, pedestrian)
    }

    /// The pair for the verdict on an episode: the ego and the pedestrian that it touched, or the first pedestrian when it touched none.
    pub fn main_pair<'a>(&'a self, scenario: &'a Scenario) -> Pair<'a> {
        let struck = self.contact.and_then(|contact| contact.pedestrian_at_ego());
        self.pair(scenario, 0, struck.unwrap_or(0))
    }
}

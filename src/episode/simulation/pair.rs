use std::sync::Arc;

use super::pursuit::{meeting_heading, walking_heading};
use super::trace::VehicleFrame;
use crate::requirement::Degree;
use crate::{ActionSpec, Observation, ObservationSpec, PedestrianRole, RecordedActor, ReferenceFrame, Scenario, Trace};
use road::geometry::{Obstacles, OrientedBox, Point, Vector};
use world::av::DrivingMode;
use world::sim::{
    ActorId, Contact, Control, PedestrianBody, PedestrianState, VehicleBlueprint, VehicleState, WalkCommand,
};

/// A vehicle and a pedestrian at a tick, and the driver's action in the tick that ended there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    /// The car.
    pub ego: VehicleState,
    pub pedestrian: PedestrianState,
    /// The driver's action in the tick that ended here; nothing yet at the start.
    pub mode: DrivingMode,
    /// Its pedals and its wheel in that tick.
    pub control: Control,
    /// The number of the tick; 0 at the start.
    pub tick: usize,
}

/// An episode as seen by one vehicle and one pedestrian: a view of two tracks of a [`Trace`].
#[derive(Debug, Clone, Copy)]
pub struct Pair<'a> {
    pub scenario: &'a Scenario,
    /// The model of the vehicle.
    pub blueprint: &'a VehicleBlueprint,
    pub body: &'a PedestrianBody,
    role: &'a PedestrianRole,
    driving: &'a [VehicleFrame],
    /// The states of the pedestrian: at the start, and after each tick.
    pub walking: &'a [PedestrianState],
    /// The decisions of the pedestrian.
    pub decisions: &'a [WalkCommand],
    /// The touch of the two in the last tick; `None` if they did not touch.
    pub contact: Option<&'a Contact>,
    /// The record of all actors.
    pub(super) trace: &'a Trace,
    actors: (ActorId, ActorId),
}

impl<'a> Pair<'a> {
    /// The tracks of a vehicle and a pedestrian.
    pub(super) fn new(scenario: &'a Scenario, trace: &'a Trace, vehicle: usize, pedestrian: usize) -> Self {
        let pair = (ActorId::Vehicle(vehicle as u8), ActorId::Pedestrian(pedestrian as u8));
        Self {
            scenario,
            blueprint: &scenario.cast.vehicles[vehicle].blueprint,
            body: &scenario.cast.pedestrians[pedestrian].body,
            role: &scenario.cast.pedestrians[pedestrian],
            driving: trace.vehicle(vehicle),
            walking: trace.pedestrian(pedestrian),
            decisions: trace.decisions(pedestrian),
            contact: trace.contact().filter(|contact| contact.pair == pair),
            trace,
            actors: pair,
        }
    }

    /// Length of a tick (s).
    pub fn dt(&self) -> f64 {
        self.scenario.episode.tick
    }

    /// The noise of the pedestrian's velocities in a recording from elsewhere, as a mean over half a second (m/s).
    pub fn velocity_noise(&self) -> f64 {
        self.trace.velocity_noise()
    }

    /// The degree of each requirement of the scenario in the episode; see [`Trace::degrees`].
    pub fn degrees(&self) -> &'a [Degree] {
        self.trace.degrees()
    }

    /// The pair of the ego and the pedestrian that the signals of a sample are about: the one that it touches, and otherwise the nearest one.
    pub fn of_sample(&self, sample: usize) -> Self {
        if self.contact.is_some() && sample + 1 >= self.len() || self.trace.pedestrian_count() == 1 {
            return *self;
        }
        let gap = |number: &usize| {
            let pair = self.trace.pair(self.scenario, 0, *number);
            pair.gap(&pair.frame(sample.min(pair.len() - 1)))
        };
        let nearest = (0..self.trace.pedestrian_count()).min_by(|a, b| gap(a).total_cmp(&gap(b)));
        self.trace.pair(self.scenario, 0, nearest.unwrap_or(0))
    }

    /// The name of the pedestrian's role.
    pub fn pedestrian_name(&self) -> &'a str {
        &self.role.name
    }

    /// The names of the actors that touched in the last tick, whichever they are; `None` without a touch.
    pub fn last_touch(&self) -> Option<[&'a str; 2]> {
        let (first, second) = self.trace.contact()?.pair;
        Some([first, second].map(|actor| &**self.scenario.cast.name(actor)))
    }

    /// An actor of the episode.
    pub fn actor(&self, id: ActorId) -> RecordedActor<'a> {
        RecordedActor::new(self.scenario, self.trace, id)
    }

    /// The other actors of the episode.
    pub fn others(&self) -> impl Iterator<Item = RecordedActor<'a>> + Clone + use<'a> {
        let (scenario, trace, pair) = (self.scenario, self.trace, self.actors);
        let (vehicles, pedestrians) = (trace.vehicle_count() as u8, trace.pedestrian_count() as u8);
        let all = (0..vehicles).map(ActorId::Vehicle).chain((0..pedestrians).map(ActorId::Pedestrian));
        all.filter(move |id| *id != pair.0 && *id != pair.1).map(move |id| RecordedActor::new(scenario, trace, id))
    }

    /// The pedestrian's number.
    pub(super) fn pedestrian_number(&self) -> usize {
        match self.actors.1 {
            ActorId::Pedestrian(number) => number.into(),
            ActorId::Vehicle(_) => 0,
        }
    }

    /// The decision that the pedestrian takes after this number of ticks; `None` if it keeps its command, and at the end.
    pub fn decision(&self, tick: usize) -> Option<WalkCommand> {
        let hold = self.scenario.episode.hold as usize;
        tick.is_multiple_of(hold).then(|| self.decisions.get(tick / hold).copied()).flatten()
    }

    /// The numbers about the ego in the state that the controller of the pedestrian gets in a frame, in the frame and units of its adversary.
    pub fn state(&self, frame: &Frame) -> [f64; ObservationSpec::DIM] {
        let (walking, ego, observation) = (&frame.pedestrian, &frame.ego, &self.role.observation);
        let seen = Observation::new(&walking.pose, walking.speed(), &ego.pose, ego.speed, observation.speed);
        observation.encode(&seen, &walking.pose, self.first_heading(), ego.pose.position())
    }

    /// The action of the controller for a decision in a frame, in the frame and units of its adversary, up to rounding.
    pub fn action(&self, frame: &Frame, decision: WalkCommand) -> [f64; ActionSpec::DIM] {
        let (pose, ego, action) = (&frame.pedestrian.pose, &frame.ego, &self.role.action);
        let origin = |speed: f64| match action.frame {
            ReferenceFrame::Destination => {
                let start = self.walking.first().map_or(pose.position(), |first| first.pose.position());
                let place = action.destination.and_then(|destination| destination.place(&self.scenario.town, start));
                walking_heading(pose.position(), place, &self.frame(0).ego.pose, start)
            }
            ReferenceFrame::Meeting => {
                let bumper = ego.pose.to_world(Vector::new(self.blueprint.half_length, 0.0));
                meeting_heading(pose.position(), ego, bumper, speed, 1.0)
            }
            other => other.origin(pose, self.first_heading(), ego.pose.position()),
        };
        action.action_for(decision, origin)
    }

    /// The heading of the pedestrian at the start (rad).
    fn first_heading(&self) -> f64 {
        self.walking.first().map_or(0.0, |first| first.pose.yaw)
    }

    /// The number of frames: one at the start and one for each tick.
    pub fn len(&self) -> usize {
        self.driving.len()
    }

    /// Whether there is no frame, since no episode has started.
    pub fn is_empty(&self) -> bool {
        self.driving.is_empty()
    }

    /// Both after a tick; tick 0 is the start.
    pub fn frame(&self, tick: usize) -> Frame {
        frame(tick, &self.driving[tick], &self.walking[tick])
    }

    /// Both at the end; `None` if no episode has started.
    pub fn last(&self) -> Option<Frame> {
        Some(self.frame(self.len().checked_sub(1)?))
    }

    /// Both at the start and after each tick.
    pub fn frames(&self) -> impl ExactSizeIterator<Item = Frame> + DoubleEndedIterator + Clone + use<'a> {
        let states = self.driving.iter().zip(self.walking).enumerate();
        states.map(|(tick, (vehicle, pedestrian))| frame(tick, vehicle, pedestrian))
    }

    /// The position of the driver's eye: 1.9 m behind the bumper, on the axis.
    pub fn eye(&self, frame: &Frame) -> Point {
        frame.ego.eye(self.blueprint)
    }

    /// What blocks the pedestrian and sight: the obstacles of the town, and parked vehicles.
    pub fn obstacles(&self) -> &'a Arc<Obstacles> {
        self.trace.obstacles(self.scenario)
    }

    /// Whether any of the pedestrian can be seen from the driver's eye. Obstacles and other actors hide it.
    pub fn in_sight(&self, frame: &Frame) -> bool {
        let target = (frame.pedestrian.pose.position(), self.body.radius);
        let others = self.others().filter(|actor| {
            !actor.is_parked && actor.is_present(frame.tick) && !self.scenario.cast.is_absent(actor.id)
        });
        let others = others.map(|actor| OrientedBox { pose: actor.state(frame.tick).0, half: actor.half });
        self.is_on_level(frame) && self.obstacles().shows(self.eye(frame), target, others)
    }

    /// Whether both are on one level. Otherwise they neither meet nor see each other.
    pub fn is_on_level(&self, frame: &Frame) -> bool {
        !self.is_on_map() || self.scenario.town.is_on_level(frame.ego.place(), frame.pedestrian.place())
    }

    /// Whether the episode took place on the scenario's map. A recording from elsewhere did not.
    pub fn is_on_map(&self) -> bool {
        self.trace.is_on_map()
    }

    /// Distance from the pedestrian to the car's box (m); 0 when they touch.
    pub fn gap(&self, frame: &Frame) -> f64 {
        let gap = frame.pedestrian.gap_to(&self.outline(frame), self.body);
        if self.is_on_level(frame) { gap } else { f64::INFINITY }
    }

    /// The box of the car.
    pub fn outline(&self, frame: &Frame) -> OrientedBox {
        frame.ego.outline(self.blueprint)
    }
}

fn frame(tick: usize, vehicle: &VehicleFrame, pedestrian: &PedestrianState) -> Frame {
    let VehicleFrame { state, driven } = vehicle;
    Frame { ego: *state, pedestrian: *pedestrian, mode: driven.mode, control: driven.control, tick }
}

use std::ops::Range;
use std::sync::Arc;

use super::{Recording, RecordingError, Sizes};
use road::geometry::{Obstacles, OrientedBox, Point, Pose, Vector};
use world::sim::{PedestrianState, VehicleState};

/// An actor of a recording at instants in a row.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordedActor {
    pub name: String,
    pub is_pedestrian: bool,
    /// Length and width (m), as far as they are recorded.
    pub size: Option<(f64, f64)>,
    /// Its first instant.
    pub first: usize,
    /// The pose of its middle at each instant from then on, and its velocity (m/s), as far as it is recorded.
    pub states: Vec<(Pose, Option<Vector>)>,
}

/// Cars and pedestrians that were recorded together, at instants that are `dt` (s) apart.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordedScene {
    pub dt: f64,
    pub actors: Vec<RecordedActor>,
    /// The name of the car that recorded; `None` if nobody says.
    pub host: Option<String>,
    /// What stands there all the time and hides a pedestrian.
    pub obstacles: Vec<OrientedBox>,
}

/// A car and a pedestrian that come near each other.
#[derive(Debug, Clone)]
pub struct Meeting {
    /// The instant of the recording at which that of the two begins.
    pub first: usize,
    pub recording: Recording,
    pub sizes: Sizes,
    pub obstacles: Arc<Obstacles>,
}

/// The names of a car and of a pedestrian, and how they meet.
pub type NamedMeeting = (String, String, Result<Meeting, RecordingError>);

/// Time before and after the least distance of two that is judged (s).
const AROUND: (f64, f64) = (20.0, 5.0);
/// A vehicle that moves less than this (m) in the whole recording is an obstacle.
const PARKED: f64 = 0.1;

impl RecordedActor {
    fn instants(&self) -> Range<usize> {
        self.first..self.first + self.states.len()
    }

    fn pose(&self, instant: usize) -> Pose {
        self.states[instant - self.first].0
    }

    /// The velocity at an instant (m/s): that of the positions around it where none is recorded.
    fn velocity(&self, instant: usize, dt: f64) -> Vector {
        let place = instant - self.first;
        self.states[place].1.unwrap_or_else(|| {
            let (before, after) = (place.saturating_sub(1), (place + 1).min(self.states.len() - 1));
            let moved = self.states[after].0.position() - self.states[before].0.position();
            moved / ((after - before).max(1) as f64 * dt)
        })
    }

    fn is_parked(&self) -> bool {
        let at = self.states[0].0.position();
        !self.is_pedestrian && self.states.iter().all(|(pose, _)| (pose.position() - at).norm() < PARKED)
    }

    fn outline(&self, instant: usize) -> OrientedBox {
        let (length, width) = self.size.unwrap_or((4.79, 2.16));
        OrientedBox::new(self.pose(instant), length / 2.0, width / 2.0)
    }

    fn radius(&self) -> Option<f64> {
        self.size.map(|(length, width)| (length + width) / 4.0)
    }
}

impl RecordedScene {
    /// The cars that are judged: the one that recorded, or all that move. `named` takes the place of that choice.
    fn cars<'a>(&'a self, named: Option<&'a str>) -> impl Iterator<Item = &'a RecordedActor> {
        let wanted = named.or(self.host.as_deref());
        let is_judged =
            move |actor: &&RecordedActor| wanted.map_or_else(|| !actor.is_parked(), |name| name == actor.name);
        self.actors.iter().filter(|actor| !actor.is_pedestrian).filter(is_judged)
    }

    /// The pairs of a car and a pedestrian that come nearer than `near` (m), each around its first touch or its least distance.
    ///
    /// # Errors
    /// The names of both, and why their recording cannot be judged. Without velocities of pedestrians, these come from the positions.
    pub fn meetings(&self, near: f64, car: Option<&str>, without_velocity: bool) -> Vec<NamedMeeting> {
        let mut found = Vec::new();
        for car in self.cars(car) {
            let is_parked = |actor: &&RecordedActor| actor.is_parked() && actor.name != car.name;
            let parked = self.actors.iter().filter(is_parked).map(|actor| actor.outline(actor.first));
            let obstacles: Vec<OrientedBox> = self.obstacles.iter().copied().chain(parked).collect();
            let obstacles = Arc::new(Obstacles::new(&obstacles));
            for pedestrian in self.actors.iter().filter(|actor| actor.is_pedestrian) {
                let Some(instants) = self.nearest(car, pedestrian, near) else { continue };
                let recording = self.recording(car, pedestrian, instants.clone(), without_velocity);
                let meeting = recording.map(|recording| Meeting {
                    first: instants.start,
                    recording,
                    sizes: Sizes {
                        length: car.size.map(|(length, _)| length),
                        width: car.size.map(|(_, width)| width),
                        radius: pedestrian.radius(),
                        full_brake: None,
                    },
                    obstacles: obstacles.clone(),
                });
                found.push((car.name.clone(), pedestrian.name.clone(), meeting));
            }
        }
        found
    }

    /// The instants around the first touch of two, or around their least distance; `None` if they do not come near.
    fn nearest(&self, car: &RecordedActor, pedestrian: &RecordedActor, near: f64) -> Option<Range<usize>> {
        let both = car.first.max(pedestrian.first)..car.instants().end.min(pedestrian.instants().end);
        let radius = pedestrian.radius().unwrap_or(0.188);
        let reach = car.outline(car.first).half.norm() + radius + near;
        let (mut least, mut at) = (near, None);
        for instant in both.clone() {
            let place: Point = pedestrian.pose(instant).position();
            if (place - car.pose(instant).position()).norm_squared() > reach * reach {
                continue;
            }
            let gap = car.outline(instant).distance_to(place) - radius;
            if gap < least {
                (least, at) = (gap, Some(instant));
            }
            if gap <= 0.0 {
                break;
            }
        }
        let count = |time: f64| (time / self.dt).round() as usize;
        let at = at?;
        let instants = at.saturating_sub(count(AROUND.0)).max(both.start)..(at + count(AROUND.1)).min(both.end);
        (instants.len() > 1).then_some(instants)
    }

    fn recording(
        &self,
        car: &RecordedActor,
        pedestrian: &RecordedActor,
        instants: Range<usize>,
        without_velocity: bool,
    ) -> Result<Recording, RecordingError> {
        let cars = instants.clone().map(|instant| {
            let pose = car.pose(instant);
            let speed = car.velocity(instant, self.dt).dot(&pose.forward());
            VehicleState { pose, speed, ..VehicleState::default() }
        });
        let cars = cars.collect();
        let is_told = |instant: usize| pedestrian.states[instant - pedestrian.first].1.is_some();
        if without_velocity || !instants.clone().all(is_told) {
            let places: Vec<Point> = instants.map(|instant| pedestrian.pose(instant).position()).collect();
            return Recording::of_positions(self.dt, cars, &places);
        }
        let walkers = instants.map(|instant| {
            let (pose, velocity) = (pedestrian.pose(instant), pedestrian.velocity(instant, self.dt));
            let yaw = libm::atan2(velocity.y, velocity.x);
            PedestrianState { velocity, ..PedestrianState::standing(Pose { yaw, ..pose }) }
        });
        Recording::new(self.dt, cars, walkers.collect())
    }
}

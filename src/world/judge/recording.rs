use std::sync::Arc;

use super::recording_units::{Misfit, misfit};
use super::{NearMiss, Verdict, ViolationVerdict, judge};
use crate::env::{Driven, OtherDrive, Scenario, Trace, VehicleFrame, is_about_map};
use crate::geometry::{Obstacles, Point, Pose, Vector, wrap_angle};
use crate::requirement::{Degree, NamedRequirement};
use crate::sim::{Contact, PedestrianState, VehicleState, WalkCommand};

/// A car and a pedestrian that were recorded elsewhere: in another simulator, or on a road. It has no driver, no roads and no other actors.
///
/// The verdict needs nothing else: the reference drivers brake on the path that the car took, and the pedestrian is where it was. What
/// follows the first touch is not used.
#[derive(Debug, Clone)]
pub struct Recording {
    dt: f64,
    ego: Vec<VehicleState>,
    pedestrian: Vec<PedestrianState>,
}

/// Sizes in the place of those of a scenario (m).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Sizes {
    /// Length of the car, 0.1 to 100.
    pub length: Option<f64>,
    /// Width of the car, 0.1 to 100.
    pub width: Option<f64>,
    /// Radius of the pedestrian, 0.01 to 5.
    pub radius: Option<f64>,
}

impl Sizes {
    /// Gives the first car and the first pedestrian of a scenario these sizes.
    ///
    /// # Errors
    /// The name of a size that is out of its range, the size, and the range.
    pub fn apply(self, scenario: &mut Scenario) -> Result<(), RecordingError> {
        let within = |quantity, size: Option<f64>, low, high| match size {
            Some(size) if !(low..=high).contains(&size) => Err(RecordingError::Size { quantity, size, low, high }),
            size => Ok(size),
        };
        let cast = &mut scenario.cast;
        if let Some(length) = within("length", self.length, 0.1, 100.0)? {
            cast.vehicles[0].blueprint.half_length = length / 2.0;
        }
        if let Some(width) = within("width", self.width, 0.1, 100.0)? {
            cast.vehicles[0].blueprint.half_width = width / 2.0;
        }
        if let Some(radius) = within("radius", self.radius, 0.01, 5.0)? {
            let body = &mut cast.pedestrians[0].body;
            (body.radius, body.target_box) = (radius, None);
        }
        Ok(())
    }
}

/// A recording that cannot be judged.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RecordingError {
    #[error("there are {ego} instants of the car and {pedestrian} of the pedestrian; give the same number of both, 2 to {most}", most = Recording::MAX_INSTANTS)]
    Instants { ego: usize, pedestrian: usize },
    #[error("the time between two instants is {0} s; give 0.001 s to 0.5 s")]
    Step(f64),
    #[error("`{quantity}` is {size}; give {low} to {high} m")]
    Size { quantity: &'static str, size: f64, low: f64, high: f64 },
    #[error("instant {instant}: the {quantity} is {number}; give {low} to {high}")]
    Number { instant: usize, quantity: &'static str, number: f64, low: f64, high: f64 },
    #[error(
        "instant {instant}: the {who} has moved {moved:.1} m since the instant before, at {speed:.1} m/s; correct the position or the speed"
    )]
    Jump { instant: usize, who: &'static str, moved: f64, speed: f64 },
    #[error("the {who} moves {ratio:.2} times as far as its speed and the step of {dt} s explain: {likely}")]
    Units { who: &'static str, ratio: f64, dt: f64, likely: String },
    #[error("the {who} moves at {degrees:.0} deg from its heading: {likely}")]
    Heading { who: &'static str, degrees: f64, likely: &'static str },
}

/// What a recording shows.
#[derive(Debug, Clone, PartialEq)]
pub struct Encountered {
    /// The time of the first touch from the first instant (s); `None` without one.
    pub touch: Option<f64>,
    /// The least distance between the car's box and the pedestrian (m); 0 with a touch.
    pub least_gap: f64,
    /// How near the two came to a touch.
    pub near_miss: NearMiss,
    /// The verdict; `None` without a touch.
    pub verdict: Option<Verdict>,
    /// The requirements of the scenario.
    pub requirements: Vec<RecordedRequirement>,
}

/// A requirement in a recording.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordedRequirement {
    pub named: NamedRequirement,
    /// Its degree; `None` if it names the lane, the lights or crosswalks, since a recording from elsewhere has no map.
    pub degree: Option<Degree>,
    /// Whose fault its violation is.
    pub verdict: Option<ViolationVerdict>,
}

impl Recording {
    /// The most instants: 80 minutes at 20 Hz.
    pub const MAX_INSTANTS: usize = 100_000;
    /// The greatest coordinate (m).
    const MAX_COORDINATE: f64 = 1e6;
    /// The greatest speed (m/s).
    const MAX_SPEED: f64 = 150.0;
    /// How far a step may be, as a multiple of what the speed explains, and besides (m): recordings are noisy.
    const SLACK: (f64, f64) = (1.5, 2.0);

    /// Checks the states of both at instants that are `dt` (s) apart.
    ///
    /// # Errors
    /// The tracks have not 2 to [`Recording::MAX_INSTANTS`] instants each, `dt` is not 0.001 to 0.5, a coordinate exceeds 1,000 km, a
    /// speed is not 0 to 150 m/s, a step is much longer than the speed explains, or the units do not fit each other: most stretches of the way
    /// are longer or shorter than the speed explains, or are not along the heading.
    pub fn new(
        dt: f64,
        mut ego: Vec<VehicleState>,
        mut pedestrian: Vec<PedestrianState>,
    ) -> Result<Self, RecordingError> {
        if ego.len() != pedestrian.len() || !(2..=Self::MAX_INSTANTS).contains(&ego.len()) {
            return Err(RecordingError::Instants { ego: ego.len(), pedestrian: pedestrian.len() });
        }
        if !(0.001..=0.5).contains(&dt) {
            return Err(RecordingError::Step(dt));
        }
        let far = (-Self::MAX_COORDINATE, Self::MAX_COORDINATE);
        for (instant, (car, walker)) in ego.iter().zip(&pedestrian).enumerate() {
            for (quantity, number, (low, high)) in [
                ("x of the car (m)", car.pose.x, far),
                ("y of the car (m)", car.pose.y, far),
                ("heading of the car (rad)", car.pose.yaw, far),
                ("speed of the car (m/s)", car.speed, (0.0, Self::MAX_SPEED)),
                ("x of the pedestrian (m)", walker.pose.x, far),
                ("y of the pedestrian (m)", walker.pose.y, far),
                ("heading of the pedestrian (rad)", walker.pose.yaw, far),
                ("speed of the pedestrian (m/s)", walker.speed(), (0.0, Self::MAX_SPEED)),
            ] {
                if !(low..=high).contains(&number) {
                    return Err(RecordingError::Number { instant, quantity, number, low, high });
                }
            }
        }
        for (instant, (cars, walkers)) in ego.windows(2).zip(pedestrian.windows(2)).enumerate() {
            let car = (cars[1].pose.position() - cars[0].pose.position()).norm();
            let walker = (walkers[1].pose.position() - walkers[0].pose.position()).norm();
            let speeds = [cars[0].speed.max(cars[1].speed), walkers[0].speed().max(walkers[1].speed())];
            for (who, moved, speed) in [("car", car, speeds[0]), ("pedestrian", walker, speeds[1])] {
                if moved > Self::SLACK.0 * speed * dt + Self::SLACK.1 {
                    return Err(RecordingError::Jump { instant: instant + 1, who, moved, speed });
                }
            }
        }
        let cars: Vec<_> = ego.iter().map(|state| (state.pose, state.speed)).collect();
        let walkers: Vec<_> = pedestrian.iter().map(|state| (state.pose, state.speed())).collect();
        for (who, track) in [("car", cars), ("pedestrian", walkers)] {
            match misfit(&track, dt) {
                None => {}
                Some(Misfit::Speed { ratio, likely }) => return Err(RecordingError::Units { who, ratio, dt, likely }),
                Some(Misfit::Heading { degrees, likely }) => {
                    return Err(RecordingError::Heading { who, degrees, likely });
                }
            }
        }
        // Wrapped only now: degrees that were wrapped as radians are no longer recognised.
        let poses = ego.iter_mut().map(|state| &mut state.pose);
        for pose in poses.chain(pedestrian.iter_mut().map(|state| &mut state.pose)) {
            pose.yaw = wrap_angle(pose.yaw);
        }
        Ok(Self { dt, ego, pedestrian })
    }

    /// The states of a pedestrian that was at these positions, `dt` (s) apart. Its velocity is that of the step to each position; the first one
    /// has the velocity of the second.
    pub fn walked(positions: &[Point], dt: f64) -> Vec<PedestrianState> {
        let state = |(instant, position): (usize, &Point)| {
            let later = instant.max(1);
            let velocity = positions.get(later).map_or(Vector::zeros(), |to| (to - positions[later - 1]) / dt);
            let yaw = libm::atan2(velocity.y, velocity.x);
            PedestrianState { velocity, ..PedestrianState::standing(Pose::new(position.x, position.y, yaw)) }
        };
        positions.iter().enumerate().map(state).collect()
    }

    /// Judges the first touch. `scenario` gives the sizes of the car and of the pedestrian, the grip of the road, and with `obstacles`
    /// those, and its requirements; nothing else of it is used. After the touch the pedestrian continues with its last velocity.
    pub fn judged(&self, scenario: &Scenario, obstacles: Arc<Obstacles>) -> Encountered {
        let mut scenario = scenario.clone();
        scenario.obstacles = obstacles;
        (scenario.episode.tick, scenario.episode.hold) = (self.dt, 1);
        let trace = self.trace(&scenario);
        let pair = trace.pair(&scenario, 0, 0);
        let touch = trace.contact().map(|contact| (pair.len() as f64 - 2.0 + contact.fraction) * self.dt);
        let gaps = pair.frames().map(|frame| pair.gap(&frame));
        let least_gap = if touch.is_some() { 0.0 } else { gaps.fold(f64::INFINITY, f64::min) };
        let requirements = scenario.requirements.iter().map(|named| {
            let requirement = &named.requirement;
            let degree = (!requirement.mentions(&is_about_map)).then(|| OtherDrive::recorded(pair, requirement));
            let verdict = degree.and_then(|degree| ViolationVerdict::new(&pair, requirement, &degree));
            RecordedRequirement { named: named.clone(), degree, verdict }
        });
        let requirements = requirements.collect();
        Encountered { touch, least_gap, near_miss: NearMiss::new(&pair), verdict: judge(&pair), requirements }
    }

    /// Judges the first touch on a plane without obstacles: see [`Recording::judged`].
    pub fn judged_without_obstacles(&self, scenario: &Scenario) -> Encountered {
        self.judged(scenario, Arc::new(Obstacles::new(&[])))
    }

    /// The tracks up to the first touch.
    fn trace(&self, scenario: &Scenario) -> Trace {
        let (blueprint, body) = (&scenario.cast.ego().blueprint, &scenario.cast.pedestrian().body);
        let steps = self.ego.windows(2).zip(self.pedestrian.windows(2)).enumerate();
        let touch = steps.map(|(step, (cars, walkers))| {
            let contact = Contact::of_ego_in_step([&cars[0], &cars[1]], blueprint, [&walkers[0], &walkers[1]], body);
            (step, contact)
        });
        let touch = touch.into_iter().find_map(|(step, contact)| Some((step, contact?)));
        let instants = touch.map_or(self.ego.len(), |(step, _)| step + 2);
        let driving =
            self.ego[..instants].iter().map(|state| VehicleFrame { state: *state, driven: Driven::default() });
        let walking = &self.pedestrian[..instants];
        let decisions = walking[1..].iter().map(|state| WalkCommand { heading: state.pose.yaw, speed: state.speed() });
        Trace::recorded(driving.collect(), walking.to_vec(), decisions.collect(), touch.map(|(_, contact)| contact))
    }
}

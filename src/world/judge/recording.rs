use std::sync::Arc;

use super::recording_units::{Misfit, TrackOf, misfit};
use super::{Inquiry, NearMiss, Verdict, ViolationVerdict, judge};
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

/// A car whose speed is never negative may still move backwards, up to this speed (m/s).
pub(super) const MAX_UNSIGNED_REVERSING: f64 = 5.0;
/// Time (s) before the touch in which the direction of the car's motion is looked for.
const DIRECTION: f64 = 0.5;

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
    /// The verdict; `None` without a touch. It holds if nothing of the danger is missing.
    pub verdict: Option<Verdict>,
    /// How much earlier the recording must begin for a verdict that holds (s): the danger was under way at its start, and a careful human who saw it there
    /// does not avoid the touch. `None` if nothing is missing.
    pub begins_late: Option<f64>,
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
    /// The noise of a velocity that is taken from positions (m/s), where half a second is long enough for it.
    const VELOCITY_NOISE: f64 = 0.05;

    /// Checks the states of both at instants that are `dt` (s) apart. A car that reverses has a negative speed.
    ///
    /// # Errors
    /// The tracks have not 2 to [`Recording::MAX_INSTANTS`] instants each, `dt` is not 0.001 to 0.5, a coordinate exceeds 1,000 km, a
    /// speed is above 150 m/s, that of the pedestrian is negative, a step is much longer than the speed explains, or the units do not fit each other: most stretches of the way
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
                ("speed of the car (m/s)", car.speed, (-Self::MAX_SPEED, Self::MAX_SPEED)),
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
            let speeds = [cars[0].speed.abs().max(cars[1].speed.abs()), walkers[0].speed().max(walkers[1].speed())];
            for (who, moved, speed) in [("car", car, speeds[0]), ("pedestrian", walker, speeds[1])] {
                if moved > Self::SLACK.0 * speed * dt + Self::SLACK.1 {
                    return Err(RecordingError::Jump { instant: instant + 1, who, moved, speed });
                }
            }
        }
        let led = |state: &VehicleState| if state.speed < 0.0 { state.reversed() } else { *state };
        let cars: Vec<_> = ego.iter().map(led).map(|state| (state.pose, state.speed)).collect();
        let walkers: Vec<_> = pedestrian.iter().map(|state| (state.pose, state.speed())).collect();
        let reverses = if ego.iter().any(|state| state.speed < 0.0) { 0.0 } else { MAX_UNSIGNED_REVERSING };
        for (who, track, track_of) in
            [("car", cars, TrackOf::Car { reverses }), ("pedestrian", walkers, TrackOf::Pedestrian)]
        {
            match misfit(&track, dt, track_of) {
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
    /// has the velocity of the second. The noisier the positions, the longer the way that a velocity is taken from: up to half a second around it. A
    /// velocity below three standard deviations of its noise is none.
    pub fn walked(positions: &[Point], dt: f64) -> Vec<PedestrianState> {
        let last = positions.len().max(1) - 1;
        let noise = noise(positions);
        let span = (noise / (Self::VELOCITY_NOISE * dt)).ceil().clamp(1.0, (0.5 / dt).max(1.0)) as usize;
        let span = span.min(last);
        let time = span.max(1) as f64 * dt;
        let state = |(instant, position): (usize, &Point)| {
            let from = instant.saturating_sub(span - span / 2).min(last - span);
            let moved = positions[from + span] - positions[from];
            let velocity = if moved.norm() < 3.0 * noise { Vector::zeros() } else { moved / time };
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
        let begins_late = Inquiry::new(&pair).and_then(|mut inquiry| inquiry.begins_late());
        Encountered {
            touch,
            least_gap,
            near_miss: NearMiss::new(&pair),
            verdict: judge(&pair),
            begins_late,
            requirements,
        }
    }

    /// Judges the first touch on a plane without obstacles: see [`Recording::judged`].
    pub fn judged_without_obstacles(&self, scenario: &Scenario) -> Encountered {
        self.judged(scenario, Arc::new(Obstacles::new(&[])))
    }

    /// Whether a car moves backwards in the last half second of some states.
    fn reverses(&self, ego: &[VehicleState]) -> bool {
        let last = &ego[ego.len().saturating_sub((DIRECTION / self.dt) as usize + 2)..];
        let ways = last.windows(2).map(|pair| {
            let moved = pair[1].pose.position() - pair[0].pose.position();
            (moved.dot(&pair[0].pose.forward()), pair[0].speed.abs() * self.dt)
        });
        let (moved, explained) = ways.fold((0.0, 0.0), |sum, way| (sum.0 + way.0, sum.1 + way.1));
        moved < -explained / 2.0 && explained > 0.0
    }

    /// The tracks up to the first touch.
    fn trace(&self, scenario: &Scenario) -> Trace {
        let (blueprint, body) = (&scenario.cast.ego().blueprint, &scenario.cast.pedestrian().body);
        let touched = |ego: &[VehicleState]| {
            let mut steps = ego.windows(2).zip(self.pedestrian.windows(2)).enumerate();
            steps.find_map(|(step, (cars, walkers))| {
                let contact =
                    Contact::of_ego_in_step([&cars[0], &cars[1]], blueprint, [&walkers[0], &walkers[1]], body);
                Some((step, contact?))
            })
        };
        let mut touch = touched(&self.ego);
        let instants = touch.map_or(self.ego.len(), |(step, _)| step + 2);
        let mut ego = self.ego[..instants].to_vec();
        // The end that leads is the front: a car that reverses is turned round.
        if touch.is_some() && self.reverses(&ego) {
            let is_signed = ego.iter().any(|state| state.speed < 0.0);
            for state in &mut ego {
                let speed = state.speed;
                *state = state.reversed();
                if !is_signed {
                    state.speed = speed;
                }
            }
            touch = touched(&ego);
        }
        let driving = ego.iter().map(|state| VehicleFrame { state: *state, driven: Driven::default() });
        let walking = &self.pedestrian[..instants];
        let decisions = walking[1..].iter().map(|state| WalkCommand { heading: state.pose.yaw, speed: state.speed() });
        Trace::recorded(driving.collect(), walking.to_vec(), decisions.collect(), touch.map(|(_, contact)| contact))
    }
}

/// The standard deviation of the difference of two positions by noise (m), from the median of their second differences: a body changes its velocity
/// little between two instants.
fn noise(positions: &[Point]) -> f64 {
    let mut changes: Vec<f64> =
        positions.windows(3).map(|near| ((near[2] - near[1]) - (near[1] - near[0])).norm()).collect();
    changes.sort_by(f64::total_cmp);
    // Each coordinate of a second difference deviates by the square root of 6; half of all pairs of normal numbers are shorter than 1.177.
    changes.get(changes.len() / 2).map_or(0.0, |median| median / (1.177 * 6.0_f64.sqrt()) * 2.0_f64.sqrt())
}

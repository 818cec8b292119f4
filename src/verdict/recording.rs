use std::sync::Arc;

use super::recording_noise::{
    HALF_SECOND, OF_PAIR, clean_car, clean_pedestrian, median_noise, noise, taken_apart, usual_speeds, walked,
};
use super::recording_parts::{Contradiction, contradiction};
use super::recording_spikes::{remove_position_spikes, remove_spikes, remove_velocity_spikes};
use super::recording_units::{Misfit, TrackOf, fits, misfit};
use super::{Answer, Inquiry, NearMiss, Verdict, ViolationVerdict};
use episode::requirement::{Degree, NamedRequirement};
use episode::{Driven, OtherDrive, Pair, Scenario, Trace, VehicleFrame, is_about_map};
use road::geometry::{Obstacles, Point, Pose, Vector, wrap_angle};
use world::sim::{Contact, PedestrianState, VehicleState, WalkCommand};

/// A car and a pedestrian that were recorded elsewhere: in another simulator, or on a road. It has no driver, no roads and no other actors.
///
/// The verdict needs nothing else: the reference drivers brake on the path that the car took, and the pedestrian is where it was. What
/// follows the first touch is not used.
#[derive(Debug, Clone)]
pub struct Recording {
    dt: f64,
    ego: Vec<VehicleState>,
    pedestrian: Vec<PedestrianState>,
    /// Whether the velocities of the pedestrian are those of its positions.
    is_walked: bool,
    /// The instants whose speed, heading or position those before and after contradict.
    spikes: Vec<usize>,
    /// The lines of the instants in their file; empty without one.
    pub(super) lines: Vec<usize>,
}

/// Time (s) before the touch in which the direction of the car's motion is looked for.
const DIRECTION: f64 = 0.5;

/// The longest tick (s) of a verdict: states of recordings with longer steps are put between theirs.
const TICK: f64 = 0.05;

/// Time (s) between two places of a pair that did not touch, and the most places.
const RESOLUTION: f64 = 0.01;
const MAX_PLACES: usize = 500_000;

/// Sizes in the place of those of a scenario (m).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Sizes {
    /// Length of the car, 0.1 to 100.
    pub length: Option<f64>,
    /// Width of the car, 0.1 to 100.
    pub width: Option<f64>,
    /// Radius of the pedestrian, 0.01 to 5.
    pub radius: Option<f64>,
    /// Deceleration of the car at full brake (m/s²), 0.1 to 100.
    pub full_brake: Option<f64>,
}

impl Sizes {
    /// Gives the first car and the first pedestrian of a scenario these sizes.
    ///
    /// # Errors
    /// The name of a size that is out of its range, the size, and the range.
    pub fn apply(self, scenario: &mut Scenario) -> Result<(), RecordingError> {
        let within = |quantity, size: Option<f64>, low, high, unit| match size {
            Some(size) if !(low..=high).contains(&size) => {
                Err(RecordingError::Size { quantity, size, low, high, unit })
            }
            size => Ok(size),
        };
        let cast = &mut scenario.cast;
        if let Some(length) = within("length", self.length, 0.1, 100.0, "m")? {
            cast.vehicles[0].blueprint.half_length = length / 2.0;
        }
        if let Some(width) = within("width", self.width, 0.1, 100.0, "m")? {
            cast.vehicles[0].blueprint.half_width = width / 2.0;
        }
        if let Some(brake) = within("full brake", self.full_brake, 0.1, 100.0, "m/s^2")? {
            cast.vehicles[0].blueprint.full_brake = brake;
        }
        if let Some(radius) = within("radius", self.radius, 0.01, 5.0, "m")? {
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
    #[error("the time between two instants is {step} s; {}give 0.001 s to 0.5 s", unit_of_time(*.step))]
    Step { step: f64 },
    #[error("`{quantity}` is {size}; give {low} to {high} {unit}")]
    Size { quantity: &'static str, size: f64, low: f64, high: f64, unit: &'static str },
    #[error("instant {instant}: {fault}")]
    Instant { instant: usize, fault: InstantFault },
    #[error("the {who} moves {} its speed and the step of {dt} s explain: {likely}", times(*ratio))]
    Units { who: &'static str, ratio: f64, dt: f64, likely: String },
    #[error(
        "the {who} moves at {degrees:.0} deg from its heading: {likely}{}",
        if *.who == "car" { "" } else { ". Where it is that of the body, as in boxes of data sets, leave out speed and heading: they then come from the positions" }
    )]
    Heading { who: &'static str, degrees: f64, likely: &'static str },
}

/// What is wrong at an instant of a recording, or from it on.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum InstantFault {
    #[error("the {quantity} is {number}; give {low} to {high}")]
    Number { quantity: &'static str, number: f64, low: f64, high: f64 },
    #[error(
        "the {who} has moved {moved:.1} m since the instant before, at {speed:.1} m/s; correct the position or the speed"
    )]
    Jump { who: &'static str, moved: f64, speed: f64 },
    #[error(
        "in {lasts:.2} s from here on the {who} moves at {} by its positions, and at {} by its speed and heading; correct {}",
        velocity(*.moved), velocity(*.told), if *.who == "car" { "what is wrong" } else { "what is wrong, or leave out speed and heading: they then come from the positions" }
    )]
    Contradiction { who: &'static str, lasts: f64, moved: Vector, told: Vector },
}

/// What a time between two instants (s) that is too long looks like.
fn unit_of_time(step: f64) -> &'static str {
    match step {
        5.0..=500.0 => "the times look like milliseconds; ",
        5e3..=5e5 => "the times look like microseconds; ",
        5e6..=5e8 => "the times look like nanoseconds; ",
        _ => "",
    }
}

/// How much farther something moves than is explained.
fn times(ratio: f64) -> String {
    if ratio.is_finite() { format!("{ratio:.2} times as far as") } else { "farther than".into() }
}

/// A speed and its direction.
fn velocity(velocity: Vector) -> String {
    match velocity.norm() {
        speed if speed < 0.05 => "0 m/s".to_owned(),
        speed => format!("{speed:.1} m/s towards {:.0} deg", libm::atan2(velocity.y, velocity.x).to_degrees()),
    }
}

/// What a recording shows.
#[derive(Debug, Clone)]
pub struct Encountered {
    /// The time of the first touch from the first instant (s); `None` without one.
    pub touch: Option<f64>,
    /// The least distance between the car's box and the pedestrian (m); 0 with a touch. Between two instants they move on a line.
    pub least_gap: f64,
    /// The time from the last instant to a touch (s), if both then keep their velocities and it is less than three seconds: the recording ends too early.
    pub ends_before: Option<f64>,
    /// How near the two came to a touch, every 0.01 s, but in recordings of more than 500,000 such times.
    pub near_miss: NearMiss,
    /// The verdict; `None` without a touch. It holds if nothing of the danger is missing.
    pub verdict: Option<Verdict>,
    /// How much earlier the recording must begin for a verdict that holds (s): the danger was under way at its start, and a careful human who saw it there
    /// does not avoid the touch. `None` if nothing is missing.
    pub begins_late: Option<f64>,
    /// What each published driver does, and each of ours; empty without a touch.
    pub answers: Vec<Answer>,
    /// The instants at which a speed, a heading or a position was ignored, since those before and after contradict it.
    pub ignored: Vec<usize>,
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
    /// The greatest coordinate (m): ten earths.
    const MAX_COORDINATE: f64 = 1e8;
    /// The greatest heading (rad).
    const MAX_HEADING: f64 = 1e6;
    /// The greatest speed (m/s).
    const MAX_SPEED: f64 = 150.0;
    /// How long a step may be and how far it may lead to a side, as a multiple of what the speed explains; what either may be besides (m), and besides as
    /// a multiple of the noise of positions.
    const OF_WAY: (f64, f64) = (1.5, 0.3);
    const BESIDES: f64 = 0.5;
    const OF_NOISE: f64 = 6.0;
    /// The same length of a pedestrian in a short step, once spikes are removed: a length (m), and what a speed (m/s) explains.
    const BESIDES_OF_PEDESTRIAN: (f64, f64) = (0.1, 4.0);

    /// Checks the states of both at instants that are `dt` (s) apart. A car that reverses has a negative speed.
    ///
    /// # Errors
    /// The tracks have not 2 to [`Recording::MAX_INSTANTS`] instants each, `dt` is not 0.001 to 0.5, a coordinate exceeds 100,000 km, a
    /// speed is above 150 m/s, a step is much longer than the speed explains, the units do not fit each other: most stretches of the way
    /// are longer or shorter than the speed explains, or are not along the heading. Or a part of a tenth of a second to two seconds is so by more
    /// than noise, braking or a late speed explain.
    pub fn new(dt: f64, ego: Vec<VehicleState>, pedestrian: Vec<PedestrianState>) -> Result<Self, RecordingError> {
        Self::checked(Self { dt, ego, pedestrian, is_walked: false, spikes: Vec::new(), lines: Vec::new() })
    }

    /// The same of a pedestrian of which there are only positions. Its velocity is taken from them, over the longer a time the noisier they are.
    ///
    /// # Errors
    /// Those of [`Recording::new`].
    pub fn of_positions(dt: f64, ego: Vec<VehicleState>, positions: &[Point]) -> Result<Self, RecordingError> {
        let coordinates: Vec<Vector> = positions.iter().map(|position| position.coords).collect();
        let coordinates = taken_apart(&coordinates, dt);
        let mut pedestrian = walked(&coordinates, dt);
        for (state, place) in pedestrian.iter_mut().zip(coordinates) {
            (state.pose.x, state.pose.y) = (place.x, place.y);
        }
        Self::checked(Self { dt, ego, pedestrian, is_walked: true, spikes: Vec::new(), lines: Vec::new() })
    }

    fn checked(mut self) -> Result<Self, RecordingError> {
        let Self { dt, ego, pedestrian, .. } = &mut self;
        let dt = *dt;
        if ego.len() != pedestrian.len() || !(2..=Self::MAX_INSTANTS).contains(&ego.len()) {
            return Err(RecordingError::Instants { ego: ego.len(), pedestrian: pedestrian.len() });
        }
        if !(0.001..=0.5).contains(&dt) {
            return Err(RecordingError::Step { step: dt });
        }
        let far = (-Self::MAX_COORDINATE, Self::MAX_COORDINATE);
        let turned = (-Self::MAX_HEADING, Self::MAX_HEADING);
        for (instant, (car, walker)) in ego.iter().zip(&*pedestrian).enumerate() {
            for (quantity, number, (low, high)) in [
                ("x of the car (m)", car.pose.x, far),
                ("y of the car (m)", car.pose.y, far),
                ("heading of the car (rad)", car.pose.yaw, turned),
                ("speed of the car (m/s)", car.speed, (-Self::MAX_SPEED, Self::MAX_SPEED)),
                ("x of the pedestrian (m)", walker.pose.x, far),
                ("y of the pedestrian (m)", walker.pose.y, far),
                ("heading of the pedestrian (rad)", walker.pose.yaw, turned),
                ("speed of the pedestrian (m/s)", walker.speed(), (0.0, Self::MAX_SPEED)),
            ] {
                if !(low..=high).contains(&number) {
                    let fault = InstantFault::Number { quantity, number, low, high };
                    return Err(RecordingError::Instant { instant, fault });
                }
            }
        }
        self.spikes = remove_spikes(&mut self.ego, dt);
        if !self.is_walked {
            self.spikes.extend(remove_velocity_spikes(&mut self.pedestrian, dt));
        }
        let cars: Vec<_> = self.ego.iter().map(|state| (state.pose, state.speed)).collect();
        let mut walkers: Vec<_> = self.pedestrian.iter().map(|state| (state.pose, state.speed())).collect();
        if self.is_walked {
            let positions: Vec<Vector> = walkers.iter().map(|(pose, _)| pose.position().coords).collect();
            walkers.iter_mut().zip(usual_speeds(&positions, dt)).for_each(|(state, speed)| state.1 = speed);
        }
        let tracks = [("car", cars, TrackOf::Car), ("pedestrian", walkers, TrackOf::Pedestrian)];
        let jumps = |of_way: f64, most: usize, length: fn(&Vector, &Pose) -> f64| {
            let first = |(who, track, _): &(&'static str, Vec<_>, _)| {
                Some((*who, Self::jump(track, dt, (of_way, Self::BESIDES), most, length)?))
            };
            match tracks.iter().filter_map(first).min_by_key(|(_, (instant, ..))| *instant) {
                Some((who, (instant, moved, speed))) => {
                    Err(RecordingError::Instant { instant, fault: InstantFault::Jump { who, moved, speed } })
                }
                None => Ok(()),
            }
        };
        // What most steps do is a matter of units.
        jumps(Self::OF_WAY.0, self.ego.len() / 2, |moved, _| moved.norm())?;
        // A heading that was taken from positions fits them.
        let told = &tracks[..if self.is_walked { 1 } else { 2 }];
        let parts = told.iter().filter_map(|(who, track, of)| Some((*who, track, *of, contradiction(track, dt, *of)?)));
        let first = parts.min_by_key(|(.., part)| part.first);
        let contradicts = first.map(|(who, track, of, Contradiction { first: instant, lasts, told, moved })| {
            let fault = InstantFault::Contradiction { who, lasts, moved, told };
            (RecordingError::Instant { instant, fault }, fits(&track[..=instant], dt, of))
        });
        if let Some((error, true)) = contradicts {
            return Err(error);
        }
        for (who, track, track_of) in told {
            match misfit(track, dt, *track_of) {
                None => {}
                Some(Misfit::Speed { ratio, likely }) => {
                    return Err(RecordingError::Units { who, ratio, dt: (dt * 1e6).round() / 1e6, likely });
                }
                Some(Misfit::Heading { degrees, likely }) => {
                    return Err(RecordingError::Heading { who, degrees, likely });
                }
            }
        }
        jumps(Self::OF_WAY.0, usize::MAX, |moved, _| moved.norm())?;
        jumps(Self::OF_WAY.1, usize::MAX, |moved, pose| moved.dot(&pose.left()).abs())?;
        if let Some((error, _)) = contradicts {
            return Err(error);
        }
        let driven: Vec<Vector> = self.ego.iter().map(|state| state.pose.forward() * state.speed).collect();
        let walking: Vec<Vector> = self.pedestrian.iter().map(|state| state.velocity).collect();
        let known = (!self.is_walked).then_some(&walking[..]);
        let car = remove_position_spikes(self.ego.iter_mut().map(|state| &mut state.pose), Some(&driven), dt);
        let pedestrian = remove_position_spikes(self.pedestrian.iter_mut().map(|state| &mut state.pose), known, dt);
        self.spikes.extend(car.into_iter().chain(pedestrian));
        self.spikes.sort_unstable();
        self.spikes.dedup();
        let (length, speed) = Self::BESIDES_OF_PEDESTRIAN;
        let besides = Self::BESIDES.min(length + speed * dt);
        let states = self.pedestrian.iter().zip(&tracks[1].1).map(|(state, (_, speed))| (state.pose, *speed));
        let track: Vec<(Pose, f64)> = states.collect();
        let jump = Self::jump(&track, dt, (Self::OF_WAY.0, besides), usize::MAX, |moved, _| moved.norm());
        if let Some((instant, moved, speed)) = jump {
            let fault = InstantFault::Jump { who: "pedestrian", moved, speed };
            return Err(RecordingError::Instant { instant, fault });
        }
        if self.is_walked {
            let positions: Vec<Vector> = self.pedestrian.iter().map(|state| state.pose.position().coords).collect();
            for (state, walked) in self.pedestrian.iter_mut().zip(walked(&positions, dt)) {
                (state.velocity, state.pose.yaw) = (walked.velocity, walked.pose.yaw);
            }
        }
        // Wrapped only now: degrees that were wrapped as radians are no longer recognised.
        let poses = self.ego.iter_mut().map(|state| &mut state.pose);
        for pose in poses.chain(self.pedestrian.iter_mut().map(|state| &mut state.pose)) {
            pose.yaw = wrap_angle(pose.yaw);
        }
        Ok(self)
    }

    /// The first step whose length is more than a share of what the speed explains, a length (m) and the noise: its end, its length (m) and the speed
    /// (m/s). `None` if more steps than `most` are so.
    fn jump(
        track: &[(Pose, f64)],
        dt: f64,
        (of_way, besides): (f64, f64),
        most: usize,
        length: impl Fn(&Vector, &Pose) -> f64,
    ) -> Option<(usize, f64, f64)> {
        let positions: Vec<Vector> = track.iter().map(|(pose, _)| pose.position().coords).collect();
        let besides = besides + Self::OF_NOISE * noise(&positions);
        let steps = track.windows(2).zip(positions.windows(2)).enumerate();
        let mut jumps = steps.filter_map(|(instant, (states, places))| {
            let (moved, speed) = (places[1] - places[0], states[0].1.abs().max(states[1].1.abs()));
            let is_far = length(&moved, &states[1].0) > of_way * speed * dt + besides;
            is_far.then(|| (instant + 1, moved.norm(), speed))
        });
        let first = jumps.next()?;
        (jumps.count() < most).then_some(first)
    }

    /// The time between two instants (s).
    pub fn dt(&self) -> f64 {
        self.dt
    }

    /// The number of ticks of a verdict between two instants: above 1, states are put between them.
    pub fn parts(&self) -> usize {
        (self.dt / TICK - 1e-6).ceil().max(1.0) as usize
    }

    /// The line of an instant in its file; `None` without a file.
    pub fn line(&self, instant: usize) -> Option<usize> {
        self.lines.get(instant).copied()
    }

    /// Judges the first touch. `scenario` gives the sizes of the car and of the pedestrian, the grip of the road, and with `obstacles`
    /// those, and its requirements; nothing else of it is used. After the touch the pedestrian continues with its last velocity.
    pub fn judged(&self, scenario: &Scenario, obstacles: Arc<Obstacles>) -> Encountered {
        let mut scenario = scenario.clone();
        scenario.obstacles = obstacles;
        let (trace, is_reversed, tick) = self.trace(&scenario);
        (scenario.episode.tick, scenario.episode.hold) = (tick, 1);
        let pair = trace.pair(&scenario, 0, 0);
        let touch = trace.contact().map(|contact| (pair.len() as f64 - 2.0 + contact.fraction) * tick);
        let ends_before = if touch.is_none() { NearMiss::of_last(&pair) } else { None };
        let (near_miss, least_gap) = match touch {
            Some(_) => (NearMiss::new(&pair), 0.0),
            None => Self::nearest(&pair),
        };
        let requirements = scenario.requirements.iter().map(|named| {
            let requirement = &named.requirement;
            let degree = (!requirement.mentions(&is_about_map)).then(|| OtherDrive::recorded(pair, requirement));
            let verdict = degree.and_then(|degree| ViolationVerdict::new(&pair, requirement, &degree));
            RecordedRequirement { named: named.clone(), degree, verdict }
        });
        let requirements = requirements.collect();
        let mut inquiry = Inquiry::new(&pair);
        let begins_late = inquiry.as_mut().and_then(Inquiry::begins_late);
        let answers = inquiry.as_mut().map_or_else(Vec::new, Inquiry::answers);
        Encountered {
            touch,
            least_gap,
            ends_before,
            near_miss,
            verdict: inquiry.map(Inquiry::verdict).map(|verdict| Verdict {
                side: if is_reversed { verdict.side.turned_round() } else { verdict.side },
                ..verdict
            }),
            begins_late,
            answers,
            ignored: self.spikes.clone(),
            requirements,
        }
    }

    /// How near two came who did not touch, and their least distance (m): between two instants they move on a line.
    fn nearest(pair: &Pair<'_>) -> (NearMiss, f64) {
        let parts = (pair.dt() / RESOLUTION).ceil().min((MAX_PLACES / pair.len()) as f64).max(1.0) as usize;
        let (mut driving, mut walking) = (Vec::new(), Vec::new());
        for (from, to) in pair.frames().zip(pair.frames().skip(1).chain(pair.last())) {
            for share in (0..parts).map(|part| part as f64 / parts as f64) {
                driving.push(VehicleFrame { state: from.ego.between(&to.ego, share), driven: Driven::default() });
                walking.push(from.pedestrian.between(&to.pedestrian, share));
            }
        }
        let mut scenario = pair.scenario.clone();
        scenario.episode.tick = pair.dt() / parts as f64;
        let decisions = vec![WalkCommand::default(); walking.len() - 1];
        let trace = Trace::recorded(driving, walking, decisions, None, 0.0);
        let fine = trace.pair(&scenario, 0, 0);
        (NearMiss::new(&fine), fine.frames().map(|frame| fine.gap(&frame)).fold(f64::INFINITY, f64::min))
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

    /// The tracks up to the first touch, without noise, whether the car reversed and is turned round, and the tick (s). The touch moves the pedestrian, so what
    /// follows says nothing of the motion before it.
    fn trace(&self, scenario: &Scenario) -> (Trace, bool, f64) {
        let (blueprint, body) = (&scenario.cast.ego().blueprint, &scenario.cast.pedestrian().body);
        let touched = |ego: &[VehicleState], pedestrian: &[PedestrianState]| {
            let mut steps = ego.windows(2).zip(pedestrian.windows(2)).enumerate();
            steps.find_map(|(step, (cars, walkers))| {
                let contact =
                    Contact::of_ego_in_step([&cars[0], &cars[1]], blueprint, [&walkers[0], &walkers[1]], body);
                Some((step, contact?))
            })
        };
        let first = touched(&self.ego, &self.pedestrian);
        let mut instants = first.map_or(self.ego.len(), |(step, _)| step + 2);
        let mut ego = self.ego[..instants].to_vec();
        let mut walking = self.pedestrian[..instants].to_vec();
        // The end that leads is the front: a car that reverses is turned round.
        let is_reversed = first.is_some() && self.reverses(&ego);
        if is_reversed {
            let is_signed = ego.iter().any(|state| state.speed < 0.0);
            for state in &mut ego {
                let speed = state.speed;
                *state = state.reversed();
                if !is_signed {
                    state.speed = speed;
                }
            }
        }
        let mut touch = first.and_then(|_| touched(&ego, &walking));
        clean_car(&mut ego, self.dt);
        let velocity_noise = if self.is_walked {
            let positions: Vec<Vector> = walking.iter().map(|state| state.pose.position().coords).collect();
            walking = walked(&positions, self.dt);
            noise(&positions) / HALF_SECOND
        } else {
            let velocities: Vec<Vector> = walking.iter().map(|state| state.velocity).collect();
            clean_pedestrian(&mut walking, self.dt);
            median_noise(&velocities, OF_PAIR)
        };
        // Without noise they may touch a moment earlier, or later than the recording tells.
        if let Some((step, contact)) = first.and_then(|_| touched(&ego, &walking)) {
            (instants, touch) = (step + 2, Some((step, contact)));
        }
        let parts = touch.map_or(1, |_| self.parts());
        if parts > 1 {
            (ego, walking) = (refined(&ego[..instants], parts), refined(&walking[..instants], parts));
            // That of the noisy tracks, if these miss each other.
            touch = touched(&ego, &walking).or(touch.map(|(step, contact)| {
                let place = contact.fraction * parts as f64;
                let part = place.floor().min(parts as f64 - 1.0);
                (step * parts + part as usize, Contact { fraction: place - part, ..contact })
            }));
            instants = touch.map_or(ego.len(), |(step, _)| step + 2);
        }
        let driving = ego[..instants].iter().map(|state| VehicleFrame { state: *state, driven: Driven::default() });
        let walking = &walking[..instants];
        let decisions = walking[1..].iter().map(|state| WalkCommand { heading: state.pose.yaw, speed: state.speed() });
        let contact = touch.map(|(_, contact)| contact);
        let decisions = decisions.collect();
        let trace = Trace::recorded(driving.collect(), walking.to_vec(), decisions, contact, velocity_noise);
        (trace, is_reversed, self.dt / parts as f64)
    }
}

/// Divides each step of a track into this number of parts.
fn refined<S: Between>(track: &[S], parts: usize) -> Vec<S> {
    let shares = || (0..parts).map(|part| part as f64 / parts as f64);
    let steps = track.windows(2).flat_map(|pair| shares().map(|share| pair[0].between(&pair[1], share)));
    steps.chain(track.last().cloned()).collect()
}

/// A state between two, at a share of the time: on a line, as in [`Contact::of_ego_in_step`].
trait Between: Clone {
    fn between(&self, next: &Self, share: f64) -> Self;
}

impl Between for VehicleState {
    fn between(&self, next: &Self, share: f64) -> Self {
        let speed = self.speed + (next.speed - self.speed) * share;
        Self { pose: self.pose.between(&next.pose, share), speed, ..*self }
    }
}

impl Between for PedestrianState {
    fn between(&self, next: &Self, share: f64) -> Self {
        let velocity = self.velocity + (next.velocity - self.velocity) * share;
        Self { pose: self.pose.between(&next.pose, share), velocity, ..*self }
    }
}

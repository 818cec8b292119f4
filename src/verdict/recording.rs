use std::sync::Arc;

use super::recording_error::{InstantFault, MAX_INSTANTS, RecordingError};
use super::recording_findings::{
    Damage, Finding, contradiction, held, spikes_of_car, spikes_of_pedestrian, spikes_of_positions,
};
use super::recording_noise::{HALF_SECOND, Noise, OF_PAIR, median_noise, noise, usual_speeds, walked};
use super::recording_units::{TrackOf, fits, misfit};
use super::{Answer, Inquiry, NearMiss, Sensitivity, Verdict, ViolationVerdict};
use base::seed::Seed;
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
    /// What is wrong in it.
    findings: Vec<Finding>,
}

/// Time (s) before the touch in which the direction of the car's motion is looked for.
const DIRECTION: f64 = 0.5;

/// The longest tick (s) of a verdict: states of recordings with longer steps are put between theirs.
const TICK: f64 = 0.05;

/// Time (s) between two places of a pair that did not touch, and the most places.
const RESOLUTION: f64 = 0.01;
const MAX_PLACES: usize = 500_000;

/// An actor, its poses and speeds (m/s), and whose they are.
type Track = (&'static str, Vec<(Pose, f64)>, TrackOf);

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
    /// These sizes, and others where there is none.
    #[must_use]
    pub fn or(self, others: Self) -> Self {
        Self {
            length: self.length.or(others.length),
            width: self.width.or(others.width),
            radius: self.radius.or(others.radius),
            full_brake: self.full_brake.or(others.full_brake),
        }
    }

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
    /// What is wrong in the recording.
    pub findings: Vec<Finding>,
    /// The finding that lies where the verdict is decided, so that nobody can tell.
    pub undecided: Option<Finding>,
    /// The requirements of the scenario.
    pub requirements: Vec<RecordedRequirement>,
    /// The time between two recorded instants (s).
    pub step: f64,
    /// What was judged: the tracks up to the first touch, and the scenario with the sizes, the tick and the obstacles.
    pub trace: Trace,
    pub scenario: Scenario,
}

impl Encountered {
    /// How much the verdict rests on what nobody knows exactly; `None` without a touch.
    pub fn sensitivity(&self) -> Option<Sensitivity> {
        let pair = self.trace.pair(&self.scenario, 0, 0);
        Inquiry::new(&pair).map(|inquiry| Sensitivity::new(inquiry.encounter()))
    }

    /// What each published driver does, and each of ours; empty without a touch.
    pub fn answers(&self) -> Vec<Answer> {
        let pair = self.trace.pair(&self.scenario, 0, 0);
        Inquiry::new(&pair).as_mut().map_or_else(Vec::new, Inquiry::answers)
    }

    /// The verdict; `None` without a touch, and where nobody can tell.
    pub fn told(&self) -> Option<&Verdict> {
        self.verdict.as_ref().filter(|_| self.begins_late.is_none() && self.undecided.is_none())
    }
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
    pub const MAX_INSTANTS: usize = MAX_INSTANTS;
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
    /// How often as much noise is added again to see whether it decides the verdict, and in how many of these the verdict may be another.
    const NOISE_ADDED: u32 = 20;
    const MAX_DIFFERENT: usize = 1;
    /// What happens at most this long before the danger decides the verdict (s).
    const BEFORE_DANGER: f64 = 1.5;
    /// The same length of a pedestrian in a short step: a length (m), and what a speed (m/s) explains.
    const BESIDES_OF_PEDESTRIAN: (f64, f64) = (0.1, 4.0);

    /// Checks the states of both at instants that are `dt` (s) apart. A car that reverses has a negative speed.
    ///
    /// # Errors
    /// The tracks have not 2 to [`Recording::MAX_INSTANTS`] instants each, `dt` is not 0.001 to 0.5, a coordinate exceeds 100,000 km, a
    /// speed is above 150 m/s, a step is much longer than the speed explains, the units do not fit each other: most stretches of the way
    /// are longer or shorter than the speed explains, or are not along the heading. Or a part of a tenth of a second to two seconds is so by more
    /// than noise, braking or a late speed explain.
    pub fn new(dt: f64, ego: Vec<VehicleState>, pedestrian: Vec<PedestrianState>) -> Result<Self, RecordingError> {
        Self::checked(Self { dt, ego, pedestrian, is_walked: false, findings: Vec::new() })
    }

    /// The same of a pedestrian of which there are only positions. Its velocity is taken from them, over the longer a time the noisier they are.
    ///
    /// # Errors
    /// Those of [`Recording::new`].
    pub fn of_positions(dt: f64, ego: Vec<VehicleState>, positions: &[Point]) -> Result<Self, RecordingError> {
        let coordinates: Vec<Vector> = positions.iter().map(|position| position.coords).collect();
        let pedestrian = walked(&coordinates, dt);
        Self::checked(Self { dt, ego, pedestrian, is_walked: true, findings: Vec::new() })
    }

    fn checked(mut self) -> Result<Self, RecordingError> {
        if self.ego.len() != self.pedestrian.len() || !(2..=Self::MAX_INSTANTS).contains(&self.ego.len()) {
            return Err(RecordingError::Instants { ego: self.ego.len(), pedestrian: self.pedestrian.len() });
        }
        if !(0.001..=0.5).contains(&self.dt) {
            return Err(RecordingError::Step { step: self.dt });
        }
        self.check_numbers()?;
        self.findings = self.damages()?;
        // Wrapped only now: degrees that were wrapped as radians are no longer recognised.
        let poses = self.ego.iter_mut().map(|state| &mut state.pose);
        for pose in poses.chain(self.pedestrian.iter_mut().map(|state| &mut state.pose)) {
            pose.yaw = wrap_angle(pose.yaw);
        }
        Ok(self)
    }

    fn check_numbers(&self) -> Result<(), RecordingError> {
        let far = (-Self::MAX_COORDINATE, Self::MAX_COORDINATE);
        let turned = (-Self::MAX_HEADING, Self::MAX_HEADING);
        for (instant, (car, walker)) in self.ego.iter().zip(&self.pedestrian).enumerate() {
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
        Ok(())
    }

    /// The poses and speeds of both (m/s); those of a pedestrian of whom there are only positions are its usual ones.
    fn tracks(&self) -> [Track; 2] {
        let cars = self.ego.iter().map(|state| (state.pose, state.speed)).collect();
        let mut walkers: Vec<_> = self.pedestrian.iter().map(|state| (state.pose, state.speed())).collect();
        if self.is_walked {
            let positions: Vec<Vector> = walkers.iter().map(|(pose, _)| pose.position().coords).collect();
            walkers.iter_mut().zip(usual_speeds(&positions, self.dt)).for_each(|(state, speed)| state.1 = speed);
        }
        [("car", cars, TrackOf::Car), ("pedestrian", walkers, TrackOf::Pedestrian)]
    }

    /// What is wrong at single instants and in parts.
    ///
    /// # Errors
    /// The units do not fit each other.
    fn damages(&self) -> Result<Vec<Finding>, RecordingError> {
        let dt = self.dt;
        let tracks = self.tracks();
        // A heading that was taken from positions fits them.
        let told = &tracks[..if self.is_walked { 1 } else { 2 }];
        let parts = told.iter().filter_map(|(who, track, of)| Some((contradiction(who, track, dt, *of)?, track, *of)));
        let first = parts.min_by_key(|(part, ..)| part.first);
        let fits_before = first.as_ref().is_some_and(|(part, track, of)| fits(&track[..=part.first], dt, *of));
        let jumps = tracks.each_ref().map(|(who, track, of)| Self::jumps(who, track, dt, *of));
        // What most steps do is a matter of units.
        let is_whole = |place: usize| jumps[place].is_empty() || jumps[place].len() * 2 > self.ego.len();
        for (_, (who, track, track_of)) in told.iter().enumerate().filter(|(place, _)| !fits_before && is_whole(*place))
        {
            misfit(who, track, dt, *track_of)?;
        }
        let mut found: Vec<Finding> = first.into_iter().map(|(part, ..)| part).collect();
        found.extend(spikes_of_car(&self.ego, dt));
        if !self.is_walked {
            found.extend(spikes_of_pedestrian(&self.pedestrian, dt));
        }
        for (who, track, _) in &tracks {
            let places: Vec<Vector> = track.iter().map(|(pose, _)| pose.position().coords).collect();
            found.extend(spikes_of_positions(who, &places, dt));
            found.extend(held(who, &places, dt));
        }
        found.extend(jumps.into_iter().flatten());
        let Noise { car, pedestrian } = self.noise();
        let noisy = ["positions", "speeds", "headings"].into_iter().zip(car).map(|noise| ("car", noise));
        let walking = ["positions", "velocities"].into_iter().zip(pedestrian).map(|noise| ("pedestrian", noise));
        for (who, (quantity, noise)) in noisy.chain(walking).filter(|(_, (_, noise))| *noise > 0.0) {
            found.push(Finding::new(who, (0, self.ego.len() - 1), Damage::Noise(quantity, noise)));
        }
        found.sort_by_key(|finding| finding.first);
        Ok(found)
    }

    /// The finding in which the verdict on a touch at this time (s) lies, which a danger of `warning` (s) came before.
    fn undecided(&self, touch: f64, warning: f64) -> Option<Finding> {
        let last = (touch / self.dt).ceil();
        let first = ((touch - warning - Self::BEFORE_DANGER) / self.dt).floor();
        let lies_there = |finding: &&Finding| finding.first as f64 <= last && finding.last as f64 >= first;
        self.findings.iter().filter(|finding| finding.decides()).find(lies_there).cloned()
    }

    fn noise(&self) -> Noise {
        Noise::of(&self.ego, &self.pedestrian, self.is_walked, self.dt)
    }

    /// The first finding about noise, if the verdict is another with as much noise again.
    fn decided_by_noise(&self, scenario: &Scenario, verdict: (bool, bool)) -> Option<Finding> {
        let finding = self.findings.iter().find(|finding| matches!(finding.what, Damage::Noise(..)))?;
        let (noise, mut stream) = (self.noise(), Seed::root(0).child("judge").child("noise").stream());
        let differs = |_: &u32| {
            let mut again = self.clone();
            noise.add(&mut again.ego, &mut again.pedestrian, &mut stream);
            let (trace, ..) = again.trace(scenario);
            let pair = trace.pair(scenario, 0, 0);
            Inquiry::new(&pair).map(|mut inquiry| inquiry.blame()) != Some(verdict)
        };
        ((0..Self::NOISE_ADDED).filter(differs).count() > Self::MAX_DIFFERENT).then(|| finding.clone())
    }

    /// The steps whose length, or to a side, is more than a share of what the speed explains, a length (m) and the noise.
    fn jumps(who: &'static str, track: &[(Pose, f64)], dt: f64, of: TrackOf) -> Vec<Finding> {
        let positions: Vec<Vector> = track.iter().map(|(pose, _)| pose.position().coords).collect();
        let (length, speed) = Self::BESIDES_OF_PEDESTRIAN;
        let besides = if of == TrackOf::Car { Self::BESIDES } else { Self::BESIDES.min(length + speed * dt) };
        let besides = besides + Self::OF_NOISE * noise(&positions);
        let steps = track.windows(2).zip(positions.windows(2)).enumerate();
        let jumps = steps.filter_map(|(instant, (states, places))| {
            let (moved, speed) = (places[1] - places[0], states[0].1.abs().max(states[1].1.abs()));
            let aside = moved.dot(&states[1].0.left()).abs();
            let explained = |share: f64| share * speed * dt;
            let is_far = moved.norm() > explained(Self::OF_WAY.0) + besides
                || of == TrackOf::Car && aside > explained(Self::OF_WAY.1) + besides;
            let what = Damage::Jump { moved: moved.norm(), speed };
            is_far.then(|| Finding::new(who, (instant + 1, instant + 1), what))
        });
        jumps.collect()
    }

    /// The time between two instants (s).
    pub fn dt(&self) -> f64 {
        self.dt
    }

    /// The number of ticks of a verdict between two instants: above 1, states are put between them.
    pub fn parts(&self) -> usize {
        (self.dt / TICK - 1e-6).ceil().max(1.0) as usize
    }

    /// Tells the lines of the instants in their file.
    pub(super) fn tell_lines(&mut self, lines: &[usize]) {
        for finding in &mut self.findings {
            finding.lines = Some((lines[finding.first], lines[finding.last]));
        }
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
        let undecided = inquiry.as_mut().and_then(|inquiry| {
            let damaged = self.undecided(touch?, inquiry.encounter().warning);
            damaged.or_else(|| self.decided_by_noise(&scenario, inquiry.blame()))
        });
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
            findings: self.findings.clone(),
            undecided,
            requirements,
            step: self.dt,
            trace,
            scenario,
        }
    }

    /// How near two came who did not touch, and their least distance (m): between two instants they move on a line.
    fn nearest(pair: &Pair<'_>) -> (NearMiss, f64) {
        let parts = (pair.dt() / RESOLUTION).ceil().min((MAX_PLACES / pair.len()) as f64).max(1.0) as usize;
        let cars: Vec<VehicleState> = pair.frames().map(|frame| frame.ego).collect();
        let walking = refined(pair.walking, parts);
        let driving = refined(&cars, parts).into_iter().map(|state| VehicleFrame { state, driven: Driven::default() });
        let mut scenario = pair.scenario.clone();
        scenario.episode.tick = pair.dt() / parts as f64;
        let decisions = vec![WalkCommand::default(); walking.len() - 1];
        let trace = Trace::recorded(driving.collect(), walking, decisions, None, 0.0);
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

    /// The tracks up to the first touch, whether the car reversed and is turned round, and the tick (s). The touch moves the pedestrian, so what
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
        let velocity_noise = if self.is_walked {
            let positions: Vec<Vector> = walking.iter().map(|state| state.pose.position().coords).collect();
            walking = walked(&positions, self.dt);
            noise(&positions) / HALF_SECOND
        } else {
            median_noise(&walking.iter().map(|state| state.velocity).collect::<Vec<_>>(), OF_PAIR)
        };
        let parts = touch.map_or(1, |_| self.parts());
        if parts > 1 {
            (ego, walking) = (refined(&ego[..instants], parts), refined(&walking[..instants], parts));
            // That of the whole step, if its parts miss each other.
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

use super::brake_rules::BrakeRules;
use super::classifier::Classifier;
use super::command::Command;
use super::controller::{Controller, Overruled, Situation, Verdict};
use super::detection::{Blob, BlobKind, Detector};
use super::forecast::Forecast;
use super::frame::{EgoPoint, clockwise_yaw};
use super::hazards;
use super::plan::{Tempo, write_plan};
use super::version::{MAX_HORIZON, Version};
use base::keys;
use base::seed::Stream;
use world::av::{DrivingMode, DrivingPolicy, Path, Perception};
use world::sim::Control;

keys! {
    /// LAV, a surrogate. It does not see through buildings. Made for `mkz_2017`.
    pub struct LavKeys = "lav" {
        /// The agent: of the paper, of the leaderboard, or the leaderboard's fast variant.
        version: Version = "v2",
    }
    .made_for(0.05)
    .surrogate(
        "Exact: LAV's controller and rules. Assumed: its networks, which are not run; its route and what it perceives take the \
         place of its plan, detections and forecasts, and the rules that labelled its training data that of its brake classifier. \
         So its rates show the limits of LAV's rules and not the mistakes of its networks.",
    )
}

/// Half of the length of the car that LAV was trained in (m); its networks know no other car.
const TRAINED_HALF_LENGTH: f64 = 2.450_842;
/// The detector's score for a vehicle that it sees.
const SEEN: f64 = 0.9;
/// The planner treats nearer detections as the ego itself (m).
const OWN_BODY: f64 = 1.0;
/// v1's guess of others' speeds, as a share of the speed that it would drive, since it cannot see them.
const GUESSED_SPEED: f64 = 0.5;

/// LAV (*Learning from All Vehicles*), faithful to its planner: its own rules, with a surrogate of its networks as input.
///
/// **Exact**, tested with numbers computed by its code: the gates of the detection map, the transformation of forecasts, the
/// check of plan against forecasts, both PID controllers, the overriding rules, their order in a tick, creeping.
/// **Exact as a rule, assumed as a network**: it brakes for pedestrians when the rules that labelled its training data do
/// ([`BrakeRules`]), within the cameras' 184° and with free sight, after a first-order filter. **Assumed**: the plan is
/// the centre line of the route at the training expert's speed, or full braking for a hazard. Vehicles in sight are
/// detected up to where they were labelled and drive where they point; v1 guesses their speed. It brakes for a red light's line
/// at the distance at which it would brake for a pedestrian there. The wheel was tuned for the Lincoln MKZ.
///
/// It therefore never forecasts pedestrians, and brakes fully or not at all. Its first tick is empty.
///
/// Closed loop with the MKZ under 30 km/h, which is 6.6 m/s for v1 and 4.0 m/s for v2, and an adult at full speed at once. Distances
/// at the first brake are between middles, gaps are between bodies:
///
/// | a pedestrian | v1 | v2 |
/// |---|---|---|
/// | stands exactly dead ahead | brakes at 5.9 m, stops with a gap of 1.5 m | 6.0 m, 2.9 m |
/// | stands in the lane, 0.5 m aside | 8.6 m, 4.1 m | 8.6 m, 5.4 m |
/// | stands in the other lane, 2.1 m aside | 5.7 m, 1.3 m | 5.8 m, 2.5 m |
/// | stands in the other lane, 3 m aside | passes | passes |
/// | crosses from 6 m to the left at 3.5 m/s, 15 m ahead | 7.7 m, 3.0 m | 8.5 m, 5.4 m |
/// | the same, 10 m ahead | hits at 2.3 m/s | 5.8 m, 2.4 m |
/// | the same, 8 m ahead | hits unbraked at 6.6 m/s | 4.8 m, 0.9 m |
/// | the same, 6 m ahead | is past before | touches at 0.03 m/s |
/// | the same at 1.4 m/s, 12 m ahead | is past before | hits unbraked at 3.9 m/s |
///
/// # Source
/// `dotchen/LAV`, `team_code/lav_agent.py` (v1), `team_code_v2/{lav_agent,lav_agent_fast}.py` (v2, its fast variant).
#[derive(Debug, Clone)]
pub struct Lav {
    version: Version,
    path: Path,
    command: Command,
    classifier: Classifier,
    detector: Detector,
    controller: Controller,
    mode: DrivingMode,
    cause: DrivingMode,
    started: bool,
    plan: [EgoPoint; MAX_HORIZON],
    blobs: Vec<Blob>,
    speeds: Vec<f64>,
    forecasts: Vec<Forecast>,
    verdict: Option<Verdict>,
}

impl Lav {
    pub fn from_keys(keys: LavKeys) -> Self {
        Self::new(keys.version)
    }

    /// Makes one without a way until [`DrivingPolicy::reset`].
    pub fn new(version: Version) -> Self {
        let room = 64;
        Self {
            version,
            path: Path::default(),
            command: Command::default(),
            classifier: Classifier::default(),
            detector: Detector::new(version),
            controller: Controller::new(version),
            mode: DrivingMode::Cruise,
            cause: DrivingMode::EmergencyStop,
            started: false,
            plan: [EgoPoint::default(); MAX_HORIZON],
            blobs: Vec::with_capacity(room),
            speeds: Vec::with_capacity(room),
            forecasts: Vec::with_capacity(room),
            verdict: None,
        }
    }

    /// The way that it follows.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The turn that it was told in the last tick.
    pub fn command(&self) -> Command {
        self.command
    }

    /// Its controller's decision in the last tick, with the reason; `None` after the empty first one.
    pub fn verdict(&self) -> Option<&Verdict> {
        self.verdict.as_ref()
    }

    /// Forecasts of the vehicles in sight that pass the detection map; `cruise` is the speed (m/s) of an ego there.
    fn look(&mut self, perception: &Perception<'_>, cruise: f64) {
        let traits = self.version.traits();
        let ego = &perception.ego.pose;
        self.blobs.clear();
        self.speeds.clear();
        self.forecasts.clear();
        for vehicle in perception.vehicles {
            let place = EgoPoint::seen_from(ego, vehicle.pose.position());
            if place.distance(EgoPoint::default()) <= traits.labelled_within && perception.in_sight(vehicle) {
                let yaw = clockwise_yaw(ego, &vehicle.pose);
                let (kind, half) = (BlobKind::Vehicle, vehicle.half);
                self.blobs.push(Blob::of_body(kind, place, yaw, half.x, half.y, SEEN));
                let speed = vehicle.velocity.dot(&vehicle.pose.forward()).max(0.0);
                self.speeds.push(if traits.senses_speed { speed } else { GUESSED_SPEED * cruise });
            }
        }
        if self.blobs.is_empty() {
            return;
        }
        for found in self.detector.detect(&self.blobs) {
            let source = self.blobs.iter().position(|blob| *blob == found.blob);
            if let Some(source) = source.filter(|_| found.place.distance(EgoPoint::default()) > OWN_BODY) {
                self.forecasts.push(Forecast::of(found, self.speeds[source], traits));
            }
        }
    }
}

impl DrivingPolicy for Lav {
    fn reset(&mut self, perception: &Perception<'_>, stream: Stream) {
        self.path.reset(perception, stream);
        self.command = Command::default();
        self.classifier.reset();
        self.controller = Controller::new(self.version);
        self.mode = DrivingMode::Cruise;
        self.started = false;
        self.verdict = None;
    }

    fn drive(&mut self, perception: &Perception<'_>) -> Control {
        let ego = &perception.ego;
        self.path.advance(perception);
        self.command = self.command.follow(&self.path, ego.pose.position());
        if !std::mem::replace(&mut self.started, true) {
            return Control::default();
        }
        let rules = BrakeRules { ego_half_length: TRAINED_HALF_LENGTH, speed_limit: perception.carla_limit() };
        let hazard = hazards::find(&rules, &self.path, perception);
        self.cause = hazard.unwrap_or(self.cause);
        let brake_score = self.classifier.run(hazard.is_some(), perception.dt);
        let in_turn = matches!(self.command, Command::Left | Command::Right);
        let expert = Tempo::of_expert(perception.carla_limit(), in_turn);
        let (Tempo::Cruise(cruise) | Tempo::Brake(cruise, _)) = expert;
        self.look(perception, cruise);
        let braking = Tempo::Brake(ego.speed(), perception.blueprint.full_brake);
        let tempo = if hazard.is_some() { braking } else { expert };
        let plan = &mut self.plan[..self.version.traits().horizon];
        write_plan(&self.path, &ego.pose, tempo, plan);
        let verdict = self.controller.run(&Situation {
            speed: ego.speed(),
            command: self.command,
            brake_score,
            plan,
            forecasts: &self.forecasts,
        });
        let pedals = verdict.pedals;
        self.mode = match verdict.overruled {
            Some(Overruled::Classifier) if pedals.brake > 0.0 => self.cause,
            Some(Overruled::Collision) if pedals.brake > 0.0 => DrivingMode::EmergencyStop,
            _ if pedals.brake > 0.0 && self.path.ends() => DrivingMode::Arrived,
            _ if in_turn => DrivingMode::Turn,
            _ => DrivingMode::Cruise,
        };
        self.verdict = Some(verdict);
        Control { throttle: pedals.throttle, brake: pedals.brake, steer: -pedals.steer }
    }

    fn mode(&self) -> DrivingMode {
        self.mode
    }

    fn snapshot(&self) -> Option<Box<dyn DrivingPolicy>> {
        Some(Box::new(self.clone()))
    }

    fn reseed(&mut self, stream: Stream) {
        self.path.reseed(stream);
    }
}

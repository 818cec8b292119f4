use std::f64::consts::{FRAC_PI_2, TAU};

use super::EgoVector;
use super::controller::{Controller, Decision, Inputs, Reason};
use super::corridor::WAYPOINTS;
use super::detection::find_detections;
use super::forecast::Forecast;
use super::object_map::{Cell, ObjectMap, Sighting};
use super::settings::Settings;
use super::tracker::Tracker;
use base::seed::Stream;
use road::geometry::{Point, wrap_angle};
use world::av::{DrivingMode, DrivingPolicy, Path, Perception};
use world::sim::{Control, LightColour};

/// The first waypoint is the last point of the route within this distance (m).
const FIRST_WAYPOINT: f64 = 4.0;
/// The output of a network that is right; a softmax never gives 0 or 1.
const SURE: f64 = 0.95;
/// Red and yellow lights affect the ego from here (m), or from their trigger boxes.
const LIGHT: f64 = 8.0;
/// A light belongs to the lane when its stop is within this distance of a point of the route (m).
const LIGHT_ASIDE: f64 = 1.0;
/// Before this step every command is carried out and every map is used; from it on every second one.
const FIRST_STEPS: u32 = 4;

/// InterFuser with ideal perception: its published planner and controller on the map that its network is trained to give.
///
/// **A surrogate.** *Exact*, compared with the published code: the map's geometry, peaks, classes, tracker, forecast, drawing to
/// the pixel, distances, speed decision, controllers, counters, and the order and rates of all these. *Assumed*: the
/// network. It sees every actor that the [`Perception`] lists, through walls, at once and without noise; it follows its
/// route and knows its junctions; a light affects it where the expert of its training data brakes. There are no stop
/// signs in our towns.
///
/// It counts ticks, as published, so its times are right for ticks of 0.05 s. At the end of the road it brakes and stays; that
/// rule is our own.
///
/// # Source
/// Shao et al., *Safety-Enhanced Autonomous Driving Using Interpretable Sensor Fusion Transformer*, CoRL 2022;
/// `opendilab/InterFuser` at 14ca80e.
#[derive(Debug, Clone)]
pub struct InterFuser {
    path: Path,
    map: ObjectMap,
    detections: Vec<Cell>,
    tracker: Tracker,
    forecast: Forecast,
    controller: Controller,
    step: u32,
    /// The current command and its reason.
    command: (Control, DrivingMode),
    decision: Option<Decision>,
}

impl Default for InterFuser {
    fn default() -> Self {
        Self::new()
    }
}

impl InterFuser {
    /// Makes one without a way until [`DrivingPolicy::reset`].
    pub fn new() -> Self {
        Self {
            path: Path::default(),
            map: ObjectMap::default(),
            detections: Vec::with_capacity(400),
            tracker: Tracker::new(),
            forecast: Forecast::new(),
            controller: Controller::new(&Settings::default()),
            step: 0,
            command: (Control::default(), DrivingMode::Cruise),
            decision: None,
        }
    }

    /// The planner's decision in the last [`DrivingPolicy::drive`], carried out or not; `None` at the end of the road.
    pub fn decision(&self) -> Option<&Decision> {
        self.decision.as_ref()
    }

    /// The road users that it reacts to, as the tracker left them.
    pub fn detections(&self) -> &[Cell] {
        &self.detections
    }

    /// Draws the map anew, finds all road users in it and forecasts where they go.
    fn look(&mut self, perception: &Perception<'_>) {
        let ego = &perception.ego.pose;
        let actors = perception.pedestrians.iter().chain(perception.vehicles);
        self.map.perceive(actors.map(|actor| Sighting::new(ego, actor)));
        self.map.clamp();
        find_detections(&self.map, &mut self.detections);
        let compass = (FRAC_PI_2 - ego.yaw).rem_euclid(TAU);
        self.tracker.update(&mut self.detections, ego.position(), compass, i64::from(self.step / 2));
        self.forecast.draw(&self.detections);
    }

    /// Ten points of the route ahead, in the ego's frame; `None` if the road ends before.
    fn waypoints(&self, perception: &Perception<'_>) -> Option<[EgoVector; WAYPOINTS]> {
        let ego = &perception.ego.pose;
        let here = ego.position();
        let near = |place: Point| (place - here).norm_squared() <= FIRST_WAYPOINT * FIRST_WAYPOINT;
        let within = self.path.points().take_while(|point| near(point.pose.position())).count();
        let mut points = self.path.points().skip(within.saturating_sub(1));
        let mut waypoints = [EgoVector::zeros(); WAYPOINTS];
        for waypoint in &mut waypoints {
            let local = ego.to_local(points.next()?.pose.position());
            *waypoint = EgoVector::new(-local.y, -local.x);
        }
        Some(waypoints)
    }

    /// Whether a red or yellow light affects the ego.
    ///
    /// # Source
    /// InterFuser `team_code/auto_pilot.py`, `_is_light_red`, which labels the training data.
    fn at_red(&self, perception: &Perception<'_>) -> bool {
        let here = perception.ego.pose.position();
        let affecting = perception.affecting_light.and_then(|index| perception.lights.get(index));
        let mut lights = perception.lights.iter();
        affecting.is_some_and(|light| light.colour != LightColour::Green)
            || lights.any(|light| {
                let stop = light.trigger.position();
                light.colour != LightColour::Green
                    && (stop - here).norm_squared() <= LIGHT * LIGHT
                    && self.path.points().take(LIGHT as usize + 2).any(|point| {
                        (point.pose.position() - stop).norm_squared() <= LIGHT_ASIDE * LIGHT_ASIDE
                            && wrap_angle(point.pose.yaw - light.trigger.yaw).abs() < FRAC_PI_2
                    })
            })
    }
}

impl DrivingPolicy for InterFuser {
    fn reset(&mut self, perception: &Perception<'_>, stream: Stream) {
        self.path.reset(perception, stream);
        self.map.clear();
        self.detections.clear();
        self.tracker.reset();
        self.forecast.draw(&[]);
        self.controller.reset();
        self.step = 0;
        self.command = (Control::default(), DrivingMode::Cruise);
        self.decision = None;
    }

    fn drive(&mut self, perception: &Perception<'_>) -> Control {
        let (even, first) = (self.step.is_multiple_of(2), self.step <= FIRST_STEPS);
        self.path.advance(perception);
        let waypoints = self.waypoints(perception);
        if even || self.step < FIRST_STEPS {
            self.look(perception);
        }
        self.step += 1;
        let sure = |fact: bool| if fact { SURE } else { 1.0 - SURE };
        self.decision = waypoints.map(|waypoints| {
            let inputs = Inputs {
                speed: perception.ego.speed(),
                waypoints,
                p_not_junction: sure(!self.path.points().next().is_some_and(|point| point.is_junction)),
                p_red: sure(self.at_red(perception)),
                p_no_stop_sign: SURE,
            };
            self.controller.step(&inputs, &self.forecast)
        });
        if even || first {
            self.command = match &self.decision {
                Some(decision) => (decision.control(), mode(decision.reason)),
                None => (Control { brake: 1.0, ..Control::default() }, DrivingMode::Arrived),
            };
        }
        self.command.0
    }

    fn mode(&self) -> DrivingMode {
        self.command.1
    }

    fn snapshot(&self) -> Option<Box<dyn DrivingPolicy>> {
        Some(Box::new(self.clone()))
    }

    fn reseed(&mut self, stream: Stream) {
        self.path.reseed(stream);
    }
}

fn mode(reason: Reason) -> DrivingMode {
    match reason {
        Reason::None => DrivingMode::Cruise,
        Reason::Slower | Reason::StopSign => DrivingMode::Yield,
        Reason::Blocked => DrivingMode::EmergencyStop,
        Reason::RedLight => DrivingMode::RedLight,
    }
}

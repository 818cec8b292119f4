use std::sync::Arc;

use super::delay::Delay;
use super::message::{self, Begin, Body, Car, Load, Model, Moved, Pedals, Step, Walker, read_loaded, read_moved};
use super::odometer::Odometer;
use super::{ExternalWorld, LaneMatch, Loaded};
use crate::{PedestrianRole, Scenario};
use base::seed::Seed;
use road::geometry::{Pose, Vector, wrap_angle};
use road::{ForkRule, LaneFilter, RandomWalk, RoadOption, RoutePoint, Town, Waypoint};
use world::av::Fault;
use world::av::external::Peer;
use world::sim::{Control, PedestrianState, VehicleState, World};

/// How far a pedestrian may be from where the world was told to place it, if the world does not say how far (m).
pub(super) const MOVED: f64 = 0.01;
/// How far the car may be from its start (m, rad, m/s) when an episode begins.
const PLACED: f64 = 0.01;
/// A car that is slower stands (m/s): on springs it is never quite at rest.
pub(super) const STANDING: f64 = 0.02;
/// How far a lane of the world may be from that of the town (m).
const LANES: f64 = 0.1;
/// The distance between places on lanes (m), and their maximum number.
const SPACING: f64 = 10.0;
const MAX_PLACES: usize = 2_000;
/// The length of the way of another simulator's driver (points, a metre apart).
const ROUTE: usize = 600;
/// A trial of the brake, of which episodes may show only what any tyres hold: from this speed (m/s), for this time (s), with everybody else this far away (m).
const HALF_BRAKE: Control = Control { throttle: 0.0, brake: 0.5, steer: 0.0 };
const TRIED_FROM: f64 = 8.0;
const TRIED: f64 = 0.8;
const AWAY: f64 = 30.0;

/// The driver of the other simulator that drives, and the lanes that it is to take; `None` if the driver is ours.
type Driver<'a> = Option<(&'a str, &'a [Waypoint])>;

/// A program that bridges to another simulator, for one episode after another. It is started for the first one, and again after a fault.
pub(crate) struct Bridge {
    world: Arc<ExternalWorld>,
    /// `None` before the first episode.
    peer: Option<Peer>,
    /// The message with the town.
    load: Vec<u8>,
    request: Vec<u8>,
    answer: Vec<u8>,
    /// Whether the program has braked since it was started.
    has_braked: bool,
    /// Whether a driver of ours drives in the running episode, how the car moves, and how late pedestrians are.
    is_ours: bool,
    odometer: Odometer,
    delay: Delay,
}

impl Drop for Bridge {
    /// Keeps a program that runs for the next bridge.
    fn drop(&mut self) {
        if let Some(peer) = self.peer.take().filter(Peer::is_running) {
            let load = std::mem::take(&mut self.load);
            self.world.keep(Loaded { peer, load, has_braked: self.has_braked });
        }
    }
}

impl Bridge {
    /// Makes one. The program is not started before the first episode.
    pub fn new(world: Arc<ExternalWorld>) -> Self {
        Self {
            world,
            peer: None,
            load: Vec::new(),
            request: Vec::new(),
            answer: Vec::new(),
            has_braked: false,
            is_ours: true,
            odometer: Odometer::default(),
            delay: Delay::default(),
        }
    }

    /// Places the actors of a world whose first tick comes next. If a driver of the other simulator drives, it gets a way that begins with the given
    /// lanes.
    ///
    /// # Errors
    /// The program failed, its lanes are others, or it placed an actor elsewhere.
    pub fn begin(&mut self, scenario: &Scenario, here: &World, seed: u64, driver: Driver<'_>) -> Result<(), Fault> {
        let begun = self.try_begin(scenario, here, seed, driver);
        begun.inspect_err(|_| self.end())
    }

    /// Ends the program: what it says later would not be the answer to a later question.
    fn end(&mut self) {
        self.peer.iter_mut().for_each(Peer::end);
    }

    fn try_begin(&mut self, scenario: &Scenario, here: &World, seed: u64, driver: Driver<'_>) -> Result<(), Fault> {
        self.start(scenario)?;
        if driver.is_none() && !self.has_braked {
            self.try_brake(here)?;
            self.has_braked = true;
        }
        self.place(here, seed, driver)
    }

    /// Lets the car brake on a lane of the town, the same at each start of the program.
    fn try_brake(&mut self, here: &World) -> Result<(), Fault> {
        let Some([x, y]) = places(&here.town).first().copied() else { return Ok(()) };
        let mut trial = here.clone();
        let place = Pose { x, y, yaw: 0.0 };
        let lane = here.town.nearest_lane(place.position(), LaneFilter::Driving);
        let pose = lane.map_or(place, |lane| here.town.pose(lane));
        trial.ticks = 0;
        trial.vehicles[0].state = VehicleState {
            pose,
            speed: TRIED_FROM,
            age: here.ego().blueprint.start_up_pause,
            ..VehicleState::default()
        };
        for (number, pedestrian) in trial.pedestrians.iter_mut().enumerate() {
            let aside = pose.to_world(Vector::new(-2.0 * number as f64, AWAY));
            pedestrian.state = PedestrianState::standing(Pose { x: aside.x, y: aside.y, yaw: 0.0 });
        }
        self.place(&trial, 0, None)?;
        // What is wrong shows a tick later.
        for _ in 0..=((TRIED + self.pedal_delay()) / here.dt) as u32 {
            let ego = self.try_tick(&trial, HALF_BRAKE)?;
            trial.follow(ego);
        }
        Ok(())
    }

    /// Places the actors, and checks that they are there.
    fn place(&mut self, here: &World, seed: u64, driver: Driver<'_>) -> Result<(), Fault> {
        let ego = here.ego();
        let begin = Begin {
            r#type: "begin",
            seed,
            ego: Car::new(&ego.state),
            driver: driver.map(|(name, _)| name),
            speed_limit: ego.speed_limit,
            route: driver.map_or_else(Vec::new, |(_, lanes)| route(&here.town, &ego.state.pose, lanes, seed)),
            pedestrians: walkers(here),
        };
        let moved = self.ask(&begin, self.world.start_timeout, read_moved).map_err(Fault::at_start)?;
        (self.is_ours, self.odometer, self.delay) = (driver.is_none(), Odometer::default(), Delay::default());
        self.check(&moved, 0, here)?;
        let (pose, placed) = (ego.state.pose, moved.ego);
        let apart = libm::hypot(placed.x - pose.x, placed.y - pose.y);
        let (turned, faster) = (wrap_angle(placed.yaw - pose.yaw), placed.speed - ego.state.speed);
        match [apart, turned, faster].iter().any(|off| off.abs() > PLACED) {
            true => Err(Fault::Placed {
                millimetres: millimetres(apart),
                degrees: turned.to_degrees().round() as i32,
                faster: (faster * 10.0).round() as i32,
            }),
            false => Ok(()),
        }
    }

    /// Starts the program if it does not run, and lets it load the town. Returns how well the lanes match; `None` if they were not compared now.
    pub(super) fn start(&mut self, scenario: &Scenario) -> Result<Option<LaneMatch>, Fault> {
        if self.peer.as_ref().is_some_and(Peer::is_running) {
            return Ok(None);
        }
        let lanes = places(&scenario.town);
        if self.peer.is_none() {
            let map = self.world.map(&scenario.town).map_err(|_| Fault::NoMap)?;
            self.load = load(scenario, &map, &lanes);
            if let Some(idle) = self.world.take(&self.load) {
                (self.peer, self.has_braked) = (Some(idle.peer), idle.has_braked);
                return Ok(None);
            }
            self.peer = Some(self.world.peer());
        }
        let Some(peer) = &mut self.peer else { return Err(Fault::NotStarted) };
        peer.forgive();
        self.has_braked = false;
        peer.ready(message::hello, &message::GREETING, |line| message::read_greeting(line).map(|_| ()))?;
        let loaded = peer.exchange(&self.load, self.world.start_timeout, &mut self.answer, read_loaded);
        let loaded = loaded.map_err(Fault::at_start)?;
        let Some(theirs) = loaded.lanes else { return Ok(None) };
        if theirs.len() != lanes.len() {
            return Err(Fault::Answer("not one place for each place on the lanes"));
        }
        let apart = |(ours, theirs): (&[f64; 2], &[f64; 2])| libm::hypot(ours[0] - theirs[0], ours[1] - theirs[1]);
        let apart: Vec<f64> = lanes.iter().zip(&theirs).map(apart).collect();
        let farthest = apart.iter().copied().fold(0.0, f64::max);
        if farthest > LANES {
            return Err(Fault::Lanes { millimetres: millimetres(farthest) });
        }
        Ok(Some(LaneMatch {
            places: lanes.len(),
            mean: apart.iter().sum::<f64>() / lanes.len().max(1) as f64,
            farthest,
        }))
    }

    /// Moves the car by a control, after the pedestrians have walked; returns its new state.
    ///
    /// # Errors
    /// The program failed, ended the episode, or moved an actor as it cannot move.
    pub fn tick(&mut self, here: &World, control: Control) -> Result<VehicleState, Fault> {
        self.try_tick(here, control).inspect_err(|_| self.end())
    }

    fn try_tick(&mut self, here: &World, control: Control) -> Result<VehicleState, Fault> {
        let ego = here.ego();
        let (state, car) = (&ego.state, &ego.blueprint);
        let mut next = state.step(control, car, here.dt);
        if state.speed < 0.0 {
            // It rolls back until its brake has stopped it.
            next.speed = next.speed.min(state.speed + car.full_brake * here.dt);
        }
        let acceleration = (next.speed - state.speed) / here.dt;
        let wheel_angle = car.wheel_angle(control.steer, state.speed);
        let step = Step {
            r#type: "step",
            tick: here.ticks + 1,
            control: Pedals::new(control, acceleration, wheel_angle),
            pedestrians: walkers(here),
        };
        let moved = self.ask(&step, self.world.timeout, read_moved)?;
        self.check(&moved, step.tick, here)?;
        let Car { x, y, yaw, speed } = moved.ego;
        let speed = if speed.abs() < STANDING { 0.0 } else { speed };
        let moved =
            VehicleState { pose: Pose { x, y, yaw: wrap_angle(yaw) }, speed, age: next.age, ..VehicleState::default() };
        let control = self.is_ours.then_some(control);
        self.odometer.add([state, &next, &moved], (car, control), (here.dt, self.tolerance(), self.pedal_delay()))?;
        Ok(moved)
    }

    /// Whether the episode goes on at this tick, with each pedestrian where it was told to be.
    fn check(&mut self, moved: &Moved, tick: u32, here: &World) -> Result<(), Fault> {
        if moved.tick != tick {
            return Err(Fault::Answer("another tick than it was asked for"));
        }
        if moved.end {
            return Err(Fault::EndedEarly);
        }
        if moved.pedestrians.len() != here.pedestrians.len() {
            return Err(Fault::Answer("not one place for each pedestrian"));
        }
        let apart = moved.pedestrians.iter().zip(&here.pedestrians).map(|([x, y], told)| {
            let told = told.state.pose;
            libm::hypot(x - told.x, y - told.y)
        });
        let farthest = apart.fold(0.0, f64::max);
        if farthest > self.tolerance().max(MOVED) {
            return Err(Fault::Moved { millimetres: millimetres(farthest) });
        }
        // Without a tolerance a late pedestrian is elsewhere.
        if self.tolerance() > MOVED { self.delay.add(&here.pedestrians, &moved.pedestrians) } else { Ok(()) }
    }

    /// How far from where it is told the world may place an actor (m).
    fn tolerance(&self) -> f64 {
        self.world.abilities.as_ref().map_or(0.0, |abilities| abilities.tolerance)
    }

    /// How late the car of the world may follow its pedals (s).
    fn pedal_delay(&self) -> f64 {
        self.world.abilities.as_ref().map_or(0.0, |abilities| abilities.pedal_delay)
    }

    fn ask<T>(
        &mut self,
        message: &impl serde::Serialize,
        limit: f64,
        read: impl FnOnce(&[u8]) -> Result<T, Fault>,
    ) -> Result<T, Fault> {
        let Self { peer: Some(peer), request, answer, .. } = self else { return Err(Fault::NotStarted) };
        request.clear();
        write(request, message);
        peer.exchange(request, limit, answer, read)
    }
}

/// Appends a message with its line end.
fn write(line: &mut Vec<u8>, message: &impl serde::Serialize) {
    serde_json::to_writer(&mut *line, message).expect("numbers and words have a form in JSON");
    line.push(b'\n');
}

/// The message with the town of a scenario.
fn load(scenario: &Scenario, map: &str, lanes: &[[f64; 2]]) -> Vec<u8> {
    let Scenario { town, cast, episode, .. } = scenario;
    let car = &cast.ego().blueprint;
    let body = |role: &PedestrianRole| Body { radius: role.body.radius, height: 2.0 * role.body.half_height };
    let load = Load {
        r#type: "load",
        town: &town.name,
        map,
        tick_s: episode.tick,
        vehicle: Model {
            length: 2.0 * car.half_length,
            width: 2.0 * car.half_width,
            wheelbase: car.wheelbase,
            full_brake: car.full_brake,
        },
        pedestrians: cast.pedestrians.iter().map(body).collect(),
        friction: episode.friction,
        lanes,
    };
    let mut line = Vec::new();
    write(&mut line, &load);
    line
}

/// A way through a town from a place, along the given lanes as far as they lead: x, y, yaw.
fn route(town: &Town, from: &Pose, lanes: &[Waypoint], seed: u64) -> Vec<[f64; 3]> {
    let mut walk = RandomWalk::new(ForkRule::AnyBranch);
    walk.take(lanes);
    let mut stream = Seed::root(seed).child("route").stream();
    let start = lanes.first().copied().or_else(|| town.lane_under(from));
    let start = start.map(|lane| RoutePoint::new(town, lane, RoadOption::LaneFollow));
    let points = std::iter::successors(start, |last| walk.next(town, last, 1.0, &mut stream));
    points.take(ROUTE).map(|point| [point.pose.x, point.pose.y, point.pose.yaw]).collect()
}

fn walkers(here: &World) -> Vec<Walker> {
    here.pedestrians.iter().map(|pedestrian| Walker::new(&pedestrian.state)).collect()
}

/// Places on the middle of driving lanes outside junctions, where simulators draw their own.
fn places(town: &Town) -> Vec<[f64; 2]> {
    let all = town.generate_waypoints(SPACING).into_iter().filter(|place| !town.is_junction(*place));
    let all: Vec<[f64; 2]> = all.map(|place| town.pose(place)).map(|pose| [pose.x, pose.y]).collect();
    let stride = all.len().div_ceil(MAX_PLACES).max(1);
    all.into_iter().step_by(stride).collect()
}

pub(super) fn millimetres(metres: f64) -> u32 {
    (metres * 1000.0).round() as u32
}

use super::lane_watch::{LanePlace, LaneWatch};
use super::motion::STANDING;
use crate::MOVING_ABOVE;
use crate::scenario::actor_signal::FARTHEST;
use crate::scenario::signal::{AHEAD, HORIZON, Situation, Wanted};
use road::geometry::{OrientedBox, Point, Vector, polygon, time_to_touch};
use road::{Crosswalk, Place, TrafficLight};
use world::sim::{ActorId, Contact, LightColour, Pedestrian, World};

/// How far from a crosswalk a pedestrian still waits at it (m).
const WAITING: f64 = 1.5;
/// From the middle of a light's trigger box to the end of its lane, where cars stop at the latest (m).
///
/// # Source
/// CARLA `Traffic/TrafficLightComponent.cpp`, as of [`TrafficLight`].
const STOP_LINE: f64 = 3.0;
/// The half widths of a trigger box within which a car is on the light's lane: the box has half the width of the lane.
const LANE_WIDTHS: f64 = 2.0;

/// Measures the signals that formulas name, tick by tick, and no others.
///
/// The pedestrian of a signal is the one that the ego touches, and otherwise the nearest one.
#[derive(Debug, Clone)]
pub(super) struct SignalMeter {
    wanted: Wanted,
    now: Situation,
    /// The last tick: the ego's speed (m/s), its acceleration (m/s²) if it is known, and the pedestrians' velocities (m/s).
    speed: f64,
    acceleration: Option<f64>,
    velocities: Vec<Vector>,
    lanes: LaneWatch,
    encroachment: Encroachment,
}

impl SignalMeter {
    /// A meter of the wanted signals, with memory for this number of samples.
    pub(super) fn new(wanted: Wanted, world: &World, samples: usize) -> Self {
        Self {
            wanted,
            now: Situation::default(),
            speed: 0.0,
            acceleration: None,
            velocities: vec![Vector::zeros(); world.pedestrians.len()],
            lanes: LaneWatch::new(),
            encroachment: Encroachment::new(world.dt, if wanted.pet { samples } else { 0 }),
        }
    }

    /// The signals of the last sample; 0 for those that are not wanted.
    pub(super) fn now(&self) -> &Situation {
        &self.now
    }

    /// The signals that are measured.
    pub(super) fn wanted(&self) -> &Wanted {
        &self.wanted
    }

    /// The pedestrian that counts in this tick.
    pub(super) fn pedestrian(world: &World, contact: Option<&Contact>) -> usize {
        if world.pedestrians.len() == 1 {
            return 0;
        }
        contact.and_then(Contact::pedestrian_at_ego).unwrap_or_else(|| {
            let all = 0..world.pedestrians.len();
            all.min_by(|a, b| world.gap(0, *a).total_cmp(&world.gap(0, *b))).unwrap_or(0)
        })
    }

    /// Measures the start of an episode.
    pub(super) fn begin(&mut self, world: &World) {
        (self.speed, self.acceleration) = (world.ego().state.speed, None);
        self.lanes = LaneWatch::new();
        self.encroachment.clear();
        for (velocity, pedestrian) in self.velocities.iter_mut().zip(&world.pedestrians) {
            *velocity = pedestrian.state.velocity;
        }
        (self.now.ego_acceleration, self.now.ego_jerk, self.now.pedestrian_acceleration) = (0.0, 0.0, 0.0);
        self.measure(world, None);
    }

    /// Measures a tick that has just been simulated.
    pub(super) fn tick(&mut self, world: &World, contact: Option<&Contact>) {
        let speed = world.ego().state.speed;
        let acceleration = (speed - self.speed) / world.dt;
        self.now.ego_acceleration = acceleration;
        self.now.ego_jerk = self.acceleration.map_or(0.0, |before| (acceleration - before) / world.dt);
        (self.speed, self.acceleration) = (speed, Some(acceleration));
        if self.wanted.pedestrian_acceleration {
            let number = Self::pedestrian(world, contact);
            let change = world.pedestrians[number].state.velocity - self.velocities[number];
            self.now.pedestrian_acceleration = change.norm() / world.dt;
            for (velocity, pedestrian) in self.velocities.iter_mut().zip(&world.pedestrians) {
                *velocity = pedestrian.state.velocity;
            }
        }
        self.measure(world, contact);
    }

    /// Measures what follows from the state of the world alone, and the post-encroachment time.
    fn measure(&mut self, world: &World, contact: Option<&Contact>) {
        let (wanted, now) = (&self.wanted, &mut self.now);
        let number = Self::pedestrian(world, contact);
        let hit = contact.filter(|contact| contact.pedestrian_at_ego().is_some());
        let (ego, walker) = (world.ego(), &world.pedestrians[number]);
        let speed = hit.map_or(ego.state.speed, |hit| hit.impact_speed);
        let place = walker.state.pose.position();
        now.moving = f64::from(speed > MOVING_ABOVE);
        if wanted.gap {
            now.gap = if hit.is_some() { 0.0 } else { world.gap(0, number).min(FARTHEST) };
        }
        if wanted.closing_speed || wanted.ttc {
            let pose = &ego.state.pose;
            let velocity = walker.state.velocity - pose.forward() * speed;
            if wanted.closing_speed {
                let apart = place - pose.position();
                now.closing_speed = -apart.dot(&velocity) / apart.norm().max(1e-9);
            }
            if wanted.ttc {
                let local = pose.to_local(place);
                let closing = Vector::new(velocity.dot(&pose.forward()), velocity.dot(&pose.left()));
                let half = Vector::new(ego.blueprint.half_length, ego.blueprint.half_width);
                let local = Vector::new(local.x, local.y);
                let time = || time_to_touch(local, closing, half, walker.body.radius, HORIZON);
                now.ttc = match (hit.is_some(), speed > STANDING && world.is_on_level(0, number)) {
                    (_, false) => HORIZON,
                    (true, true) => 0.0,
                    (false, true) => time().unwrap_or(HORIZON),
                };
            }
        }
        if wanted.pet {
            let outline = ego.outline();
            // Who is on another level is at no place of the car.
            let place = if world.is_on_level(0, number) { place } else { Point::new(f64::INFINITY, 0.0) };
            now.pet = self.encroachment.tick(&outline, place, walker.body.radius, hit.is_some());
        }
        if wanted.lane_offset {
            let lane = world.town.lane_around(ego.state.place());
            now.lane_offset =
                lane.map_or(0.0, |lane| world.town.pose(lane.place).to_local(ego.state.pose.position()).y);
        }
        if wanted.left_lane || wanted.left_road {
            let place = self.lanes.look(&world.town, &ego.state);
            now.left_lane = f64::from(place != LanePlace::Inside);
            now.left_road = f64::from(place == LanePlace::OffRoad);
        }
        if wanted.light_distance || wanted.red_light {
            let (distance, red) = next_light(world);
            (now.light_distance, now.red_light) = (distance, f64::from(red));
        }
        if wanted.crosswalk_distance || wanted.crosswalk_taken || wanted.crosswalk_waiting {
            let (distance, corners) = next_crosswalk(world);
            let near = |reach: (f64, f64)| {
                let within = |place: Place| {
                    let here = corners.filter(|corners| world.town.is_on_level(place, corners.place()));
                    let apart = here.map_or(f64::INFINITY, |corners| polygon::distance(corners, place.point));
                    reach.0 <= apart && apart <= reach.1
                };
                let there = |walker: &Pedestrian| walker.is_present && within(walker.state.place());
                f64::from(world.pedestrians.iter().any(there))
            };
            now.crosswalk_distance = distance;
            now.crosswalk_taken = near((0.0, 0.0));
            now.crosswalk_waiting = near((f64::MIN_POSITIVE, WAITING));
        }
        if wanted.in_sight {
            now.in_sight = f64::from(world.sees(ActorId::EGO, ActorId::Pedestrian(number as u8)));
        }
    }
}

/// The distance of the ego's front to the stop line of the next light on its lane (m), negative while its body is across, and whether that
/// light is red; [`AHEAD`] and no red light without one.
fn next_light(world: &World) -> (f64, bool) {
    let none = (AHEAD, false);
    let Some(clock) = world.light_clock() else { return none };
    let (pose, blueprint) = (&world.ego().state.pose, &world.ego().blueprint);
    let front = pose.to_world(Vector::new(blueprint.half_length, 0.0));
    let distance = |light: &TrafficLight| {
        let local = light.stop.to_local(front);
        let on_lane = local.y.abs() <= light.trigger.half.y * LANE_WIDTHS;
        let left = STOP_LINE - local.x;
        let ahead = (-2.0 * blueprint.half_length..AHEAD).contains(&left);
        let is_here = || world.town.is_on_level(world.ego().state.place(), world.town.place_of_car(&light.stop));
        (on_lane && ahead && pose.forward().dot(&light.stop.forward()) > 0.7 && is_here()).then_some(left)
    };
    let all = world.town.traffic_lights.iter().filter_map(|light| Some((distance(light)?, light)));
    let next = all.min_by(|(a, _), (b, _)| a.total_cmp(b));
    next.map_or(none, |(left, light)| (left, clock.colour(light) == LightColour::Red))
}

/// The distance of the ego's front to the next crosswalk straight ahead (m), 0 while its body is on it, with its corners; [`AHEAD`] without one.
fn next_crosswalk(world: &World) -> (f64, Option<&Crosswalk>) {
    let (pose, blueprint) = (&world.ego().state.pose, &world.ego().blueprint);
    // Where the axis of the car, from its back on, is on the crosswalk first and last.
    let along = |corners: &[Point]| {
        let local = |corner: &Point| pose.to_local(*corner);
        let ends = corners.iter().map(local).zip(corners.iter().map(local).cycle().skip(1));
        let crossed =
            ends.filter(|(a, b)| (a.y > 0.0) != (b.y > 0.0)).map(|(a, b)| a.x - a.y * (b.x - a.x) / (b.y - a.y));
        let (first, last) = crossed.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
        (last >= -blueprint.half_length).then_some((first - blueprint.half_length).max(0.0))
    };
    let all = world.town.crosswalks.iter().filter_map(|corners| Some((along(corners)?, corners)));
    let here = |walk: &Crosswalk| world.town.is_on_level(world.ego().state.place(), walk.place());
    let next = all.filter(|(distance, walk)| *distance < AHEAD && here(walk)).min_by(|(a, _), (b, _)| a.total_cmp(b));
    next.map_or((AHEAD, None), |(distance, corners)| (distance, Some(corners)))
}

/// The post-encroachment time up to now: the places of both bodies in the last ten seconds.
///
/// # Source
/// Allen, Shin and Cooper, *Analysis of traffic conflicts and collisions*, Transportation Research Record 667, 1978; here it is the least over all
/// places that both sweep.
#[derive(Debug, Clone)]
struct Encroachment {
    dt: f64,
    cars: Vec<OrientedBox>,
    walkers: Vec<Point>,
    /// Minimum number of ticks between both at one place.
    least: usize,
}

impl Encroachment {
    fn new(dt: f64, samples: usize) -> Self {
        Self { dt, cars: Vec::with_capacity(samples), walkers: Vec::with_capacity(samples), least: 0 }
    }

    fn clear(&mut self) {
        self.cars.clear();
        self.walkers.clear();
        self.least = (HORIZON / self.dt) as usize + 1;
    }

    /// Adds a sample; returns the time so far (s).
    fn tick(&mut self, car: &OrientedBox, walker: Point, radius: f64, is_hit: bool) -> f64 {
        self.cars.push(*car);
        self.walkers.push(walker);
        let reach = car.half.norm() + radius;
        let touch = |car: &OrientedBox, walker: Point| {
            (walker - car.pose.position()).norm_squared() <= reach * reach && car.distance_to(walker) <= radius
        };
        let lags = 0..self.least.min(self.cars.len());
        let met = |lag: usize| {
            let before = self.cars.len() - 1 - lag;
            touch(car, self.walkers[before]) || touch(&self.cars[before], walker)
        };
        let lag = if is_hit { Some(0) } else { lags.into_iter().find(|lag| met(*lag)) };
        self.least = lag.unwrap_or(self.least);
        (self.least as f64 * self.dt).min(HORIZON)
    }
}

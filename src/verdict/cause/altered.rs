use std::sync::Arc;

use base::seed::{Seed, Stream};
use episode::{Scenario, Trace};
use road::geometry::{Obstacles, Point, Pose, Vector, wrap_angle};
use world::av::{Actor, DrivingMode, DrivingPolicy, Fault, Perception};
use world::sim::{Control, PedestrianState};

/// A brake above this counts as braking.
pub(super) const BRAKING: f64 = 0.02;
/// How far ahead in time people are forecast at most (s).
const HORIZON: f64 = 3.0;
/// Deceleration of comfortable braking (m/s²).
const COMFORTABLE: f64 = 3.0;
/// Lateral acceleration of a swerve (m/s²), and the time for which it leads aside, and back again (s).
const SWERVE: (f64, f64) = (4.0, 1.0);
/// A car that is slower (m/s) stands.
const STANDING: f64 = 0.1;
/// What is seen nearer stays this far from the bumper (m).
const KEPT: f64 = 0.5;

/// The one thing that is changed in a counterfactual run: what a driver sees of the pedestrian that it hits, or what becomes of its commands. Ticks count
/// from the start of the episode.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Change {
    /// From a tick on the brake is full, whatever the driver wants.
    BrakesFrom(u32),
    /// From a tick on the car brakes comfortably.
    SlowsFrom(u32),
    /// From a tick on the car swerves, to the left if that is true.
    SwervesFrom(u32, bool),
    /// Nobody is there.
    Unseen,
    /// Instead of all pedestrians one stands at this place from a tick on, or nobody does; the car then seems to have a share of its speed.
    Appears { from: u32, somebody: Option<Point>, speed: f64 },
    /// No obstacle hides anybody.
    SeenThrough,
    /// The driver sees where pedestrians will be this number of ticks later, as seen from the car if it keeps its speed.
    Earlier(u32),
    /// Pedestrians seem nearer to the middle of its way by this (m).
    Sideways(f64),
    /// They seem nearer along its way by this (m).
    Nearer(f64),
    /// They seem to come from the other side.
    Mirrored,
    /// The velocity of the pedestrian is that which leads straight to the place of the touch in time.
    TrueVelocity,
    /// Somebody stands at the place of the touch from the start.
    Foretold,
    /// Pedestrians seem to be where they will be at constant velocity after this share of the time until the car is there.
    Forecast(f64),
    /// Pedestrians seem to stand where they are.
    Standing,
    /// The car seems to be faster by this (m/s).
    Faster(f64),
    /// The driver draws other numbers, those of this index.
    Redrawn(u64),
    /// Each braking is full braking.
    BrakesFully,
    /// It brakes until it stands, once it brakes.
    KeepsBraking,
    /// The speed limit is at most this (m/s), in the run-up, too.
    Limited(f64),
}

/// A driver with one thing changed.
struct Altered {
    driver: Box<dyn DrivingPolicy>,
    change: Change,
    story: Arc<Story>,
    /// The tick of the episode; `None` before it.
    tick: Option<u32>,
    /// The hardest braking up to now.
    held: f64,
    pedestrians: Vec<Actor>,
}

/// What happened: the walk of each pedestrian up to the touch, and who was struck.
pub(super) struct Story {
    walks: Vec<Vec<PedestrianState>>,
    struck: usize,
    nothing: Obstacles,
    dt: f64,
}

/// The numbers that a driver draws in a run with other ones.
fn redrawn(index: u64) -> Stream {
    Seed::root(index).child("redrawn").stream()
}

/// A scenario whose driver under test sees no pedestrian.
pub fn unseeing(scenario: &Scenario) -> Arc<Scenario> {
    let (mut scenario, nothing) = (scenario.clone(), Obstacles::new(&[]));
    let story = Arc::new(Story { walks: Vec::new(), struck: 0, nothing, dt: scenario.episode.tick });
    let make = scenario.cast.ego().policy.clone();
    scenario.cast.vehicles[0].policy = Arc::new(move || story.alter(make(), Change::Unseen));
    Arc::new(scenario)
}

impl Story {
    pub fn new(trace: &Trace, scenario: &Scenario) -> Self {
        let walks = (0..trace.pedestrian_count()).map(|number| trace.pedestrian(number).to_vec()).collect();
        let struck = trace.contact().and_then(|contact| contact.pedestrian_at_ego()).unwrap_or(0);
        Self { walks, struck, nothing: Obstacles::new(&[]), dt: scenario.episode.tick }
    }

    /// The state of a pedestrian at a tick; after its end it keeps its velocity. `None` of one that does not exist.
    fn state(&self, number: usize, tick: usize) -> Option<PedestrianState> {
        let walk = self.walks.get(number)?;
        let last = walk.len().checked_sub(1)?;
        let mut state = walk[tick.min(last)];
        let way = state.velocity * (tick.saturating_sub(last) as f64 * self.dt);
        (state.pose.x, state.pose.y) = (state.pose.x + way.x, state.pose.y + way.y);
        Some(state)
    }

    /// A driver with one thing changed.
    pub fn alter(self: &Arc<Self>, driver: Box<dyn DrivingPolicy>, change: Change) -> Box<dyn DrivingPolicy> {
        let story = self.clone();
        let mut driver = driver;
        if let Change::Redrawn(index) = change {
            driver.reseed(redrawn(index));
        }
        Box::new(Altered { driver, change, story, tick: None, held: 0.0, pedestrians: Vec::new() })
    }
}

impl Altered {
    /// Sets what the driver sees.
    fn look(&mut self, perception: &Perception<'_>) {
        let Self { change, story, tick, pedestrians, .. } = self;
        pedestrians.clear();
        let Some(tick) = *tick else { return };
        let ego = &perception.ego;
        let seen = perception.pedestrians.iter();
        let moved = |actor: &Actor, x: f64, y: f64| {
            let place = ego.pose.to_world(Vector::new(x, y));
            let mut actor = *actor;
            (actor.pose.x, actor.pose.y) = (place.x, place.y);
            actor
        };
        match *change {
            Change::Unseen => {}
            Change::Appears { from, somebody, .. } => {
                let there = perception.pedestrians.first().zip(somebody).filter(|_| tick >= from);
                pedestrians.extend(there.map(|(like, place)| {
                    let pose = Pose { x: place.x, y: place.y, ..like.pose };
                    Actor { pose, velocity: Vector::zeros(), ..*like }
                }));
            }
            Change::Earlier(ticks) => {
                let way = ego.velocity * (f64::from(ticks) * story.dt);
                pedestrians.extend(seen.enumerate().map(|(number, actor)| {
                    let Some(then) = story.state(number, (tick + ticks) as usize) else { return *actor };
                    let mut pose = then.pose;
                    (pose.x, pose.y) = (pose.x - way.x, pose.y - way.y);
                    Actor { pose, velocity: then.velocity, ..*actor }
                }));
            }
            Change::Sideways(way) => pedestrians.extend(seen.map(|actor| {
                let local = ego.pose.to_local(actor.pose.position());
                moved(actor, local.x, local.y - local.y.clamp(-way, way))
            })),
            Change::Nearer(way) => pedestrians.extend(seen.map(|actor| {
                let local = ego.pose.to_local(actor.pose.position());
                let least = (ego.half.x + actor.half.x + KEPT).min(local.x);
                moved(actor, (local.x - way).max(least), local.y)
            })),
            Change::Forecast(part) => pedestrians.extend(seen.map(|actor| {
                let ahead = ego.pose.to_local(actor.pose.position()).x - ego.half.x;
                let then = (part * ahead / ego.speed().max(STANDING)).clamp(0.0, HORIZON);
                let place = actor.pose.position() + actor.velocity * then;
                Actor { pose: Pose { x: place.x, y: place.y, ..actor.pose }, ..*actor }
            })),
            Change::Standing => pedestrians.extend(seen.map(|actor| Actor { velocity: Vector::zeros(), ..*actor })),
            Change::Mirrored => pedestrians.extend(seen.map(|actor| {
                let local = ego.pose.to_local(actor.pose.position());
                let mut actor = moved(actor, local.x, -local.y);
                let (ahead, left) = (ego.pose.forward(), ego.pose.left());
                actor.velocity = ahead * ahead.dot(&actor.velocity) - left * left.dot(&actor.velocity);
                actor.pose.yaw = wrap_angle(2.0 * ego.pose.yaw - actor.pose.yaw);
                actor
            })),
            Change::TrueVelocity => pedestrians.extend(seen.enumerate().map(|(number, actor)| {
                let last = story.walks.get(number).map_or(0, |walk| walk.len().saturating_sub(1));
                let left = last.saturating_sub(tick as usize) as f64 * story.dt;
                match story.state(number, last) {
                    Some(end) if left > story.dt => {
                        Actor { velocity: (end.pose.position() - actor.pose.position()) / left, ..*actor }
                    }
                    _ => *actor,
                }
            })),
            Change::Foretold => {
                pedestrians.extend(seen);
                let place = story.walks.get(story.struck).and_then(|walk| walk.last());
                let like = perception.pedestrians.get(story.struck).or(perception.pedestrians.first());
                pedestrians.extend(place.zip(like).map(|(place, like)| Actor {
                    id: Actor::FALSE_ALARM,
                    pose: place.pose,
                    velocity: Vector::zeros(),
                    ..*like
                }));
            }
            _ => pedestrians.extend(seen),
        }
    }

    /// What becomes of the driver's command.
    fn act(&mut self, control: Control, perception: &Perception<'_>) -> Control {
        let Some(tick) = self.tick else { return control };
        let full = Control { steer: control.steer, ..Control::FULL_BRAKE };
        let (speed, blueprint) = (perception.ego.speed(), perception.blueprint);
        match self.change {
            Change::BrakesFrom(from) if tick >= from => full,
            Change::SlowsFrom(from) if tick >= from => {
                let pedals = blueprint.pedals_for(-COMFORTABLE, speed);
                if speed < STANDING { full } else { Control { steer: control.steer, ..pedals } }
            }
            Change::SwervesFrom(from, left) if tick >= from => {
                let time = f64::from(tick - from) * perception.dt;
                let side = if left { 1.0 } else { -1.0 };
                let part = if time < SWERVE.1 {
                    side
                } else if time < 2.0 * SWERVE.1 {
                    -side
                } else {
                    0.0
                };
                let slip = (SWERVE.0 * blueprint.wheelbase / 2.0 / (speed * speed).max(1.0)).min(0.5);
                let wheel = libm::atan(2.0 * libm::tan(libm::asin(slip)));
                Control { throttle: 0.0, brake: 0.0, steer: part * blueprint.steer_for(wheel, speed) }
            }
            Change::BrakesFully if control.brake > BRAKING => full,
            Change::KeepsBraking => {
                self.held = if speed < STANDING { 0.0 } else { self.held.max(control.brake) };
                if self.held > BRAKING && control.brake < self.held {
                    return Control { throttle: 0.0, brake: self.held, steer: control.steer };
                }
                control
            }
            _ => control,
        }
    }

    /// Asks the driver with what it sees.
    fn ask<T>(
        &mut self,
        perception: &Perception<'_>,
        of: impl FnOnce(&mut dyn DrivingPolicy, &Perception<'_>) -> T,
    ) -> T {
        self.look(perception);
        let obstacles = if self.change == Change::SeenThrough { &self.story.nothing } else { perception.obstacles };
        let mut ego = perception.ego;
        if let Change::Appears { from, speed, .. } = self.change
            && self.tick.is_some_and(|tick| tick >= from)
        {
            ego.velocity *= speed;
        }
        if let (Change::Faster(by), Some(_)) = (self.change, self.tick) {
            ego.velocity += ego.pose.forward() * by;
        }
        let mut seen = Perception { ego, pedestrians: &self.pedestrians, obstacles, ..*perception };
        if let Change::Limited(limit) = self.change {
            seen.speed_limit = seen.speed_limit.min(limit);
            seen.signed_limit = seen.signed_limit.map(|signed| signed.min(limit));
        }
        of(&mut *self.driver, &seen)
    }
}

impl DrivingPolicy for Altered {
    fn reset(&mut self, perception: &Perception<'_>, stream: Stream) {
        // In a run-up there is nobody; otherwise the episode begins now.
        self.tick = (!perception.pedestrians.is_empty()).then_some(0);
        self.held = 0.0;
        let stream = if let Change::Redrawn(index) = self.change { redrawn(index) } else { stream };
        self.ask(perception, |driver, seen| driver.reset(seen, stream));
        self.tick = None;
    }

    fn speed_limit_for(&self, speed: f64) -> f64 {
        self.driver.speed_limit_for(speed)
    }

    fn drive(&mut self, perception: &Perception<'_>) -> Control {
        self.tick = match self.tick {
            None => (!perception.pedestrians.is_empty()).then_some(0),
            Some(tick) => Some(tick + 1),
        };
        let control = self.ask(perception, |driver, seen| driver.drive(seen));
        self.act(control, perception)
    }

    fn mode(&self) -> DrivingMode {
        self.driver.mode()
    }

    fn fault(&self) -> Option<Fault> {
        self.driver.fault()
    }

    fn snapshot(&self) -> Option<Box<dyn DrivingPolicy>> {
        let (driver, pedestrians) = (self.driver.snapshot()?, self.pedestrians.clone());
        Some(Box::new(Self { driver, pedestrians, story: self.story.clone(), ..*self }))
    }

    fn reseed(&mut self, stream: Stream) {
        self.driver.reseed(stream);
    }
}

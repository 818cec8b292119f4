//! A small pedestrian world with every equation written out.
//!
//! It is not part of the program. It is the world for the comparison of the learner with stable-baselines3.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_3, PI, TAU};

use base::seed::Stream;
use learn::{Env, Step};
use rand::Rng;

/// The length of a tick (s).
const TICK: f64 = 0.05;
/// The number of ticks after which an episode is cut off.
pub const TICKS: u32 = 600;
/// The number of ticks of a decision.
const HOLD: u32 = 20;
/// Half the length and width of the car (m).
const CAR: [f64; 2] = [2.35, 0.925];
/// The radius of the pedestrian (m).
const PEDESTRIAN: f64 = 0.3;
/// The car's speed on a straight line and in a turn (m/s).
const CRUISE: f64 = 8.0;
const IN_TURN: f64 = 4.0;
/// The acceleration and the deceleration of the car (m/s²).
const GAIN: f64 = 2.0;
const BRAKE: f64 = 6.0;
/// Half the width of the strip that the car watches, and the distance that it keeps (m).
const CORRIDOR: f64 = 1.75;
const MARGIN: f64 = 2.0;
/// The pedestrian's top speed (m/s).
pub const WALK: f64 = 3.5;
/// A hit within this angle of dead ahead is frontal (rad).
const FRONT: f64 = FRAC_PI_3;

/// The road of the car.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Road {
    /// An endless straight line.
    Straight,
    /// A line, then a quarter arc to the left or right, then an endless line.
    Tee,
}

/// The units of observations or actions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Units {
    /// Radians, metres, metres per second.
    Raw,
    /// About one.
    Scaled,
}

/// The value of a hit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reward {
    /// One.
    R1,
    /// More for a frontal and a fast one.
    R2,
}

/// The end of an episode.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// At a hit or after thirty seconds.
    Paper,
    /// Also when the car has passed out of reach, which is a terminal state.
    Lost,
}

/// A variant of the world.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Rules {
    pub road: Road,
    pub obs: Units,
    pub act: Units,
    pub reward: Reward,
    pub end: End,
}

/// The start of an episode.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Start {
    /// The car's distance along its route at the start (m).
    pub s: f64,
    /// Whether the arc turns left.
    pub left: bool,
    /// The distance from the car to the pedestrian (m).
    pub distance: f64,
    /// The direction from the car to the pedestrian, relative to the car's heading (rad).
    pub bearing: f64,
    /// The pedestrian's heading in the world (rad).
    pub heading: f64,
}

/// A collision.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    pub front: bool,
    pub moving: bool,
}

/// The world during an episode.
#[derive(Debug, Clone)]
pub struct PedWorld {
    rules: Rules,
    starts: Stream,
    left: bool,
    pub tick: u32,
    pub s: f64,
    pub speed: f64,
    /// x, y and heading.
    pub car: [f64; 3],
    pub pedestrian: [f64; 3],
    hit: Option<Hit>,
}

impl PedWorld {
    /// Makes a world whose episodes start at random.
    pub fn new(rules: Rules, starts: Stream) -> Self {
        let (car, pedestrian) = ([0.0; 3], [0.0; 3]);
        Self { rules, starts, left: true, tick: 0, s: 0.0, speed: 0.0, car, pedestrian, hit: None }
    }

    /// Starts an episode here.
    pub fn begin(&mut self, start: &Start, obs: &mut [f64]) {
        (self.s, self.left, self.speed, self.tick, self.hit) = (start.s, start.left, 0.0, 0, None);
        self.car = self.pose(start.s);
        let direction = self.car[2] + start.bearing;
        self.pedestrian = [
            self.car[0] + start.distance * libm::cos(direction),
            self.car[1] + start.distance * libm::sin(direction),
            start.heading,
        ];
        self.observe(obs);
    }

    /// The collision that ended the episode.
    pub fn hit(&self) -> Option<Hit> {
        self.hit
    }

    fn draw(&mut self, low: f64, high: f64) -> f64 {
        let unit = (self.starts.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
        low + (high - low) * unit
    }

    /// The radius of the arc and the length of the line before it (m).
    fn arc(&self) -> (f64, f64) {
        let radius = if self.left { 9.5 } else { 6.0 };
        (radius, 30.0 - radius)
    }

    fn pose(&self, s: f64) -> [f64; 3] {
        if self.rules.road == Road::Straight {
            return [s, 0.0, 0.0];
        }
        let ((radius, line), turn) = (self.arc(), if self.left { 1.0 } else { -1.0 });
        let angle = (s - line) / radius;
        if s <= line {
            [-30.0 + s, -1.75, 0.0]
        } else if angle <= FRAC_PI_2 {
            let (sin, cos) = (libm::sin(angle), libm::cos(angle));
            [-30.0 + line + radius * sin, -1.75 + turn * radius * (1.0 - cos), turn * angle]
        } else {
            let beyond = s - line - radius * PI / 2.0;
            [-30.0 + line + radius, -1.75 + turn * (radius + beyond), turn * PI / 2.0]
        }
    }

    fn speed_limit(&self) -> f64 {
        let (radius, line) = self.arc();
        let near_arc = line - 6.0 <= self.s && self.s <= line + radius * PI / 2.0;
        if self.rules.road == Road::Tee && near_arc { IN_TURN } else { CRUISE }
    }

    /// The pedestrian ahead and to the left of the car's centre (m).
    pub fn seen_from_car(&self) -> [f64; 2] {
        let (dx, dy) = (self.pedestrian[0] - self.car[0], self.pedestrian[1] - self.car[1]);
        let (sin, cos) = (libm::sin(self.car[2]), libm::cos(self.car[2]));
        [cos * dx + sin * dy, -sin * dx + cos * dy]
    }

    fn observe(&self, obs: &mut [f64]) {
        let (dx, dy) = (self.car[0] - self.pedestrian[0], self.car[1] - self.pedestrian[1]);
        let bearing = wrap_angle(libm::atan2(dy, dx) - self.pedestrian[2]);
        let heading = wrap_angle(self.car[2] - self.pedestrian[2]);
        let distance = (dx * dx + dy * dy).sqrt();
        obs.copy_from_slice(&match self.rules.obs {
            Units::Raw => [bearing, distance, heading, self.speed],
            Units::Scaled => [bearing / PI, distance / 30.0, heading / PI, self.speed / CRUISE],
        });
    }

    fn drive(&mut self, [ahead, aside]: [f64; 2]) {
        let stop = self.speed * self.speed / (2.0 * BRAKE) + self.speed * TICK + MARGIN;
        let limit = self.speed_limit();
        let blocked = ahead > 0.0 && aside.abs() <= CORRIDOR && ahead - CAR[0] - PEDESTRIAN <= stop;
        if blocked || self.speed > limit + 0.1 {
            self.speed = (self.speed - BRAKE * TICK).max(0.0);
        } else if self.speed < limit {
            self.speed = (self.speed + GAIN * TICK).min(limit);
        }
        self.s += self.speed * TICK;
        self.car = self.pose(self.s);
    }

    fn contact(&self, [ahead, aside]: [f64; 2]) -> Option<Hit> {
        let (x, y) = ((ahead.abs() - CAR[0]).max(0.0), (aside.abs() - CAR[1]).max(0.0));
        (x * x + y * y <= PEDESTRIAN * PEDESTRIAN)
            .then(|| Hit { front: libm::atan2(aside, ahead).abs() <= FRONT, moving: self.speed > 0.1 })
    }
}

impl Env for PedWorld {
    fn obs_dim(&self) -> usize {
        4
    }

    fn action_bounds(&self) -> Vec<(f64, f64)> {
        match self.rules.act {
            Units::Raw => vec![(-PI, PI), (0.0, WALK)],
            Units::Scaled => vec![(-1.0, 1.0); 2],
        }
    }

    fn reset(&mut self, obs: &mut [f64]) {
        let (mut s, mut left) = (0.0, true);
        if self.rules.road == Road::Tee {
            s = self.draw(0.0, 15.0);
            left = self.draw(0.0, 1.0) < 0.5;
        }
        let distance = self.draw(7.0, 30.0);
        let bearing = self.draw(-FRONT, FRONT);
        let heading = self.draw(-PI, PI);
        self.begin(&Start { s, left, distance, bearing, heading }, obs);
    }

    fn step(&mut self, action: &[f64], obs: &mut [f64]) -> Step {
        let (turn, pace) = match self.rules.act {
            Units::Raw => (action[0], action[1]),
            Units::Scaled => (PI * action[0], 0.5 * WALK * (action[1] + 1.0)),
        };
        self.pedestrian[2] = wrap_angle(self.pedestrian[2] + turn);
        let (sin, cos) = (libm::sin(self.pedestrian[2]), libm::cos(self.pedestrian[2]));
        let pace = [pace * cos * TICK, pace * sin * TICK];
        let mut place = self.seen_from_car();
        for _ in 0..HOLD {
            self.tick += 1;
            self.drive(place);
            self.pedestrian[0] += pace[0];
            self.pedestrian[1] += pace[1];
            place = self.seen_from_car();
            self.hit = self.contact(place);
            if self.hit.is_some() {
                break;
            }
        }
        self.observe(obs);
        let reward = match (self.hit, self.rules.reward) {
            (None, _) => 0.0,
            (Some(_), Reward::R1) => 1.0,
            (Some(hit), Reward::R2) if hit.front => (1.5 * self.speed).max(3.0),
            (Some(_), Reward::R2) => (0.5 * self.speed).max(1.0),
        };
        let (ahead, aside) = (place[0], place[1]);
        let far = ahead * ahead + aside * aside > 3600.0;
        let away = far || (ahead < -10.0 && self.speed > 3.5);
        let over = self.tick >= TICKS;
        let lost = self.rules.end == End::Lost && !over && away;
        let terminated = self.hit.is_some() || lost;
        Step { reward, terminated, truncated: over && !terminated }
    }
}

/// An angle in (−π, π].
fn wrap_angle(angle: f64) -> f64 {
    if angle > -PI && angle <= PI { angle } else { angle - TAU * ((angle - PI) / TAU).ceil() }
}

use std::f64::consts::FRAC_PI_2;

use super::EgoVector;
use super::corridor::{Corridor, WAYPOINTS};
use super::forecast::{Forecast, HORIZONS};
use super::pid::Pid;
use super::settings::Settings;
use world::sim::Control;

/// Distance that it leaves to a road user in the way (m).
const GAP: f64 = 2.0;
/// It brakes for less room than this (m) at any speed.
const MIN_ROOM: f64 = 3.0;
/// Ticks at rest after which it creeps.
const MAX_STOP_STEPS: u32 = 1200;
/// Ticks that it creeps.
const CREEP: u32 = 12;
/// Throttle while creeping.
const CREEP_THROTTLE: f64 = 0.8;
/// Ticks at red after which the light is ignored.
const MAX_RED_LIGHT_STEPS: u32 = 1000;
/// Ticks for which it is ignored.
const RED_IGNORED: u32 = 80;
/// Distance for which a stop sign is not checked again (m).
const STOP_SIGN_WAY: f64 = 2.0;
/// How often a stop sign takes effect again after that distance.
const STOP_SIGN_TIMES: u32 = 3;
/// Length of a tick for counting that distance (s).
const TICK: f64 = 0.05;

/// The inputs of the controller at a tick in addition to the [`Forecast`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Inputs {
    /// Speed of the ego (m/s).
    pub speed: f64,
    /// Ten points of the route, about a metre apart.
    pub waypoints: [EgoVector; WAYPOINTS],
    /// Probability that the ego is not in a junction.
    pub p_not_junction: f64,
    /// Probability that a red or yellow light affects the ego.
    pub p_red: f64,
    /// Probability that no stop sign is in force.
    pub p_no_stop_sign: f64,
}

/// The memory of the controller between ticks, except its windows.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Counters {
    /// Ticks at rest, minus ten for each tick in motion.
    pub stop_steps: u32,
    /// Remaining ticks of creeping.
    pub forced_forward_steps: u32,
    /// Ticks at a red light.
    pub red_light_steps: u32,
    /// Remaining ticks for which it ignores red lights.
    pub block_red_light: u32,
    /// Whether a stop sign holds it.
    pub in_stop_sign_effect: bool,
    /// Remaining distance for which no new stop sign takes effect (m).
    pub block_stop_sign_distance: f64,
    /// How often the last stop sign will take effect again.
    pub stop_sign_trigger_times: u32,
}

/// Why the car is slower than its wanted speed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Reason {
    /// It is not slower.
    #[default]
    None,
    /// A road user is, or will be, in the way further ahead.
    Slower,
    /// A road user is in the way now.
    Blocked,
    RedLight,
    StopSign,
}

/// The controller's decision at a tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Decision {
    /// Points of the path that was tested.
    pub path_points: usize,
    /// Room now, over the next 0.75 s and over the next 2 s, minus the gap (m).
    pub safe_distances: [f64; HORIZONS.len()],
    /// Room now, over the next 0.75 s and over the next 2 s, less the gap (m).
    pub room: [f64; 3],
    /// How far the path is free in all forecasts that count (m).
    pub safe_distance: f64,
    /// The wanted speed (m/s).
    pub desired_speed: f64,
    /// Steer, positive to the right as in CARLA, −1 to 1.
    pub steer: f64,
    /// Throttle, 0 to 1.
    pub throttle: f64,
    /// Whether it brakes; it only brakes fully.
    pub brake: bool,
    /// Why it is slower than its wanted speed.
    pub reason: Reason,
}

impl Decision {
    /// The pedals and the wheel after the agent's clean-up: no throttle while braking.
    pub fn control(&self) -> Control {
        Control {
            throttle: if self.brake { 0.0 } else { self.throttle },
            brake: f64::from(u8::from(self.brake)),
            steer: -self.steer,
        }
    }
}

/// Turns a forecast and ten points of the route into pedals and a wheel, twenty times a second.
///
/// # Source
/// InterFuser `team_code/interfuser_controller.py`. Closed forms replace the linear programme of the paper there;
/// the forecast for one second is drawn and not used.
#[derive(Debug, Clone)]
pub struct Controller {
    settings: Settings,
    turn: Pid,
    speed: Pid,
    corridor: Corridor,
    counters: Counters,
}

impl Controller {
    /// Makes one in its initial state.
    pub fn new(settings: &Settings) -> Self {
        Self {
            settings: *settings,
            turn: Pid::new(settings.turn_gains),
            speed: Pid::new(settings.speed_gains),
            corridor: Corridor::new(settings.margin, settings.overlap),
            counters: Counters::default(),
        }
    }

    /// Forgets everything.
    pub fn reset(&mut self) {
        self.turn = Pid::new(self.settings.turn_gains);
        self.speed = Pid::new(self.settings.speed_gains);
        self.counters = Counters::default();
    }

    /// Its memory.
    pub fn counters(&self) -> &Counters {
        &self.counters
    }

    /// Decides; call it once per tick, even if the decision is not carried out.
    pub fn step(&mut self, inputs: &Inputs, forecast: &Forecast) -> Decision {
        let speed = inputs.speed;
        let p_red = self.count(inputs);
        let steer = self.steer(inputs);
        let path_points = self.corridor.follow(&inputs.waypoints);
        let safe_distances = self.corridor.safe_distances(forecast);
        let [now, half, three_quarters, _, one_and_half, two] = safe_distances;
        let soon = now.min(half).min(three_quarters);
        let later = soon.min(one_and_half).min(two);
        let room = [now, soon, later].map(|distance| (distance - GAP).max(0.0));
        let (desired_speed, reason) = self.desired_speed(speed, room, inputs.p_not_junction, p_red);
        let lack = (desired_speed - speed).clamp(0.0, self.settings.speed_step);
        let mut throttle = self.speed.step(lack).clamp(0.0, self.settings.max_throttle);
        // A wanted speed of 0 brakes only a car that moves; the other reasons brake in any case.
        let stopped = matches!(reason, Reason::Blocked | Reason::RedLight);
        let mut decision = Decision {
            path_points,
            safe_distances,
            room,
            safe_distance: later,
            desired_speed,
            steer,
            throttle,
            brake: stopped || speed > desired_speed * self.settings.brake_ratio,
            reason,
        };
        let counters = &mut self.counters;
        if counters.stop_steps > MAX_STOP_STEPS {
            counters.forced_forward_steps = CREEP;
            counters.stop_steps = 0;
        }
        if counters.forced_forward_steps > 0 {
            counters.forced_forward_steps -= 1;
            throttle = CREEP_THROTTLE;
            decision = Decision { throttle, brake: false, reason: Reason::None, ..decision };
        }
        if counters.in_stop_sign_effect {
            decision = Decision { throttle: 0.0, brake: true, reason: Reason::StopSign, ..decision };
        }
        decision
    }

    /// Updates the counters; returns the probability of a red light, reduced after too long a wait.
    fn count(&mut self, inputs: &Inputs) -> f64 {
        let (counters, speed) = (&mut self.counters, inputs.speed);
        counters.stop_steps =
            if speed < 0.2 { counters.stop_steps + 1 } else { counters.stop_steps.saturating_sub(10) };
        if speed < 0.06 {
            counters.in_stop_sign_effect = false;
        }
        if inputs.p_not_junction < 0.3 {
            counters.stop_sign_trigger_times = 0;
        }
        let mut p_red = inputs.p_red;
        counters.red_light_steps = if p_red > 0.7 { counters.red_light_steps + 1 } else { 0 };
        if counters.red_light_steps > MAX_RED_LIGHT_STEPS {
            counters.block_red_light = RED_IGNORED;
            counters.red_light_steps = 0;
        }
        if counters.block_red_light > 0 {
            counters.block_red_light -= 1;
            p_red = 0.01;
        }
        if inputs.p_no_stop_sign < 0.6 && counters.block_stop_sign_distance < 0.1 {
            counters.in_stop_sign_effect = true;
            counters.block_stop_sign_distance = STOP_SIGN_WAY;
            counters.stop_sign_trigger_times = STOP_SIGN_TIMES;
        }
        counters.block_stop_sign_distance = (counters.block_stop_sign_distance - TICK * speed).max(0.0);
        if counters.block_stop_sign_distance < 0.1 && counters.stop_sign_trigger_times > 0 {
            counters.block_stop_sign_distance = STOP_SIGN_WAY;
            counters.stop_sign_trigger_times -= 1;
            counters.in_stop_sign_effect = true;
        }
        p_red
    }

    /// Steers for the midpoint of the first two waypoints.
    fn steer(&mut self, inputs: &Inputs) -> f64 {
        let aim = (inputs.waypoints[1] + inputs.waypoints[0]) / 2.0;
        let angle = (FRAC_PI_2 - libm::atan2(-aim.y, aim.x)).to_degrees() / 90.0;
        let angle = if inputs.speed < 0.01 { 0.0 } else { angle };
        self.turn.step(angle).clamp(-1.0, 1.0)
    }

    fn desired_speed(&self, speed: f64, room: [f64; 3], p_not_junction: f64, p_red: f64) -> (f64, Reason) {
        let [now, soon, later] = room;
        if now < speed.max(MIN_ROOM) {
            return (0.0, Reason::Blocked);
        }
        if p_not_junction > 0.0 && p_red > 0.3 {
            return (0.0, Reason::RedLight);
        }
        let fast = (speed - 2.5).max(0.0);
        let allowed = (4.0 * soon - speed - fast).min(2.0 * later - 0.5 * speed - fast);
        if allowed < self.settings.max_speed {
            return (allowed.max(0.0), Reason::Slower);
        }
        (self.settings.max_speed, Reason::None)
    }
}

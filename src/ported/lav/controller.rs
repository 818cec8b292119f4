use super::collision::{mean_step, plan_collides};
use super::command::Command;
use super::forecast::Forecast;
use super::frame::EgoPoint;
use super::pid::{Gains, Pid};
use super::version::{Traits, Version};

const SPEED_GAINS: Gains = Gains { proportional: 5.0, integral: 0.5, differential: 1.0 };
/// Points of a plan per second: converts their spacing into a speed.
const POINTS_PER_SECOND: f64 = 4.0;
/// A plan slower than this brakes (m/s).
const STOP_BELOW: f64 = 0.8;
/// Maximum error that the speed controller receives (m/s).
const MAX_ERROR: f64 = 0.25;
const MAX_THROTTLE: f64 = 0.8;
/// No throttle above this speed (m/s).
const THROTTLE_UP_TO: f64 = 35.0 / 3.6;
/// Below this speed (m/s) v2 counts its ticks at rest.
const AT_REST: f64 = 0.1;
/// It creeps after this number of ticks at rest,
const MAX_TICKS_AT_REST: u32 = 600;
/// for this number of ticks,
const CREEP_FOR: u32 = 20;
const CREEP_THROTTLE: f64 = 0.4;

/// The inputs of the controller in a tick.
#[derive(Debug, Clone, Copy)]
pub struct Situation<'a> {
    /// Speed of the ego (m/s).
    pub speed: f64,
    /// The command of the route.
    pub command: Command,
    /// Score of the brake classifier, 0 to 1.
    pub brake_score: f64,
    /// The ego's plan, points 0.25 s apart, the first one 0.25 s from now; at least as long as its version aims ahead.
    pub plan: &'a [EgoPoint],
    /// Forecasts of the detected vehicles.
    pub forecasts: &'a [Forecast],
}

/// Pedals and wheel in LAV's form.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Pedals {
    /// Accelerator, 0 to 1.
    pub throttle: f64,
    /// Brake, 0 or 1.
    pub brake: f64,
    /// Wheel, −1 to 1, positive to the right.
    pub steer: f64,
}

/// The rule that overrode the PID controllers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Overruled {
    /// The brake classifier.
    Classifier,
    /// The check of plan against forecasts.
    Collision,
}

/// The controller's decision, with the reason.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Verdict {
    /// Mean speed of the plan (m/s); NaN for a plan with NaN.
    pub desired_speed: f64,
    /// The output of the PID controllers.
    pub pid: Pedals,
    /// Whether plan and forecasts collide, whether or not the rules check it.
    pub collides: bool,
    /// The rule that overrode them.
    pub overruled: Option<Overruled>,
    /// Consecutive ticks at rest; v1 does not count.
    pub ticks_at_rest: u32,
    /// Remaining ticks of creeping.
    pub creeping: u32,
    /// The resulting pedals.
    pub pedals: Pedals,
}

/// LAV's controller: from a plan to pedals, with the overriding rules in LAV's order.
///
/// The desired speed is the plan's mean spacing; a plan that only slows down releases the throttle and never brakes.
///
/// # Source
/// `pid_control`, `PIDController` and `run_step` of LAV.
#[derive(Debug, Clone)]
pub struct Controller {
    traits: &'static Traits,
    turn: Pid,
    speed: Pid,
    ticks_at_rest: u32,
    creeping: u32,
}

impl Controller {
    /// The controller of a version, in its initial state.
    pub fn new(version: Version) -> Self {
        let traits = version.traits();
        Self { traits, turn: Pid::new(traits.turn), speed: Pid::new(SPEED_GAINS), ticks_at_rest: 0, creeping: 0 }
    }

    /// Decides for a tick.
    pub fn run(&mut self, situation: &Situation<'_>) -> Verdict {
        let speed = situation.speed;
        if self.traits.creeps {
            self.ticks_at_rest = if speed < AT_REST { self.ticks_at_rest.saturating_add(1) } else { 0 };
        }
        let desired_speed = POINTS_PER_SECOND * mean_step(situation.plan);
        let pid = self.follow(situation, desired_speed);
        let collides = plan_collides(self.traits, situation.plan, situation.forecasts);
        let overruled = if situation.brake_score > self.traits.brake_score {
            Some(Overruled::Classifier)
        } else {
            collides.then_some(Overruled::Collision)
        };
        let mut pedals = if overruled.is_some() { Pedals { throttle: 0.0, brake: 1.0, ..pid } } else { pid };
        if speed > THROTTLE_UP_TO {
            pedals.throttle = 0.0;
        }
        if self.ticks_at_rest >= MAX_TICKS_AT_REST {
            self.creeping = CREEP_FOR;
        }
        if self.creeping > 0 {
            self.creeping -= 1;
            pedals = Pedals { throttle: pedals.throttle.max(CREEP_THROTTLE), brake: 0.0, ..pedals };
        }
        Verdict {
            desired_speed,
            pid,
            collides,
            overruled,
            ticks_at_rest: self.ticks_at_rest,
            creeping: self.creeping,
            pedals,
        }
    }

    /// The PID controllers; a plan with NaN gives no output.
    fn follow(&mut self, situation: &Situation<'_>, desired_speed: f64) -> Pedals {
        let aim = situation.plan.get(self.traits.aim[situation.command.index()]).or(situation.plan.last());
        let Some(aim) = aim.filter(|_| !desired_speed.is_nan()) else { return Pedals::default() };
        let angle = (90.0 - libm::atan2(-aim.back, aim.right).to_degrees()) / 90.0;
        let steer = self.turn.run(angle).clamp(-1.0, 1.0);
        let wanted = self.traits.speed_ratio[situation.command.index()] * desired_speed;
        let throttle = self.speed.run((wanted - situation.speed).clamp(0.0, MAX_ERROR)).clamp(0.0, MAX_THROTTLE);
        if desired_speed < STOP_BELOW {
            return Pedals { throttle: 0.0, brake: 1.0, steer };
        }
        Pedals { throttle, brake: 0.0, steer }
    }
}

use super::crosswalks::CrosswalkKeys;
use super::guarded::{Guarded, LaneGuard};
use super::lane_follower::{Intent, LaneKeys};
use super::route_trace::{RouteTrace, distance_to_box};
use super::{Actor, DrivingMode, Perception};
use crate::sim::{Control, advance};
use base::{choice, keys};

choice! {
    /// What people may do from now on.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum Assumption {
        AnyMotion = "any_motion",
        SameVelocity = "same_velocity",
    }
}

keys! {
    /// Knows everybody at once and brakes with everything at the last tick that still avoids a moving collision: what braking
    /// alone can reach.
    pub struct OracleBrakeKeys = "oracle_brake" {
        ..lane: LaneKeys,
        /// Whether people may do anything from now on, or keep their velocity.
        assumes: Assumption = "any_motion",
        ..at_crosswalks: CrosswalkKeys,
    }
}

/// The limit of braking alone: it knows all road users, even through walls, and brakes fully at the last tick at which
/// that still avoids a collision with the moving car.
///
/// In every tick it checks whether it would touch a road user before it stands if it continued for one more tick and then braked
/// fully. If so it brakes now. It has two models of where road users can be:
///
/// - `any_motion`: every place that a pedestrian running at 3.5 m/s can reach from now on. No pedestrian can run into this car
///   while it moves, if it starts safely and stands still for pedestrians that stay near.
/// - `same_velocity`: the places they reach at their present velocity, and only if continuing without braking would touch them. It is
///   late by design: it hits a pedestrian that turns at the last moment.
///
/// # Source
/// Our own; the first model is the test for inevitable collision states (Fraichard and Asama, 2003) with braking as the only evasion.
#[derive(Debug, Clone)]
pub struct OracleBrake {
    any_motion: bool,
}

/// How fast people run in any direction (m/s): the default maximum of an adversary.
const RUNNING: f64 = 3.5;
/// How far ahead the oracle looks for a touch without braking (s).
const HORIZON: f64 = 6.0;
/// Slack for the car's offset from its lane's centre and the turn within a tick (m).
const SLACK: f64 = 0.15;

impl OracleBrake {
    pub fn new(keys: OracleBrakeKeys) -> Guarded<Self> {
        Guarded::new(Self { any_motion: keys.assumes == Assumption::AnyMotion }, keys.lane, keys.at_crosswalks)
    }

    /// Whether it may touch an actor before it stands, with this acceleration (m/s²) for some ticks and full braking after them.
    fn touches(
        &self,
        (trace, perception): (&RouteTrace, &Perception<'_>),
        actor: &Actor,
        acceleration: f64,
        ticks: u32,
    ) -> bool {
        let (ego, dt) = (&perception.ego, perception.dt);
        let size = actor.half.x.max(actor.half.y) + SLACK;
        let (place, velocity) = (actor.pose.position(), actor.velocity);
        let (mut speed, mut along, mut time) = (ego.speed(), 0.0, 0.0);
        for tick in 0.. {
            let braking = || perception.blueprint.acceleration(Control::FULL_BRAKE, speed);
            let gain = if tick < ticks { acceleration } else { braking() };
            let (way, after) = advance(speed, gain, dt);
            (along, speed, time) = (along + way, after, time + dt);
            let Some((middle, ahead)) = trace.at(along) else { return false };
            let (then, grown) =
                if self.any_motion { (place, size + RUNNING * time) } else { (place + velocity * time, size) };
            if distance_to_box(then, middle, &ahead, &ego.half) < grown {
                return true;
            }
            if speed <= 0.0 && (tick >= ticks || acceleration <= 0.0) || time > HORIZON {
                return false;
            }
        }
        false
    }

    fn must_brake(&self, trace: &RouteTrace, perception: &Perception<'_>, acceleration: f64) -> bool {
        let seen = (trace, perception);
        let actors = perception.pedestrians.iter().chain(perception.vehicles);
        actors.into_iter().any(|actor| {
            let would_meet = self.any_motion || self.touches(seen, actor, acceleration, u32::MAX);
            would_meet && self.touches(seen, actor, acceleration, 1)
        })
    }
}

impl LaneGuard for OracleBrake {
    fn drive(&mut self, intent: &Intent, trace: &RouteTrace, perception: &Perception<'_>) -> (Control, DrivingMode) {
        if self.must_brake(trace, perception, intent.acceleration) {
            return (Control { steer: intent.steer, ..Control::FULL_BRAKE }, DrivingMode::EmergencyStop);
        }
        (intent.control(intent.acceleration, perception), intent.mode)
    }
}

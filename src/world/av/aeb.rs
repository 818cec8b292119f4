use super::crosswalks::CrosswalkKeys;
use super::lane_follower::{LaneFollower, LaneKeys};
use super::route_trace::OnTrace;
use super::{DrivingMode, DrivingPolicy, Perception};
use crate::sim::Control;
use base::keys;
use base::seed::Stream;

keys! {
    /// A driver that sees no actors, with automatic emergency braking by time to collision. It trusts the positions that it is
    /// given: add sensors.
    pub struct AebKeys = "aeb" {
        ..lane: LaneKeys,
        /// Time to collision from which the throttle is let go (assumed).
        warning: f64 as non_negative(TIME) = "2 s",
        /// Time to collision from which it brakes partially (assumed).
        partial: f64 as non_negative(TIME) = "1.5 s",
        /// Time to collision from which it brakes fully (assumed).
        full: f64 as non_negative(TIME) = "1 s",
        /// Deceleration of the partial brake (assumed).
        partial_brake: f64 as positive(ACCELERATION) = "4 m/s^2",
        /// Deceleration of the full brake: 0.85 g, UN R157's model of an automatic brake.
        full_brake: f64 as positive(ACCELERATION) = "8.34 m/s^2",
        /// Time from none to full braking, from the same model.
        ramp: f64 as positive(TIME) = "0.6 s",
        /// How far beside the car an actor is still in its way (assumed).
        margin: f64 as non_negative(LENGTH) = "0.3 m",
        ..at_crosswalks: CrosswalkKeys,
    }
    .rising(&["full", "partial", "warning"])
}

/// A driver that ignores all road users, with automatic emergency braking for road users that will be in its way.
///
/// The time to collision is `gap / closing speed` with each actor that is in the corridor now or, at constant velocity, when the
/// car arrives. Below three thresholds the system warns (and releases the throttle), brakes partially, and brakes fully. The
/// deceleration follows its target along ramps of constant jerk.
///
/// # Source
/// Full braking 0.85 g after a ramp of 0.6 s: the automatic brake of UN R157's performance model. UN R152 requires full braking
/// of at least 5 m/s². Stages by time to collision, a partial brake and release below standstill are common practice;
/// their values here are assumptions, stated at each key.
#[derive(Debug, Clone)]
pub struct Aeb {
    keys: AebKeys,
    driver: LaneFollower,
    /// The present deceleration of the brakes (m/s²).
    braking: f64,
    mode: DrivingMode,
}

/// Below this speed (m/s) the brakes hold the car while a road user in its way is nearer than this (m) (assumed).
const HOLD: (f64, f64) = (0.5, 2.0);

impl Aeb {
    pub fn new(keys: AebKeys) -> Self {
        let driver = LaneFollower::new(keys.lane, keys.at_crosswalks);
        Self { keys, driver, braking: 0.0, mode: DrivingMode::Cruise }
    }

    /// The least time to collision (s) with any actor.
    fn time_to_collision(&self, perception: &Perception<'_>) -> f64 {
        let actors = perception.pedestrians.iter().chain(perception.vehicles);
        let found = actors.filter_map(|actor| self.driver.trace.locate(actor));
        found.map(|actor| time_to(&actor, perception, self.keys.margin)).fold(f64::INFINITY, f64::min)
    }
}

/// The time until the car meets an actor (s), both at constant velocity; infinite when they do not meet.
fn time_to(actor: &OnTrace, perception: &Perception<'_>, margin: f64) -> f64 {
    let ego = &perception.ego;
    let closing = ego.speed() - actor.velocity.x;
    let ahead = actor.place.x - ego.half.x - actor.reach.x;
    let corridor = ego.half.y + actor.reach.y + margin;
    if ego.speed() < HOLD.0 && actor.place.x > 0.0 && ahead < HOLD.1 && actor.place.y.abs() <= corridor {
        return 0.0;
    }
    // Braking no longer helps a road user beside the car's middle.
    if closing <= 0.0 || actor.place.x < 0.0 {
        return f64::INFINITY;
    }
    let time = ahead.max(0.0) / closing;
    let then = actor.place.y + actor.velocity.y * time;
    let in_way = actor.place.y.abs() <= corridor || then.abs() <= corridor;
    if in_way { time } else { f64::INFINITY }
}

impl DrivingPolicy for Aeb {
    fn speed_limit_for(&self, speed: f64) -> f64 {
        self.driver.speed_limit_for(speed)
    }

    fn reset(&mut self, perception: &Perception<'_>, stream: Stream) {
        self.driver.reset(perception, stream);
        self.braking = 0.0;
        self.mode = DrivingMode::Cruise;
    }

    fn drive(&mut self, perception: &Perception<'_>) -> Control {
        let intent = self.driver.intend(perception);
        let time = self.time_to_collision(perception);
        let target = match time {
            time if time < self.keys.full => self.keys.full_brake,
            time if time < self.keys.partial => self.keys.partial_brake,
            _ => 0.0,
        };
        let step = self.keys.full_brake / self.keys.ramp * perception.dt;
        self.braking = if target > self.braking { (self.braking + step).min(target) } else { target };
        self.mode = match target {
            target if target >= self.keys.full_brake => DrivingMode::EmergencyStop,
            target if target > 0.0 || time < self.keys.warning => DrivingMode::Yield,
            _ => intent.mode,
        };
        let allowed = if time < self.keys.warning { -self.braking } else { f64::INFINITY };
        intent.control(intent.acceleration.min(allowed), perception)
    }

    fn mode(&self) -> DrivingMode {
        self.mode
    }

    fn snapshot(&self) -> Option<Box<dyn DrivingPolicy>> {
        Some(Box::new(self.clone()))
    }
}

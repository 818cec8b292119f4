use super::route_trace::{OnTrace, RouteTrace};
use super::{DrivingMode, Path, Perception};
use crate::sim::Control;
use base::keys;

keys! {
    /// The brake of [`Aeb`](super::Aeb).
    #[derive(Copy)]
    pub struct BrakeKeys {
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
    }
}

/// The defaults of the keys.
impl Default for BrakeKeys {
    fn default() -> Self {
        Self { warning: 2.0, partial: 1.5, full: 1.0, partial_brake: 4.0, full_brake: 8.34, ramp: 0.6, margin: 0.3 }
    }
}

/// Automatic emergency braking by time to collision, without the driver that it watches.
///
/// The time to collision is `gap / closing speed` with each actor that is in the corridor now or, at constant velocity, when the
/// car arrives. Below three thresholds it warns (and releases the throttle), brakes partially, and brakes fully. The
/// deceleration follows its target along ramps of constant jerk.
///
/// # Source
/// Full braking 0.85 g after a ramp of 0.6 s: the automatic brake of UN R157's performance model. UN R152 requires full braking
/// of at least 5 m/s². Stages by time to collision, a partial brake and release below standstill are common practice;
/// their values here are assumptions, stated at each key.
#[derive(Debug, Clone)]
pub struct EmergencyBrake {
    keys: BrakeKeys,
    /// The present deceleration of the brakes (m/s²).
    braking: f64,
}

/// What the brake demands in a tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Demand {
    /// The greatest acceleration that it allows (m/s²).
    pub allowed: f64,
    /// Its manoeuvre.
    pub mode: DrivingMode,
}

/// Below this speed (m/s) the brakes hold the car while a road user in its way is nearer than this (m) (assumed).
const HOLD: (f64, f64) = (0.5, 2.0);

impl EmergencyBrake {
    pub fn new(keys: BrakeKeys) -> Self {
        Self { keys, braking: 0.0 }
    }

    /// Releases the brakes.
    pub fn release(&mut self) {
        self.braking = 0.0;
    }

    /// Watches the way ahead; `None` while it demands nothing.
    pub fn watch(&mut self, trace: &RouteTrace, perception: &Perception<'_>) -> Option<Demand> {
        let keys = &self.keys;
        let time = time_to_collision(trace, perception, keys.margin);
        let target = match time {
            time if time < keys.full => keys.full_brake,
            time if time < keys.partial => keys.partial_brake,
            _ => 0.0,
        };
        let step = keys.full_brake / keys.ramp * perception.dt;
        self.braking = if target > self.braking { (self.braking + step).min(target) } else { target };
        let mode = if target >= keys.full_brake { DrivingMode::EmergencyStop } else { DrivingMode::Yield };
        let warns = time < keys.warning;
        let allowed = if warns { -self.braking } else { f64::INFINITY };
        (warns || target > 0.0).then_some(Demand { allowed, mode })
    }
}

/// The least time to collision (s) with any actor.
fn time_to_collision(trace: &RouteTrace, perception: &Perception<'_>, margin: f64) -> f64 {
    let actors = perception.pedestrians.iter().chain(perception.vehicles);
    let found = actors.filter_map(|actor| trace.locate(actor));
    found.map(|actor| time_to(&actor, perception, margin)).fold(f64::INFINITY, f64::min)
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

/// An emergency brake in front of a driver: it watches the driver's way and overrides its pedals where it demands more.
#[derive(Debug, Clone)]
pub struct Guard {
    brake: EmergencyBrake,
    trace: RouteTrace,
}

impl Guard {
    pub fn new(keys: BrakeKeys) -> Self {
        Self { brake: EmergencyBrake::new(keys), trace: RouteTrace::default() }
    }

    /// Starts an episode.
    pub fn reset(&mut self) {
        self.brake.release();
    }

    /// The control of a driver on this path as the brake lets it through, and the brake's manoeuvre if it demands something. The wheel stays the driver's.
    pub fn guard(
        &mut self,
        control: Control,
        path: &Path,
        perception: &Perception<'_>,
    ) -> (Control, Option<DrivingMode>) {
        self.trace.follow(path, perception);
        let Some(demand) = self.brake.watch(&self.trace, perception) else { return (control, None) };
        let most = perception.pedals_or_hold(demand.allowed);
        let (throttle, brake) = (control.throttle.min(most.throttle), control.brake.max(most.brake));
        (Control { throttle, brake, ..control }, Some(demand.mode))
    }
}

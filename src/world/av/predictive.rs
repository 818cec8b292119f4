use super::crosswalks::CrosswalkKeys;
use super::guarded::{Guarded, LaneGuard};
use super::lane_follower::{Intent, LaneKeys};
use super::route_trace::{RouteTrace, distance_to_box};
use super::{Actor, DrivingMode, Perception};
use crate::sim::Control;
use base::keys;

keys! {
    /// Forecasts every actor at constant velocity and takes the greatest acceleration along its lane without a collision.
    pub struct PredictiveKeys = "predictive" {
        ..lane: LaneKeys,
        /// How far it looks into the future (assumed).
        horizon: f64 as within(TIME, 0.1, 10.0) = "4 s",
        /// Distance that it keeps to where it expects others (assumed).
        margin: f64 as non_negative(LENGTH) = "0.7 m",
        /// Deceleration when nothing milder is free (assumed).
        max_deceleration: f64 as positive(ACCELERATION) = "8 m/s^2",
        ..at_crosswalks: CrosswalkKeys,
    }
}

/// A planner that forecasts all road users at constant velocity and drives as fast as possible without meeting a forecast.
///
/// It chooses from a ladder of constant accelerations, from the one that the lane allows down to full braking. It takes the greatest
/// with which the car, moved along its lane, keeps `margin` to every forecast actor over `horizon`, or full braking when none does.
/// It plans anew in every tick.
///
/// # Source
/// The common baseline of motion planning (constant velocity is hard to beat for short forecasts: Schöller et al., *What the
/// constant velocity model can teach us about pedestrian motion prediction*, RA-L 2020); the ladder and margins are assumptions.
#[derive(Debug, Clone)]
pub struct Predictive {
    keys: PredictiveKeys,
}

/// Steps of a forecast (s).
const STEP: f64 = 0.1;
/// Accelerations to choose from (m/s²), the greatest first; after the last there is only the maximum deceleration.
const LADDER: [f64; 9] = [1.5, 0.75, 0.0, -0.75, -1.5, -2.5, -3.5, -4.5, -6.0];

impl Predictive {
    pub fn new(keys: PredictiveKeys) -> Guarded<Self> {
        let (lane, at_crosswalks) = (keys.lane, keys.at_crosswalks);
        Guarded::new(Self { keys }, lane, at_crosswalks)
    }

    /// Whether the car meets a forecast actor at this acceleration (m/s²), up to a speed (m/s).
    fn meets(&self, seen: (&RouteTrace, &Perception<'_>), acceleration: f64, top: f64) -> bool {
        let actors = seen.1.pedestrians.iter().chain(seen.1.vehicles);
        actors.into_iter().any(|actor| self.meets_one(seen, actor, acceleration, top))
    }

    fn meets_one(
        &self,
        (trace, perception): (&RouteTrace, &Perception<'_>),
        actor: &Actor,
        acceleration: f64,
        top: f64,
    ) -> bool {
        let ego = &perception.ego;
        let mut speed = ego.speed();
        let size = self.keys.margin + actor.half.x.max(actor.half.y);
        let reach = ego.half.norm() + size;
        // Too far away for both to meet within the horizon.
        let fastest = speed.max(top) + actor.speed();
        let far = reach + fastest * self.keys.horizon;
        if (actor.pose.position() - ego.pose.position()).norm_squared() > far * far {
            return false;
        }
        let (mut along, mut time) = (0.0, 0.0);
        while time < self.keys.horizon {
            // An actor that touches a standing car was not hit by the car.
            if speed <= 0.0 && acceleration <= 0.0 {
                return false;
            }
            let next = (speed + acceleration * STEP).clamp(0.0, top.max(speed));
            along += (speed + next) / 2.0 * STEP;
            speed = next;
            time += STEP;
            let Some((middle, ahead)) = trace.at(along) else { return false };
            let place = actor.pose.position() + actor.velocity * time;
            if (place - middle).norm_squared() < reach * reach
                && distance_to_box(place, middle, &ahead, &ego.half) < size
            {
                return true;
            }
        }
        false
    }
}

impl LaneGuard for Predictive {
    fn drive(&mut self, intent: &Intent, trace: &RouteTrace, perception: &Perception<'_>) -> (Control, DrivingMode) {
        let milder = LADDER.into_iter().filter(|acceleration| *acceleration < intent.acceleration);
        let mut plans = std::iter::once(intent.acceleration).chain(milder);
        let free = plans.find(|acceleration| !self.meets((trace, perception), *acceleration, intent.wanted));
        let chosen = free.unwrap_or(-self.keys.max_deceleration).max(-self.keys.max_deceleration);
        let mode = match chosen {
            chosen if chosen >= intent.acceleration => intent.mode,
            chosen if chosen > -4.0 => DrivingMode::Yield,
            _ => DrivingMode::EmergencyStop,
        };
        (intent.control(chosen, perception), mode)
    }
}

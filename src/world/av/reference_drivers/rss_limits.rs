use std::f64::consts::PI;

/// The assumptions of RSS about an actor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RssLimits {
    /// Response time (s).
    pub response: f64,
    /// Greatest acceleration (m/s²).
    pub acceleration: f64,
    /// Least deceleration that the actor must apply (m/s²).
    pub braking: f64,
    /// Greatest deceleration that is expected of it (m/s²).
    pub hardest: f64,
    /// Greatest speed (m/s).
    pub fastest: f64,
    /// Radius of the circle on which it may turn during the response time (m).
    pub turn_radius: f64,
}

impl RssLimits {
    /// A car of `ad-rss-lib` and CARLA.
    pub fn car() -> Self {
        Self { response: 1.0, acceleration: 3.5, braking: 4.0, hardest: 8.0, fastest: f64::INFINITY, turn_radius: 3.5 }
    }

    /// CARLA's pedestrian.
    pub fn pedestrian() -> Self {
        Self { response: 0.5, acceleration: 2.0, braking: 2.0, hardest: 4.0, fastest: 10.0, turn_radius: 2.0 }
    }

    /// The car of JRC's comparison of models.
    pub fn jrc() -> Self {
        Self { response: 0.75, acceleration: 3.0, braking: 6.0, hardest: 6.0, ..Self::car() }
    }

    /// A car that responds fast and does not accelerate: the least demanding assumptions of the rule.
    pub fn bare() -> Self {
        Self { response: 0.5, acceleration: 0.0, braking: 8.0, hardest: 8.0, ..Self::car() }
    }

    /// The distance (m) from a speed (m/s) if it accelerates during its response and then brakes as weakly as allowed.
    pub fn braking_reach(&self, speed: f64) -> f64 {
        let after = speed + self.response * self.acceleration;
        (speed + after) / 2.0 * self.response + after * after / (2.0 * self.braking)
    }

    /// The distance (m) in the time of that stop if it accelerates all the time.
    pub fn forward_reach(&self, speed: f64) -> f64 {
        let time = self.response + (speed + self.response * self.acceleration) / self.braking;
        let rising = ((self.fastest - speed).max(0.0) / self.acceleration).min(time);
        speed * rising
            + self.acceleration * rising * rising / 2.0
            + (time - rising) * (speed + self.acceleration * rising)
    }

    /// The greatest turn during its response (rad); any direction when it stands.
    pub(super) fn turn(&self, speed: f64) -> f64 {
        if speed <= STANDING {
            return PI;
        }
        let way = speed * self.response + self.acceleration * self.response * self.response / 2.0;
        (way / self.turn_radius).min(PI)
    }
}

/// A slower actor counts as standing (m/s).
const STANDING: f64 = 0.1;

/// The safe distance (m) of a car behind another in the same direction.
///
/// `d = max(0, v ρ + a ρ²/2 + (v + ρ a)²/(2 b_min) − u²/(2 b_max))`
pub fn longitudinal_distance(behind: f64, ahead: f64, limits: &RssLimits) -> f64 {
    (limits.braking_reach(behind) - ahead * ahead / (2.0 * limits.hardest)).max(0.0)
}

/// The safe lateral distance (m) of two actors that move at speeds towards the second one's side (m/s).
///
/// `d = max(0, μ + (2 v₁ + ρ a) ρ/2 + [v₁ + ρ a]₊²/(2 b) − (2 v₂ − ρ a) ρ/2 + [ρ a − v₂]₊²/(2 b))`, with `a`, `b` the lateral
/// acceleration and braking of both (m/s²), `μ` the margin (m), `ρ` the response (s). An actor that moves away after its response is
/// credited with nothing beyond it, as in ad-rss-lib.
pub fn lateral_distance(first: f64, second: f64, response: f64, acceleration: f64, braking: f64, margin: f64) -> f64 {
    let push = response * acceleration;
    let way = |before: f64, after: f64| (before + after) / 2.0 * response;
    let stop = |towards: f64| towards.max(0.0) * towards.max(0.0) / (2.0 * braking);
    let (a, b) = (first + push, second - push);
    (margin + way(first, a) + stop(a) - way(second, b) + stop(-b)).max(0.0)
}

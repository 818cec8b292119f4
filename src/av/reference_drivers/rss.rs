use std::f64::consts::PI;

use super::{OwnMotion, ReferenceDriver, Threat};

/// What RSS assumes of an actor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RssLimits {
    /// Response time (s).
    pub response: f64,
    /// Greatest acceleration (m/s²).
    pub acceleration: f64,
    /// Least deceleration that it owes (m/s²).
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

    /// How far it gets (m) from a speed (m/s) if it accelerates during its response and then brakes as weakly as allowed.
    pub fn braking_reach(&self, speed: f64) -> f64 {
        let after = speed + self.response * self.acceleration;
        (speed + after) / 2.0 * self.response + after * after / (2.0 * self.braking)
    }

    /// How far it gets (m) in the time of that stop if it accelerates all the while.
    pub fn forward_reach(&self, speed: f64) -> f64 {
        let time = self.response + (speed + self.response * self.acceleration) / self.braking;
        let rising = ((self.fastest - speed).max(0.0) / self.acceleration).min(time);
        speed * rising
            + self.acceleration * rising * rising / 2.0
            + (time - rising) * (speed + self.acceleration * rising)
    }

    /// By how much it may turn during its response (rad); anywhere when it stands.
    fn turn(&self, speed: f64) -> f64 {
        if speed <= STANDING {
            return PI;
        }
        let way = speed * self.response + self.acceleration * self.response * self.response / 2.0;
        (way / self.turn_radius).min(PI)
    }
}

/// Who is slower stands (m/s).
const STANDING: f64 = 0.1;

/// The safe distance (m) of a car behind another in the same direction.
///
/// `d = max(0, v ρ + a ρ²/2 + (v + ρ a)²/(2 b_min) − u²/(2 b_max))`
pub fn longitudinal_distance(behind: f64, ahead: f64, limits: &RssLimits) -> f64 {
    (limits.braking_reach(behind) - ahead * ahead / (2.0 * limits.hardest)).max(0.0)
}

/// The safe distance (m) aside, of two that move at speeds towards the second one's side (m/s).
///
/// `d = μ + max(0, (2 v₁ + ρ a) ρ/2 + (v₁ + ρ a)²/(2 b) − (2 v₂ − ρ a) ρ/2 + (v₂ − ρ a)²/(2 b))`, with `a`, `b` the lateral
/// acceleration and braking of both (m/s²), `μ` the margin (m), `ρ` the response (s).
pub fn lateral_distance(first: f64, second: f64, response: f64, acceleration: f64, braking: f64, margin: f64) -> f64 {
    let push = response * acceleration;
    let way = |before: f64, after: f64| (before + after) / 2.0 * response;
    let (a, b) = (first + push, second - push);
    let (stop_a, stop_b) = (a * a.abs() / (2.0 * braking), b * b.abs() / (2.0 * braking));
    margin + (way(first, a) + stop_a - way(second, b) - stop_b).max(0.0)
}

/// Responsibility-Sensitive Safety towards a pedestrian: the rule for unstructured scenes.
///
/// Each actor has a set `T_b` of places that it may reach when it brakes after its response time, and `T_f` when it goes on.
/// It is safe when car and pedestrian could both still stop apart: `T_b` misses `T_b`. Otherwise the car brakes, unless at
/// the last safe instant the pedestrian alone could still have given way (its `T_b` missed the car's `T_f`, while the car's
/// `T_b` met its `T_f`): then it is the pedestrian's turn, and the car goes on. A danger from the beginning is braked for.
///
/// That a pedestrian who walks up to the lane was to stop is the rule's opinion, not ours: such a driver hits people.
///
/// Simplified: the car keeps to its path, so its sets are stretches of the swept path, and driving away is left out; a
/// pedestrian's set is a fan of straight ways about its direction, as wide as the permitted turn, instead of arcs; each `T_f` lasts
/// as long as its actor's slowest stop; beyond the far side the swept path has no end.
///
/// # Source
/// `intel/ad-rss-lib`, unstructured scenes, with CARLA's parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct Rss {
    /// What is assumed of the car.
    pub car: RssLimits,
    /// What is assumed of the pedestrian.
    pub pedestrian: RssLimits,
    others_turn: bool,
    braked: bool,
}

impl Default for Rss {
    fn default() -> Self {
        Self::new(RssLimits::car(), RssLimits::pedestrian())
    }
}

/// Half of the ways of a fan beside the middle one.
const RAYS: i32 = 8;

impl Rss {
    /// Makes one with assumptions of its own.
    pub fn new(car: RssLimits, pedestrian: RssLimits) -> Self {
        Self { car, pedestrian, others_turn: false, braked: false }
    }

    /// Whether both could still stop apart.
    pub fn is_safe(&self, own: &OwnMotion, threat: &Threat) -> bool {
        let reach = self.pedestrian.braking_reach(pace(threat));
        !self.meet(own, threat, self.car.braking_reach(own.speed), reach)
    }

    /// Whether the pedestrian could stop clear of a car that goes on, and only it.
    fn is_others_turn(&self, own: &OwnMotion, threat: &Threat) -> bool {
        let (car, pedestrian) = (&self.car, &self.pedestrian);
        let pace = pace(threat);
        !self.meet(own, threat, car.forward_reach(own.speed), pedestrian.braking_reach(pace))
            && self.meet(own, threat, car.braking_reach(own.speed), pedestrian.forward_reach(pace))
    }

    /// Whether the fan of the pedestrian meets the stretch of the path from the car's rear to so far ahead of its bumper.
    fn meet(&self, own: &OwnMotion, threat: &Threat, ahead: f64, reach: f64) -> bool {
        let behind = -own.length - threat.length;
        let within = |gap: f64| (behind..=ahead).contains(&gap);
        if threat.aside <= 0.0 && within(threat.gap) {
            return true;
        }
        if threat.aside > reach || threat.gap - reach > ahead || threat.gap + reach < behind {
            return false;
        }
        let pace = pace(threat);
        let middle = if pace > 0.0 { libm::atan2(-threat.towards, threat.along) } else { 0.0 };
        let turn = self.pedestrian.turn(pace);
        (-RAYS..=RAYS).any(|ray| {
            let (sin, cos) = libm::sincos(middle + turn * f64::from(ray) / f64::from(RAYS));
            let (along, inward) = (cos * reach, -sin * reach);
            // The part of the way that lies in the path, as shares of the way.
            let enters = if threat.aside <= 0.0 { 0.0 } else { threat.aside / inward };
            if !(0.0..=1.0).contains(&enters) {
                return false;
            }
            let (first, last) = (threat.gap + along * enters, threat.gap + along);
            first.min(last) <= ahead && first.max(last) >= behind
        })
    }
}

fn pace(threat: &Threat) -> f64 {
    (threat.along * threat.along + threat.towards * threat.towards).sqrt()
}

impl ReferenceDriver for Rss {
    fn begin(&mut self) {
        (self.others_turn, self.braked) = (false, false);
    }

    fn brake(&mut self, own: &OwnMotion, threat: Option<&Threat>, _: f64) -> Option<f64> {
        let kept = self.braked.then_some(0.0);
        let Some(threat) = threat else { return kept };
        if self.is_safe(own, threat) {
            self.others_turn = self.is_others_turn(own, threat);
            return kept;
        }
        if self.others_turn {
            return kept;
        }
        self.braked = true;
        Some(self.car.braking)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_to_a_standing_pedestrian_are_those_of_the_table() {
        let bare = RssLimits { response: 0.5, acceleration: 0.0, braking: 8.0, hardest: 8.0, ..RssLimits::car() };
        let rows = [
            (RssLimits::car(), [15.78, 21.35, 27.57, 53.44]),
            (RssLimits::jrc(), [8.97, 12.48, 16.42, 32.97]),
            (bare, [4.06, 6.12, 8.50, 19.0]),
        ];
        for (limits, wanted) in rows {
            for (kmh, wanted) in [18.0, 24.0, 30.0, 50.0].into_iter().zip(wanted) {
                let found = longitudinal_distance(kmh / 3.6, 0.0, &limits);
                assert!((found - wanted).abs() < 0.02, "{kmh} km/h: {found}, not {wanted}");
            }
        }
        assert_eq!(longitudinal_distance(1.0, 20.0, &RssLimits::car()), 0.0);
    }

    #[test]
    fn a_pedestrian_gets_as_far_as_the_table_says() {
        for (speed, wanted) in [(0.0, 0.50), (1.39, 2.37), (2.22, 3.95), (3.5, 7.06)] {
            let found = RssLimits::pedestrian().braking_reach(speed);
            assert!((found - wanted).abs() < 0.006, "{speed} m/s: {found}");
        }
    }

    #[test]
    fn two_side_by_side_need_the_margin_and_both_pushes() {
        // ρ = 1 s, a = 0.2, b = 0.8: each drifts 0.1 m and stops in 0.025 m.
        assert!((lateral_distance(0.0, 0.0, 1.0, 0.2, 0.8, 0.1) - 0.35).abs() < 1e-12);
        assert_eq!(lateral_distance(-3.0, 3.0, 1.0, 0.2, 0.8, 0.1), 0.1, "they part");
    }

    #[test]
    fn it_brakes_for_whoever_stands_in_the_way_from_the_beginning() {
        let own = OwnMotion { speed: 5.0, acceleration: 0.0, length: 4.5 };
        let standing = |gap| Threat { gap, length: 0.4, aside: 0.0, along: 0.0, towards: 0.0 };
        let mut rss = Rss::default();
        // 15.78 m of the car and 0.5 m of the pedestrian, who may start towards it.
        assert_eq!(rss.brake(&own, Some(&standing(16.3)), 0.05), None);
        assert_eq!(rss.brake(&own, Some(&standing(16.2)), 0.05), Some(4.0));
        assert_eq!(rss.brake(&own, Some(&standing(16.3)), 0.05), Some(0.0), "safe again, it keeps its speed");
    }

    #[test]
    fn it_goes_on_when_the_pedestrian_was_to_stop() {
        let own = OwnMotion { speed: 8.0, acceleration: 0.0, length: 4.5 };
        let walking = |aside, towards| Threat { gap: 8.0, length: 0.4, aside, along: 0.0, towards };
        let mut rss = Rss::default();
        assert_eq!(rss.brake(&own, Some(&walking(3.0, 1.39)), 0.05), None, "it can stop within 2.37 m");
        assert_eq!(rss.brake(&own, Some(&walking(2.0, 1.39)), 0.05), None);
        rss.begin();
        assert_eq!(rss.brake(&own, Some(&walking(2.0, 1.39)), 0.05), Some(4.0), "a danger from the beginning");
    }
}

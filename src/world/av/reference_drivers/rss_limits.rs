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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_to_a_standing_pedestrian_are_those_of_the_table() {
        let rows = [
            (RssLimits::car(), [15.78, 21.35, 27.57, 53.44]),
            (RssLimits::jrc(), [8.97, 12.48, 16.42, 32.97]),
            (RssLimits::bare(), [4.06, 6.12, 8.50, 19.0]),
        ];
        for (limits, wanted) in rows {
            for (kmh, wanted) in [18.0, 24.0, 30.0, 50.0].into_iter().zip(wanted) {
                let found = longitudinal_distance(kmh / 3.6, 0.0, &limits);
                assert!((found - wanted).abs() < 0.02, "{kmh} km/h: {found}, not {wanted}");
            }
        }
        for behind in [1.0, 5.0] {
            assert_eq!(
                longitudinal_distance(behind, 30.0, &RssLimits::car()),
                0.0,
                "somebody fast in front may be near"
            );
        }
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
        assert_eq!(lateral_distance(-3.0, 3.0, 1.0, 0.2, 0.8, 0.1), 0.0, "they part");
    }

    /// The recorded values of Intel's library; `tests/reference/ad_rss` computes them again where it is installed.
    #[test]
    fn distances_are_those_of_ad_rss() {
        let text = include_str!("../../../../tests/reference/ad_rss/distances.csv");
        let mut compared = 0;
        for line in text.lines().filter(|line| !line.starts_with('#')).skip(1) {
            let fields: Vec<&str> = line.split(',').collect();
            let number = |field: usize| fields[field].parse::<f64>().unwrap();
            let (first, second, wanted) = (number(2), number(3), number(4));
            let found = match (fields[0], fields[1]) {
                ("longitudinal", "car") => longitudinal_distance(first, second, &RssLimits::car()),
                ("longitudinal", "jrc") => longitudinal_distance(first, second, &RssLimits::jrc()),
                ("longitudinal", "bare") => longitudinal_distance(first, second, &RssLimits::bare()),
                ("longitudinal", "pedestrian") => longitudinal_distance(first, second, &RssLimits::pedestrian()),
                ("lateral", "car") => lateral_distance(first, second, 1.0, 0.2, 0.8, 0.1),
                other => panic!("{other:?}"),
            };
            assert!((found - wanted).abs() < 1e-5, "{line}: {found}");
            compared += 1;
        }
        assert_eq!(compared, 240);
    }
}

//! The distances of Responsibility-Sensitive Safety that a guard along a lane needs.
//!
//! | symbol | field | unit |
//! |---|---|---|
//! | ρ | `response` | s |
//! | a_max | `accelerates` | m/s² |
//! | b_min, b_max | `brakes_least`, `brakes_most` | m/s² |
//!
//! # Source
//! Shalev-Shwartz, Shammah, Shashua, arXiv 1708.06374; figures as in intel/ad-rss-lib, CARLA's RssCheck and ec-jrc/JRC-FSM.

/// What is assumed of an actor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RssFigures {
    /// Response time (s).
    pub response: f64,
    /// Greatest acceleration during the response (m/s²).
    pub accelerates: f64,
    /// Deceleration that it brakes with at least, afterwards (m/s²).
    pub brakes_least: f64,
    /// Deceleration that it brakes with at most (m/s²).
    pub brakes_most: f64,
}

/// ad-rss-lib's and CARLA's vehicle.
pub const AD_RSS: RssFigures = RssFigures { response: 1.0, accelerates: 3.5, brakes_least: 4.0, brakes_most: 8.0 };
/// The vehicle of the Joint Research Centre's comparison.
pub const JRC: RssFigures = RssFigures { response: 0.75, accelerates: 3.0, brakes_least: 6.0, brakes_most: 6.0 };
/// A vehicle that answers fast and does not accelerate: the least that the rule can ask.
pub const BARE: RssFigures = RssFigures { response: 0.5, accelerates: 0.0, brakes_least: 8.0, brakes_most: 8.0 };
/// CARLA's pedestrian.
pub const PEDESTRIAN: RssFigures = RssFigures { response: 0.5, accelerates: 2.0, brakes_least: 2.0, brakes_most: 4.0 };
/// Greatest speed of CARLA's pedestrian (m/s), and the least radius that it turns with while it moves (m).
pub const PEDESTRIAN_TOP_SPEED: f64 = 10.0;
/// See [`PEDESTRIAN_TOP_SPEED`].
pub const PEDESTRIAN_TURN: f64 = 2.0;
/// Lateral fluctuation margin μ (m) of ad-rss-lib.
pub const MARGIN: f64 = 0.1;

impl RssFigures {
    /// The farthest it gets before it stands, when it responds as late and brakes as weakly as allowed (m).
    pub fn farthest(&self, speed: f64) -> f64 {
        let (rho, a) = (self.response, self.accelerates);
        let after = speed + rho * a;
        speed * rho + a * rho * rho / 2.0 + after * after / (2.0 * self.brakes_least)
    }

    /// The safe distance to somebody in front who may brake with `brakes_most` (m); speeds in m/s.
    pub fn safe_distance(&self, rear: f64, front: f64, front_brakes: f64) -> f64 {
        (self.farthest(rear) - front * front / (2.0 * front_brakes)).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn safe_distances_to_somebody_standing() {
        let table = [
            (AD_RSS, [15.78, 21.35, 27.57, 53.44]),
            (JRC, [8.97, 12.48, 16.42, 32.97]),
            (BARE, [4.06, 6.12, 8.50, 19.0]),
        ];
        for (figures, wanted) in table {
            for (speed, wanted) in [5.0, 6.67, 8.33, 13.89].into_iter().zip(wanted) {
                let got = figures.safe_distance(speed, 0.0, 8.0);
                assert!((got - wanted).abs() < 0.03, "{figures:?} at {speed}: {got}, not {wanted}");
            }
        }
        assert_eq!(AD_RSS.safe_distance(5.0, 30.0, 8.0), 0.0, "somebody fast in front may be near");
    }

    #[test]
    fn how_far_a_pedestrian_gets() {
        for (speed, wanted) in [(0.0, 0.50), (1.39, 2.37), (2.22, 3.95), (3.5, 7.06)] {
            let got = PEDESTRIAN.farthest(speed);
            assert!((got - wanted).abs() < 0.015, "{speed}: {got}, not {wanted}");
        }
    }
}

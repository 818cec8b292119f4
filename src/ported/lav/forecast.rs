use super::command::Command;
use super::detection::Detection;
use super::frame::EgoPoint;
use super::version::{MAX_HORIZON, Traits};

/// Time between points of plans and forecasts (s).
pub(super) const STEP: f64 = 0.25;
/// Below this half width (m) a vehicle may be a person, and forecasts of turns are possible.
const NARROW: f64 = 0.5;
/// Radius of a turn (m).
const TURN_RADIUS: f64 = 8.0;

/// LAV's forecast of a vehicle, one path for each command.
#[derive(Debug, Clone, PartialEq)]
pub struct Forecast {
    /// Points 0.25 s apart, the first one 0.25 s from now; v1 looks at ten of them.
    pub modes: [[EgoPoint; MAX_HORIZON]; 6],
    /// The probability of each, 0 to 1; they need not sum to one.
    pub scores: [f64; 6],
}

impl Forecast {
    /// The surrogate's forecast of a detection that drives at a speed (m/s). LAV moves every vehicle like an ego vehicle, so
    /// each drives where it points.
    ///
    /// A vehicle keeps its heading, at a score of 0.9. A narrow detection is less certain: 0.6 for keeping its heading, 0.2
    /// for a turn of 8 m to either side. All of these are assumptions.
    pub(super) fn of(detection: &Detection, speed: f64, traits: &Traits) -> Self {
        let narrow = detection.blob.half_width < NARROW * super::frame::PIXELS_PER_METRE;
        let mut modes = [[EgoPoint::default(); MAX_HORIZON]; 6];
        for command in Command::ALL {
            let side = match command {
                Command::Left => -1.0,
                Command::Right => 1.0,
                _ => 0.0,
            };
            for (k, point) in modes[command.index()].iter_mut().take(traits.horizon).enumerate() {
                let way = speed * STEP * (k + 1) as f64;
                *point = along_turn(way, side).out_of_object(detection.place, detection.blob.yaw);
            }
        }
        let mut scores = [0.0; 6];
        scores[Command::LaneFollow.index()] = if narrow { 0.6 } else { 0.9 };
        if narrow {
            scores[Command::Left.index()] = 0.2;
            scores[Command::Right.index()] = 0.2;
        }
        Self { modes, scores }
    }
}

/// The end of a way (m) that is straight or turns to a side: −1 left, 1 right. After a quarter turn it is straight again.
fn along_turn(way: f64, side: f64) -> EgoPoint {
    if side == 0.0 {
        return EgoPoint::new(0.0, -way);
    }
    let angle = (way / TURN_RADIUS).min(std::f64::consts::FRAC_PI_2);
    let beyond = way - angle * TURN_RADIUS;
    let (sin, cos) = libm::sincos(angle);
    EgoPoint::new(side * (TURN_RADIUS * (1.0 - cos) + beyond * sin), -(TURN_RADIUS * sin + beyond * cos))
}

#[cfg(test)]
mod tests {
    use super::super::detection::{Blob, BlobKind, Detector};
    use super::super::version::Version;
    use super::*;

    fn forecast(half_width: f64, yaw: f64) -> Forecast {
        let blob = Blob::of_body(BlobKind::Vehicle, EgoPoint::new(3.0, -9.0), yaw, 2.0, half_width, 0.9);
        let mut detector = Detector::new(Version::V2);
        Forecast::of(&detector.detect(&[blob])[0], 4.0, Version::V2.traits())
    }

    #[test]
    fn a_vehicle_drives_where_it_points() {
        let left = forecast(1.0, -std::f64::consts::FRAC_PI_2);
        assert!(left.modes[3][0].distance(EgoPoint::new(2.0, -9.0)) < 1e-12);
        assert!(left.modes[3][19].distance(EgoPoint::new(-17.0, -9.0)) < 1e-12);
        assert_eq!(left.scores, [0.0, 0.0, 0.0, 0.9, 0.0, 0.0]);
    }

    #[test]
    fn narrow_actors_may_turn() {
        let person = forecast(0.3, 0.0);
        assert_eq!(person.scores, [0.2, 0.2, 0.0, 0.6, 0.0, 0.0]);
        // 20 m of way: a quarter turn of 8 m and the rest straight to the left.
        let straight = 20.0 - 8.0 * std::f64::consts::FRAC_PI_2;
        assert!(person.modes[0][19].distance(EgoPoint::new(3.0 - 8.0 - straight, -9.0 - 8.0)) < 1e-12);
        assert!(person.modes[1][19].right > 11.0);
    }
}

use super::forecast::STEP;
use super::frame::EgoPoint;
use road::geometry::Pose;
use world::av::Path;

/// The expert's maximum speed (m/s), and by how much it stays below the limit along lanes and in turns.
const MAX_SPEED: f64 = 40.0 / 3.6;
const BELOW_LIMIT: f64 = 6.0 / 3.6;
const BELOW_LIMIT_IN_TURNS: f64 = 5.0 / 3.6;
/// If the limit is too low for that difference, the share of the limit.
const MIN_SHARE: f64 = 0.5;
/// Distance between the points of a plan that stands (m), so that the wheel still has a target.
const MIN_SPACING: f64 = 0.01;

/// The speed of a plan along the route.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Tempo {
    /// At this speed (m/s).
    Cruise(f64),
    /// From a speed (m/s) to rest at a deceleration (m/s²).
    Brake(f64, f64),
}

impl Tempo {
    /// The expert's speed under a limit (m/s).
    pub fn of_expert(limit: f64, in_turn: bool) -> Self {
        let below = if in_turn { BELOW_LIMIT_IN_TURNS } else { BELOW_LIMIT };
        Self::Cruise((limit - below).max(MIN_SHARE * limit).min(MAX_SPEED))
    }

    /// The distance (m) after a time (s).
    fn way(self, time: f64) -> f64 {
        match self {
            Self::Cruise(speed) => speed * time,
            Self::Brake(speed, braking) => {
                let time = time.min(speed / braking);
                time * (speed - 0.5 * braking * time)
            }
        }
    }
}

/// Writes the surrogate's plan: points of the route's centre line, 0.25 s apart, starting abeam the ego.
///
/// At the end of the road the plan stands.
pub(super) fn write_plan(path: &Path, ego: &Pose, tempo: Tempo, plan: &mut [EgoPoint]) {
    let mut points = path.points().map(|point| &point.pose);
    let Some(mut from) = points.next() else { return plan.fill(EgoPoint::default()) };
    let mut to = points.next();
    // The path's first point is the nearest to the ego, not the one abeam it.
    let abeam = from.to_local(ego.position()).x;
    let (mut behind, mut before) = (0.0, 0.0);
    for (k, point) in plan.iter_mut().enumerate() {
        let count = (k + 1) as f64;
        before = tempo.way(STEP * count).max(before + MIN_SPACING);
        let place = loop {
            let along = abeam + before - behind;
            let Some(next) = to else { break from.position() };
            let chord = next.position() - from.position();
            let length = chord.norm();
            if along <= length {
                break from.position() + chord * (along / length);
            }
            behind += length;
            (from, to) = (next, points.next());
        };
        *point = EgoPoint::seen_from(ego, place);
    }
}

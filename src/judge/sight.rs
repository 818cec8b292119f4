use crate::env::{Moment, Recording, Scenario};
use crate::geometry::{Obstacles, Vector};

/// From the bumper back to the driver's eye (m).
const EYE: f64 = 1.9;

/// Whether the pedestrian could be seen from the driver's eye in the last [`Sight::WINDOW`] before the touch, whatever the driver's
/// sensors are. Only obstacles hide it, not the car itself.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sight {
    /// Share of that time, or of as much of it as the episode lasted, in which it was hidden.
    pub hidden: f64,
    /// For how long before the touch it had been in sight without a break (s), at most [`Sight::WINDOW`]; where the episode is
    /// shorter, its beginning counts as if it had been in sight before.
    pub seen: f64,
}

impl Sight {
    /// How far back it looks (s).
    pub const WINDOW: f64 = 3.0;
    /// A pedestrian that was in sight for less (s) was occluded: a careful human needs as long until the car brakes.
    pub const LATE: f64 = 1.15;

    /// Looks back over the end of an episode that ended in a touch.
    pub(super) fn new(scenario: &Scenario, recording: &Recording) -> Self {
        let dt = scenario.episode.tick;
        let before = recording.moments().split_last().map_or([].as_slice(), |(_, before)| before);
        let ticks = ((Self::WINDOW / dt).round() as usize).min(before.len());
        let (half, radius) = (scenario.vehicle.half_length, scenario.adversary.body.radius);
        let (mut hidden, mut last) = (0, None);
        for (back, moment) in before.iter().rev().take(ticks).enumerate() {
            if !is_in_sight(moment, half, radius, &scenario.obstacles) {
                hidden += 1;
                last.get_or_insert(back);
            }
        }
        Self {
            hidden: f64::from(hidden) / ticks.max(1) as f64,
            seen: last.map_or(Self::WINDOW, |back| back as f64 * dt),
        }
    }

    /// Whether it was hidden until shortly before the touch.
    pub fn is_occluded(&self) -> bool {
        self.seen < Self::LATE
    }
}

/// Whether the middle or an edge of the pedestrian, of such a radius (m), is in sight from the driver's eye in a car of such a half
/// length (m).
pub(super) fn is_in_sight(moment: &Moment, half_length: f64, radius: f64, obstacles: &Obstacles) -> bool {
    let pedestrian = moment.pedestrian.pose.position();
    let eye = moment.ego.pose.to_world(Vector::new(half_length - EYE, 0.0));
    let sight = (pedestrian - eye).try_normalize(1e-9).unwrap_or_else(Vector::x);
    let edge = Vector::new(-sight.y, sight.x) * radius;
    [Vector::zeros(), edge, -edge].iter().any(|offset| !obstacles.blocks_sight(eye, pedestrian + offset))
}

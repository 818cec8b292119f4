use episode::Pair;

/// Whether the pedestrian could be seen from the driver's eye in the last [`Sight::WINDOW`] before the touch. The driver's sensors do
/// not matter; only obstacles hide it, not the car itself.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Sight {
    /// Time before the touch in which it was in sight without a break (s), at most [`Sight::WINDOW`]. In a shorter episode the pedestrian
    /// counts as in sight before its start.
    pub seen: f64,
}

impl Sight {
    /// The length of the time that is considered (s).
    pub const WINDOW: f64 = 3.0;
    /// A pedestrian that was in sight for less (s) was occluded: a careful human needs this time until the car brakes.
    pub const LATE: f64 = 1.15;

    /// Measures the end of an episode that ended in a touch.
    pub(super) fn new(pair: &Pair<'_>) -> Self {
        let dt = pair.dt();
        let before = pair.len().saturating_sub(1);
        let ticks = ((Self::WINDOW / dt).round() as usize).min(before);
        let last = pair.frames().take(before).rev().take(ticks).position(|frame| !pair.in_sight(&frame));
        Self { seen: last.map_or(Self::WINDOW, |back| back as f64 * dt) }
    }

    /// Whether it was hidden until shortly before the touch.
    pub fn is_occluded(&self) -> bool {
        self.seen < Self::LATE
    }
}

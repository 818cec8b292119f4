/// The first touch of pedestrian and ego.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contact {
    /// When, as a share of the tick from 0 to 1.
    pub fraction: f64,
    /// Bearing of the pedestrian from the middle of the ego's box (rad), positive to the left.
    pub bearing: f64,
    /// How far the pedestrian is ahead of the middle of the ego's box (m).
    pub ahead: f64,
    /// How far the pedestrian is to the left of the ego's axis (m).
    pub aside: f64,
    /// Speed of the ego then (m/s).
    pub impact_speed: f64,
}

impl Contact {
    /// Whether the pedestrian was within the front sector of this half angle (rad).
    ///
    /// # Source
    /// The paper's commented text: −60° to 60° about the forward axis, from the centre; parts of the sides belong to it.
    pub fn is_front(&self, half_angle: f64) -> bool {
        self.bearing.abs() <= half_angle
    }
}

/// The planner's settings; the defaults are the published ones.
///
/// # Source
/// InterFuser `team_code/interfuser_config.py`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// The maximum wanted speed (m/s).
    pub max_speed: f64,
    /// Room that is added to the ego's half length and half width (m).
    pub margin: [f64; 2],
    /// Share of the ego's box above which a road user is in the way.
    pub overlap: f64,
    /// The maximum throttle, except while creeping.
    pub max_throttle: f64,
    /// Ratio of speed to wanted speed above which it brakes.
    pub brake_ratio: f64,
    /// The maximum speed error that the throttle receives (m/s).
    pub speed_step: f64,
    /// Proportional, integral and derivative gains of the throttle.
    pub speed_gains: [f64; 3],
    /// Proportional, integral and derivative gains of the wheel.
    pub turn_gains: [f64; 3],
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            max_speed: 5.0,
            margin: [2.5, 1.2],
            overlap: 0.04,
            max_throttle: 0.75,
            brake_ratio: 1.1,
            speed_step: 0.35,
            speed_gains: [5.0, 0.5, 1.0],
            turn_gains: [1.25, 0.75, 0.3],
        }
    }
}

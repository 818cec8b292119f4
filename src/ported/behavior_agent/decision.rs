/// The reasons for the agent's control in a tick.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Decision {
    /// The red-light step decided to stop.
    pub red_light: bool,
    /// Distance to the actor that the walker step found, near or far (m); a vehicle if no walker is near.
    pub walker: Option<f64>,
    /// Distance to the vehicle that the vehicle step found (m); also `None` if that step was not reached.
    pub vehicle: Option<f64>,
    /// The control is an emergency stop.
    pub emergency: bool,
    /// Speed that the planner aims at (m/s); the limit in an emergency stop.
    pub target_speed: f64,
}

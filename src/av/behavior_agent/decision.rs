/// Why the agent did what it did in a tick.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Decision {
    /// The red-light step said stop.
    pub red_light: bool,
    /// Distance to what the walker step found, near or far (m); a vehicle at times, see
    /// [`Quirks::vehicles_for_walkers`](super::Quirks::vehicles_for_walkers).
    pub walker: Option<f64>,
    /// Distance to what the vehicle step found (m); none too when that step was not reached.
    pub vehicle: Option<f64>,
    /// The control is an emergency stop.
    pub emergency: bool,
    /// Speed that the planner aims at (m/s); the limit in an emergency stop.
    pub target_speed: f64,
}

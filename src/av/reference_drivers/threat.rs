/// The car's own motion, for its reference driver.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OwnMotion {
    /// Speed (m/s).
    pub speed: f64,
    /// Acceleration (m/s²), negative when it brakes.
    pub acceleration: f64,
    /// Length of the car (m).
    pub length: f64,
}

/// A pedestrian in the way, or possibly so soon, in the frame of the path that the car follows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Threat {
    /// Clear distance along the path from the bumper to the near side (m); negative when the bumper is past it.
    pub gap: f64,
    /// Length along the path (m).
    pub length: f64,
    /// Clear distance from the side of the swept path (m); 0 within it.
    pub aside: f64,
    /// Speed along the path, in the car's direction (m/s).
    pub along: f64,
    /// Speed towards the middle of the path (m/s).
    pub towards: f64,
}

/// A pedestrian slower than this (m/s) does not count as moving towards the path.
const STILL: f64 = 0.1;

impl Threat {
    /// Whether it is in the swept path or moves towards it.
    pub fn is_on_its_way(&self) -> bool {
        self.aside <= 0.0 || self.towards > STILL
    }

    /// Time until the bumper reaches it at present speeds (s); infinite when they do not approach.
    pub fn time_to_collision(&self, speed: f64) -> f64 {
        let closing = speed - self.along;
        if closing > 0.0 { self.gap.max(0.0) / closing } else { f64::INFINITY }
    }
}

/// A driver that decides when and how hard to brake.
pub trait ReferenceDriver: Send {
    /// Forgets the last encounter.
    fn begin(&mut self);

    /// Decides for the next `dt` (s); `threat` is the visible threat, if any. Returns the deceleration (m/s²), 0 to keep the speed;
    /// none as long as it has no reason to interfere.
    fn brake(&mut self, own: &OwnMotion, threat: Option<&Threat>, dt: f64) -> Option<f64>;
}

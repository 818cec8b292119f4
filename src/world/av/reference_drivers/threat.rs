/// The car's own motion, for its reference driver.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OwnMotion {
    /// Speed (m/s).
    pub speed: f64,
    /// Acceleration (m/s²), negative when it brakes.
    pub acceleration: f64,
    /// Mean acceleration (m/s²) that its driver intends for the next seconds if nothing is in the way. It lets a driver that is about to
    /// pull away know how soon it will be there.
    pub intended: f64,
    /// Length of the car (m).
    pub length: f64,
    /// The greatest deceleration that the car and the road allow (m/s²).
    pub brake: f64,
}

impl OwnMotion {
    /// Up to this speed (m/s) a car stands.
    pub const STANDING: f64 = 0.1;

    /// Whether the car stands.
    pub fn stands(&self) -> bool {
        self.speed <= Self::STANDING
    }
}

/// A pedestrian in the way, or possibly so soon, in the frame of the path that the car follows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Threat {
    /// Clear distance along the path from the bumper to the near side (m); negative when the bumper is past it.
    pub gap: f64,
    /// Length along the path (m).
    pub length: f64,
    /// Distance of its middle from the middle of the path (m), at least 0.
    pub offset: f64,
    /// The offset at which it leaves the swept path (m): half the width of the car and half of its own.
    pub reach: f64,
    /// Speed along the path, in the car's direction (m/s).
    pub along: f64,
    /// Speed towards the middle of the path (m/s); negative when it walks away from it.
    pub towards: f64,
}

/// A pedestrian slower than this (m/s) does not count as moving towards the path.
const STILL: f64 = 0.1;
/// A pedestrian that walks towards the path is on course into it when it is expected within this distance of it (m). Our choice: JRC's code
/// takes a cut-in to be one from a lateral gap of 0.5 m on.
const MARGIN: f64 = 0.5;
/// It is expected for this much longer than the car needs to pass (s), as in JRC's code.
const TOLERANCE: f64 = 0.1;

impl Threat {
    /// Clear distance from the side of the swept path (m); 0 within it.
    pub fn aside(&self) -> f64 {
        (self.offset - self.reach).max(0.0)
    }

    /// Whether it is in the swept path or moves towards it.
    pub fn is_on_its_way(&self) -> bool {
        self.aside() <= 0.0 || self.towards > STILL
    }

    /// Time until the bumper reaches it (s), when it keeps its velocity and the car its speed and intention; infinite when the bumper
    /// never does, 0 beside the car.
    ///
    /// With the closing speed `c`, the gap `d` and the intended acceleration `a`: `c t + a t²/2 = d`.
    pub fn time_to_collision(&self, own: &OwnMotion) -> f64 {
        reached(own.speed - self.along, own.intended, self.gap)
    }

    /// Whether it is expected in the path, or nearer to it than half a metre, at some time while the car passes.
    ///
    /// Both keep their velocities, as in [`Threat::time_to_collision`]. A pedestrian that will have left the path when the car arrives is not
    /// on course, nor one that will come only after the car.
    pub fn is_on_course(&self, own: &OwnMotion) -> bool {
        let first = self.time_to_collision(own);
        if !self.is_on_its_way() || first == f64::INFINITY {
            return false;
        }
        let passed = reached(own.speed - self.along, own.intended, self.gap + self.length + own.length) + TOLERANCE;
        // Distances from the middle at both times, positive on the side from which it comes.
        let (at_first, at_last) = (self.offset - self.towards * first, self.offset - self.towards * passed);
        let nearest = if at_first > 0.0 && at_last > 0.0 {
            at_first.min(at_last)
        } else if at_first < 0.0 && at_last < 0.0 {
            -at_first.max(at_last)
        } else {
            0.0
        };
        nearest <= self.reach + MARGIN
    }
}

/// The time (s) after which a distance (m) is covered at a speed (m/s) that grows by `acceleration` (m/s²).
fn reached(speed: f64, acceleration: f64, distance: f64) -> f64 {
    if distance <= 0.0 {
        return 0.0;
    }
    let root = speed * speed + 2.0 * acceleration * distance;
    let sum = speed + root.max(0.0).sqrt();
    if root < 0.0 || sum <= 0.0 { f64::INFINITY } else { 2.0 * distance / sum }
}

/// A driver that decides when and how hard to brake.
pub trait ReferenceDriver: Send {
    /// Forgets the last encounter.
    fn begin(&mut self);

    /// Decides for the next `dt` (s); `threat` is the visible threat, if any. Returns the deceleration (m/s²), 0 to keep the speed;
    /// none as long as it has no reason to interfere.
    fn brake(&mut self, own: &OwnMotion, threat: Option<&Threat>, dt: f64) -> Option<f64>;

    /// The time (s) for which it has noticed the pedestrian when it begins to brake.
    fn noticed_for(&self) -> f64 {
        0.0
    }

    /// Whether it has noticed the pedestrian since it began.
    fn has_noticed(&self) -> bool;
}

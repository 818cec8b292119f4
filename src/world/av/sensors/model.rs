use std::f64::consts::{PI, TAU};

use base::signature::{MAX_MAGNITUDE, MIN_POSITIVE};
use base::{choice, keys};
use road::geometry::{Point, Pose, Vector, wrap_angle};

/// Maximum length and width of what a pedestrian is mistaken for (m): larger than any vehicle.
const MAX_CONFUSED: f64 = 30.0;

choice! {
    /// Whether old beliefs are moved on.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum Prediction {
        None = "none",
        ConstantVelocity = "constant_velocity",
    }
}

choice! {
    /// What a pedestrian is that is taken for a vehicle.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum ConfusedAs {
        Vehicle = "vehicle",
        Both = "both",
    }
}

keys! {
    /// What a driver knows of others: where its sensors look, what they miss and mistake, and when it learns of it. Without any
    /// key they are exact, immediate and see through walls.
    pub struct SensorKeys = "sensors" {
        /// Nothing farther ahead of the ego's middle is found.
        ahead: Option<f64> as non_negative(LENGTH),
        /// Nothing farther behind it is found.
        behind: Option<f64> as non_negative(LENGTH),
        /// Nothing farther to either side of it is found.
        aside: Option<f64> as non_negative(LENGTH),
        /// Nothing farther from the eye is found.
        range: Option<f64> as non_negative(LENGTH),
        /// Place of the eye ahead of the ego's middle.
        eye: f64 as within(LENGTH, -100.0, 100.0) = "0 m",
        /// How often they look, in whole ticks; every tick when left out.
        update_rate: Option<f64> as within(FREQUENCY, 0.1, MAX_MAGNITUDE),
        /// Age at which a measurement reaches the driver, in whole ticks.
        latency: f64 as within(TIME, 0.0, 10.0) = "0 s",
        /// Whether old beliefs are moved on by their velocities before the driver gets them.
        prediction: Prediction = "none",
        /// How long an actor that is no longer detected is assumed to move on as before.
        memory: f64 as non_negative(TIME) = "0 s",
        /// Share of an actor that rays from the eye must reach; at 0 they see through everything.
        least_visible: f64 as share() = "0",
        /// Distance up to which `miss_near` holds.
        near: f64 as non_negative(LENGTH) = "0 m",
        /// Distance from which `miss_far` holds; linear in between.
        far: f64 as non_negative(LENGTH) = "0 m",
        /// Rate of misses near by.
        miss_near: f64 as share() = "0",
        /// Rate of misses far away.
        miss_far: f64 as share() = "0",
        /// Correlation time of misses: the autocorrelation after t is exp(-t / this), a miss lasts about this long.
        miss_correlation: f64 as non_negative(TIME) = "0 s",
        /// Standard deviation of the position, on either axis.
        position_noise: f64 as non_negative(LENGTH) = "0 m",
        /// Standard deviation of the velocity, on either axis.
        velocity_noise: f64 as non_negative(SPEED) = "0 m/s",
        /// Standard deviation of the heading; the velocity does not turn with it.
        heading_noise: f64 as non_negative(ANGLE) = "0 deg",
        /// Standard deviation of the logarithm of the size.
        size_noise: f64 as share() = "0",
        /// Correlation time of these four errors.
        noise_correlation: f64 as non_negative(TIME) = "0 s",
        /// Share of `walking_speed` in the believed speed of pedestrians; the rest is their own.
        speed_pull: f64 as share() = "0",
        /// Speed that pedestrians are expected to have, and that false alarms have.
        walking_speed: f64 as non_negative(SPEED) = "1.2 m/s",
        /// Share of time for which a pedestrian is taken for a vehicle.
        confusion: f64 as share() = "0",
        /// Correlation time of that.
        confusion_correlation: f64 as non_negative(TIME) = "0 s",
        /// Whether it is then a vehicle only, or both.
        confused_as: ConfusedAs = "vehicle",
        /// Length of that vehicle: a bicycle's (assumed).
        confused_length: f64 as within(LENGTH, MIN_POSITIVE, MAX_CONFUSED) = "1.8 m",
        /// Its width (assumed).
        confused_width: f64 as within(LENGTH, MIN_POSITIVE, MAX_CONFUSED) = "0.8 m",
        /// How often a pedestrian is detected where there is none: between 5 and 30 m away, at most 60 degrees from the heading
        /// (assumed).
        false_alarms: f64 as non_negative(FREQUENCY) = "0 Hz",
        /// How long it stays on average (assumed).
        false_alarm_length: f64 as within(TIME, 0.001, MAX_MAGNITUDE) = "1 s",
    }
    .rising(&["near", "far"])
    .holding(vec![Sector::signature(), Seam::signature()])
}

keys! {
    /// What a camera or a scanner covers; without any, everything around. Sectors written here replace those of a kind.
    #[derive(Copy)]
    pub struct Sector = "sector" {
        /// Direction of its middle from the heading, positive to the left.
        facing: f64 as within(ANGLE, -PI, PI) = "0 deg",
        /// Whole angle that it covers.
        width: f64 as within(ANGLE, 0.0, TAU),
        /// How far it reaches from the eye.
        range: Option<f64> as positive(LENGTH),
    }
}

keys! {
    /// Directions in which more is missed. Seams written here replace those of a kind.
    #[derive(Copy)]
    pub struct Seam = "seam" {
        /// Direction of its middle from the heading, positive to the left.
        facing: f64 as within(ANGLE, -PI, PI) = "0 deg",
        /// Whole angle that it covers.
        width: f64 as within(ANGLE, 0.0, TAU),
        /// Rate of misses in it, on top of all others.
        miss: f64 as share(),
    }
}

impl Sector {
    fn covers(&self, bearing: f64, distance: f64) -> bool {
        let reaches = self.range.is_none_or(|range| distance <= range);
        reaches && wrap_angle(bearing - self.facing).abs() <= self.width / 2.0
    }
}

/// The errors and delays of sensors, and where they look.
#[derive(Debug, Clone, PartialEq)]
pub struct SensorModel {
    pub keys: SensorKeys,
    /// The covered sectors; all directions when empty.
    pub sectors: Vec<Sector>,
    /// The directions in which more is missed.
    pub seams: Vec<Seam>,
}

impl SensorModel {
    /// The place of the eye for an ego at this pose.
    pub fn eye(&self, ego: &Pose) -> Point {
        ego.to_world(Vector::new(self.keys.eye, 0.0))
    }

    /// The distance of a place from the eye (m) and the rate at which a seam hides it; `None` if it is outside.
    pub fn covers(&self, ego: &Pose, place: Point) -> Option<(f64, f64)> {
        let SensorKeys { ahead, behind, aside, range, eye, .. } = self.keys;
        let local = ego.to_local(place);
        let offset = Vector::new(local.x - eye, local.y);
        let distance = offset.norm();
        let is_beyond = |extent: Option<f64>, way: f64| extent.is_some_and(|extent| way > extent);
        let outside = is_beyond(ahead, local.x) || is_beyond(behind, -local.x) || is_beyond(aside, local.y.abs());
        if outside || is_beyond(range, distance) {
            return None;
        }
        if self.sectors.is_empty() && self.seams.is_empty() {
            return Some((distance, 0.0));
        }
        let bearing = libm::atan2(offset.y, offset.x);
        let covered = self.sectors.is_empty() || self.sectors.iter().any(|sector| sector.covers(bearing, distance));
        let in_seam = |seam: &&Seam| wrap_angle(bearing - seam.facing).abs() <= seam.width / 2.0;
        let seam = self.seams.iter().filter(in_seam).map(|seam| seam.miss).fold(0.0, f64::max);
        covered.then_some((distance, seam))
    }

    /// Half of the length and of the width of the vehicle that a pedestrian is mistaken for (m).
    pub fn confused_half(&self) -> Vector {
        Vector::new(self.keys.confused_length, self.keys.confused_width) / 2.0
    }

    /// The rate at which an actor in the field is missed: at a distance (m), in a seam of this rate. The two causes are
    /// independent.
    pub fn miss_rate(&self, distance: f64, seam: f64) -> f64 {
        let beyond = distance - self.keys.near;
        let share = if beyond <= 0.0 { 0.0 } else { (beyond / (self.keys.far - self.keys.near).max(1e-9)).min(1.0) };
        let plain = self.keys.miss_near + share * (self.keys.miss_far - self.keys.miss_near);
        1.0 - (1.0 - plain) * (1.0 - seam)
    }

    /// Whether a setting depends on how much of an actor is visible.
    pub fn looks(&self) -> bool {
        self.keys.least_visible > 0.0
    }

    /// Whether measurements have errors.
    pub fn is_noisy(&self) -> bool {
        [self.keys.position_noise, self.keys.velocity_noise, self.keys.heading_noise, self.keys.size_noise]
            .iter()
            .any(|noise| *noise > 0.0)
    }

    /// The number of ticks of this length (s) between two updates.
    pub fn ticks_between(&self, dt: f64) -> u32 {
        let period = self.keys.update_rate.map_or(0.0, |rate| 1.0 / rate);
        ((period / dt).round() as u32).max(1)
    }

    /// The number of ticks of this length (s) until a measurement reaches the driver.
    pub fn ticks_late(&self, dt: f64) -> u32 {
        (self.keys.latency / dt).round() as u32
    }
}

/// The correlation after a time `dt` of a process with this correlation time, both in s; 0 for white noise.
pub fn correlation(dt: f64, time: f64) -> f64 {
    if time > 0.0 { libm::exp(-dt / time) } else { 0.0 }
}

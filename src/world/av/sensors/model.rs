use super::Field;
use crate::geometry::Vector;

/// The errors and delays of sensors. The default is exact, immediate and sees through walls.
#[derive(Debug, Clone, PartialEq)]
pub struct SensorModel {
    pub field: Field,
    /// Time between two updates (s), rounded to whole ticks, at least one tick.
    pub period: f64,
    /// Age at which a measurement reaches the driver (s), rounded to whole ticks.
    pub latency: f64,
    /// Whether beliefs are moved on by their velocities to the time at which the driver gets them.
    pub predicts: bool,
    /// How long an actor that is no longer found is believed to keep its last velocity (s).
    pub memory: f64,
    /// Share of an actor that must be visible; at 0 they see through everything.
    pub least_visible: f64,
    /// Distance up to which `miss_near` applies (m).
    pub near: f64,
    /// Distance from which `miss_far` applies (m); linear in between.
    pub far: f64,
    /// Rate of misses near by.
    pub miss_near: f64,
    /// Rate of misses far away.
    pub miss_far: f64,
    /// Correlation time of misses (s).
    pub miss_correlation: f64,
    /// Standard deviation of the position on either axis (m).
    pub position_noise: f64,
    /// Standard deviation of the velocity on either axis (m/s).
    pub velocity_noise: f64,
    /// Standard deviation of the heading (rad); the velocity does not turn with it.
    pub heading_noise: f64,
    /// Standard deviation of the logarithm of the size.
    pub size_noise: f64,
    /// Correlation time of all these errors (s).
    pub noise_correlation: f64,
    /// Weight of `walking_speed` in the believed speed of pedestrians; the rest is the weight of their true speed.
    pub speed_pull: f64,
    /// Speed that the sensors expect of pedestrians (m/s).
    pub walking_speed: f64,
    /// Share of time for which a detected pedestrian is mistaken for a vehicle.
    pub confusion: f64,
    /// Correlation time of that mistake (s).
    pub confusion_correlation: f64,
    /// Whether the vehicle is believed in addition to the pedestrian.
    pub confusion_adds: bool,
    /// Half extents of that vehicle (m).
    pub confused_half: Vector,
    /// Rate at which false pedestrians appear (1/s).
    pub false_alarms: f64,
    /// The mean duration of one (s).
    pub false_alarm_length: f64,
}

impl Default for SensorModel {
    fn default() -> Self {
        Self {
            field: Field::default(),
            period: 0.0,
            latency: 0.0,
            predicts: false,
            memory: 0.0,
            least_visible: 0.0,
            near: 0.0,
            far: 0.0,
            miss_near: 0.0,
            miss_far: 0.0,
            miss_correlation: 0.0,
            position_noise: 0.0,
            velocity_noise: 0.0,
            heading_noise: 0.0,
            size_noise: 0.0,
            noise_correlation: 0.0,
            speed_pull: 0.0,
            walking_speed: 0.0,
            confusion: 0.0,
            confusion_correlation: 0.0,
            confusion_adds: false,
            confused_half: Vector::new(0.9, 0.4),
            false_alarms: 0.0,
            false_alarm_length: 1.0,
        }
    }
}

impl SensorModel {
    /// The rate at which an actor in the field is missed: at a distance (m), in a seam of this rate. The two causes are
    /// independent.
    pub fn miss_rate(&self, distance: f64, seam: f64) -> f64 {
        let beyond = distance - self.near;
        let share = if beyond <= 0.0 { 0.0 } else { (beyond / (self.far - self.near).max(1e-9)).min(1.0) };
        let plain = self.miss_near + share * (self.miss_far - self.miss_near);
        1.0 - (1.0 - plain) * (1.0 - seam)
    }

    /// Whether a setting depends on how much of an actor is visible.
    pub fn looks(&self) -> bool {
        self.least_visible > 0.0
    }

    /// Whether measurements have errors.
    pub fn is_noisy(&self) -> bool {
        [self.position_noise, self.velocity_noise, self.heading_noise, self.size_noise].iter().any(|noise| *noise > 0.0)
    }

    /// The number of ticks of this length (s) between two updates.
    pub fn ticks_between(&self, dt: f64) -> u32 {
        ((self.period / dt).round() as u32).max(1)
    }

    /// The number of ticks of this length (s) until a measurement reaches the driver.
    pub fn ticks_late(&self, dt: f64) -> u32 {
        (self.latency / dt).round() as u32
    }
}

/// The correlation after a time `dt` of a process with this correlation time, both in s; 0 for white noise.
pub fn correlation(dt: f64, time: f64) -> f64 {
    if time > 0.0 { libm::exp(-dt / time) } else { 0.0 }
}

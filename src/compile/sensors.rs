use std::f64::consts::{PI, TAU};

use super::sensor_suites::{SUITES, Suite};
use base::signature::{Form, Keys, MAX_MAGNITUDE, MIN_POSITIVE, Signature};
use base::{choice, keys};
use lang::hir::Block;
use world::av::sensors::{Field, Seam, Sector, SensorModel};
use world::geometry::Vector;

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
    .holding(vec![SectorKeys::signature(), SeamKeys::signature()])
}

keys! {
    /// What a camera or a scanner covers; without any, everything around. Sectors written here replace those of a kind.
    pub struct SectorKeys = "sector" {
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
    pub struct SeamKeys = "seam" {
        /// Direction of its middle from the heading, positive to the left.
        facing: f64 as within(ANGLE, -PI, PI) = "0 deg",
        /// Whole angle that it covers.
        width: f64 as within(ANGLE, 0.0, TAU),
        /// Rate of misses in it, on top of all others.
        miss: f64 as share(),
    }
}

/// The form `sensors`.
pub fn form() -> Form {
    let kind = |Suite { name, doc, figures, .. }: &Suite| {
        let own = Signature { name, doc, ..SensorKeys::signature() };
        figures.iter().fold(own, |kind, (key, value, doc)| kind.usually(key, Some(*value), doc))
    };
    Form { kinds: SUITES.iter().map(kind).collect(), ..Form::plain(SensorKeys::signature()) }
}

pub fn lower(block: &Block) -> SensorModel {
    let keys: SensorKeys = block.keys();
    let or_any = |range: Option<f64>| range.unwrap_or(f64::INFINITY);
    let sector = |SectorKeys { facing, width, range }| Sector { facing, width, range: or_any(range) };
    let seam = |SeamKeys { facing, width, miss }| Seam { facing, width, miss };
    let mut sectors: Vec<Sector> = block.inside().map(|(_, keys)| sector(keys)).collect();
    let mut seams: Vec<Seam> = block.inside().map(|(_, keys)| seam(keys)).collect();
    if let Some(suite) = SUITES.iter().find(|suite| suite.name == block.word) {
        if sectors.is_empty() {
            sectors.extend_from_slice(suite.sectors);
        }
        if seams.is_empty() {
            seams.extend_from_slice(suite.seams);
        }
    }
    SensorModel {
        field: Field {
            ahead: or_any(keys.ahead),
            behind: or_any(keys.behind),
            aside: or_any(keys.aside),
            range: or_any(keys.range),
            eye: keys.eye,
            sectors,
            seams,
        },
        period: keys.update_rate.map_or(0.0, |rate| 1.0 / rate),
        latency: keys.latency,
        predicts: keys.prediction == Prediction::ConstantVelocity,
        memory: keys.memory,
        least_visible: keys.least_visible,
        near: keys.near,
        far: keys.far,
        miss_near: keys.miss_near,
        miss_far: keys.miss_far,
        miss_correlation: keys.miss_correlation,
        position_noise: keys.position_noise,
        velocity_noise: keys.velocity_noise,
        heading_noise: keys.heading_noise,
        size_noise: keys.size_noise,
        noise_correlation: keys.noise_correlation,
        speed_pull: keys.speed_pull,
        walking_speed: keys.walking_speed,
        confusion: keys.confusion,
        confusion_correlation: keys.confusion_correlation,
        confusion_adds: keys.confused_as == ConfusedAs::Both,
        confused_half: Vector::new(keys.confused_length, keys.confused_width) / 2.0,
        false_alarms: keys.false_alarms,
        false_alarm_length: keys.false_alarm_length,
    }
}

use std::f64::consts::{PI, TAU};

use super::sensor_suites::{SUITES, Suite};
use base::signature::{Form, LEAST, MOST, Param, Signature, Type};
use base::units::Dimension;
use lang::hir::Block;
use world::av::sensors::{Field, Seam, Sector, SensorModel};
use world::geometry::Vector;

/// Greatest length and width of what a pedestrian is mistaken for (m): larger than any vehicle.
const LONGEST_CONFUSED: f64 = 30.0;
/// The keys of the distances at which misses start and stop to change.
const RISING: &[&str] = &["near", "far"];

/// The form `sensors`.
pub fn form() -> Form {
    let kind = |suite: &Suite| {
        let mut params = params();
        for (key, value, doc) in suite.figures {
            let param = params.iter_mut().find(|param| param.name == *key);
            let param = param.unwrap_or_else(|| panic!("`{}` has a figure for `{key}`, which is no key", suite.name));
            (param.default, param.doc) = (Some(*value), *doc);
        }
        Signature { children: blocks(), ..Signature::new(suite.name, suite.doc, params).rising(RISING) }
    };
    Form {
        name: "sensors",
        doc: "What a driver knows of others: where its sensors look, what they miss and mistake, and when it learns of it. Without any key they are exact, immediate and see through walls.",
        plain: Some(Signature { children: blocks(), ..Signature::new("sensors", "", params()).rising(RISING) }),
        multiplies: false,
        kinds: SUITES.iter().map(kind).collect(),
    }
}

fn blocks() -> Vec<Signature> {
    let direction = Type::Quantity { dimension: Dimension::ANGLE, min: -PI, max: PI };
    let width = || Type::Quantity { dimension: Dimension::ANGLE, min: 0.0, max: TAU };
    let facing = "Direction of its middle from the heading, positive to the left.";
    vec![
        Signature::new(
            "sector",
            "What a camera or a scanner covers; without any, everything around. Sectors written here replace those of a kind.",
            vec![
                Param::with_default("facing", direction.clone(), "0 deg", facing),
                Param::required("width", width(), "Whole angle that it covers."),
                Param::optional("range", Type::positive(Dimension::LENGTH), "How far it reaches from the eye."),
            ],
        ),
        Signature::new(
            "seam",
            "Directions in which more is missed. Seams written here replace those of a kind.",
            vec![
                Param::with_default("facing", direction, "0 deg", facing),
                Param::required("width", width(), "Whole angle that it covers."),
                Param::required("miss", Type::share(), "Rate of misses in it, on top of all others."),
            ],
        ),
    ]
}

fn params() -> Vec<Param> {
    let (length, time) = (|| Type::non_negative(Dimension::LENGTH), || Type::non_negative(Dimension::TIME));
    let least = |dimension, min| Type::Quantity { dimension, min, max: MOST };
    let no_time = |name, doc| Param::with_default(name, time(), "0 s", doc);
    let never = |name, doc| Param::with_default(name, Type::share(), "0", doc);
    vec![
        Param::optional("ahead", length(), "Nothing farther ahead of the ego's middle is found."),
        Param::optional("behind", length(), "Nothing farther behind it is found."),
        Param::optional("aside", length(), "Nothing farther to either side of it is found."),
        Param::optional("range", length(), "Nothing farther from the eye is found."),
        Param::with_default(
            "eye",
            Type::Quantity { dimension: Dimension::LENGTH, min: -100.0, max: 100.0 },
            "0 m",
            "Place of the eye ahead of the ego's middle.",
        ),
        Param::optional(
            "update_rate",
            least(Dimension::FREQUENCY, 0.1),
            "How often they look, in whole ticks; every tick when left out.",
        ),
        Param::with_default(
            "latency",
            Type::Quantity { dimension: Dimension::TIME, min: 0.0, max: 10.0 },
            "0 s",
            "Age at which a measurement reaches the driver, in whole ticks.",
        ),
        Param::with_default(
            "prediction",
            Type::Choice(&["none", "constant_velocity"]),
            "none",
            "Whether old beliefs are moved on by their velocities before the driver gets them.",
        ),
        no_time("memory", "How long an actor that is no longer detected is assumed to move on as before."),
        never(
            "least_visible",
            "Share of an actor that rays from the eye must reach; at 0 they see through everything.",
        ),
        Param::with_default("near", length(), "0 m", "Distance up to which `miss_near` holds."),
        Param::with_default("far", length(), "0 m", "Distance from which `miss_far` holds; linear in between."),
        never("miss_near", "Rate of misses near by."),
        never("miss_far", "Rate of misses far away."),
        never("miss_hidden", "Further rate of misses when just `least_visible` can be seen, falling linearly to none."),
        no_time(
            "miss_correlation",
            "Correlation time of misses: the autocorrelation after t is exp(-t / this), a miss lasts about this long.",
        ),
        Param::with_default("position_noise", length(), "0 m", "Standard deviation of the position, on either axis."),
        Param::with_default(
            "velocity_noise",
            Type::non_negative(Dimension::SPEED),
            "0 m/s",
            "Standard deviation of the velocity, on either axis.",
        ),
        Param::with_default(
            "heading_noise",
            Type::non_negative(Dimension::ANGLE),
            "0 deg",
            "Standard deviation of the heading; the velocity does not turn with it.",
        ),
        never("size_noise", "Standard deviation of the logarithm of the size."),
        no_time("noise_correlation", "Correlation time of these four errors."),
        never("speed_pull", "Share of `walking_speed` in the believed speed of pedestrians; the rest is their own."),
        Param::with_default(
            "walking_speed",
            Type::non_negative(Dimension::SPEED),
            "1.2 m/s",
            "Speed that pedestrians are expected to have, and that false alarms have.",
        ),
        never("confusion", "Share of time for which a pedestrian is taken for a vehicle."),
        no_time("confusion_correlation", "Correlation time of that."),
        Param::with_default(
            "confused_as",
            Type::Choice(&["vehicle", "both"]),
            "vehicle",
            "Whether it is then a vehicle only, or both.",
        ),
        Param::with_default(
            "confused_length",
            Type::Quantity { dimension: Dimension::LENGTH, min: LEAST, max: LONGEST_CONFUSED },
            "1.8 m",
            "Length of that vehicle: a bicycle's (assumed).",
        ),
        Param::with_default(
            "confused_width",
            Type::Quantity { dimension: Dimension::LENGTH, min: LEAST, max: LONGEST_CONFUSED },
            "0.8 m",
            "Its width (assumed).",
        ),
        Param::with_default(
            "false_alarms",
            Type::non_negative(Dimension::FREQUENCY),
            "0 Hz",
            "How often a pedestrian is detected where there is none: between 5 and 30 m away, at most 60 degrees from the heading (assumed).",
        ),
        Param::with_default(
            "false_alarm_length",
            least(Dimension::TIME, 0.001),
            "1 s",
            "How long it stays on average (assumed).",
        ),
    ]
}

pub fn lower(block: &Block) -> SensorModel {
    let arguments = &block.arguments;
    let number = |key: &str| arguments.number(key);
    let or_any = |arguments: &base::signature::Arguments, key: &str| match arguments.has(key) {
        true => arguments.number(key),
        false => f64::INFINITY,
    };
    let suite = SUITES.iter().find(|suite| suite.name == block.word);
    let sector = |child: &Block| Sector {
        facing: child.arguments.number("facing"),
        width: child.arguments.number("width"),
        range: or_any(&child.arguments, "range"),
    };
    let seam = |child: &Block| Seam {
        facing: child.arguments.number("facing"),
        width: child.arguments.number("width"),
        miss: child.arguments.number("miss"),
    };
    let mut sectors: Vec<Sector> = block.nested("sector").map(sector).collect();
    let mut seams: Vec<Seam> = block.nested("seam").map(seam).collect();
    if let Some(suite) = suite {
        if sectors.is_empty() {
            sectors.extend_from_slice(suite.sectors);
        }
        if seams.is_empty() {
            seams.extend_from_slice(suite.seams);
        }
    }
    SensorModel {
        field: Field {
            ahead: or_any(arguments, "ahead"),
            behind: or_any(arguments, "behind"),
            aside: or_any(arguments, "aside"),
            range: or_any(arguments, "range"),
            eye: number("eye"),
            sectors,
            seams,
        },
        period: if arguments.has("update_rate") { 1.0 / number("update_rate") } else { 0.0 },
        latency: number("latency"),
        predicts: arguments.choice("prediction") == "constant_velocity",
        memory: number("memory"),
        least_visible: number("least_visible"),
        near: number("near"),
        far: number("far"),
        miss_near: number("miss_near"),
        miss_far: number("miss_far"),
        miss_hidden: number("miss_hidden"),
        miss_correlation: number("miss_correlation"),
        position_noise: number("position_noise"),
        velocity_noise: number("velocity_noise"),
        heading_noise: number("heading_noise"),
        size_noise: number("size_noise"),
        noise_correlation: number("noise_correlation"),
        speed_pull: number("speed_pull"),
        walking_speed: number("walking_speed"),
        confusion: number("confusion"),
        confusion_correlation: number("confusion_correlation"),
        confusion_adds: arguments.choice("confused_as") == "both",
        confused_half: Vector::new(number("confused_length"), number("confused_width")) / 2.0,
        false_alarms: number("false_alarms"),
        false_alarm_length: number("false_alarm_length"),
    }
}

use std::f64::consts::PI;

use base::signature::{Arguments, Form, Param, Signature, Type};
use base::units::Dimension;
use world::env::EpisodeRule;
use world::sim::LightCycle;

/// The form `episode`.
pub fn form() -> Form {
    let seconds = || Type::Quantity { dimension: Dimension::TIME, min: 0.1, max: 3600.0 };
    let params = vec![
        Param::with_default(
            "tick",
            Type::Quantity { dimension: Dimension::TIME, min: 0.001, max: 0.1 },
            "0.05 s",
            "Length of a tick. CARLA's driver assumes 0.05 s.",
        ),
        Param::with_default(
            "hold",
            Type::Ticks { min: 1, max: 10_000 },
            "20",
            "Ticks for which the pedestrian holds a command.",
        ),
        Param::with_default("ticks", Type::Ticks { min: 1, max: 1_000_000 }, "600", "Most ticks of an episode."),
        Param::optional(
            "end_when",
            Type::Condition("step"),
            "Ends the episode after a command without a hit when it holds; not in the paper.",
        ),
        Param::with_default(
            "front",
            Type::Quantity { dimension: Dimension::ANGLE, min: 0.0, max: PI },
            "60 deg",
            "A hit is frontal when the pedestrian's bearing from the ego's middle is at most this.",
        ),
        Param::with_default(
            "moving_above",
            Type::non_negative(Dimension::SPEED),
            "0.1 m/s",
            "The ego counts as moving above this speed.",
        ),
        Param::optional(
            "friction",
            Type::Quantity { dimension: Dimension::RATIO, min: 0.02, max: 2.0 },
            "Friction of the road: no car brakes, accelerates or turns with more than this times 9.81 m/s^2. Without it the figures of the `vehicle` alone hold, which are those of a dry road.",
        ),
        Param::with_default("traffic_lights", Type::Boolean, "true", "Whether the town's traffic lights work."),
        Param::with_default(
            "light_green",
            seconds(),
            "10 s",
            "Green of each turn of the traffic lights (CARLA's, as the next two).",
        ),
        Param::with_default("light_yellow", seconds(), "3 s", "Yellow of each turn."),
        Param::with_default(
            "light_red",
            seconds(),
            "2 s",
            "Time after a turn in which all lights of a junction are red.",
        ),
        Param::optional(
            "light_phase",
            Type::Distribution { dimension: Dimension::TIME, min: 0.0, max: 36_000.0 },
            "Time within the cycle of all junctions when the car sets off: at the start of the episode, or of its run-up. Any time without it. At 0 s the first turn becomes green.",
        ),
    ];
    Form {
        name: "episode",
        doc: "How long an episode lasts and what ends it.",
        plain: Some(Signature::new("episode", "", params)),
        multiplies: false,
        kinds: Vec::new(),
    }
}

pub fn lower(arguments: &Arguments) -> EpisodeRule {
    EpisodeRule {
        tick: arguments.number("tick"),
        hold: arguments.integer("hold") as u32,
        ticks: arguments.integer("ticks") as u32,
        end_when: arguments.condition("end_when").cloned(),
        front_half_angle: arguments.number("front"),
        moving_above: arguments.number("moving_above"),
        friction: arguments.has("friction").then(|| arguments.number("friction")),
        traffic_lights: arguments.boolean("traffic_lights"),
        light_cycle: LightCycle {
            green: arguments.number("light_green"),
            yellow: arguments.number("light_yellow"),
            red: arguments.number("light_red"),
        },
        light_phase: arguments.has("light_phase").then(|| arguments.distribution("light_phase").clone()),
    }
}

use crate::env::{
    ActionSpec, Controller, FirstHeading, ObservationSpec, ObservedSpeed, PedestrianRole, ReferenceFrame, Scaling,
};
use crate::signature::{Arguments, Form, Param, Signature, Type};
use crate::sim::PedestrianBody;
use crate::units::Dimension;

const FRAMES: &[&str] = &["heading", "initial", "line_of_sight", "world"];
const SCALINGS: &[&str] = &["natural", "unit"];

/// The form `adversary`.
pub fn form() -> Form {
    let frame = || Type::Choice(FRAMES);
    let scaling = || Type::Choice(SCALINGS);
    let params = vec![
        Param::with_default(
            "body",
            Type::Choice(&["adult", "child"]),
            "adult",
            "Its size: CARLA's adult (radius 0.188 m) or child (0.25 m) (B).",
        ),
        Param::with_default(
            "ramp",
            Type::non_negative(Dimension::TIME),
            "2 s",
            "Time from rest to any speed; `0 s` for at once. CARLA's walkers take 2 s (the formula A, its 20.48 m/s^2 D).",
        ),
        Param::with_default(
            "turning",
            Type::positive(Dimension::FREQUENCY),
            "8 Hz",
            "Rate at which its velocity turns; 20 Hz or more for at once. CARLA's 8 Hz is Unreal's default (D).",
        ),
        Param::with_default(
            "speed",
            Type::Range { dimension: Dimension::SPEED, min: 0.0, max: 40.96 },
            "0 m/s .. 3.5 m/s",
            "The speeds it can choose.",
        ),
        Param::with_default(
            "observation_frame",
            frame(),
            "heading",
            "Where the angles of its state are measured from.",
        ),
        Param::with_default("action_frame", frame(), "heading", "Where the heading it chooses is measured from."),
        Param::with_default(
            "observation_scaling",
            scaling(),
            "natural",
            "Units of its state: rad, m, rad, m/s, or those over π, 30, π, 8.",
        ),
        Param::with_default(
            "action_scaling",
            scaling(),
            "natural",
            "Units of its action: rad and m/s, or the whole range as -1 to 1.",
        ),
        Param::with_default(
            "observed_speed",
            Type::Choice(&["ego", "relative"]),
            "ego",
            "The speed in its state: the ego's, or that of the two relative to each other.",
        ),
        Param::with_default(
            "first_heading",
            Type::Choice(&["random", "towards_ego"]),
            "random",
            "Where it looks at first.",
        ),
    ];
    Form {
        name: "adversary",
        doc: "The pedestrian that attacks: its body, and how its states and actions are to be read.",
        plain: Some(Signature::new("adversary", "", params)),
        multiplies: false,
        kinds: Vec::new(),
    }
}

/// The pedestrian.
pub fn lower(arguments: &Arguments) -> PedestrianRole {
    let size = match arguments.choice("body") {
        "child" => PedestrianBody::child(),
        _ => PedestrianBody::adult(),
    };
    let ramp = arguments.number("ramp");
    // A pedestrian that starts at once stops at once.
    let stopping = if ramp == 0.0 { f64::INFINITY } else { size.stopping };
    PedestrianRole {
        body: PedestrianBody { ramp, turning: arguments.number("turning"), stopping, ..size },
        observation: ObservationSpec {
            frame: frame(arguments.choice("observation_frame")),
            scaling: scaling(arguments.choice("observation_scaling")),
            speed: match arguments.choice("observed_speed") {
                "relative" => ObservedSpeed::Relative,
                _ => ObservedSpeed::Ego,
            },
        },
        action: ActionSpec {
            speed: arguments.range("speed"),
            frame: frame(arguments.choice("action_frame")),
            scaling: scaling(arguments.choice("action_scaling")),
        },
        controller: Controller::External,
        first_heading: match arguments.choice("first_heading") {
            "towards_ego" => FirstHeading::TowardsEgo,
            _ => FirstHeading::Random,
        },
    }
}

fn frame(word: &str) -> ReferenceFrame {
    match word {
        "initial" => ReferenceFrame::Initial,
        "line_of_sight" => ReferenceFrame::LineOfSight,
        "world" => ReferenceFrame::World,
        _ => ReferenceFrame::Heading,
    }
}

fn scaling(word: &str) -> Scaling {
    if word == "unit" { Scaling::Unit } else { Scaling::Natural }
}

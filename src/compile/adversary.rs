use base::diagnostic::Diagnostic;
use base::signature::{Arguments, Form, Param, Signature, Type};
use base::units::Dimension;
use lang::diagnostics;
use lang::hir::Block;
use world::env::{
    ActionSpec, Controller, FirstHeading, ObservationSpec, ObservedSpeed, PedestrianRole, ReferenceFrame, Scaling,
    TargetBox,
};
use world::sim::{Gait, PedestrianBody};

const FRAMES: &[&str] = &["heading", "initial", "line_of_sight", "world"];
const ACTION_FRAMES: &[&str] = &["heading", "initial", "line_of_sight", "world", "meeting"];
const SCALINGS: &[&str] = &["natural", "unit"];

/// Heights of the adult and the child target of Euro NCAP (m).
///
/// # Source
/// ACEA, *Articulated Pedestrian Target Specification* 1.0 (2016).
const ADULT_HEIGHT: f64 = 1.8;
const CHILD_HEIGHT: f64 = 1.154;

/// The form `adversary`.
pub fn form() -> Form {
    let frame = || Type::Choice(FRAMES);
    let scaling = || Type::Choice(SCALINGS);
    let params = vec![
        Param::with_default(
            "body",
            Type::Choice(&["adult", "child", "adult_box", "child_box"]),
            "adult",
            "Its size: CARLA's adult (a disc of radius 0.188 m) or child (0.25 m) (B); or the `target` of a test as a box, 0.6 m by 0.5 m (`adult_box`) or 0.711 m by 0.298 m (`child_box`).",
        ),
        Param::with_default(
            "ramp",
            Type::non_negative(Dimension::TIME),
            "2 s",
            "Time from rest to any speed; `0 s` for at once. CARLA's walkers take 2 s (the formula A). Not with `acceleration`.",
        ),
        Param::with_default(
            "turning",
            Type::positive(Dimension::FREQUENCY),
            "8 Hz",
            "Rate at which its velocity turns; 20 Hz or more for at once. Unreal's formula (A) with its default friction, 8 Hz (D). Not with `acceleration`.",
        ),
        Param::optional(
            "acceleration",
            Type::positive(Dimension::ACCELERATION),
            "Greatest acceleration in any direction, so that turns need time. It replaces CARLA's gait (`ramp`, `turning`) by a body with inertia.",
        ),
        Param::optional(
            "stopping",
            Type::positive(Dimension::ACCELERATION),
            "Greatest deceleration. Without it that of `acceleration`; without `acceleration` 20.48 m/s^2 (Unreal's default, D), at once with a `ramp` of 0 s.",
        ),
        Param::optional(
            "turn_rate",
            Type::positive(Dimension::TURN_RATE),
            "Greatest rate at which its direction of motion turns; a body at rest starts in any direction. Only with `acceleration`, which alone limits turns without it.",
        ),
        Param::with_default(
            "speed",
            Type::Range { dimension: Dimension::SPEED, min: 0.0, max: 40.96 },
            "0 m/s .. 3.5 m/s",
            "The speeds it can choose.",
        ),
        Param::optional(
            "heading",
            Type::Range { dimension: Dimension::ANGLE, min: -std::f64::consts::PI, max: std::f64::consts::PI },
            "The headings it can choose, from the direction of its `action_frame`, positive to the left; all without it.",
        ),
        Param::with_default(
            "observation_frame",
            frame(),
            "heading",
            "Where the angles of its state are measured from.",
        ),
        Param::with_default(
            "action_frame",
            Type::Choice(ACTION_FRAMES),
            "heading",
            "Where the heading it chooses is measured from; `meeting` is the direction in which it would meet the car's bumper at the speed \
             it chooses, if the car kept its velocity.",
        ),
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

/// Reports keys that exclude each other.
pub fn check(block: &Block, said: &mut Vec<Diagnostic>) {
    let given = |key: &str| block.places.iter().find(|(name, _)| *name == key).map(|(_, span)| *span);
    match given("acceleration") {
        Some(acceleration) => {
            for (key, what) in [("ramp", "the time to any speed"), ("turning", "a rate of turning without inertia")] {
                if let Some(span) = given(key) {
                    let message = format!("`{key}` is {what}, and `acceleration` bounds both: remove one of the two");
                    let label = "this makes it a body with inertia";
                    said.push(diagnostics::contradiction(span, message).label(acceleration, label));
                }
            }
        }
        None => said.extend(given("turn_rate").map(|span| {
            let message = "`turn_rate` needs `acceleration`: only a body with inertia has one".to_string();
            diagnostics::contradiction(span, message)
                .help("add `acceleration: 1.65 m/s^2`, or write `turning` for CARLA's gait")
        })),
    }
}

pub fn lower(arguments: &Arguments) -> PedestrianRole {
    let size = match arguments.choice("body") {
        "child" => PedestrianBody::child(),
        "adult_box" => target(&TargetBox::ADULT, ADULT_HEIGHT),
        "child_box" => target(&TargetBox::CHILD, CHILD_HEIGHT),
        _ => PedestrianBody::adult(),
    };
    let given = |key: &str| arguments.has(key).then(|| arguments.number(key));
    let (stopping, ramp) = (given("stopping"), arguments.number("ramp"));
    let gait = match given("acceleration") {
        Some(acceleration) => Gait::Inertial {
            acceleration,
            stopping: stopping.unwrap_or(acceleration),
            turn_rate: given("turn_rate").unwrap_or(f64::INFINITY),
        },
        None => {
            // A pedestrian that starts at once stops at once.
            let usual = if ramp == 0.0 { f64::INFINITY } else { Gait::CARLA_STOPPING };
            Gait::Carla { ramp, turning: arguments.number("turning"), stopping: stopping.unwrap_or(usual) }
        }
    };
    PedestrianRole {
        body: PedestrianBody { gait, ..size },
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
            heading: if arguments.has("heading") { arguments.range("heading") } else { ActionSpec::ANY_HEADING },
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

/// The body of a target of a test.
fn target(target: &TargetBox, height: f64) -> PedestrianBody {
    PedestrianBody::boxed(target.half_length, target.half_width, height / 2.0)
}

fn frame(word: &str) -> ReferenceFrame {
    match word {
        "initial" => ReferenceFrame::Initial,
        "line_of_sight" => ReferenceFrame::LineOfSight,
        "world" => ReferenceFrame::World,
        "meeting" => ReferenceFrame::Meeting,
        _ => ReferenceFrame::Heading,
    }
}

fn scaling(word: &str) -> Scaling {
    if word == "unit" { Scaling::Unit } else { Scaling::Natural }
}

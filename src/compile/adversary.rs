use std::f64::consts::PI;

use base::diagnostic::Diagnostic;
use base::signature::{Form, Keys};
use base::{choice, keys};
use episode::{
    ActionSpec, Controller, Destination, FirstHeading, ObservationSpec, ObservedSpeed, PedestrianRole, Placement,
    ReferenceFrame, Scaling, TargetBox,
};
use lang::diagnostics;
use lang::hir::Block;
use world::sim::{Gait, PedestrianBody};

/// Heights of the adult and the child target of Euro NCAP (m).
///
/// # Source
/// ACEA, *Articulated Pedestrian Target Specification* 1.0 (2016).
const ADULT_HEIGHT: f64 = 1.8;
const CHILD_HEIGHT: f64 = 1.154;

choice! {
    /// The body of a pedestrian.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum Body {
        Adult = "adult",
        Child = "child",
        AdultBox = "adult_box",
        ChildBox = "child_box",
    }
}

keys! {
    /// The pedestrian that attacks: its body, and how its states and actions are to be read.
    pub struct BodyKeys = "body" {
        /// Its size: CARLA's adult (a disc of radius 0.188 m) or child (0.25 m) (B); or the `target` of a test as a box, 0.6 m by
        /// 0.5 m (`adult_box`) or 0.711 m by 0.298 m (`child_box`).
        shape: Body = "adult",
        /// Time from rest to any speed; `0 s` for at once. CARLA's walkers take 2 s (the formula A). Not with `acceleration`.
        ramp: f64 as non_negative(TIME) = "2 s",
        /// Rate at which its velocity turns; 20 Hz or more for at once. Unreal's formula (A) with its default friction, 8 Hz
        /// (D). Not with `acceleration`.
        turning: f64 as positive(FREQUENCY) = "8 Hz",
        /// Maximum acceleration in any direction, so that turns need time. It replaces CARLA's gait (`ramp`, `turning`) by a
        /// body with inertia.
        acceleration: Option<f64> as positive(ACCELERATION),
        /// Maximum deceleration. Without it that of `acceleration`; without `acceleration` 20.48 m/s^2 (Unreal's default, D),
        /// at once with a `ramp` of 0 s.
        stopping: Option<f64> as positive(ACCELERATION),
        /// Maximum rate at which its direction of motion turns; a body at rest starts in any direction. Only with
        /// `acceleration`, which alone limits turns without it.
        turn_rate: Option<f64> as positive(TURN_RATE),
        /// The speeds it can choose.
        speed: (f64, f64) as range(SPEED, 0.0, 40.96) = "0 m/s .. 3.5 m/s",
        /// The headings it can choose, from the direction of its `action_frame`, positive to the left; all without it.
        heading: Option<(f64, f64)> as range(ANGLE, -PI, PI),
        /// Where the angles of its state are measured from.
        observation_frame: ReferenceFrame as Choice(&["heading", "initial", "line_of_sight", "world"]) = "heading",
        /// Where the heading it chooses is measured from; `meeting` is the direction in which it would meet the car's bumper at
        /// the speed it chooses, if the car kept its velocity.
        action_frame: ReferenceFrame = "heading",
        /// The place to which it is on its way with `action_frame: destination`, where its heading is a correction of that way; `bus_stop` is the stop
        /// nearest to its start. Without it, it crosses the road.
        destination: Option<Destination>,
        /// Units of its state: rad, m, rad, m/s, or those over π, 30, π, 8.
        observation_scaling: Scaling = "natural",
        /// Units of its action: rad and m/s, or the whole range as -1 to 1.
        action_scaling: Scaling = "natural",
        /// The speed in its state: the ego's, or that of the two relative to each other.
        observed_speed: ObservedSpeed = "ego",
        /// Whether it sees the road: 8 numbers more in its state. They are its place along and beside the lane that the car is on, how far it is beyond the
        /// edge of that lane and inside the nearest driving lane, the direction of the car's lane beside it, and how the car stands in its lane.
        road: Option<bool>,
        /// Directions in which it sees obstacles, a multiple of 4: each adds a number to its state, how far the view is free, up to 20 m. They go
        /// evenly around, counterclockwise, from where angles are measured from.
        rays: usize as whole(0, 64) = "0",
        /// Places in its state for the nearest other actors of a cast, the nearest first: each adds 8 numbers, which are 0 if nobody is left.
        others: Option<u32> as whole(1, 16),
        /// Where it looks at first.
        first_heading: FirstHeading = "random",
    }
}

/// The form `body`.
pub fn form() -> Form {
    Form::plain(BodyKeys::signature())
}

/// Reports keys that exclude each other.
pub fn check(block: &Block, said: &mut Vec<Diagnostic>) {
    let rays = block.keys::<BodyKeys>().rays;
    if !rays.is_multiple_of(4) {
        let message = format!("{rays} rays: the number must be a multiple of 4");
        said.push(diagnostics::contradiction(block.place("rays"), message).help("write 4, 8, 12, 16 or more"));
    }
    let given = |key: &str| block.places.iter().find(|(name, _)| *name == key).map(|(_, span)| *span);
    if let Some(span) =
        given("destination").filter(|_| block.keys::<BodyKeys>().action_frame != ReferenceFrame::Destination)
    {
        let message = "`destination` is where headings are measured from only in the frame of that name".to_string();
        said.push(diagnostics::contradiction(span, message).help("add `action_frame: destination`"));
    }
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

pub fn lower(keys: BodyKeys) -> PedestrianRole {
    let size = match keys.shape {
        Body::Adult => PedestrianBody::adult(),
        Body::Child => PedestrianBody::child(),
        Body::AdultBox => target(&TargetBox::ADULT, ADULT_HEIGHT),
        Body::ChildBox => target(&TargetBox::CHILD, CHILD_HEIGHT),
    };
    let BodyKeys { ramp, turning, stopping, .. } = keys;
    let gait = match keys.acceleration {
        Some(acceleration) => Gait::Inertial {
            acceleration,
            stopping: stopping.unwrap_or(acceleration),
            turn_rate: keys.turn_rate.unwrap_or(f64::INFINITY),
        },
        None => {
            // A pedestrian that starts at once stops at once.
            let usual = if ramp == 0.0 { f64::INFINITY } else { Gait::CARLA_STOPPING };
            Gait::Carla { ramp, turning, stopping: stopping.unwrap_or(usual) }
        }
    };
    PedestrianRole {
        name: "pedestrian".into(),
        body: PedestrianBody { gait, ..size },
        observation: ObservationSpec {
            frame: keys.observation_frame,
            scaling: keys.observation_scaling,
            speed: keys.observed_speed,
            road: keys.road.unwrap_or(false),
            rays: keys.rays,
            others: keys.others.unwrap_or(0) as usize,
        },
        action: ActionSpec {
            speed: keys.speed,
            heading: keys.heading.unwrap_or(ActionSpec::ANY_HEADING),
            frame: keys.action_frame,
            destination: keys.destination,
            scaling: keys.action_scaling,
        },
        controller: Controller::External,
        first_heading: keys.first_heading,
        is_absent: false,
        place: Placement::Spawn,
    }
}

/// The body of a target of a test.
fn target(target: &TargetBox, height: f64) -> PedestrianBody {
    PedestrianBody::boxed(target.half_length, target.half_width, height / 2.0)
}

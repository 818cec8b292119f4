//! What a pedestrian's controller gets and gives, for `falsify explain state` and `falsify explain action`.

use std::fmt::Write;

use base::signature::short;
use episode::{ActionSpec, Component, ObservationSpec, ObservedSpeed, ReferenceFrame, Scaling};

/// The page of the state.
pub fn state() -> String {
    let spec = |frame, scaling, speed| ObservationSpec { frame, scaling, speed, road: false, rays: 0, others: 0 };
    let usual = spec(ReferenceFrame::Heading, Scaling::Natural, ObservedSpeed::Ego);
    let mut page = format!(
        "state: what a pedestrian gets before each decision, {} numbers in this order\n\n",
        ObservationSpec::DIM
    );
    list(&mut page, &usual.components());
    let sight = &spec(ReferenceFrame::LineOfSight, Scaling::Natural, ObservedSpeed::Ego).components()[0];
    let _ = write!(
        page,
        "\nAngles are positive to the left. The `body` says where they are measured from (`observation_frame`):\n\n{}\n\
         With `line_of_sight` the bearing would always be 0; the first number is then `{}`: {}.\n\n",
        frames(&[ReferenceFrame::Heading, ReferenceFrame::Initial, ReferenceFrame::LineOfSight, ReferenceFrame::World]),
        sight.name,
        sight.meaning
    );
    let relative = &spec(ReferenceFrame::Heading, Scaling::Natural, ObservedSpeed::Relative).components()[3];
    let _ = writeln!(page, "`observed_speed: relative` makes the last number the {}.", relative.meaning);
    let units = spec(ReferenceFrame::Heading, Scaling::Unit, ObservedSpeed::Ego).components();
    let units: Vec<&str> = units.iter().map(|component| component.unit.as_str()).collect();
    let _ = writeln!(page, "`observation_scaling: unit` divides the numbers by {}.", units.join(", "));
    let _ = writeln!(page, "`road: true` adds {} numbers, which are cut at these bounds:\n", ObservationSpec::ROAD_DIM);
    list(&mut page, &ObservationSpec { road: true, ..usual }.components()[ObservationSpec::DIM..]);
    let _ = writeln!(
        page,
        "\n`observation_scaling: unit` divides them by their greatest values. They do not depend on where a town lies; if it is mirrored, those to the \
         left, the sine and the turn change their signs."
    );
    let _ = writeln!(
        page,
        "`rays: N` adds N numbers: how far the view is free of obstacles, up to {} m, evenly around from angle 0, counterclockwise.",
        ObservationSpec::REACH
    );
    let _ = writeln!(
        page,
        "`others: N` adds {} numbers for each of the N nearest other actors of a cast: {}. All are 0 where nobody is left.",
        ObservationSpec::OTHER_DIM,
        ObservationSpec::other_names().join(", ")
    );
    page.push_str(
        "With the key `frame_stack: N` of a training the networks get the last N states, the oldest first; zeros precede the first state.\n",
    );
    page.push_str(&decision());
    page
}

/// The page of the action.
pub fn action() -> String {
    let spec = |scaling| ActionSpec {
        speed: (0.0, 3.5),
        heading: ActionSpec::ANY_HEADING,
        frame: ReferenceFrame::Heading,
        destination: None,
        scaling,
    };
    let mut page =
        format!("action: what a pedestrian chooses in each decision, {} numbers in this order\n\n", ActionSpec::DIM);
    list(&mut page, &spec(Scaling::Natural).components());
    let all = [
        ReferenceFrame::Heading,
        ReferenceFrame::Initial,
        ReferenceFrame::LineOfSight,
        ReferenceFrame::World,
        ReferenceFrame::Meeting,
        ReferenceFrame::Destination,
    ];
    let _ = write!(
        page,
        "\nThe bounds are those of a `body` without `speed` and `heading`. The heading is positive to the left, measured from (`action_frame`):\n\n{}\n",
        frames(&all)
    );
    let [heading, speed] = spec(Scaling::Unit).components();
    let _ = writeln!(
        page,
        "`action_scaling: unit` gives both numbers the bounds {} and {}: {}, {}.",
        heading.low.map_or(String::new(), short),
        heading.high.map_or(String::new(), short),
        heading.unit,
        speed.unit
    );
    page.push_str("The body follows with its own acceleration and rate of turning (`falsify explain body`).\n");
    page.push_str(&decision());
    page
}

fn decision() -> String {
    "A decision lasts `hold` ticks of `tick` (`falsify explain episode`). The headers of the networks in the folder `pedestrians` of a report \
     (ONNX, safetensors) have the names, units and bounds of both under `state` and `action`, and `replay NAME --ticks FILE` writes both for every decision.\n"
        .into()
}

fn list(page: &mut String, components: &[Component]) {
    for component in components {
        let range = match (component.low, component.high) {
            (Some(low), Some(high)) => format!("{} .. {}", bound(low), bound(high)),
            (Some(low), None) => format!("{} or more", bound(low)),
            _ => "any".into(),
        };
        let _ = writeln!(page, "  {:16}  {:4}  {:10}  {}", component.name, component.unit, range, component.meaning);
    }
}

fn bound(value: f64) -> String {
    if value.abs() == std::f64::consts::PI { format!("{}π", if value < 0.0 { "-" } else { "" }) } else { short(value) }
}

fn frames(frames: &[ReferenceFrame]) -> String {
    let line = |frame: &ReferenceFrame| format!("  {:13}  {}\n", frame.name(), frame.meaning());
    frames.iter().map(line).collect()
}

//! The messages in JSON.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::refusal::{ID, KeyOf, Keyed, answer_refusal, greeting_refusal};
use crate::av::view::{Kind, LaneAhead, Seen, View};
use crate::av::{DrivingMode, Fault, Perception, Word};
use crate::sim::{Control, LightColour};
use road::geometry::Pose;

/// Name and major version of the protocol. Keys may be added within a version; a driver must ignore keys that it does not know.
pub const PROTOCOL: &str = "falsify-av/1";

/// What messages hold beyond the first version of the protocol. A driver asks for it in its greeting; others get the messages of
/// revision 1, which stay as they are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default, Deserialize)]
#[serde(try_from = "u32")]
pub(super) enum Revision {
    /// As first published.
    #[default]
    First,
    /// With the ids of actors, and the lanes and speed limits along the route.
    Second,
}

impl Revision {
    /// The newest, which the greeting names.
    pub const NEWEST: u32 = 2;
}

impl TryFrom<u32> for Revision {
    type Error = &'static str;

    fn try_from(number: u32) -> Result<Self, &'static str> {
        match number {
            1 => Ok(Self::First),
            2 => Ok(Self::Second),
            _ => Err("a revision other than 1 or 2"),
        }
    }
}

/// The first message to a driver.
#[derive(Serialize)]
pub(super) struct Hello<'a> {
    pub r#type: &'static str,
    pub protocol: &'static str,
    pub tick_s: f64,
    pub town: &'a str,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub map: Option<serde_json::Value>,
    pub vehicle: Vehicle,
    pub worlds: usize,
    pub actors: usize,
    pub route_points: usize,
    pub revision: u32,
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub parameters: &'a BTreeMap<String, f64>,
}

#[derive(Serialize)]
pub(super) struct Vehicle {
    length: f64,
    width: f64,
    wheelbase: f64,
    pub greatest_wheel_angle: f64,
}

impl Vehicle {
    pub fn new(perception: &Perception<'_>) -> Self {
        let blueprint = perception.blueprint;
        Self {
            length: 2.0 * blueprint.half_length,
            width: 2.0 * blueprint.half_width,
            wheelbase: blueprint.wheelbase,
            greatest_wheel_angle: blueprint.greatest_wheel_angle * blueprint.steering_response,
        }
    }
}

/// The encoding of messages after the greeting.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Encoding {
    #[default]
    Json,
    Binary,
}

/// The meaning of the first two numbers of a binary answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Pedals {
    #[default]
    Pedals,
    Acceleration,
}

/// The keys of a greeting.
pub(super) const GREETING: [KeyOf; 6] = [
    ("protocol", "a text", |value| value.is_string()),
    ("name", "a text", |_| true),
    ("encoding", "`json` or `binary`", |value| ["json", "binary"].iter().any(|word| value == word)),
    ("control", "`pedals` or `acceleration`", |value| ["pedals", "acceleration"].iter().any(|word| value == word)),
    ("wheel_angle", "true or false", |value| value.is_boolean()),
    ("revision", "1 or 2", |value| [1, 2].iter().any(|number| value == number)),
];

/// Reads the greeting of a driver.
///
/// # Errors
/// It is not one, or another protocol.
pub(super) fn read_greeting(line: &[u8]) -> Result<Greeting, Fault> {
    let Keyed(greeting): Keyed<Greeting> =
        serde_json::from_slice(line).map_err(|_| greeting_refusal(line, &GREETING))?;
    if greeting.protocol == PROTOCOL {
        Ok(greeting)
    } else {
        Err(Fault::Greeting("another protocol than falsify-av/1"))
    }
}

#[derive(Deserialize)]
pub(super) struct Greeting {
    pub protocol: String,
    #[serde(default)]
    pub encoding: Encoding,
    #[serde(default)]
    pub control: Pedals,
    #[serde(default)]
    pub wheel_angle: bool,
    #[serde(default)]
    pub revision: Revision,
}

/// Where a road user is and how fast it is: m, rad, m/s.
#[derive(Serialize)]
pub struct Body {
    x: f64,
    y: f64,
    yaw: f64,
    speed: f64,
}

impl Body {
    pub fn new(pose: &Pose, speed: f64) -> Self {
        Self { x: pose.x, y: pose.y, yaw: pose.yaw, speed }
    }
}

#[derive(Serialize)]
struct Light {
    colour: &'static str,
    distance: f64,
}

#[derive(Serialize)]
struct Sign {
    kind: &'static str,
    distance: f64,
}

#[derive(Serialize)]
struct Actor {
    #[serde(skip_serializing_if = "Option::is_none")]
    id: Option<u32>,
    kind: &'static str,
    x: f64,
    y: f64,
    yaw: f64,
    vx: f64,
    vy: f64,
    length: f64,
    width: f64,
}

#[derive(Serialize)]
struct Lane {
    width: f64,
    left: u32,
    right: u32,
    junction: bool,
    speed_limit: f64,
}

#[derive(Serialize)]
struct World<'a> {
    id: u32,
    tick: u32,
    #[serde(skip_serializing_if = "Option::is_none")]
    seed: Option<u64>,
    ego: Body,
    speed_limit: f64,
    light: Option<Light>,
    sign: Option<Sign>,
    actors: Each<'a, Seen, Actor>,
    route: Each<'a, road::geometry::Pose, [f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    lanes: Option<Each<'a, LaneAhead, Lane>>,
}

/// A list whose members are converted while they are written, without a second list.
struct Each<'a, T, U>(&'a [T], fn(&T) -> U);

impl<T, U: Serialize> Serialize for Each<'_, T, U> {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.0.iter().map(self.1))
    }
}

fn actor(seen: &Seen) -> Actor {
    Actor {
        id: None,
        kind: match seen.kind {
            Kind::Pedestrian => "pedestrian",
            Kind::Vehicle => "vehicle",
        },
        x: seen.pose.x,
        y: seen.pose.y,
        yaw: seen.pose.yaw,
        vx: seen.velocity.x,
        vy: seen.velocity.y,
        length: 2.0 * seen.half.x,
        width: 2.0 * seen.half.y,
    }
}

fn lane(ahead: &LaneAhead) -> Lane {
    let LaneAhead { width, left, right, is_junction, speed_limit } = *ahead;
    Lane { width, left, right, junction: is_junction, speed_limit }
}

/// Appends a world to a request; `seed` only at the start of an episode.
pub(super) fn write_world(out: &mut Vec<u8>, id: u32, tick: u32, seed: Option<u64>, view: &View, revision: Revision) {
    let is_second = revision >= Revision::Second;
    let world = World {
        id,
        tick,
        seed,
        ego: Body::new(&view.ego, view.speed),
        speed_limit: view.speed_limit,
        light: view.light.map(|light| Light {
            colour: match light.colour {
                LightColour::Green => "green",
                LightColour::Yellow => "yellow",
                LightColour::Red => "red",
            },
            distance: light.distance,
        }),
        sign: view.sign.map(|sign| Sign { kind: sign.kind.name(), distance: sign.distance }),
        actors: match is_second {
            true => Each(&view.actors, |seen| Actor { id: Some(seen.id), ..actor(seen) }),
            false => Each(&view.actors, actor),
        },
        route: Each(&view.route, |pose| [pose.x, pose.y, pose.yaw]),
        lanes: is_second.then_some(Each(view.lanes.as_slice(), lane as fn(&LaneAhead) -> Lane)),
    };
    serde_json::to_writer(out, &world).expect("numbers and words have a form in JSON");
}

/// A number may be out of its range by this much, as 32 bits round it.
const ROUNDED: f64 = 1e-6;

/// A driver's decision for a world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Decision {
    pub pedals: Choice,
    /// The steering wheel, −1 to 1, if there is no angle.
    pub steer: f64,
    /// The angle of the front wheels (rad), positive to the left.
    pub wheel_angle: Option<f64>,
    pub mode: DrivingMode,
}

/// A driver's use of the pedals.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Choice {
    Pedals { throttle: f64, brake: f64 },
    Acceleration(f64),
}

impl Decision {
    /// The control at this speed; numbers out of range are clamped.
    pub fn control(&self, perception: &Perception<'_>) -> Control {
        let angle = self.wheel_angle.map(|angle| perception.blueprint.steer_for(angle, perception.ego.speed()));
        let steer = angle.unwrap_or(self.steer).clamp(-1.0, 1.0);
        match self.pedals {
            Choice::Pedals { throttle, brake } => {
                Control { throttle: throttle.clamp(0.0, 1.0), brake: brake.clamp(0.0, 1.0), steer }
            }
            Choice::Acceleration(wanted) => Control { steer, ..perception.pedals_or_hold(wanted) },
        }
    }

    /// What is said if a number is out of its range, and clamped; the greatest angle of the front wheels is that at no speed (rad).
    pub fn out_of_range(&self, greatest_angle: f64) -> Option<String> {
        let most = (greatest_angle * 1e3).round() / 1e3;
        let steer = ("steer", self.steer, 1.0);
        let (key, turn, most) = self.wheel_angle.map_or(steer, |angle| ("wheel_angle", angle, most));
        let turns = turn.abs() <= most + ROUNDED;
        let is_pedal = |number: f64| (-ROUNDED..=1.0 + ROUNDED).contains(&number);
        match self.pedals {
            Choice::Pedals { throttle, brake } => {
                let fits = is_pedal(throttle) && is_pedal(brake) && turns;
                let answer = format!("answers throttle {throttle}, brake {brake}, {key} {turn}");
                (!fits).then(|| format!("{answer}: clamped to 0 to 1, 0 to 1, -{most} to {most}"))
            }
            Choice::Acceleration(wanted) => (!turns)
                .then(|| format!("answers acceleration {wanted}, {key} {turn}: {key} is clamped to -{most} to {most}")),
        }
    }

    /// Checks that all its numbers are finite.
    pub fn finite(self) -> Result<Self, Fault> {
        let finite = match self.pedals {
            Choice::Pedals { throttle, brake } => throttle.is_finite() && brake.is_finite(),
            Choice::Acceleration(wanted) => wanted.is_finite(),
        };
        let finite = finite && self.wheel_angle.unwrap_or(self.steer).is_finite();
        if finite { Ok(self) } else { Err(Fault::Answer("a control is not finite")) }
    }
}

#[derive(Deserialize)]
struct Answers {
    actions: Vec<Keyed<Action>>,
}

/// The keys of an action.
const ACTION: [KeyOf; 7] = [
    ID,
    ("throttle", "a number", serde_json::Value::is_number),
    ("brake", "a number", serde_json::Value::is_number),
    ("acceleration", "a number", serde_json::Value::is_number),
    ("steer", "a number", serde_json::Value::is_number),
    ("wheel_angle", "a number", serde_json::Value::is_number),
    ("mode", "a text", serde_json::Value::is_string),
];

/// The names of these keys.
const KNOWN: &str = "id, throttle, brake, acceleration, steer, wheel_angle, mode";

/// What is said of a mode that is none of [`DrivingMode`].
const UNKNOWN_MODE: &str =
    "a mode other than cruise, turn, follow, yield, emergency_stop, red_light, give_way, arrived, unknown";

/// Keys are those of the revision that the driver speaks: an unknown one is a typo.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Action {
    id: u32,
    // Many programs write NaN as null, so that is not a missing number.
    #[serde(default, deserialize_with = "number")]
    throttle: Option<f64>,
    #[serde(default, deserialize_with = "number")]
    brake: Option<f64>,
    #[serde(default, deserialize_with = "number")]
    acceleration: Option<f64>,
    #[serde(default, deserialize_with = "number")]
    steer: Option<f64>,
    #[serde(default, deserialize_with = "number")]
    wheel_angle: Option<f64>,
    mode: Option<String>,
}

fn number<'de, D: serde::Deserializer<'de>>(from: D) -> Result<Option<f64>, D::Error> {
    f64::deserialize(from).map(Some)
}

/// Why a line is not an answer.
fn refusal(line: &[u8]) -> Fault {
    let parsed: Option<serde_json::Value> = serde_json::from_slice(line).ok();
    let actions = parsed.as_ref().and_then(|answer| answer.get("actions")?.as_array());
    let mut keys =
        actions.into_iter().flatten().filter_map(serde_json::Value::as_object).flat_map(|action| action.keys());
    match keys.find(|key| ACTION.iter().all(|(known, ..)| known != key)) {
        Some(key) => Fault::UnknownKey { key: Word::new(key.as_bytes()), known: KNOWN },
        None => answer_refusal(line, &ACTION),
    }
}

/// Reads a driver's decisions for the requested worlds, in their order.
///
/// # Errors
/// The line is not an answer, or does not answer each world once.
pub(super) fn read_decisions(line: &[u8], asked: &[u32], decisions: &mut Vec<Decision>) -> Result<(), Fault> {
    let Keyed(answers): Keyed<Answers> = serde_json::from_slice(line).map_err(|_| refusal(line))?;
    if answers.actions.len() != asked.len() {
        return Err(Fault::Answer("not one action for each world"));
    }
    decisions.clear();
    for (place, id) in asked.iter().enumerate() {
        // Most drivers answer in the order of the request.
        let Keyed(here) = &answers.actions[place];
        let action = Some(here).filter(|here| here.id == *id);
        let action =
            action.or_else(|| answers.actions.iter().map(|Keyed(action)| action).find(|action| action.id == *id));
        let action = action.ok_or(Fault::Answer("not one action for each world"))?;
        let pedals = match (action.acceleration, action.throttle, action.brake) {
            (Some(acceleration), None, None) => Choice::Acceleration(acceleration),
            (None, None, None) => return Err(Fault::Answer("an action without throttle, brake or acceleration")),
            (None, throttle, brake) => {
                Choice::Pedals { throttle: throttle.unwrap_or(0.0), brake: brake.unwrap_or(0.0) }
            }
            _ => return Err(Fault::Answer("an action with both acceleration and pedals")),
        };
        let mode = match action.mode.as_deref() {
            None => DrivingMode::Unknown,
            Some(mode) => DrivingMode::named(mode).ok_or(Fault::Answer(UNKNOWN_MODE))?,
        };
        let (steer, wheel_angle) = (action.steer.unwrap_or(0.0), action.wheel_angle);
        if action.steer.and(wheel_angle).is_some() {
            return Err(Fault::Answer("an action with both steer and wheel_angle"));
        }
        decisions.push(Decision { pedals, steer, wheel_angle, mode }.finite()?);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::refusal::unknown_key;
    use super::*;

    /// A change of this text is a change of the protocol and needs a new version or description.
    #[test]
    fn a_world_is_written_as_the_protocol_says() {
        let text = |revision| {
            let mut text = Vec::new();
            write_world(&mut text, 7, 0, Some(99), &View::example(), revision);
            String::from_utf8(text).unwrap()
        };
        let second = text(Revision::Second);
        assert!(second.contains(r#""actors":[{"id":3,"kind":"pedestrian","x":12.0"#), "{second}");
        let lanes = r#""lanes":[{"width":3.5,"left":1,"right":0,"junction":true,"speed_limit":8.5}]}"#;
        assert!(second.ends_with(lanes), "{second}");
        assert_eq!(
            text(Revision::First),
            concat!(
                r#"{"id":7,"tick":0,"seed":99,"ego":{"x":1.0,"y":2.0,"yaw":0.5,"speed":8.0},"speed_limit":10.0,"#,
                r#""light":{"colour":"red","distance":30.0},"sign":{"kind":"stop","distance":12.5},"#,
                r#""actors":[{"kind":"pedestrian","x":12.0,"y":1.5,"yaw":-1.5,"#,
                r#""vx":0.0,"vy":-1.25,"length":0.5,"width":0.5}],"route":[[3.0,4.0,0.25]]}"#
            )
        );
    }

    #[test]
    fn every_mode_may_be_reported_and_the_message_names_all_of_them() {
        for mode in DrivingMode::ALL {
            let line = format!(r#"{{"actions":[{{"id":3,"brake":1,"mode":"{}"}}]}}"#, mode.name());
            let mut decisions = Vec::new();
            assert_eq!(read_decisions(line.as_bytes(), &[3], &mut decisions), Ok(()), "{mode:?}");
            assert_eq!(decisions[0].mode, mode);
            assert!(UNKNOWN_MODE.split([' ', ',']).any(|word| word == mode.name()), "{mode:?}");
        }
    }

    const NOT_FINITE: &str =
        "JSON has no NaN and no Infinity: give finite numbers (`json.dumps` of Python writes them)";

    #[test]
    fn a_number_out_of_its_range_is_said() {
        let said = |keys: &str| {
            let mut decisions = Vec::new();
            read_decisions(format!(r#"{{"actions":[{{"id":3,{keys}}}]}}"#).as_bytes(), &[3], &mut decisions).unwrap();
            decisions[0].out_of_range(0.8552)
        };
        for keys in [r#""throttle":1.0000001"#, r#""brake":1,"steer":-1"#, r#""acceleration":-12"#] {
            assert_eq!(said(keys), None, "{keys}");
        }
        let text = "answers throttle 2, brake -1, steer 0: clamped to 0 to 1, 0 to 1, -1 to 1";
        assert_eq!(said(r#""throttle":2,"brake":-1"#).as_deref(), Some(text));
        assert!(said(r#""brake":0,"steer":1.5"#).is_some());
        let text = "answers acceleration -2, steer -6.5: steer is clamped to -1 to 1";
        assert_eq!(said(r#""acceleration":-2,"steer":-6.5"#).as_deref(), Some(text));
        assert_eq!(said(r#""acceleration":-2,"wheel_angle":-0.855"#), None);
        let text = "answers acceleration -2, wheel_angle 1.5: wheel_angle is clamped to -0.855 to 0.855";
        assert_eq!(said(r#""acceleration":-2,"wheel_angle":1.5"#).as_deref(), Some(text));
    }

    #[test]
    fn answers_may_come_in_any_order_and_each_must_be_one_decision() {
        let read = |line: &str| {
            let mut decisions = Vec::new();
            read_decisions(line.as_bytes(), &[3, 5], &mut decisions).map(|()| decisions)
        };
        let good =
            read(r#"{"actions":[{"id":5,"acceleration":-2,"mode":"yield"},{"id":3,"throttle":0.1,"steer":-1}]}"#);
        let decision = |pedals, steer, mode| Decision { pedals, steer, wheel_angle: None, mode };
        let pedals = decision(Choice::Pedals { throttle: 0.1, brake: 0.0 }, -1.0, DrivingMode::Unknown);
        let braking = decision(Choice::Acceleration(-2.0), 0.0, DrivingMode::Yield);
        let turning = read(r#"{"actions":[{"id":3,"brake":1,"wheel_angle":-0.2},{"id":5,"brake":1}]}"#);
        assert_eq!(turning.unwrap()[0].wheel_angle, Some(-0.2));
        assert_eq!(good, Ok(vec![pedals, braking]));
        for (line, reason) in [
            ("", "an empty line"),
            (r#"{"actions":[{"id":3,"brake":NaN},{"id":5,"brake":1}]}"#, NOT_FINITE),
            ("[]", "JSON, and not an object with `actions`"),
            ("{}", "JSON, and not an object with `actions`"),
            (r#"{"actions":[3]}"#, "an action that is not an object"),
            (r#"{"actions":[{"brake":1}]}"#, "an action without `id`"),
            (r#"{"actions":[{"id":3,"brake":1,"brake":0}]}"#, "an action with a key that is there twice"),
            ("\u{feff}{}", "it begins with a byte order mark: write UTF-8 without one"),
            (r#"{"actions":[{"id":3,"brake":-Infinity}]}"#, NOT_FINITE),
            (r#"[[{"id":3,"brake":1},{"id":5,"brake":1}]]"#, "JSON, and not an object with `actions`"),
            (r#"{"actions":[[3,1,0],[5,1,0]]}"#, "an action that is not an object"),
            ("{\0\"\0", "it is UTF-16: write UTF-8"),
            (r#"{"actions":[{"id":3,"brake":1}]}"#, "not one action for each world"),
            (r#"{"actions":[{"id":3,"brake":1},{"id":3,"brake":1}]}"#, "not one action for each world"),
            (r#"{"actions":[{"id":3,"brake":1,"mode":"cruize"},{"id":5,"brake":1}]}"#, UNKNOWN_MODE),
            (r#"{"actions":[{"id":3,"brake":1},{"id":5}]}"#, "an action without throttle, brake or acceleration"),
            (
                r#"{"actions":[{"id":3,"brake":1},{"id":5,"brake":1,"acceleration":0}]}"#,
                "an action with both acceleration and pedals",
            ),
            (
                r#"{"actions":[{"id":3,"brake":1},{"id":5,"brake":1,"steer":0,"wheel_angle":0}]}"#,
                "an action with both steer and wheel_angle",
            ),
        ] {
            assert_eq!(read(line), Err(Fault::Answer(reason)), "{line}");
        }
        assert_eq!(KNOWN.split(", ").collect::<Vec<_>>(), ACTION.map(|(key, ..)| key));
        for (line, said) in [
            (
                r#"{"actions":[{"id":3,"throtle":1},{"id":5,"brake":1}]}"#,
                format!("an action with the key `throtle`; known are {KNOWN}"),
            ),
            (
                r#"{"actions":[{"id":3,"brake":0,"a b\u00e9":1},{"id":5}]}"#,
                format!("an action with the key `a b??`; known are {KNOWN}"),
            ),
            ("turn left", "not JSON: `turn left`".into()),
            ("Traceback (most recent call last):\n", "not JSON: `Traceback (most recent …`".into()),
            (r#"{"actions":[{"id":3,"brake":1}"#, r#"not JSON: `{"actions":[{"id":3,"br…`"#.into()),
        ] {
            assert_eq!(read(line).unwrap_err().to_string(), format!("gave a wrong answer: {said}"));
        }
    }
    #[test]
    fn a_value_of_a_wrong_type_is_named_with_its_key() {
        let read = |key: &str, value: &str| {
            let line = format!(r#"{{"actions":[{{"id":3,"brake":1}},{{"id":5,"{key}":{value}}}]}}"#);
            read_decisions(line.as_bytes(), &[3, 5], &mut Vec::new()).unwrap_err().to_string()
        };
        for key in ["throttle", "brake", "acceleration", "steer", "wheel_angle"] {
            for (value, kind) in [
                ("null", "null"),
                (r#""0.3""#, "a text"),
                ("true", "true or false"),
                ("[0.3]", "a list"),
                ("{}", "an object"),
            ] {
                assert_eq!(
                    read(key, value),
                    format!("gave a wrong answer: `{key}` is {kind}; give a number"),
                    "{value}"
                );
            }
        }
        assert_eq!(read("mode", "3"), "gave a wrong answer: `mode` is another number; give a text");
        for line in
            [r#"{"actions":[{"id":"3","brake":1}]}"#, r#"{"actions":[{"id":-1}]}"#, r#"{"actions":[{"id":3.5}]}"#]
        {
            let fault = read_decisions(line.as_bytes(), &[3], &mut Vec::new()).unwrap_err().to_string();
            assert!(
                fault.starts_with("gave a wrong answer: `id` is ")
                    && fault.ends_with("; give the id of a world, a whole number")
            );
        }
        let fault = read_decisions(br#"{"actions":[{"id":0.0,"brake":1}]}"#, &[0], &mut Vec::new()).unwrap_err();
        let said = "gave a wrong answer: `id` is a decimal number; give the id of a world, a whole number";
        assert_eq!(fault.to_string(), said);
        for number in ["1e999", "-1E+400"] {
            let said = format!("gave a wrong answer: `brake` is {number}, and the largest number is about 1.8e308");
            assert_eq!(read("brake", number), said);
        }
        assert!(read("brake", "1e999999999999999999999999999").contains("`brake` is 1e9999"));
        let fault = read_decisions(br#"{"actions":{"id":3}}"#, &[3], &mut Vec::new()).unwrap_err().to_string();
        assert_eq!(fault, "gave a wrong answer: `actions` is an object; give a list");
        // A missing pedal is 0, and a mode may be left open.
        assert!(read_decisions(br#"{"actions":[{"id":3,"brake":1,"mode":null}]}"#, &[3], &mut Vec::new()).is_ok());
    }

    #[test]
    fn what_is_wrong_with_a_greeting_is_said() {
        let refused = |line: &str| read_greeting(line.as_bytes()).err().map(|fault| fault.to_string());
        assert_eq!(refused(r#"{"protocol":"falsify-av/1","revision":2,"novelty":1}"#), None);
        for (line, said) in [
            ("hello", "not JSON: `hello`"),
            ("\u{feff}{}", "it begins with a byte order mark: write UTF-8 without one"),
            ("[]", "JSON, and not an object"),
            (r#"["falsify-av/1"]"#, "JSON, and not an object"),
            ("{}", "an object without `protocol`"),
            (r#"{"protocol":1}"#, "`protocol` is another number; give a text"),
            (r#"{"protocol":"falsify-av/1","revision":"2"}"#, "`revision` is a text; give 1 or 2"),
            (r#"{"protocol":"falsify-av/1","encoding":"xml"}"#, "`encoding` is a text; give `json` or `binary`"),
            (r#"{"protocol":"falsify-av/9"}"#, "another protocol than falsify-av/1"),
            (r#"{"revision":1e999}"#, "`revision` is 1e999, and the largest number is about 1.8e308"),
        ] {
            assert_eq!(refused(line), Some(format!("greeted wrongly: {said}")), "{line}");
        }
        let ignored = |line: &str| unknown_key(line.as_bytes(), &GREETING);
        assert_eq!(ignored(r#"{"protocol":"falsify-av/1","name":3,"revision":2}"#), None);
        let text = "its greeting has a key `revison`, which is unknown and ignored; did you mean `revision`?";
        assert_eq!(ignored(r#"{"protocol":"falsify-av/1","revison":2}"#).as_deref(), Some(text));
        let text = ignored(r#"{"protocol":"falsify-av/1","\u001bfar":2}"#).unwrap();
        assert!(text.ends_with("key ` far`, which is unknown and ignored; known are `protocol`, `name`, `encoding`, `control`, `wheel_angle`, `revision`"), "{text}");
    }
}

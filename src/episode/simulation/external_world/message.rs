//! The messages in JSON.

use std::collections::BTreeSet;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use base::printable::is_command;
use road::geometry::Pose;
use world::av::Fault;
use world::av::external::{KeyOf, greeting_refusal};
use world::sim::{Control, PedestrianState, VehicleState};

/// Name and major version of the protocol. Keys may be added within a version; a program must ignore keys that it does not know.
pub const PROTOCOL: &str = "falsify-world/1";

/// The name of our own simulator, which no other one has.
pub const HERE: &str = "here";

/// The first message to a program.
pub(super) fn hello() -> Vec<u8> {
    serde_json::to_vec(&serde_json::json!({ "type": "hello", "protocol": PROTOCOL }))
        .expect("words have a form in JSON")
}

/// How far from where it is told a world may say that it places a pedestrian (m).
const MAX_TOLERANCE: f64 = 0.5;

/// How late a world may say that its car follows the pedals (s).
const MAX_PEDAL_DELAY: f64 = 0.5;

/// Maximum length of a name, and of its version (bytes), and maximum number of its drivers: they are recorded and shown.
const MAX_NAME: usize = 60;
const MAX_VERSION: usize = 200;
const MAX_DRIVERS: usize = 100;

/// What a program says that its simulator is and can do: its greeting.
#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
pub struct Abilities {
    protocol: String,
    /// Name of the simulator.
    pub name: String,
    /// Its version, with that of the bridge.
    pub version: String,
    /// The drivers of its own.
    #[serde(default)]
    pub drivers: Vec<String>,
    /// Whether a driver of ours can drive its car.
    #[serde(default = "yes")]
    pub controls: bool,
    /// How far from where it is told it may place a pedestrian, and by how much a car may jump in a tick (m), up to half a metre; 1 cm and 0.1 m without it.
    #[serde(default)]
    pub tolerance: f64,
    /// How late its car follows the pedals (s), beside a tenth of a second: up to half a second, in which an actuator waits or a brake builds up pressure.
    #[serde(default)]
    pub pedal_delay: f64,
    /// Whether the friction of the road can be set.
    #[serde(default)]
    pub friction: bool,
    /// Whether its own drivers see the traffic lights of the town.
    #[serde(default)]
    pub lights: bool,
    /// Whether all that it draws follows the seed of an episode.
    #[serde(default)]
    pub seeds: bool,
}

fn yes() -> bool {
    true
}

const TEXT: fn(&Value) -> bool = Value::is_string;
const BOOLEAN: fn(&Value) -> bool = Value::is_boolean;

/// The keys of a greeting.
pub(super) const GREETING: [KeyOf; 10] = [
    ("protocol", "a text", TEXT),
    ("name", "a text", TEXT),
    ("version", "a text", TEXT),
    ("drivers", "a list of texts", |value| value.as_array().is_some_and(|list| list.iter().all(TEXT))),
    ("controls", "true or false", BOOLEAN),
    ("tolerance", "a number", Value::is_number),
    ("pedal_delay", "a number", Value::is_number),
    ("friction", "true or false", BOOLEAN),
    ("lights", "true or false", BOOLEAN),
    ("seeds", "true or false", BOOLEAN),
];

/// Reads the greeting of a program.
///
/// # Errors
/// It is not one, or of another protocol.
pub(super) fn read_greeting(line: &[u8]) -> Result<Abilities, Fault> {
    let abilities: Abilities = serde_json::from_slice(line).map_err(|_| match greeting_refusal(line, &GREETING) {
        Fault::Greeting("an object with a key that is there twice") => {
            Fault::Greeting("an object without `name` or `version`, or with a key that is there twice")
        }
        other => other,
    })?;
    if !(0.0..=MAX_TOLERANCE).contains(&abilities.tolerance) {
        let why = "a `tolerance` that is not between 0 and 0.5: in m, how far from where it is told a pedestrian may be, and half a metre decides whether a car touches it";
        return Err(Fault::Greeting(why));
    }
    if !(0.0..=MAX_PEDAL_DELAY).contains(&abilities.pedal_delay) {
        let why = "a `pedal_delay` that is not between 0 and 0.5: in s, how late the car follows its pedals";
        return Err(Fault::Greeting(why));
    }
    if abilities.protocol != PROTOCOL {
        return Err(Fault::Greeting("another protocol than falsify-world/1"));
    }
    let is_seen = |letter: char| !letter.is_control() && !is_command(letter);
    let is_word = |text: &str, longest| !text.trim().is_empty() && text.len() <= longest && text.chars().all(is_seen);
    if !is_word(&abilities.name, MAX_NAME) || abilities.name == HERE {
        return Err(Fault::Greeting(
            "a `name` that is empty, longer than 60 bytes, with control characters, or `here`, our own simulator",
        ));
    }
    if !is_word(&abilities.version, MAX_VERSION) {
        let why = "a `version` that is empty, longer than 200 bytes, or with control characters: it is recorded";
        return Err(Fault::Greeting(why));
    }
    let drivers: BTreeSet<&String> = abilities.drivers.iter().collect();
    let all_fit = drivers.len() <= MAX_DRIVERS && drivers.iter().all(|name| is_word(name, MAX_NAME));
    if drivers.len() < abilities.drivers.len() || !all_fit {
        let why = "`drivers` of which one is there twice, empty, longer than 60 bytes or with control characters, or more than 100";
        return Err(Fault::Greeting(why));
    }
    Ok(abilities)
}

/// The place and motion of a car: middle of its box on the ground, heading, and speed along it.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub(super) struct Car {
    pub x: f64,
    pub y: f64,
    pub yaw: f64,
    pub speed: f64,
}

impl Car {
    pub fn new(state: &VehicleState) -> Self {
        let Pose { x, y, yaw } = state.pose;
        Self { x, y, yaw, speed: state.speed }
    }
}

/// The place and motion of a pedestrian.
#[derive(Serialize)]
pub(super) struct Walker {
    x: f64,
    y: f64,
    yaw: f64,
    vx: f64,
    vy: f64,
}

impl Walker {
    pub fn new(state: &PedestrianState) -> Self {
        let Pose { x, y, yaw } = state.pose;
        Self { x, y, yaw, vx: state.velocity.x, vy: state.velocity.y }
    }
}

/// The town, the length of a tick, the car and the pedestrians, once for each start of the program.
#[derive(Serialize)]
pub(super) struct Load<'a> {
    pub r#type: &'static str,
    pub town: &'a str,
    /// In OpenDRIVE.
    pub map: &'a str,
    pub tick_s: f64,
    pub vehicle: Model,
    pub pedestrians: Vec<Body>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub friction: Option<f64>,
    /// Places on the middle of lanes.
    pub lanes: &'a [[f64; 2]],
}

#[derive(Serialize)]
pub(super) struct Model {
    pub length: f64,
    pub width: f64,
    pub wheelbase: f64,
    /// Greatest deceleration of the brake (m/s²).
    pub full_brake: f64,
}

#[derive(Serialize)]
pub(super) struct Body {
    pub radius: f64,
    pub height: f64,
}

#[derive(Serialize)]
pub(super) struct Begin<'a> {
    pub r#type: &'static str,
    pub seed: u64,
    pub ego: Car,
    /// The world's own driver; `null` if the controls of each step drive.
    pub driver: Option<&'a str>,
    /// The speed limit at the start (m/s).
    pub speed_limit: f64,
    /// The way that the world's own driver takes: x, y, yaw of points a metre apart. Empty if another drives.
    pub route: Vec<[f64; 3]>,
    pub pedestrians: Vec<Walker>,
}

#[derive(Serialize)]
pub(super) struct Step {
    pub r#type: &'static str,
    pub tick: u32,
    pub control: Pedals,
    pub pedestrians: Vec<Walker>,
}

/// What the driver does, and what our car would do with it.
#[derive(Serialize)]
pub(super) struct Pedals {
    pub throttle: f64,
    pub brake: f64,
    pub steer: f64,
    /// The acceleration of our car (m/s²).
    pub acceleration: f64,
    /// The angle of its front wheels (rad), positive to the left.
    pub wheel_angle: f64,
}

impl Pedals {
    pub fn new(control: Control, acceleration: f64, wheel_angle: f64) -> Self {
        let Control { throttle, brake, steer } = control;
        Self { throttle, brake, steer, acceleration, wheel_angle }
    }
}

/// The answer to [`Load`]: for each given place the nearest one on the middle of a lane of the world. A world without lanes gives none.
#[derive(Deserialize)]
pub(super) struct Loaded {
    pub lanes: Option<Vec<[f64; 2]>>,
}

/// The answer to [`Begin`], which is tick 0, and to [`Step`].
#[derive(Debug, Deserialize)]
pub(super) struct Moved {
    pub tick: u32,
    pub ego: Car,
    pub pedestrians: Vec<[f64; 2]>,
    /// Whether the world has ended the episode.
    #[serde(default)]
    pub end: bool,
}

const PLACES: fn(&Value) -> bool = |value| {
    let is_place =
        |place: &Value| place.as_array().is_some_and(|place| place.len() == 2 && place.iter().all(Value::is_number));
    value.as_array().is_some_and(|list| list.iter().all(is_place))
};
const CAR: fn(&Value) -> bool = |value| ["x", "y", "yaw", "speed"].iter().all(|key| value[*key].is_number());

/// The keys of the answers.
const LOADED: [KeyOf; 1] = [("lanes", "a list of [x, y], or null", |value| value.is_null() || PLACES(value))];
const MOVED: [KeyOf; 4] = [
    ("tick", "a whole number", |value| value.is_u64()),
    ("ego", "an object with the numbers x, y, yaw, speed", CAR),
    ("pedestrians", "a list of [x, y]", PLACES),
    ("end", "true or false", BOOLEAN),
];

/// Reads an answer with these keys.
fn read<'a, T: Deserialize<'a>>(line: &'a [u8], keys: &[KeyOf]) -> Result<T, Fault> {
    serde_json::from_slice(line).map_err(|_| match greeting_refusal(line, keys) {
        Fault::WrongType { key, found, wanted, .. } => Fault::WrongType { greeting: false, key, found, wanted },
        Fault::TooLarge { key, number, .. } => Fault::TooLarge { greeting: false, key, number },
        Fault::NotJson { text, .. } => Fault::NotJson { greeting: false, text },
        Fault::Greeting(why) if serde_json::from_slice::<serde_json::Value>(line).is_err() => Fault::Answer(why),
        Fault::Greeting("JSON, and not an object") => Fault::Answer("JSON, and not an object"),
        _ => Fault::Answer("an object with a key that is missing or there twice"),
    })
}

pub(super) fn read_loaded(line: &[u8]) -> Result<Loaded, Fault> {
    read(line, &LOADED)
}

pub(super) fn read_moved(line: &[u8]) -> Result<Moved, Fault> {
    read(line, &MOVED)
}

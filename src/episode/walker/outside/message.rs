//! The messages in JSON.

use serde::{Deserialize, Serialize};

use crate::Scene;
use world::av::Fault;
use world::av::external::{Body, ID, KeyOf, Keyed, answer_refusal, greeting_refusal};

/// Name and major version of the protocol. Keys may be added within a version; a program must ignore keys that it does not know.
pub const PROTOCOL: &str = "falsify-pedestrian/1";

/// The first message to a program.
#[derive(Serialize)]
pub(super) struct Hello<'a> {
    r#type: &'static str,
    protocol: &'static str,
    tick_s: f64,
    hold: u32,
    town: &'a str,
    vehicle: Car,
    pedestrians: usize,
    state: usize,
    action_bounds: &'a [(f64, f64)],
}

/// The size of the car (m).
#[derive(Serialize)]
struct Car {
    length: f64,
    width: f64,
}

impl<'a> Hello<'a> {
    pub fn new(scene: &Scene<'a>) -> Self {
        let (scenario, car) = (scene.scenario, &scene.world.ego().blueprint);
        Self {
            r#type: "hello",
            protocol: PROTOCOL,
            tick_s: scenario.episode.tick,
            hold: scenario.episode.hold,
            town: &scenario.town.name,
            vehicle: Car { length: 2.0 * car.half_length, width: 2.0 * car.half_width },
            pedestrians: scene.controlled().count(),
            state: scene.obs_dim(),
            action_bounds: scene.bounds(),
        }
    }
}

#[derive(Deserialize)]
struct Greeting {
    protocol: String,
}

/// The keys of a greeting.
pub(super) const GREETING: [KeyOf; 2] =
    [("protocol", "a text", |value| value.is_string()), ("name", "a text", |_| true)];

/// Reads a program's greeting.
///
/// # Errors
/// [`Fault::Greeting`].
pub(super) fn read_greeting(line: &[u8]) -> Result<(), Fault> {
    let Keyed(greeting): Keyed<Greeting> =
        serde_json::from_slice(line).map_err(|_| greeting_refusal(line, &GREETING))?;
    let known = greeting.protocol == PROTOCOL;
    known.then_some(()).ok_or(Fault::Greeting("another protocol than falsify-pedestrian/1"))
}

#[derive(Serialize)]
struct World<'a> {
    id: u32,
    tick: u32,
    #[serde(skip_serializing_if = "Option::is_none")]
    seed: Option<u64>,
    state: &'a [f64],
    ego: Body,
    pedestrians: Vec<Body>,
}

#[derive(Serialize)]
struct Step<'a> {
    r#type: &'static str,
    worlds: [World<'a>; 1],
}

/// Writes the request for a decision, with its line end; `seed` only at the first decision of an episode.
pub(super) fn write_request(out: &mut Vec<u8>, id: u32, seed: Option<u64>, state: &[f64], scene: &Scene<'_>) {
    let world = scene.world;
    let ego = &world.ego().state;
    let pedestrians = scene.controlled().map(|(number, _)| {
        let walker = &world.pedestrians[number].state;
        Body::new(&walker.pose, walker.speed())
    });
    let request = World {
        id,
        tick: world.ticks,
        seed,
        state,
        ego: Body::new(&ego.pose, ego.speed),
        pedestrians: pedestrians.collect(),
    };
    out.clear();
    serde_json::to_writer(&mut *out, &Step { r#type: "step", worlds: [request] })
        .expect("numbers and words have a form in JSON");
    out.push(b'\n');
}

#[derive(Deserialize)]
struct Action {
    id: u32,
    action: Vec<f64>,
}

#[derive(Deserialize)]
struct Answers {
    actions: Vec<Keyed<Action>>,
}

/// Reads the action for a world.
///
/// # Errors
/// [`Fault::Answer`].
pub(super) fn read_action(line: &[u8], id: u32, action: &mut [f64]) -> Result<(), Fault> {
    let numbers = |value: &serde_json::Value| value.as_array().is_some_and(|list| list.iter().all(|n| n.is_number()));
    let keys: [KeyOf; 2] = [ID, ("action", "a list of numbers", numbers)];
    let Keyed(answers): Keyed<Answers> = serde_json::from_slice(line).map_err(|_| answer_refusal(line, &keys))?;
    match answers.actions.as_slice() {
        [Keyed(answer)] if answer.id == id => {
            if answer.action.len() != action.len() {
                return Err(Fault::Answer("not two numbers for each pedestrian"));
            }
            action.copy_from_slice(&answer.action);
            Ok(())
        }
        _ => Err(Fault::Answer("not one action for each world")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_answer_is_one_action_of_finite_numbers() {
        let read = |line: &str| {
            let mut action = [0.0; 2];
            read_action(line.as_bytes(), 3, &mut action).map(|()| action)
        };
        assert_eq!(read(r#"{"actions":[{"id":3,"action":[-1,2.5],"new":0}]}"#), Ok([-1.0, 2.5]));
        for (line, reason) in [
            ("", "an empty line"),
            (
                r#"{"actions":[{"id":3,"action":[NaN,1]}]}"#,
                "JSON has no NaN and no Infinity: give finite numbers (`json.dumps` of Python writes them)",
            ),
            ("\u{feff}{}", "it begins with a byte order mark: write UTF-8 without one"),
            (r#"{"actions":[{"id":3}]}"#, "an action without `action`"),
            (r#"{"actions":[{"id":3,"action":[0,1],"action":[0,1]}]}"#, "an action with a key that is there twice"),
            (r#"{"actions":[]}"#, "not one action for each world"),
            (r#"{"actions":[{"id":4,"action":[0,1]}]}"#, "not one action for each world"),
            (r#"{"actions":[{"id":3,"action":[0]}]}"#, "not two numbers for each pedestrian"),
        ] {
            assert_eq!(read(line), Err(Fault::Answer(reason)), "{line}");
        }
        for (action, kind) in [("[0,null]", "a list with null"), (r#""0""#, "a text"), ("3", "another number")] {
            let said = read(&format!(r#"{{"actions":[{{"id":3,"action":{action}}}]}}"#)).unwrap_err().to_string();
            assert_eq!(said, format!("gave a wrong answer: `action` is {kind}; give a list of numbers"));
        }
        assert_eq!(read("walk").unwrap_err().to_string(), "gave a wrong answer: not JSON: `walk`");
        let said = read(r#"{"actions":[{"id":3,"action":[0, 1e999]}]}"#).unwrap_err().to_string();
        assert_eq!(said, "gave a wrong answer: `action` is 1e999, and the largest number is about 1.8e308");
    }

    #[test]
    fn a_greeting_names_this_protocol() {
        assert_eq!(read_greeting(br#"{"protocol":"falsify-pedestrian/1","name":"mine"}"#), Ok(()));
        assert_eq!(read_greeting(b"{}"), Err(Fault::Greeting("an object without `protocol`")));
        let other = Err(Fault::Greeting("another protocol than falsify-pedestrian/1"));
        assert_eq!(read_greeting(br#"{"protocol":"falsify-av/1"}"#), other);
    }
}

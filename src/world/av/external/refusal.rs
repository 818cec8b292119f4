//! What is wrong with a line that is not the message it should be.

use std::fmt::{self, Formatter};
use std::marker::PhantomData;

use serde::de::value::MapAccessDeserializer;
use serde::de::{Deserialize, Deserializer, MapAccess, Visitor};
use serde_json::{Map, Value};

use crate::av::{Fault, Word};
use base::printable::printable;
use base::suggest::nearest;

/// The number of bytes of a wrong answer that are shown.
const SHOWN: usize = 200;

/// A key of a message: its name, what its value must be, and whether a value is that.
pub type KeyOf = (&'static str, &'static str, fn(&Value) -> bool);

/// The key of an action that says which world it is for.
pub const ID: KeyOf =
    ("id", "the id of a world, a whole number", |value| value.as_u64().is_some_and(|id| u32::try_from(id).is_ok()));

/// A message that is an object: a list of its values without their keys is refused.
pub struct Keyed<T>(pub T);

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Keyed<T> {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        from.deserialize_map(Object(PhantomData)).map(Self)
    }
}

struct Object<T>(PhantomData<T>);

impl<'de, T: Deserialize<'de>> Visitor<'de> for Object<T> {
    type Value = T;

    fn expecting(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str("an object")
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<T, A::Error> {
        T::deserialize(MapAccessDeserializer::new(map))
    }
}

/// What is wrong with a line that is not a greeting with these keys, of which the first must be there.
pub fn greeting_refusal(line: &[u8], keys: &[KeyOf]) -> Fault {
    let value = match serde_json::from_slice::<Value>(line) {
        Ok(value) => value,
        Err(error) => return not_json(line, &error, true),
    };
    let Some(greeting) = value.as_object() else { return Fault::Greeting("JSON, and not an object") };
    let missing = keys.first().is_some_and(|(first, ..)| !greeting.contains_key(*first));
    match wrong_type(greeting, keys, true) {
        Some(fault) => fault,
        None if missing => Fault::Greeting("an object without `protocol`"),
        None => Fault::Greeting("an object with a key that is there twice"),
    }
}

/// What is wrong with a line that is not an answer of actions with these keys.
pub fn answer_refusal(line: &[u8], keys: &[KeyOf]) -> Fault {
    let value = match serde_json::from_slice::<Value>(line) {
        Ok(value) => value,
        Err(error) => return not_json(line, &error, false),
    };
    let Some(actions) = value.get("actions") else { return Fault::Answer("JSON, and not an object with `actions`") };
    let Some(actions) = actions.as_array() else {
        return Fault::WrongType { greeting: false, key: "actions", found: kind(actions), wanted: "a list" };
    };
    for action in actions {
        let Some(action) = action.as_object() else { return Fault::Answer("an action that is not an object") };
        if let Some(fault) = wrong_type(action, keys, false) {
            return fault;
        }
        if !action.contains_key(ID.0) {
            return Fault::Answer("an action without `id`");
        }
        if keys.iter().any(|(key, ..)| *key == "action") && !action.contains_key("action") {
            return Fault::Answer("an action without `action`");
        }
    }
    Fault::Answer("an action with a key that is there twice")
}

/// The first key whose value has a wrong type.
fn wrong_type(object: &Map<String, Value>, keys: &[KeyOf], greeting: bool) -> Option<Fault> {
    keys.iter().find_map(|(key, wanted, fits)| {
        let value = object.get(*key).filter(|value| !fits(value))?;
        Some(Fault::WrongType { greeting, key, found: kind(value), wanted })
    })
}

/// The type of a value, in words.
fn kind(value: &Value) -> &'static str {
    match value {
        Value::Null => "null",
        Value::Bool(_) => "true or false",
        Value::Number(number) if number.is_f64() => "a decimal number",
        Value::Number(_) => "another number",
        Value::String(_) => "a text",
        Value::Array(list) if list.iter().any(Value::is_null) => "a list with null",
        Value::Array(list) if !list.iter().all(Value::is_number) => "a list with other values than numbers",
        Value::Array(_) => "a list",
        Value::Object(_) => "an object",
    }
}

/// Why a line is not JSON: its encoding, or a number that no `f64` holds.
fn not_json(line: &[u8], error: &serde_json::Error, greeting: bool) -> Fault {
    let why = match line {
        [0xef, 0xbb, 0xbf, ..] => "it begins with a byte order mark: write UTF-8 without one",
        [0xff, 0xfe, ..] | [0xfe, 0xff, ..] | [_, 0, ..] | [0, _, ..] => "it is UTF-16: write UTF-8",
        _ if [&b"NaN"[..], b"Infinity"].iter().any(|word| line.windows(word.len()).any(|part| part == *word)) => {
            "JSON has no NaN and no Infinity: give finite numbers (`json.dumps` of Python writes them)"
        }
        _ if error.to_string().starts_with("number out of range") => {
            let (key, number) = number_before(line, error.column());
            return Fault::TooLarge { greeting, key: Word::new(key), number: Word::new(number) };
        }
        [] => "an empty line",
        _ => return Fault::NotJson { greeting, text: Word::new(line.trim_ascii_end()) },
    };
    if greeting { Fault::Greeting(why) } else { Fault::Answer(why) }
}

/// The number in a line that ends about here (bytes), and the key before it.
fn number_before(line: &[u8], end: usize) -> (&[u8], &[u8]) {
    let is_part = |byte: &u8| matches!(byte, b'0'..=b'9' | b'+' | b'-' | b'.' | b'e' | b'E');
    let last = line[..end.min(line.len())].iter().rposition(is_part).unwrap_or(0);
    let first = line[..last].iter().rposition(|byte| !is_part(byte)).map_or(0, |place| place + 1);
    let after = line[first..].iter().position(|byte| !is_part(byte)).map_or(line.len(), |length| first + length);
    let key = line[..first].rsplit(|byte| *byte == b'"').nth(1).unwrap_or_default();
    (key, &line[first..after])
}

/// What a greeting says, without what is ignored.
pub(super) fn known(line: &[u8], keys: &[KeyOf]) -> String {
    let greeting: Map<String, Value> = serde_json::from_slice(line).unwrap_or_default();
    keys.iter().filter_map(|(key, ..)| Some(format!("{key}: {}\n", greeting.get(*key)?))).collect()
}

/// The first key of a greeting that is none of these, in words; the user is warned of it, with the nearest known key.
pub(super) fn unknown_key(line: &[u8], keys: &[KeyOf]) -> Option<String> {
    let greeting: Map<String, Value> = serde_json::from_slice(line).ok()?;
    let known = || keys.iter().map(|(key, ..)| *key);
    let unknown = greeting.keys().find(|key| known().all(|other| other != key.as_str()))?;
    let help = match nearest(unknown, known()) {
        Some(near) => format!("did you mean `{near}`?"),
        None => format!("known are `{}`", known().collect::<Vec<_>>().join("`, `")),
    };
    Some(format!("its greeting has a key {}, which is unknown and ignored; {help}", shown(unknown.as_bytes())))
}

/// The start of an answer, in printable characters.
pub(super) fn shown(said: &[u8]) -> String {
    let text = String::from_utf8_lossy(&said[..said.len().min(SHOWN)]).replace(char::is_control, " ");
    let dots = if said.len() > SHOWN { "…" } else { "" };
    format!("`{}{dots}`", printable(&text))
}

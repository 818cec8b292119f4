//! CARLA: a client script in Python that sets the actors tick by tick, or leaves the ego to CARLA's agent.
//!
//! # Source
//! CARLA 0.9.16: the stubs `libcarla.pyi` of its client package, and `agents/navigation/behavior_agent.py`. No script has run with a server.

use serde_json::{Value, json};

use super::episode::{Actor, Shape};
use super::format::{EgoDriver, ExportFile, Exporter, Variant, Walking};
use super::{Episode, ExportError, opendrive};

const NAME: &str = "carla";
/// The script; the episode takes the place of an empty one.
const SCRIPT: &str = include_str!("carla_client.py");
const EMPTY: &str = "json.loads(\"{}\")";

pub(super) const CARLA: Exporter = Exporter {
    name: NAME,
    about: "a Python script for CARLA's client, with the OpenDRIVE map; with an ego of the user, CARLA's agent drives it",
    approximates: "not run with a server; CARLA's models have sizes of their own; a world made from OpenDRIVE has no obstacles; places to 1e-4 m",
    holds: |_| true,
    files,
    ..Exporter::RECORDED
};

fn files(episode: &Episode<'_>, variant: Variant) -> Result<Vec<ExportFile>, ExportError> {
    if variant.ego == EgoDriver::User {
        episode.without_lights(NAME)?;
        episode.without_friction(NAME)?;
    }
    let release = match variant.walking {
        Walking::Recorded => None,
        Walking::Released => {
            let (tick, [x, y, _]) = episode.release(NAME, |at| [at.pose.x, at.pose.y, at.ground])?;
            Some((tick, libm::hypot(x, y)))
        }
    };
    let map = opendrive::map_file(&episode.scenario.town)?;
    let actors = episode.actors();
    let velocity = actors[0].track[0].velocity;
    let content = json!({
        "name": episode.name,
        "summary": episode.summary(),
        "map": map.name,
        "dt": episode.dt(),
        "ego": if variant.ego == EgoDriver::User { "agent" } else { "recorded" },
        "ego_velocity": [short(velocity.x), short(velocity.y)],
        "pedestrian": episode.main_pedestrian(),
        "release": release.map(|(tick, distance)| json!([tick, short(distance)])),
        "touch": match episode.outcome.is_collision() {
            true => format!("{:.2} s", episode.ticks() as f64 * episode.dt()),
            false => "none".to_owned(),
        },
        "actors": actors.iter().map(actor).collect::<Vec<_>>(),
    });
    // A JSON string is a literal of Python, too.
    let literal = format!("json.loads({})", Value::String(content.to_string()));
    let script = SCRIPT.replacen(EMPTY, &literal, 1);
    let script = ExportFile { name: format!("{}.carla.py", episode.stem()), bytes: script.into_bytes() };
    Ok(vec![script, map])
}

/// A number with at most four decimals.
fn short(number: f64) -> f64 {
    (number * 1e4).round() / 1e4
}

fn actor(actor: &Actor) -> Value {
    let (kind, blueprint, is_box) = match actor.shape {
        Shape::Vehicle(_) => ("vehicle", "vehicle.tesla.model3", true),
        Shape::Pedestrian(body) => ("pedestrian", "walker.pedestrian.0001", body.target_box.is_some()),
    };
    let state = |at: &super::episode::Motion| {
        json!([short(at.pose.x), short(at.pose.y), short(at.ground), (at.heading * 1e6).round() / 1e6])
    };
    json!({
        "name": actor.name,
        "kind": kind,
        "blueprint": blueprint,
        "shape": if is_box { "box" } else { "disc" },
        "size": actor.size().map(short),
        "track": actor.track.iter().map(state).collect::<Vec<_>>(),
    })
}

//! The parts of a file that have no effect here, counted by what they are.

use roxmltree::Node;

use super::attributes::{Context, Counted, children};
use super::obstacles::is_obstacle;
use super::{signals, traffic_lights};
use crate::{GiveWay, LaneKind};

/// The names of signal types that maps of CARLA, esmini and SUMO have.
///
/// # Source
/// The catalogue of OpenDRIVE 1.4, appendix "Signal types"; the numbers below 1000 are those of the German road traffic regulations.
const SIGNALS: [(&str, &str); 14] = [
    ("274", "speed limit without a number"),
    ("294", "stop line"),
    ("301", "sign of priority at the next junction"),
    ("306", "sign of a priority road"),
    ("1000001", "traffic light that is switched off"),
    ("1000002", "light for pedestrians"),
    ("1000003", "crosswalk marking"),
    ("1000007", "light for pedestrians and bicycles"),
    ("1000008", "yellow flashing light"),
    ("1000009", "traffic light that is switched off"),
    ("1000010", "traffic light that is switched off"),
    ("1000011", "traffic light that is switched off"),
    ("1000013", "light for bicycles"),
    ("1000014", "light for trams"),
];

/// Types of lanes for cars, in lower case, on which no car drives here: CARLA's cars do not, and one for both directions has none of its own.
const NOT_DRIVEN: [&str; 9] =
    ["bidirectional", "entry", "exit", "mwyentry", "mwyexit", "onramp", "offramp", "connectingramp", "sliplane"];

/// Counts everything that has no effect.
pub(super) fn note(context: &mut Context, root: Node) {
    let by_signs = context.only_signs_limit;
    for node in root.descendants().filter(Node::is_element) {
        if is_not_driven(node) {
            let kind = node.attribute("type").unwrap_or_default();
            context.count(node, Counted::NotDriven, format!("lane of type {kind}"));
        } else if let Some(what) = unused(node, by_signs) {
            context.not_used(node, what);
        }
    }
}

/// Whether an element is a lane for cars on which no car drives here.
fn is_not_driven(node: Node) -> bool {
    let beside = node.parent_element().is_some_and(|side| matches!(side.tag_name().name(), "left" | "right"));
    let kind = || node.attribute("type").unwrap_or_default().to_ascii_lowercase();
    beside && node.tag_name().name() == "lane" && NOT_DRIVEN.contains(&kind().as_str())
}

/// What an element is, if it has no effect; `by_signs` if limits have none.
fn unused(node: Node, by_signs: bool) -> Option<String> {
    let parent = node.parent_element().map_or("", |parent| parent.tag_name().name());
    let changes = |names: &[&str]| {
        let number = |name: &&str| node.attribute(*name).and_then(|text| text.trim().parse::<f64>().ok());
        names.iter().filter_map(number).any(|number| number != 0.0)
    };
    let has_number = |name: &str| node.attribute(name).is_some_and(|text| text.trim().parse::<f64>().is_ok());
    let fixed = |what: &str| Some(what.to_owned());
    match (parent, node.tag_name().name()) {
        ("signals", "signal") if signals::limit(node).is_none() && !traffic_lights::is_light(node) => {
            let kind = node.attribute("type").unwrap_or("none");
            if GiveWay::of_signal(kind).is_some() || kind == signals::BUS_STOP {
                return None;
            }
            let name = SIGNALS.iter().find(|(number, _)| *number == kind);
            Some(
                name.map_or_else(
                    || format!("signal of type {kind}"),
                    |(_, name)| format!("{name} (signal type {kind})"),
                ),
            )
        }
        ("objects", "object") if signals::limit(node).is_none() && !is_crosswalk(node) && !is_obstacle(node) => {
            let kind = node.attribute("type").filter(|kind| !matches!(*kind, "-1" | "" | "none"));
            Some(kind.map_or_else(|| "object of no type".to_owned(), |kind| format!("object of type {kind}")))
        }
        ("objects", "objectReference") => fixed("object of another road (objectReference)"),
        ("objects", "bridge") => fixed("bridge"),
        ("objects", "tunnel") => fixed("tunnel"),
        ("left" | "right", "lane") => {
            let kind = node.attribute("type")?;
            let lost = LaneKind::from_opendrive(kind) == LaneKind::None && !kind.eq_ignore_ascii_case("none");
            lost.then(|| format!("lane of type {kind}"))
        }
        ("lane", "height") if changes(&["inner", "outer"]) => fixed("height of a lane"),
        ("lane", "speed") if by_signs && has_number("max") => fixed("speed limit of a lane, since CARLA's signs count"),
        ("type", "speed") if by_signs && has_number("max") => {
            fixed("speed limit of a road type, since CARLA's signs count")
        }
        ("lateralProfile", "superelevation") if changes(&["a", "b", "c", "d"]) => fixed("superelevation"),
        ("lateralProfile", "crossfall") if changes(&["a", "b", "c", "d"]) => fixed("crossfall"),
        ("lateralProfile", "shape") if changes(&["a", "b", "c", "d"]) => fixed("lateral shape"),
        ("surface", "CRG") => fixed("road surface (CRG)"),
        ("OpenDRIVE", "junction") if node.attribute("type") == Some("virtual") => {
            let has = |name| children(node, name).next().is_some();
            (has("connection") || !has("crossPath")).then(|| "virtual junction".to_owned())
        }
        ("OpenDRIVE", "station") => fixed("station"),
        _ => None,
    }
}

pub(super) fn is_crosswalk(object: Node) -> bool {
    let named = |key: &str| object.attribute(key).is_some_and(|value| value.to_ascii_lowercase().contains("crosswalk"));
    named("type") || named("name")
}

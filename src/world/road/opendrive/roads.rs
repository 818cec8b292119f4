use std::collections::BTreeMap;

use roxmltree::Node;

use super::attributes::{Context, child, children};
use super::budget::MAX_LENGTH;
use super::{OpenDriveProblem, lanes, limits, plan_view};
use crate::road::{Cubic, JunctionIndex, Profile, Road, RoadEnd, RoadIndex, RoadLink};

/// The roads of a file, with the elements they come from.
pub(super) struct Roads<'a, 'x> {
    pub roads: Vec<Road>,
    pub nodes: Vec<Node<'a, 'x>>,
    pub by_id: BTreeMap<&'a str, RoadIndex>,
}

/// Reads all usable roads, without their links.
pub(super) fn read<'a, 'x: 'a>(context: &mut Context, root: Node<'a, 'x>) -> Roads<'a, 'x> {
    let mut found = Roads { roads: Vec::new(), nodes: Vec::new(), by_id: BTreeMap::new() };
    for node in children(root, "road") {
        let id = node.attribute("id").unwrap_or_default();
        context.road = Some(id.to_owned());
        if found.by_id.contains_key(id) {
            context.warn(node, OpenDriveProblem::Duplicate { element: "road", id: id.to_owned() });
            continue;
        }
        let Some(mut road) = road(context, node) else { continue };
        road.id = number_of(context, node, id, found.roads.len());
        found.by_id.insert(id, RoadIndex(found.roads.len() as u32));
        found.roads.push(road);
        found.nodes.push(node);
    }
    context.road = None;
    found
}

/// The number that is used for an `id`, which may be any text.
pub(super) fn number_of(context: &mut Context, node: Node, id: &str, place: usize) -> u32 {
    id.trim().parse().unwrap_or_else(|_| {
        let given = place as u32;
        context.warn(node, OpenDriveProblem::IdNotNumber { id: id.to_owned(), given });
        given
    })
}

fn road(context: &mut Context, node: Node) -> Option<Road> {
    let plan_view = plan_view::read(context, node);
    let Some(last) = plan_view.pieces().last() else {
        context.warn(node, OpenDriveProblem::NoReferenceLine);
        return None;
    };
    let drawn = last.s + last.length;
    let length = context.optional(node, "length").filter(|length| *length > 0.0).unwrap_or(drawn);
    if !(length > 0.0 && length <= MAX_LENGTH) {
        context.warn(node, OpenDriveProblem::NoReferenceLine);
        return None;
    }
    let lanes = child(node, "lanes");
    let types = limits::of_types(context, node);
    let sections = lanes.map(|lanes| lanes::sections(context, lanes, length, &types)).unwrap_or_default();
    if sections.is_empty() {
        context.warn(node, OpenDriveProblem::NoLaneSection);
        return None;
    }
    Some(Road {
        id: 0,
        name: node.attribute("name").unwrap_or_default().to_owned(),
        length,
        junction: None,
        left_hand: node.attribute("rule").is_some_and(|rule| rule.trim().eq_ignore_ascii_case("LHT")),
        plan_view: plan_view.with_elevation(elevation(context, node)),
        lane_offset: lanes.map_or_else(|| Profile::constant(0.0), |lanes| lanes::offset(context, lanes)),
        sections,
        predecessor: None,
        successor: None,
    })
}

/// Reads the height of a road; empty if it is level at 0.
fn elevation(context: &mut Context, road: Node) -> Profile {
    let profiles = child(road, "elevationProfile");
    let cubics = profiles.into_iter().flat_map(|profile| children(profile, "elevation"));
    let cubics: Vec<Cubic> = cubics.map(|node| lanes::cubic(context, node, "s", 0.0)).collect();
    let level = cubics.iter().all(|cubic| [cubic.a, cubic.b, cubic.c, cubic.d].iter().all(|number| *number == 0.0));
    if level { Profile::default() } else { Profile::new(cubics) }
}

impl Roads<'_, '_> {
    /// Resolves the links of the roads, and the junctions they lie in.
    ///
    /// # Source
    /// CARLA `road/MapBuilder.cpp`, `GetLaneNext`: a link leads to the road of that number if there is one, and to the junction
    /// otherwise, whatever its `elementType`.
    pub fn link(&mut self, context: &mut Context, junctions: &BTreeMap<&str, JunctionIndex>) {
        for (road, node) in self.roads.iter_mut().zip(&self.nodes) {
            context.road = node.attribute("id").map(str::to_owned);
            road.junction = node.attribute("junction").and_then(|id| junctions.get(id).copied());
            let Some(link) = child(*node, "link") else { continue };
            let mut resolve = |name, default| {
                let node = child(link, name)?;
                let id = node.attribute("elementId").unwrap_or_default();
                let end = contact(node).unwrap_or(default);
                let road = self.by_id.get(id).map(|road| RoadLink::Road(*road, end));
                let found = road.or_else(|| junctions.get(id).copied().map(RoadLink::Junction));
                let (wanted, other) = match (node.attribute("elementType"), found) {
                    (Some("junction"), Some(RoadLink::Road(..))) => ("junction", "road"),
                    (Some("road"), Some(RoadLink::Junction(_))) => ("road", "junction"),
                    _ => ("", ""),
                };
                if wanted != other {
                    let id = id.to_owned();
                    context.warn(node, OpenDriveProblem::AmbiguousLink { element: name, wanted, found: other, id });
                }
                if found.is_none() {
                    context
                        .warn(node, OpenDriveProblem::UnknownReference { element: name.to_owned(), id: id.to_owned() });
                }
                found
            };
            road.predecessor = resolve("predecessor", RoadEnd::End);
            road.successor = resolve("successor", RoadEnd::Start);
        }
        context.road = None;
    }
}

/// The end of a road that an element names.
pub(super) fn contact(node: Node) -> Option<RoadEnd> {
    match node.attribute("contactPoint")? {
        "start" => Some(RoadEnd::Start),
        "end" => Some(RoadEnd::End),
        _ => None,
    }
}

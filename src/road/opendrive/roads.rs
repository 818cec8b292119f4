use std::collections::{BTreeMap, BTreeSet};

use roxmltree::Node;

use super::attributes::{Context, ROUNDED, child, children, metres};
use super::budget::MAX_LENGTH;
use super::{OpenDriveProblem, lanes, limits, plan_view};
use crate::geometry::wrap_angle;
use crate::{
    Cubic, Geometry, JunctionIndex, Lane, LaneKind, LaneSection, PlanView, Profile, Road, RoadEnd, RoadIndex, RoadLink,
};

/// A reference line that turns by more (rad) between two geometries has a kink: polylines of bends turn by less.
const KINK: f64 = 0.5;

/// Over this distance to both sides a bend is measured (m).
const NEAR: f64 = 0.05;

/// The roads of a file, with the elements they come from.
pub(super) struct Roads<'a, 'x> {
    pub roads: Vec<Road>,
    pub nodes: Vec<Node<'a, 'x>>,
    pub by_id: BTreeMap<&'a str, RoadIndex>,
}

/// Reads all usable roads, without their links.
pub(super) fn read<'a, 'x: 'a>(context: &mut Context, root: Node<'a, 'x>) -> Roads<'a, 'x> {
    let mut found = Roads { roads: Vec::new(), nodes: Vec::new(), by_id: BTreeMap::new() };
    let numbers = numbers(children(root, "road").map(id_of));
    for node in children(root, "road") {
        let id = id_of(node);
        context.road = Some(id.to_owned());
        if found.by_id.contains_key(id) {
            context.warn(node, OpenDriveProblem::Duplicate { element: "road", id: id.to_owned() });
            continue;
        }
        let Some(mut road) = road(context, node) else { continue };
        road.id = number_of(context, node, id, &numbers);
        found.by_id.insert(id, RoadIndex(found.roads.len() as u32));
        found.roads.push(road);
        found.nodes.push(node);
    }
    context.road = None;
    found
}

/// The `id` of an element; empty if it has none.
pub(super) fn id_of<'a>(node: Node<'a, '_>) -> &'a str {
    node.attribute("id").unwrap_or_default()
}

/// The number that is used for each `id`, which may be any text: the number that it is, or else a free one.
pub(super) fn numbers<'a>(ids: impl Iterator<Item = &'a str>) -> BTreeMap<&'a str, u32> {
    let ids: Vec<&str> = ids.collect();
    let (mut found, mut taken) = (BTreeMap::new(), BTreeSet::new());
    // An id that is written as a number is comes before others of that value, such as `01`.
    for as_written in [true, false] {
        for id in
            ids.iter().copied().filter(|id| id.trim().parse().is_ok_and(|n: u32| (n.to_string() == **id) == as_written))
        {
            let number = id.trim().parse().ok();
            if let Some(number) = number.filter(|number| !found.contains_key(id) && taken.insert(*number)) {
                found.insert(id, number);
            }
        }
    }
    let mut free = (0..).filter(|number| !taken.contains(number));
    for id in ids {
        found.entry(id).or_insert_with(|| free.next().unwrap_or(u32::MAX));
    }
    found
}

/// The number that is used for an `id`, with a warning if it is another one than the file gives.
pub(super) fn number_of(context: &mut Context, node: Node, id: &str, numbers: &BTreeMap<&str, u32>) -> u32 {
    let given = numbers.get(id).copied().unwrap_or_default();
    if id.trim().parse() != Ok(given) {
        context.warn(node, OpenDriveProblem::IdNotNumber { id: id.to_owned(), given });
    }
    given
}

fn road(context: &mut Context, node: Node) -> Option<Road> {
    let plan_view = plan_view::read(context, node);
    let Some(last) = plan_view.pieces().last() else {
        context.warn(node, OpenDriveProblem::NoReferenceLine);
        return None;
    };
    let drawn = last.s + last.length;
    let gaps = gaps(context, node, &plan_view);
    let stated = context.number(node, "length");
    if stated.is_some_and(|length| length <= 0.0) {
        context.bad(node, "length", node.attribute("length").unwrap_or_default());
    }
    let mut length = stated.filter(|length| *length > 0.0).unwrap_or(drawn);
    if (length - drawn).abs() > ROUNDED {
        let (length, drawn) = (metres(length), metres(drawn));
        context.warn(node, OpenDriveProblem::OtherLength { length, drawn });
    }
    if length > drawn + ROUNDED {
        length = drawn;
    }
    if !(length > 0.0 && length <= MAX_LENGTH) {
        context.warn(node, OpenDriveProblem::NoReferenceLine);
        return None;
    }
    let lanes = child(node, "lanes");
    let types = limits::of_types(context, node);
    let sections = lanes.map(|lanes| lanes::sections(context, lanes, length, &types)).unwrap_or_default();
    let sections = gaps.into_iter().fold(sections, cut);
    if sections.is_empty() {
        context.warn(node, OpenDriveProblem::NoLaneSection);
        return None;
    }
    let road = Road {
        id: 0,
        name: node.attribute("name").unwrap_or_default().to_owned(),
        length,
        junction: None,
        left_hand: is_left_hand(context, node),
        plan_view: plan_view.with_elevation(elevation(context, node)),
        lane_offset: lanes.map_or_else(|| Profile::constant(0.0), |lanes| lanes::offset(context, lanes)),
        sections,
        predecessor: None,
        successor: None,
    };
    if let Some(bend) = tight_bend(&road) {
        context.warn(node, bend);
    }
    Some(road)
}

/// The first bend whose centre is nearer to the reference line than the centre of a lane for cars is; that lane turns back there.
fn tight_bend(road: &Road) -> Option<OpenDriveProblem> {
    let places = road.plan_view.pieces().iter().flat_map(|piece| [0.0, 0.5, 1.0].map(|part| (piece, part)));
    places.into_iter().find_map(|(piece, part)| {
        let along = part * piece.length;
        let (from, to) = ((along - NEAR).max(0.0), (along + NEAR).min(piece.length));
        let curvature = wrap_angle(piece.pose(to).yaw - piece.pose(from).yaw) / (to - from);
        let s = piece.s + along;
        road.sections_at(s).find_map(|section| {
            let driving = road.sections[section].lanes.iter().filter(|lane| lane.kind == LaneKind::Driving);
            let inside = |lane: &Lane| Some((lane.id, road.lane_centre(section, lane.id, s)?.0));
            let (lane, _) = driving.filter_map(inside).find(|(_, beside)| curvature * beside > 1.0)?;
            Some(OpenDriveProblem::TightBend { at: metres(s), radius: metres(1.0 / curvature.abs()), lane })
        })
    })
}

/// Whether traffic on a road keeps to the left; to the right without a `rule`.
fn is_left_hand(context: &mut Context, road: Node) -> bool {
    let rule = road.attribute("rule").map_or("RHT", str::trim);
    let is_left = rule.eq_ignore_ascii_case("LHT");
    if !is_left && !rule.eq_ignore_ascii_case("RHT") {
        context.unknown(road, "rule", rule, "traffic keeps to the right, as by `RHT`");
    }
    is_left
}

/// Finds the parts of a road that no geometry draws (m), and names them, the parts that two draw, the places at which the line leaps, and its sharpest kink.
///
/// # Source
/// ASAM OpenDRIVE 1.8, section 9.2: geometries follow each other in ascending order, without leaps or kinks; each begins where the one before ends.
fn gaps(context: &mut Context, road: Node, plan_view: &PlanView) -> Vec<(f64, f64)> {
    let (mut drawn, mut before, mut gaps): (f64, Option<&Geometry>, _) = (0.0, None, Vec::new());
    let mut sharpest = (KINK, 0.0);
    for piece in plan_view.pieces() {
        if piece.s > drawn + ROUNDED {
            context.warn(road, OpenDriveProblem::Gap { from: metres(drawn), to: metres(piece.s) });
            gaps.push((drawn, piece.s));
        } else if let Some(before) = before {
            let end = before.pose(piece.s - before.s);
            let apart = (end.position() - piece.start.position()).norm();
            let turned = wrap_angle(piece.start.yaw - end.yaw).abs();
            if turned > sharpest.0 && apart <= ROUNDED {
                sharpest = (turned, piece.s);
            }
            if piece.s < drawn - ROUNDED {
                context.warn(road, OpenDriveProblem::Overlap { from: metres(piece.s), to: metres(drawn) });
            }
            if apart > ROUNDED {
                context.warn(road, OpenDriveProblem::Leap { apart: metres(apart), at: metres(piece.s) });
            }
        }
        (drawn, before) = (drawn.max(piece.s + piece.length), Some(piece));
    }
    let (turned, at) = sharpest;
    if turned > KINK {
        let degrees = turned.to_degrees().round() as u32;
        context.warn(road, OpenDriveProblem::Kink { degrees, at: metres(at) });
    }
    gaps
}

/// Takes the lanes away between two places (m).
fn cut(sections: Vec<LaneSection>, (from, to): (f64, f64)) -> Vec<LaneSection> {
    let parts = |LaneSection { start, end, lanes }: LaneSection| {
        let parts = [
            (start, end.min(from), lanes.clone()),
            (start.max(from), end.min(to), Vec::new()),
            (start.max(to), end, lanes),
        ];
        let sections = parts.map(|(start, end, lanes)| LaneSection { start, end, lanes });
        sections.into_iter().filter(|section| section.end > section.start)
    };
    sections.into_iter().flat_map(parts).collect()
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

use roxmltree::Node;

use super::OpenDriveProblem;
use super::attributes::{Context, child, children};
use super::placed::{Placed, placed};
use super::roads::Roads;
use super::signals::BESIDE;
use super::unused::is_crosswalk;
use crate::geometry::{Point, Pose, Vector, polygon};
use crate::lane_index::{LaneIndex, Lanes};
use crate::lane_network::LaneNetwork;
use crate::{Crosswalk, Lane, LaneFilter, LaneKind, Road};

/// The least length and width of a crosswalk without an outline (m); a smaller object of that name is a sign or a lamp.
const MIN_SIDE: f64 = 1.0;

/// Maximum number of crosswalks of one `repeat`.
const MAX_REPEATED: f64 = 1000.0;

/// Reads crosswalks: objects of that type or name, whose outlines give corners in the object's own frame or along the road. Without an outline
/// one is a box, with its length along its heading. Repeated ones are at the places of their `repeat` alone.
///
/// # Source
/// OpenDRIVE 1.4 and later, `objects/object/outline` with `cornerLocal` (u, v) or `cornerRoad` (s, t), or `length` and `width`; `repeat`, whose
/// values overrule those of the object.
///
/// Those of `crossPath` follow; one that such an object marks is there once.
pub(super) fn crosswalks(
    context: &mut Context,
    roads: &Roads,
    network: &LaneNetwork,
    cross_paths: Vec<Crosswalk>,
) -> Vec<Crosswalk> {
    let mut found: Vec<Crosswalk> = Vec::new();
    let (index, lanes) = (LaneIndex::default(), Lanes { roads: &roads.roads, network });
    for object in placed(context, roads, network, ["objects", "object"], is_crosswalk) {
        let road = &roads.roads[object.road.0 as usize];
        let before = found.len();
        for (s, t) in places(context, &object) {
            let ground = road.plan_view.elevation().value(s);
            let corners = polygons(context, object.node, road, (s, t)).into_iter();
            found.extend(corners.map(|corners| Crosswalk { corners, ground }));
        }
        context.road = roads.nodes[object.road.0 as usize].attribute("id").map(str::to_owned);
        for corners in &found[before..] {
            let middle = middle(corners);
            let near = index.nearest(lanes, middle, LaneFilter::Driving);
            let lane = near.and_then(|near| Some((network.lane(network.slot(near)?), near.s)));
            let apart = lane.map(|(lane, s)| (network.pose(&roads.roads, lane, s).position() - middle).norm());
            if let Some(apart) = apart.filter(|apart| *apart > BESIDE) {
                context.warn(object.node, OpenDriveProblem::CrosswalkAside { apart: apart as u32 });
            }
        }
        context.road = None;
        if found.len() == before {
            context.not_used(object.node, "crosswalk without an outline, or less than 1 m long or wide".to_owned());
        }
    }
    let is_marked = |corners: &Crosswalk| found.iter().any(|marked| polygon::contains(marked, middle(corners)));
    let unmarked: Vec<_> = cross_paths.into_iter().filter(|corners| !is_marked(corners)).collect();
    found.extend(unmarked);
    found
}

/// The mean of the corners.
fn middle(corners: &[Point]) -> Point {
    (corners.iter().map(|corner| corner.coords).sum::<Vector>() / corners.len() as f64).into()
}

/// Reads the crosswalks that junctions have as roads for walking. The lanes of such a road are a crosswalk, and no sidewalk.
///
/// # Source
/// ASAM OpenDRIVE 1.8, `junction/crossPath`, in all types of junctions: `startLaneLink` and `endLaneLink` name the lanes that it connects.
pub(super) fn cross_paths(context: &mut Context, root: Node, roads: &mut Roads) -> Vec<Crosswalk> {
    let (mut found, mut crossing) = (Vec::new(), Vec::new());
    for node in children(root, "junction").flat_map(|junction| children(junction, "crossPath")) {
        let id = node.attribute("crossingRoad").unwrap_or_default();
        let Some(index) = roads.by_id.get(id) else {
            let (element, id) = ("crossPath".to_owned(), id.to_owned());
            context.warn(node, OpenDriveProblem::UnknownReference { element, id });
            continue;
        };
        let road = &roads.roads[index.0 as usize];
        let (line, middle) = (&road.plan_view, road.length / 2.0);
        let mut beyond = |at, link, begin: Pose| beyond_sidewalk(context, roads, node, (at, link), begin).min(middle);
        let end = line.pose(road.length);
        let back = Pose::new(end.x, end.y, end.yaw + std::f64::consts::PI);
        let from = beyond("roadAtStart", "startLaneLink", line.pose(0.0));
        let to = road.length - beyond("roadAtEnd", "endLaneLink", back);
        let walking = |lane: &&Lane| lane.kind == LaneKind::Sidewalk;
        let edges = road.sections_at(middle).flat_map(|section| {
            let lanes = road.sections[section].lanes.iter().filter(walking);
            lanes.filter_map(move |lane| road.lane_edges(section, lane.id, middle)).flatten()
        });
        let (right, left) = edges.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), t| (low.min(t), high.max(t)));
        if right < left && from < to {
            let corners = [(from, right), (to, right), (to, left), (from, left)];
            let corners = corners.map(|(s, t)| line.pose(s).to_world(Vector::new(0.0, t))).to_vec();
            found.push(Crosswalk { corners, ground: line.elevation().value(middle) });
            crossing.push(*index);
        } else {
            context.not_used(node, "crossPath of a road without a lane of type walking".to_owned());
        }
    }
    for road in crossing {
        let lanes = roads.roads[road.0 as usize].sections.iter_mut().flat_map(|section| &mut section.lanes);
        lanes.filter(|lane| lane.kind == LaneKind::Sidewalk).for_each(|lane| lane.kind = LaneKind::None);
    }
    found
}

/// How far a crossing road leads across the sidewalk at which it begins (m), seen from this pose.
fn beyond_sidewalk(
    context: &mut Context,
    roads: &Roads,
    node: Node,
    (at, link): (&str, &'static str),
    begin: Pose,
) -> f64 {
    let road = node.attribute(at).and_then(|id| roads.by_id.get(id)).map(|index| &roads.roads[index.0 as usize]);
    let Some((road, link)) = road.zip(child(node, link)) else { return 0.0 };
    let (Some(s), Some(id)) = (context.number(link, "s"), context.whole(link, "from")) else { return 0.0 };
    let edges = road.sections_at(s).find_map(|section| {
        let lane = road.sections[section].lane(id).filter(|lane| lane.kind == LaneKind::Sidewalk);
        lane.and_then(|_| road.lane_edges(section, id, s))
    });
    let ahead = |t: f64| begin.to_local(road.plan_view.pose(s).to_world(Vector::new(0.0, t))).x;
    edges.into_iter().flatten().map(ahead).fold(0.0, f64::max)
}

/// The places (s, t) of an object along its road and beside it (m).
fn places(context: &mut Context, object: &Placed) -> Vec<(f64, f64)> {
    let own = context.number_or_zero(object.node, "t");
    let mut found = Vec::new();
    for repeat in children(object.node, "repeat") {
        let [first, length, step] =
            ["s", "length", "distance"].map(|name| context.optional(repeat, name).unwrap_or_default());
        let [from, to] = ["tStart", "tEnd"].map(|name| context.optional(repeat, name).unwrap_or(own));
        let count = if step > 0.0 { (length / step + 1e-9).floor().clamp(0.0, MAX_REPEATED) } else { 0.0 };
        found.extend((0..=count as u32).map(|number| {
            let way = f64::from(number) * step;
            (first + way, if length > 0.0 { from + (to - from) * way / length } else { from })
        }));
    }
    if found.is_empty() { vec![(object.s, own)] } else { found }
}

/// The polygons of a crosswalk at a place (m).
fn polygons(context: &mut Context, node: Node, road: &Road, (s, t): (f64, f64)) -> Vec<Vec<Point>> {
    let mut found = Vec::new();
    let hdg = context.number_or_zero(node, "hdg");
    let line = road.plan_view.pose(s);
    let middle = line.to_world(Vector::new(0.0, t));
    let own = Pose::new(middle.x, middle.y, line.yaw + hdg);
    for outline in node.descendants().filter(|node| node.tag_name().name() == "outline") {
        let mut corners: Vec<Point> = Vec::new();
        for corner in children(outline, "cornerLocal") {
            let (u, v) = (context.number(corner, "u"), context.number(corner, "v"));
            corners.extend(u.zip(v).map(|(u, v)| own.to_world(Vector::new(u, v))));
        }
        for corner in children(outline, "cornerRoad") {
            let (s, t) = (context.number(corner, "s"), context.number(corner, "t"));
            let place = |(s, t): (f64, f64)| road.plan_view.pose(s).to_world(Vector::new(0.0, t));
            corners.extend(s.zip(t).map(place));
        }
        if corners.len() > 2 && corners.iter().all(|corner| corner.coords.iter().all(|x| x.is_finite())) {
            found.push(corners);
        }
    }
    let mut half = |side| context.optional(node, side).filter(|side| *side >= MIN_SIDE).map(|side| side / 2.0);
    match half("length").zip(half("width")) {
        Some((u, v)) if found.is_empty() => {
            let corners = [(-u, -v), (u, -v), (u, v), (-u, v)];
            vec![corners.map(|(u, v)| own.to_world(Vector::new(u, v))).to_vec()]
        }
        _ => found,
    }
}

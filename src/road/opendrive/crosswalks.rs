use roxmltree::Node;

use super::OpenDriveProblem;
use super::attributes::{Context, children};
use super::roads::Roads;
use super::signals::{BESIDE, Placed, placed};
use super::unused::is_crosswalk;
use crate::geometry::{Point, Pose, Vector};
use crate::lane_index::{LaneIndex, Lanes};
use crate::lane_network::LaneNetwork;
use crate::{LaneFilter, Road};

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
pub(super) fn crosswalks(context: &mut Context, roads: &Roads, network: &LaneNetwork) -> Vec<Vec<Point>> {
    let mut found = Vec::new();
    let (index, lanes) = (LaneIndex::default(), Lanes { roads: &roads.roads, network });
    for object in placed(context, roads, network, ["objects", "object"], is_crosswalk) {
        let road = &roads.roads[object.road.0 as usize];
        let before = found.len();
        for (s, t) in places(context, &object) {
            found.extend(polygons(context, object.node, road, (s, t)));
        }
        context.road = roads.nodes[object.road.0 as usize].attribute("id").map(str::to_owned);
        for corners in &found[before..] {
            let middle = corners.iter().map(|corner| corner.coords).sum::<Vector>() / corners.len() as f64;
            let near = index.nearest(lanes, middle.into(), LaneFilter::Driving);
            let lane = near.and_then(|near| Some((network.lane(network.slot(near)?), near.s)));
            let apart = lane.map(|(lane, s)| (network.pose(&roads.roads, lane, s).position().coords - middle).norm());
            if let Some(apart) = apart.filter(|apart| *apart > BESIDE) {
                context.warn(object.node, OpenDriveProblem::CrosswalkAside { apart: apart as u32 });
            }
        }
        context.road = None;
        if found.len() == before {
            context.not_used(object.node, "crosswalk without an outline, or less than 1 m long or wide".to_owned());
        }
    }
    found
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

use super::attributes::{Context, children};
use super::roads::Roads;
use super::signals::placed;
use super::unused::is_crosswalk;
use crate::geometry::{Point, Pose, Vector};
use crate::road::lane_network::LaneNetwork;

/// The least length and width of a crosswalk without an outline (m); a smaller object of that name is a sign or a lamp.
const MIN_SIDE: f64 = 1.0;

/// Reads crosswalks: objects of that type or name, whose outlines give corners in the object's own frame or along the road. Without an outline
/// one is a box, with its length along its heading.
///
/// # Source
/// OpenDRIVE 1.4 and later, `objects/object/outline` with `cornerLocal` (u, v) or `cornerRoad` (s, t), or `length` and `width`.
pub(super) fn crosswalks(context: &mut Context, roads: &Roads, network: &LaneNetwork) -> Vec<Vec<Point>> {
    let mut found = Vec::new();
    for object in placed(context, roads, network, ["objects", "object"], is_crosswalk) {
        let road = &roads.roads[object.road.0 as usize];
        let (t, hdg) = (context.number_or_zero(object.node, "t"), context.number_or_zero(object.node, "hdg"));
        let line = road.plan_view.pose(object.s);
        let middle = line.to_world(Vector::new(0.0, t));
        let own = Pose::new(middle.x, middle.y, line.yaw + hdg);
        let before = found.len();
        for outline in object.node.descendants().filter(|node| node.tag_name().name() == "outline") {
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
        let mut half =
            |side| context.optional(object.node, side).filter(|side| *side >= MIN_SIDE).map(|side| side / 2.0);
        match half("length").zip(half("width")) {
            _ if found.len() > before => {}
            Some((u, v)) => {
                let corners = [(-u, -v), (u, -v), (u, v), (-u, v)];
                found.push(corners.map(|(u, v)| own.to_world(Vector::new(u, v))).to_vec());
            }
            None => context.not_used(object.node, "crosswalk without an outline or a size".to_owned()),
        }
    }
    found
}

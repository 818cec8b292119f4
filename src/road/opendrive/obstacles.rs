//! What `export` adds to a map beyond the standard.

use roxmltree::Node;

use super::attributes::{Context, child, children};
use super::placed::placed;
use super::roads::Roads;
use crate::geometry::{OrientedBox, Pose, Vector};
use crate::lane_network::LaneNetwork;

/// The code of the `userData` that marks an object as an obstacle. Objects of other maps are none, as in CARLA.
pub const OBSTACLE: &str = "falsify.obstacle";

/// The code of the `userData` with the box in which a speed sign takes effect: x, y (m), heading (rad), half length, half width (m).
pub const TRIGGER: &str = "falsify.trigger";

/// Reads the objects that are marked as obstacles: rectangles, whose outlines give four corners in the object's own frame.
pub(super) fn read(context: &mut Context, roads: &Roads, network: &LaneNetwork) -> Vec<OrientedBox> {
    let mut found = Vec::new();
    for object in placed(context, roads, network, ["objects", "object"], is_obstacle) {
        let road = &roads.roads[object.road.0 as usize];
        let (t, heading) = (context.number_or_zero(object.node, "t"), context.number_or_zero(object.node, "hdg"));
        let line = road.plan_view.pose(object.s);
        let middle = line.to_world(Vector::new(0.0, t));
        let own = Pose::new(middle.x, middle.y, line.yaw + heading);
        let corners = object.node.descendants().filter(|node| node.tag_name().name() == "cornerLocal");
        let corners: Vec<Vector> = corners
            .filter_map(|corner| Some(Vector::new(context.number(corner, "u")?, context.number(corner, "v")?)))
            .collect();
        let Some(first) = corners.first() else { continue };
        let (low, high) =
            corners.iter().fold((*first, *first), |(low, high), corner| (low.inf(corner), high.sup(corner)));
        let (centre, half) = (own.to_world((low + high) / 2.0), (high - low) / 2.0);
        if half.x > 0.0 && half.y > 0.0 {
            found.push(OrientedBox { pose: Pose::new(centre.x, centre.y, own.yaw), half });
        }
    }
    found
}

pub(super) fn is_obstacle(object: Node) -> bool {
    children(object, "userData").any(|data| data.attribute("code") == Some(OBSTACLE))
}

/// The box in which a speed sign takes effect, if it is given.
pub(super) fn trigger(sign: Node) -> Option<OrientedBox> {
    let data = child(sign, "userData").filter(|data| data.attribute("code") == Some(TRIGGER))?;
    let numbers =
        data.attribute("value")?.split_whitespace().map(|text| text.parse().ok().filter(|n: &f64| n.abs() < 1e9));
    let [x, y, yaw, length, width] = numbers.collect::<Option<Vec<f64>>>()?.try_into().ok()?;
    (length > 0.0 && width > 0.0).then(|| OrientedBox::new(Pose::new(x, y, yaw), length, width))
}

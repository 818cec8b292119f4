//! Crosswalks as polygons over the carriageway.

use super::{Crosswalk, LaneFilter, LaneKind, Town, Waypoint};
use crate::geometry::{Point, Vector};

/// How far beside the carriageway the middle of a crosswalk may be given (m).
const BESIDE: f64 = 1.0;

/// Why there can be no crosswalk at a place.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum CrosswalkError {
    #[error("no street is there to cross")]
    NoStreet,
    #[error("it lies inside a junction: place it on a street that leads there")]
    InJunction,
}

/// A crosswalk of a width (m, along the street) over the whole carriageway at a place: from the inner edge of one sidewalk to that
/// of the other, at a right angle to the street.
///
/// # Errors
/// When there is no carriageway at the place, or a junction.
pub fn across(town: &Town, at: Point, width: f64) -> Result<Crosswalk, CrosswalkError> {
    let lane = town.nearest_lane(at, LaneFilter::Driving).ok_or(CrosswalkError::NoStreet)?;
    if town.is_junction(lane) {
        return Err(CrosswalkError::InJunction);
    }
    let road = &town.roads[lane.road.0 as usize];
    let line = road.plan_view.pose(lane.s);
    let lanes = &road.sections[lane.section as usize].lanes;
    let kind = |id| lanes.iter().find(|lane| lane.id == id).map(|lane| lane.kind);
    let (mut right, mut left) = (f64::INFINITY, f64::NEG_INFINITY);
    for side in [-1, 1] {
        // Outwards from the middle, up to the first sidewalk.
        let carriageway = (1..)
            .map(|number| side * number)
            .take_while(|id| kind(*id).is_some_and(|kind| !matches!(kind, LaneKind::Sidewalk | LaneKind::None)));
        for id in carriageway {
            for edge in town.lane_edges(Waypoint { lane: id, ..lane }).into_iter().flatten() {
                let aside = line.to_local(edge).y;
                (right, left) = (right.min(aside), left.max(aside));
            }
        }
    }
    let own = line.to_local(at);
    if !(right - BESIDE..=left + BESIDE).contains(&own.y) || own.x.abs() > width {
        return Err(CrosswalkError::NoStreet);
    }
    let half = width / 2.0;
    let corners = [(-half, right), (half, right), (half, left), (-half, left)];
    let corners = corners.map(|(along, aside)| line.to_world(Vector::new(along, aside))).to_vec();
    Ok(Crosswalk { corners, ground: town.elevation(lane) })
}

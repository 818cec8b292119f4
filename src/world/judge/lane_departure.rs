use crate::env::Pair;
use crate::geometry::{Point, Vector};
use crate::road::{Town, Waypoint};
use crate::sim::VehicleState;

/// How long the car was outside its lane in an episode, and whether it left the road.
///
/// The centre of the car counts, not its body: the corners of a car leave the lane in any tight turn. It is inside a lane up to half of the lane's
/// width from the centre line, and 0.1 m more.
///
/// - Outside junctions its lane is the driving lane around it, if that leads the way in which the car heads (within 90°). So a lane beside its own
///   with the same direction is its lane, and the lane of the oncoming traffic is not.
/// - In a junction its lane is any of those that lead on from the lane by which it came: its route is one of them.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LaneDeparture {
    /// Time outside its lane (s), to a tick.
    pub left_lane: f64,
    /// Whether its centre was outside all driving lanes, at the start or later.
    pub left_road: bool,
}

impl LaneDeparture {
    /// Measures an episode; none for a recording from elsewhere, whose roads are unknown.
    pub fn new(pair: &Pair<'_>) -> Option<Self> {
        if !pair.is_on_map() {
            return None;
        }
        let mut watch = Watch {
            town: &pair.scenario().town,
            entered: None,
            checked: Point::origin(),
            room: -1.0,
            place: LanePlace::Inside,
        };
        let mut found = Self::default();
        for (tick, frame) in pair.frames().enumerate() {
            let place = watch.look(&frame.ego);
            found.left_road |= place == LanePlace::OffRoad;
            if tick > 0 && place != LanePlace::Inside {
                found.left_lane += pair.dt();
            }
        }
        Some(found)
    }
}

/// Where the centre of a car is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum LanePlace {
    Inside,
    /// On the road, but not in its lane.
    OutsideLane,
    OffRoad,
}

/// Follows a car along its lanes, and looks at the map only when the car may have crossed an edge since.
struct Watch<'a> {
    town: &'a Town,
    /// The last lane outside junctions in which the car was.
    entered: Option<Waypoint>,
    /// Where the car was when the map was last looked at, and how far the nearest edge of a lane was (m).
    checked: Point,
    room: f64,
    place: LanePlace,
}

impl Watch<'_> {
    fn look(&mut self, car: &VehicleState) -> LanePlace {
        let here = car.pose.position();
        if self.room < 0.0 || (here - self.checked).norm_squared() >= self.room * self.room {
            (self.place, self.room) = self.look_up(here, car.pose.forward());
            self.checked = here;
        }
        self.place
    }

    fn look_up(&mut self, here: Point, heading: Vector) -> (LanePlace, f64) {
        let Some(lane) = self.town.lane_around(here) else { return (LanePlace::Inside, 0.0) };
        let edge = lane.inside.abs();
        if lane.inside < 0.0 {
            return (LanePlace::OffRoad, edge);
        }
        if lane.is_junction {
            let inside = self.town.inside_way_on(*self.entered.get_or_insert(lane.place), here);
            let place = if inside < 0.0 { LanePlace::OutsideLane } else { LanePlace::Inside };
            return (place, edge.min(inside.abs()));
        }
        if heading.dot(&lane.direction) < 0.0 {
            return (LanePlace::OutsideLane, edge);
        }
        self.entered = Some(lane.place);
        (LanePlace::Inside, edge)
    }
}

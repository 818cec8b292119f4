use road::geometry::{Point, Vector};
use road::{Place, Town, Waypoint};
use world::sim::VehicleState;

/// Where the centre of a car is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LanePlace {
    Inside,
    /// On the road, but not in its lane.
    OutsideLane,
    OffRoad,
}

/// Follows a car along its lanes, and looks at the map only when the car may have crossed an edge since.
#[derive(Debug, Clone)]
pub struct LaneWatch {
    /// The last lane outside junctions in which the car was.
    entered: Option<Waypoint>,
    /// Where the car was when the map was last looked at, and how far the nearest edge of a lane was (m).
    checked: Point,
    room: f64,
    place: LanePlace,
}

impl Default for LaneWatch {
    fn default() -> Self {
        Self::new()
    }
}

impl LaneWatch {
    /// Nothing is known of the car yet.
    pub fn new() -> Self {
        Self { entered: None, checked: Point::origin(), room: -1.0, place: LanePlace::Inside }
    }

    /// Where the car is now.
    pub fn look(&mut self, town: &Town, car: &VehicleState) -> LanePlace {
        let here = car.pose.position();
        if self.room < 0.0 || (here - self.checked).norm_squared() >= self.room * self.room {
            (self.place, self.room) = self.look_up(town, car.place(), car.pose.forward());
            self.checked = here;
        }
        self.place
    }

    fn look_up(&mut self, town: &Town, here: Place, heading: Vector) -> (LanePlace, f64) {
        let Some(lane) = town.lane_around(here) else { return (LanePlace::Inside, 0.0) };
        let edge = lane.inside.abs();
        if lane.inside < 0.0 {
            return (LanePlace::OffRoad, edge);
        }
        if lane.is_junction {
            let inside = town.inside_way_on(*self.entered.get_or_insert(lane.place), here.point);
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

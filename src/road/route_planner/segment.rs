use super::client_location::ClientLocation;
use crate::{RoadOption, RoutePoint, Town, Waypoint};

/// Maximum number of points of a segment, a guard against files whose lanes lead past their own end.
const MAX_POINTS: usize = 100_000;

/// A point of a segment, with the location by which CARLA compares points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Place {
    pub point: RoutePoint,
    pub location: ClientLocation,
}

impl Place {
    /// Looks a waypoint up in its town.
    pub fn new(town: &Town, waypoint: Waypoint) -> Self {
        Self {
            point: RoutePoint::new(town, waypoint, RoadOption::LaneFollow),
            location: ClientLocation::on_lane(town, waypoint),
        }
    }
}

/// The first of some places that is nearest to a location.
pub(super) fn nearest(location: ClientLocation, places: &[Place]) -> usize {
    let mut best = (0, f32::INFINITY);
    for (index, place) in places.iter().enumerate() {
        let distance = place.location.distance(location);
        if distance < best.1 {
            best = (index, distance);
        }
    }
    best.0
}

/// A driving lane of one section up to one of its successors.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Segment {
    /// Its start, points at the spacing, and its end, which is the start of the successor.
    pub places: Vec<Place>,
}

impl Segment {
    /// Places points between two waypoints; `None` if they are close and the lane does not continue.
    pub fn new(town: &Town, entry: Waypoint, exit: Waypoint, sampling: f64) -> Option<Self> {
        let (entry, exit) = (Place::new(town, entry), Place::new(town, exit));
        let step = sampling as f32;
        let mut places = vec![entry];
        let mut ahead = Vec::new();
        let mut next = |from: Place| {
            ahead.clear();
            town.next(from.point.waypoint, sampling, &mut ahead);
            ahead.first().map(|waypoint| Place::new(town, *waypoint))
        };
        if entry.location.distance(exit.location) > step {
            let mut here = next(entry);
            while let Some(place) = here.filter(|place| place.location.distance(exit.location) > step) {
                if places.len() > MAX_POINTS {
                    return None;
                }
                places.push(place);
                here = next(place);
            }
        } else {
            places.push(next(entry)?);
        }
        places.push(exit);
        Some(Self { places })
    }

    /// The rest of a lane from a waypoint on, for a lane that starts no segment; `None` if no point fits.
    pub fn loose_end(town: &Town, from: Place, sampling: f64) -> Option<Self> {
        let lane = |waypoint: Waypoint| (waypoint.road, waypoint.section, waypoint.lane);
        let mut places = vec![from];
        let mut ahead = Vec::new();
        let mut here = from.point.waypoint;
        while places.len() < MAX_POINTS {
            ahead.clear();
            town.next(here, sampling, &mut ahead);
            let Some(next) = ahead.first().filter(|next| lane(**next) == lane(here)) else { break };
            here = *next;
            places.push(Place::new(town, here));
        }
        // CARLA counts the last point twice: as a point and as the end.
        let last = *places.last()?;
        (places.len() > 1).then(|| {
            places.push(last);
            Self { places }
        })
    }

    /// Its first place.
    pub fn entry(&self) -> &Place {
        &self.places[0]
    }

    /// Its last place.
    pub fn exit(&self) -> &Place {
        &self.places[self.places.len() - 1]
    }
}

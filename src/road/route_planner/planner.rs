use std::sync::{Arc, Mutex, PoisonError};

use super::client_location::ClientLocation;
use super::graph::RouteGraph;
use super::search::find_way;
use super::segment::{Place, nearest};
use super::turns::Turns;
use crate::geometry::Point;
use crate::{LaneFilter, RoutePoint, Town, Waypoint};

/// Finds routes through one town, as CARLA's `GlobalRoutePlanner` does.
///
/// CARLA's planner remembers the junction in which its last route ended. It may then name the first junction of the next
/// route wrongly if that starts elsewhere; here every route is independent.
#[derive(Debug)]
pub struct RoutePlanner {
    sampling: f64,
    graph: RouteGraph,
    destinations: Vec<Waypoint>,
}

impl Town {
    /// The planner of routes with a point every `sampling` (m), built on the first call.
    pub fn route_planner(&self, sampling: f64) -> Arc<RoutePlanner> {
        let planners = self.derived(|_| Mutex::new(Vec::<Arc<RoutePlanner>>::new()));
        let mut planners = planners.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(planner) = planners.iter().find(|planner| planner.sampling() == sampling) {
            return Arc::clone(planner);
        }
        let planner = Arc::new(RoutePlanner::new(self, sampling));
        planners.push(Arc::clone(&planner));
        planner
    }
}

impl RoutePlanner {
    /// Cuts the lanes of a town into segments with a point every `sampling` (m), and the rest at their ends.
    pub fn new(town: &Town, sampling: f64) -> Self {
        let mut destinations = town.generate_waypoints(sampling);
        destinations.retain(|waypoint| !town.is_junction(*waypoint));
        Self { sampling, graph: RouteGraph::new(town, sampling), destinations }
    }

    /// The spacing of its points along the reference line (m).
    pub fn sampling(&self) -> f64 {
        self.sampling
    }

    /// Waypoints on all driving lanes outside junctions, at its spacing.
    pub fn destinations(&self) -> &[Waypoint] {
        &self.destinations
    }

    /// The route between the lanes nearest to two places of the town it was made for; `None` if no way leads there.
    ///
    /// Where segments meet, the end of one and the start of the next are both points of the route. A destination behind
    /// the origin on the same segment gives a single point, as in CARLA. From an origin within a junction the route may
    /// start on another branch, since CARLA searches from the start of the origin's segment.
    pub fn trace(&self, town: &Town, from: Point, to: Point) -> Option<Vec<RoutePoint>> {
        let origin = town.nearest_lane(from, LaneFilter::Driving)?;
        let goal = Place::new(town, town.nearest_lane(to, LaneFilter::Driving)?);
        let target = ClientLocation::new(to, town.elevation(goal.point.waypoint));
        let (begin, end) = (self.graph.ends(origin)?, self.graph.ends(goal.point.waypoint)?);
        let mut way = find_way(&self.graph, begin.0, end.0)?;
        way.push(end.1);
        let mut turns = Turns::default();
        let mut route = Vec::new();
        let mut current = ClientLocation::on_lane(town, origin);
        for (index, ends) in way.windows(2).enumerate() {
            let option = turns.name(&self.graph, &way, index)?;
            let places = &self.graph.edge(ends[0], ends[1])?.places;
            let first = nearest(current, places);
            let last_segment = index + 2 == way.len();
            for place in &places[first..] {
                current = place.location;
                route.push(RoutePoint { option, ..place.point });
                if last_segment && self.arrives(place, &goal, target, places, first) {
                    break;
                }
            }
        }
        Some(route)
    }

    /// Whether a route ends at a point of its last segment, `first` being the segment's first point on the route.
    fn arrives(&self, place: &Place, goal: &Place, target: ClientLocation, places: &[Place], first: usize) -> bool {
        let lane = |waypoint: Waypoint| (waypoint.road, waypoint.section, waypoint.lane);
        f64::from(place.location.distance(target)) < 2.0 * self.sampling
            || (lane(place.point.waypoint) == lane(goal.point.waypoint) && first > nearest(goal.location, places))
    }
}

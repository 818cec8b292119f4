use super::brake_rules::{BrakeRules, WalkerView, bearing};
use super::frame::EgoPoint;
use road::geometry::wrap_angle;
use road::{LaneFilter, LaneKind, Waypoint};
use world::av::{Actor, DrivingMode, Path, Perception};
use world::sim::LightColour;

/// The cameras (m ahead of the middle), and half of the sector they cover (rad).
const CAMERAS: f64 = 1.5;
const SECTOR: f64 = 92.0 * std::f64::consts::PI / 180.0;
/// The expert also compares lanes this far ahead (points of the path, 1 m apart): five of its waypoints of 4.5 m.
const NEXT_LANE: usize = 22;
/// A light's line crosses the route if a point of the route is within this distance (m), and its heading within this angle (rad).
const LINE_ALONG: f64 = 0.6;
const LINE_BESIDE: f64 = 1.5;
const LINE_HEADING: f64 = 1.0;

/// Finds a hazard for which LAV's training data was labelled; returns the manoeuvre of stopping for it.
pub(super) fn find(rules: &BrakeRules, path: &Path, perception: &Perception<'_>) -> Option<DrivingMode> {
    let in_sight = |actor: &Actor| perception.in_sight(actor);
    if perception.pedestrians.iter().any(|walker| brakes_for(walker, rules, path, perception) && in_sight(walker)) {
        return Some(DrivingMode::EmergencyStop);
    }
    let ego = &perception.ego.pose;
    if perception.vehicles.iter().any(|vehicle| rules.behind_vehicle(ego, vehicle) && in_sight(vehicle)) {
        return Some(DrivingMode::Follow);
    }
    at_red_line(rules, path, perception).then_some(DrivingMode::RedLight)
}

fn brakes_for(walker: &Actor, rules: &BrakeRules, path: &Path, perception: &Perception<'_>) -> bool {
    let (position, half) = (walker.pose.position(), walker.half.max());
    let place = EgoPoint::seen_from(&perception.ego.pose, position);
    let from_camera = EgoPoint::new(place.right, place.back + CAMERAS);
    if place.distance(EgoPoint::default()) > rules.reach(half) || bearing(from_camera).abs() > SECTOR {
        return false;
    }
    let town = perception.town;
    let its = town.place_from(perception.place(), position);
    let nearest = |filter| town.nearest_lane(its, filter);
    let its = nearest(LaneFilter::Driving);
    let same = |lane: Waypoint| its.is_some_and(|its| (its.road, its.lane) == (lane.road, lane.lane));
    let mut lanes = path.points();
    let (here, next) = (lanes.next(), lanes.nth(NEXT_LANE - 1));
    rules.brake(&WalkerView {
        place,
        half,
        on_sidewalk: nearest(LaneFilter::Any).is_some_and(|lane| town.lane_kind(lane) == LaneKind::Sidewalk),
        in_lane: here.into_iter().chain(next).any(|point| same(point.waypoint)),
        from_lane_point: here.map_or(f64::INFINITY, |here| (here.pose.position() - position).norm()),
    })
}

/// Whether the line of a red light crosses the route at a place where the rules brake for it.
fn at_red_line(rules: &BrakeRules, path: &Path, perception: &Perception<'_>) -> bool {
    let ego = &perception.ego.pose;
    perception.lights.iter().filter(|light| light.colour == LightColour::Red).any(|light| {
        let line = light.trigger.position();
        let ahead = -EgoPoint::seen_from(ego, line).back;
        rules.at_line(ahead)
            && path.points().take_while(|point| (point.pose.position() - ego.position()).norm() < ahead + 2.0).any(
                |point| {
                    let local = point.pose.to_local(line);
                    local.x.abs() <= LINE_ALONG
                        && local.y.abs() <= LINE_BESIDE
                        && wrap_angle(light.trigger.yaw - point.pose.yaw).abs() < LINE_HEADING
                },
            )
    })
}

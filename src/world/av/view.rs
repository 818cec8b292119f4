use super::give_way::next_sign;
use super::lane_keeping::limit_here;
use super::{Actor, Path, Perception};
use crate::sim::{ActorId, LightColour};
use road::geometry::{Pose, Vector};
use road::{GiveWay, LaneKind, RoutePoint, Town, Waypoint};

/// The area in which a light is looked for: distance ahead (m) and beside the ego's axis (m).
const LIGHT_AHEAD: f64 = 60.0;
const LIGHT_ASIDE: f64 = 6.0;
/// Every second path point is a point of the route: 2 m apart.
const STRIDE: usize = 2;

/// The kind of a road user.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// On foot.
    Pedestrian,
    /// In a car.
    Vehicle,
}

/// A road user in sight.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Seen {
    /// A number that stays the same during an episode: pedestrians from 0 on, vehicles from 256 on.
    pub id: u32,
    pub kind: Kind,
    /// Middle of its box on the ground, and its heading.
    pub pose: Pose,
    /// Velocity (m/s).
    pub velocity: Vector,
    /// Half extents along its heading and across it (m).
    pub half: Vector,
}

/// The next traffic light that faces the ego.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LightAhead {
    pub colour: LightColour,
    /// How far ahead of the ego's middle the middle of its trigger box is, along the ego's heading (m).
    pub distance: f64,
}

/// The next stop or yield sign on the way of the ego.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SignAhead {
    pub kind: GiveWay,
    /// The way along the path from the middle of the ego to the line before which its front must stop or slow down (m).
    pub distance: f64,
}

/// The lane at a point of the route.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LaneAhead {
    /// Its width (m).
    pub width: f64,
    /// Number of driving lanes to its left that lead in the same direction.
    pub left: u32,
    /// The same to its right.
    pub right: u32,
    /// Whether the point lies inside a junction.
    pub is_junction: bool,
    /// The speed limit there (m/s): that of the lane, or where the map gives it none, that of the last sign up to there.
    pub speed_limit: f64,
}

/// A [`Perception`] in plain numbers, for drivers without access to our types: the road users in sight, the nearest first, and the route.
#[derive(Debug, Clone, Default)]
pub struct View {
    /// The ego's pose in the world.
    pub ego: Pose,
    /// The ego's speed (m/s).
    pub speed: f64,
    /// The speed limit of the ego (m/s).
    pub speed_limit: f64,
    /// The next light.
    pub light: Option<LightAhead>,
    /// The next stop or yield sign on the path, within 90 m; `None` while a traffic light takes precedence over it.
    pub sign: Option<SignAhead>,
    /// The road users in sight; those hidden by a building are left out.
    pub actors: Vec<Seen>,
    /// The route ahead in the world, points 2 m apart, the first one abeam the ego; shorter where the road ends.
    pub route: Vec<Pose>,
    /// The lane at each point of the route; empty until [`View::look_at_lanes`] is called.
    pub lanes: Vec<LaneAhead>,
}

impl View {
    /// Updates the view, with at most this number of actors and of points of the route.
    pub fn look(&mut self, perception: &Perception<'_>, path: &Path, actors: usize, points: usize) {
        let ego = &perception.ego;
        self.ego = ego.pose;
        self.speed = ego.speed();
        self.speed_limit = limit_here(path, perception);
        self.light = light_ahead(perception);
        self.sign = next_sign(perception, path).map(|(kind, distance)| SignAhead { kind, distance });
        self.actors.clear();
        let pedestrians = perception.pedestrians.iter().map(|actor| (Kind::Pedestrian, actor));
        let vehicles = perception.vehicles.iter().map(|actor| (Kind::Vehicle, actor));
        // A place that is no number has no form in a message.
        let is_somewhere = |actor: &Actor| (actor.pose.x + actor.pose.y).is_finite();
        let in_sight =
            pedestrians.chain(vehicles).filter(|(_, actor)| is_somewhere(actor) && perception.in_sight(actor));
        self.actors.extend(in_sight.map(|(kind, actor)| Seen {
            id: number(actor.id),
            kind,
            pose: actor.pose,
            velocity: actor.velocity,
            half: actor.half,
        }));
        let here = ego.pose.position();
        let distance = |seen: &Seen| (seen.pose.position() - here).norm_squared();
        self.actors.sort_by(|a, b| distance(a).total_cmp(&distance(b)));
        self.actors.truncate(actors);
        self.route.clear();
        self.route.extend(path.points().step_by(STRIDE).take(points).map(|point| point.pose));
    }
}

impl View {
    /// The colour of the light ahead, 0 for none, 1 for green, 2 for yellow and 3 for red, and its distance (m).
    pub(super) fn light_numbers(&self) -> (f64, f64) {
        let colour = |light: LightAhead| match light.colour {
            LightColour::Green => 1.0,
            LightColour::Yellow => 2.0,
            LightColour::Red => 3.0,
        };
        self.light.map_or((0.0, 0.0), |light| (colour(light), light.distance))
    }

    /// Updates the lanes at the points of the route that [`View::look`] took from the same path.
    pub fn look_at_lanes(&mut self, perception: &Perception<'_>, path: &Path) {
        let town = perception.town;
        let mut signed = perception.carla_limit();
        self.lanes.clear();
        for (place, point) in path.points().enumerate() {
            if self.lanes.len() == self.route.len() {
                return;
            }
            let here = point.pose.position();
            // The first point is abeam the ego, which knows its limit.
            let mut passed = town.speed_signs.iter().filter(|sign| place > 0 && sign.trigger.distance_to(here) <= 0.0);
            signed = passed.next_back().map_or(signed, |sign| sign.limit);
            if place.is_multiple_of(STRIDE) {
                let limit = town.limit(point.waypoint).filter(|_| perception.signed_limit.is_some());
                self.lanes.push(LaneAhead::new(town, point, limit.unwrap_or(signed)));
            }
        }
    }
}

#[cfg(test)]
impl View {
    /// A pedestrian, a light, a sign, and a point of the route in a junction.
    pub fn example() -> Self {
        let (pose, velocity) = (Pose::new(12.0, 1.5, -1.5), Vector::new(0.0, -1.25));
        Self {
            ego: Pose::new(1.0, 2.0, 0.5),
            speed: 8.0,
            speed_limit: 10.0,
            light: Some(LightAhead { colour: LightColour::Red, distance: 30.0 }),
            sign: Some(SignAhead { kind: GiveWay::Stop, distance: 12.5 }),
            actors: vec![Seen { id: 3, kind: Kind::Pedestrian, pose, velocity, half: Vector::new(0.25, 0.25) }],
            route: vec![Pose::new(3.0, 4.0, 0.25)],
            lanes: vec![LaneAhead { width: 3.5, left: 1, right: 0, is_junction: true, speed_limit: 8.5 }],
        }
    }
}

impl LaneAhead {
    fn new(town: &Town, point: &RoutePoint, speed_limit: f64) -> Self {
        let lanes = |beside: fn(&Town, Waypoint) -> Option<Waypoint>| {
            let same_way = |next: &Waypoint| {
                next.lane.signum() == point.waypoint.lane.signum() && town.lane_kind(*next) == LaneKind::Driving
            };
            let next = |lane: &Waypoint| beside(town, *lane).filter(same_way);
            std::iter::successors(next(&point.waypoint), next).count() as u32
        };
        Self {
            width: point.lane_width,
            left: lanes(Town::left_lane),
            right: lanes(Town::right_lane),
            is_junction: point.is_junction,
            speed_limit,
        }
    }
}

fn number(id: ActorId) -> u32 {
    match id {
        ActorId::Pedestrian(number) => u32::from(number),
        ActorId::Vehicle(number) => 256 + u32::from(number),
    }
}

fn light_ahead(perception: &Perception<'_>) -> Option<LightAhead> {
    let ego = &perception.ego.pose;
    let facing = perception.lights.iter().filter_map(|light| {
        let place = ego.to_local(light.trigger.position());
        let same_way = ego.forward().dot(&light.trigger.forward()) > 0.5;
        let ahead = (0.0..LIGHT_AHEAD).contains(&place.x) && place.y.abs() < LIGHT_ASIDE;
        (same_way && ahead).then_some(LightAhead { colour: light.colour, distance: place.x })
    });
    facing.min_by(|a, b| a.distance.total_cmp(&b.distance))
}

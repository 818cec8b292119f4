use super::carla_frame::{Cone, Direction, Location, exact_heading};
use super::planner::Planner;
use super::polygon::{Corner, rings_touch};
use super::release::{Measure, PolygonRule, ReleaseTraits};
use road::geometry::{Point, Pose, Vector};
use road::{LaneFilter, Place, Town, Waypoint};
use world::av::{Actor, Perception};

/// Walkers count within this distance of the lane under the ego (m).
const WALKERS_WITHIN: f64 = 10.0;
/// Vehicles count within this distance of the lane under the ego (m).
const VEHICLES_WITHIN: f64 = 45.0;
/// Cosine of 60°, half the opening of the walkers' cone.
const WALKERS_CONE: f64 = 0.5;
/// Cosine of 30°, half the opening of the vehicles' cone.
const VEHICLES_CONE: f64 = 0.866_025_403_784_438_6;
/// Slack of the pre-filters that save look-ups and change no decision (m).
const MARGIN: f64 = 0.1;

/// The driving lane under the ego, in the agent's terms.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Here {
    pub waypoint: Waypoint,
    pub pose: Pose,
    pub location: Location,
    pub in_junction: bool,
    pub lane_width: f64,
}

impl Here {
    /// Looks up the driving lane nearest to a place.
    pub fn look_up(town: &Town, place: impl Into<Place>) -> Option<Self> {
        let waypoint = town.nearest_lane(place, LaneFilter::Driving)?;
        let pose = town.pose(waypoint);
        Some(Self {
            waypoint,
            pose,
            location: Location::new(pose.position(), 0.0),
            in_junction: town.is_junction(waypoint),
            lane_width: town.lane_width(waypoint),
        })
    }
}

/// The ego in CARLA's numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct EgoBody {
    pub centre: Location,
    /// The middle of its bumper on the ground.
    pub front: Location,
    pub forward: Direction,
    pub half: Vector,
    place: Point,
    exact_heading: (f64, f64),
}

impl EgoBody {
    pub fn new(ego: &Actor) -> Self {
        let centre = Location::new(ego.pose.position(), ego.height);
        let forward = Direction::new(&ego.pose);
        let half_length = ego.half.x as f32;
        let front =
            Location { x: centre.x + half_length * forward.x, y: centre.y + half_length * forward.y, z: centre.z };
        let exact_heading = exact_heading(&ego.pose);
        Self { centre, front, forward, half: ego.half, place: ego.pose.position(), exact_heading }
    }

    /// Whether an obstacle could be found within a reach; cheap, and never wrongly false.
    pub fn may_reach(&self, obstacle: &Actor, reach: f64) -> bool {
        let far = reach + self.half.x + obstacle.half.x + MARGIN;
        (obstacle.pose.position() - self.place).norm_squared() <= far * far
    }
}

/// An obstacle that the test found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Hit {
    /// Its index in the list.
    pub index: usize,
    /// The distance as the agent measures it (m).
    pub distance: f64,
    /// The gap between the bodies by the agent's measure (m).
    pub gap: f64,
}

/// The result of the test for one obstacle.
enum Finding {
    Clear,
    Found(f64),
    /// All obstacles are tested by their polygons instead.
    AllByPolygon,
}

/// The obstacle test of one tick.
pub(super) struct ObstacleTest<'a> {
    pub traits: &'a ReleaseTraits,
    pub perception: &'a Perception<'a>,
    pub ego: &'a EgoBody,
    pub here: &'a Here,
    pub planner: &'a Planner,
    /// Its reach (m).
    pub reach: f64,
    /// Memory for the route's polygon; empty until it is needed.
    pub route: &'a mut Vec<Corner>,
}

impl ObstacleTest<'_> {
    /// The walker step: finds a walker, or a vehicle when no walker is near the lane under the ego.
    pub fn find_walker(&mut self) -> Option<Hit> {
        let Perception { pedestrians, vehicles, .. } = *self.perception;
        if self.traits.vehicles_for_walkers && !pedestrians.iter().any(|walker| self.is_near(walker, WALKERS_WITHIN)) {
            return self.find(vehicles, f64::INFINITY, WALKERS_CONE);
        }
        self.find(pedestrians, WALKERS_WITHIN, WALKERS_CONE)
    }

    /// The vehicle step.
    pub fn find_vehicle(&mut self) -> Option<(Hit, &Actor)> {
        let vehicles = self.perception.vehicles;
        self.find(vehicles, VEHICLES_WITHIN, VEHICLES_CONE).map(|hit| (hit, &vehicles[hit.index]))
    }

    /// Finds an obstacle nearer than `near` to the lane under the ego, in a cone with this cosine of half its opening.
    fn find(&mut self, obstacles: &[Actor], near: f64, cosine: f64) -> Option<Hit> {
        // No rule finds an obstacle beyond reach.
        if !obstacles.iter().any(|obstacle| self.ego.may_reach(obstacle, self.reach)) {
            return None;
        }
        for (index, obstacle) in obstacles.iter().enumerate() {
            if !self.is_near(obstacle, near) {
                continue;
            }
            match self.examine(obstacle, cosine) {
                Finding::Clear => {}
                Finding::AllByPolygon => return self.find_by_polygon(obstacles, near),
                Finding::Found(distance) => return Some(self.hit(index, obstacle, distance)),
            }
        }
        None
    }

    fn find_by_polygon(&mut self, obstacles: &[Actor], near: f64) -> Option<Hit> {
        for (index, obstacle) in obstacles.iter().enumerate() {
            let centre = location(obstacle);
            if !self.is_near(obstacle, near) || self.ego.front.distance(centre) > self.reach {
                continue;
            }
            if let Some(distance) = self.touch(obstacle, centre) {
                return Some(self.hit(index, obstacle, distance));
            }
        }
        None
    }

    /// A finding. Subtracting half lengths is right only between centres: from the bumper, that of the ego is subtracted once too often.
    fn hit(&self, index: usize, obstacle: &Actor, distance: f64) -> Hit {
        Hit { index, distance, gap: distance - obstacle.half.max() - self.ego.half.max() }
    }

    fn is_near(&self, obstacle: &Actor, near: f64) -> bool {
        self.here.location.distance(location(obstacle)) < near
    }

    fn examine(&mut self, obstacle: &Actor, cosine: f64) -> Finding {
        let centre = location(obstacle);
        let town = self.perception.town;
        let place = || town.place_from(self.perception.place(), obstacle.pose.position());
        let lane = |filter| town.nearest_lane(place(), filter);
        let mut known = None;
        match self.traits.polygons {
            PolygonRule::Never => {}
            PolygonRule::BothInJunctions => {
                if self.here.in_junction {
                    let Some(its) = lane(self.traits.obstacle_lane) else { return Finding::Clear };
                    if self.perception.town.is_junction(its) {
                        return Finding::AllByPolygon;
                    }
                    known = Some(its);
                }
            }
            PolygonRule::EitherInJunction => {
                if self.ego.front.distance(centre) > self.reach {
                    return Finding::Clear;
                }
                let wide = self.ego.half.y > self.here.lane_width / 2.0;
                let mut by_polygon = wide || self.here.in_junction;
                if !by_polygon {
                    let Some(its) = lane(self.traits.obstacle_lane) else { return Finding::Clear };
                    by_polygon = self.perception.town.is_junction(its);
                    known = Some(its);
                }
                if by_polygon && self.has_route() {
                    return self.touch(obstacle, centre).map_or(Finding::Clear, Finding::Found);
                }
            }
        }
        let Some(distance) = self.measure(obstacle, centre, cosine) else { return Finding::Clear };
        // The look-up is the expensive part, so it comes last.
        let Some(its) = known.or_else(|| lane(self.traits.obstacle_lane)) else { return Finding::Clear };
        let next = self.planner.ahead(self.traits.accepted_point).map(|next| next.point.waypoint);
        let same = |other: Waypoint| its.road == other.road && its.lane == other.lane;
        if same(self.here.waypoint) || next.is_some_and(same) { Finding::Found(distance) } else { Finding::Clear }
    }

    /// The distance of an obstacle in the cone, by the release's points of measurement.
    fn measure(&self, obstacle: &Actor, centre: Location, cosine: f64) -> Option<f64> {
        let (tip, target) = match self.traits.measure {
            Measure::Centres => (self.ego.centre, centre),
            Measure::BumperToRear => {
                // Moved in 64 bits and rounded before the sum, as CARLA's Python does.
                let half_length = f64::from(obstacle.half.x as f32);
                (self.ego.front, centre.moved(Direction::new(&obstacle.pose), -half_length))
            }
        };
        let heading = if self.traits.exact_heading { self.ego.exact_heading } else { self.ego.forward.widened() };
        let cone = Cone { tip, heading, reach: self.reach, cosine };
        cone.holds(target).then(|| tip.exact_distance(target))
    }

    /// The distance of an obstacle whose polygon touches the route's.
    fn touch(&mut self, obstacle: &Actor, centre: Location) -> Option<f64> {
        let corners = box_corners(obstacle, centre);
        (self.has_route() && rings_touch(self.route, &corners)).then(|| self.ego.front.exact_distance(centre))
    }

    /// Makes the route's polygon; false when the route has no point within reach.
    fn has_route(&mut self) -> bool {
        if self.route.is_empty() {
            let half_width = f64::from(self.ego.half.y as f32);
            let beside = |location: Location, right: Direction, side: f64| {
                let corner = location.moved(right, side * half_width);
                [f64::from(corner.x), f64::from(corner.y)]
            };
            let front = self.ego.front;
            let within = self.planner.points().take_while(|point| front.distance(point.location) <= self.reach);
            let stations = std::iter::once((front, self.ego.forward.right()))
                .chain(within.map(|point| (point.location, point.right)));
            for (location, right) in stations {
                self.route.push(beside(location, right, 1.0));
                self.route.push(beside(location, right, -1.0));
            }
        }
        self.route.len() >= 3
    }
}

fn location(actor: &Actor) -> Location {
    Location::new(actor.pose.position(), actor.height)
}

/// The corners of an obstacle's box in CARLA's order, which makes a bow-tie: back left, back right, front left, front
/// right, as seen from the obstacle in CARLA's left-handed frame.
fn box_corners(obstacle: &Actor, centre: Location) -> [Corner; 4] {
    let forward = Direction::new(&obstacle.pose);
    let (length, width) = (obstacle.half.x as f32, obstacle.half.y as f32);
    [(-length, -width), (-length, width), (length, -width), (length, width)].map(|(ahead, right)| {
        let x = ahead * forward.x - right * forward.y;
        let y = ahead * forward.y + right * forward.x;
        [f64::from(centre.x + x), f64::from(centre.y + y)]
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use world::sim::ActorId;

    #[test]
    fn boxes_have_their_corners_in_carlas_order() {
        let car = Actor {
            id: ActorId::Vehicle(1),
            pose: Pose::new(10.0, 20.0, -std::f64::consts::FRAC_PI_2),
            velocity: Vector::zeros(),
            half: Vector::new(2.0, 1.0),
            height: 0.0,
        };
        // It drives towards +y in CARLA's frame, where its right is at −x.
        let corners = box_corners(&car, Location::new(car.pose.position(), 0.0));
        let expected = [[11.0, -22.0], [9.0, -22.0], [11.0, -18.0], [9.0, -18.0]];
        for (corner, expected) in corners.iter().zip(&expected) {
            assert!((corner[0] - expected[0]).abs() < 1e-5 && (corner[1] - expected[1]).abs() < 1e-5, "{corners:?}");
        }
    }
}

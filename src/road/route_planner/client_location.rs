use crate::geometry::Point;
use crate::{Geometry, LaneId, Road, Shape, Town, Waypoint};

/// A location with the bits that CARLA's client library gives it, except for the sign of `y`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct ClientLocation {
    x: f32,
    y: f32,
    z: f32,
}

impl ClientLocation {
    /// A place of ours at some height (m) in 32 bits.
    pub fn new(place: Point, height: f64) -> Self {
        Self { x: place.x as f32, y: place.y as f32, z: height as f32 }
    }

    /// The centre of a lane.
    ///
    /// # Source
    /// CARLA `road/Lane.cpp`, `ComputeTransform`; `road/Road.cpp`, `GetDirectedPointIn`; `road/element/Geometry.cpp`.
    pub fn on_lane(town: &Town, waypoint: Waypoint) -> Self {
        let road = town.roads.get(waypoint.road.0 as usize);
        let height = town.elevation(waypoint);
        let exact = || Self::new(town.pose(waypoint).position(), height);
        let Some((road, piece)) = road.and_then(|road| Some((road, road.plan_view.piece_at(waypoint.s)?))) else {
            return exact();
        };
        let Some((mut place, yaw)) = on_piece(piece, waypoint.s - piece.s) else { return exact() };
        place.z = height as f32;
        // The offset of lane 0 and the step from there to the lane's centre are rounded one after the other.
        let offset = -(road.lane_offset.value(waypoint.s) as f32);
        place = place.beside(yaw, offset);
        place.beside(yaw, to_the_right(road, waypoint.section as usize, waypoint.lane, waypoint.s) as f32)
    }

    fn beside(self, yaw: f64, right: f32) -> Self {
        let yaw = yaw as f32;
        Self { x: self.x + right * libm::sinf(yaw), y: self.y + right * -libm::cosf(yaw), z: self.z }
    }

    /// The distance (m), in 32 bits.
    pub fn distance(self, other: Self) -> f32 {
        let (x, y, z) = (other.x - self.x, other.y - self.y, other.z - self.z);
        (x * x + y * y + z * z).sqrt()
    }

    /// In whole metres; halves round to even.
    pub fn whole(self) -> [i64; 3] {
        [self.x, self.y, self.z].map(|metres| metres.round_ties_even() as i64)
    }

    /// Its coordinates in 64 bits (m).
    pub fn widened(self) -> [f64; 3] {
        [self.x, self.y, self.z].map(f64::from)
    }
}

/// The place on a line or an arc, and the heading there; `None` on other curves, which CARLA approximates in its own way.
fn on_piece(piece: &Geometry, ds: f64) -> Option<(ClientLocation, f64)> {
    let ds = ds.clamp(0.0, piece.length.max(0.0));
    let start = ClientLocation::new(piece.start.position(), 0.0);
    let heading = piece.start.yaw;
    match piece.shape {
        Shape::Line => {
            let (sin, cos) = libm::sincos(heading);
            let (x, y) = (start.x + (ds * cos) as f32, start.y + (ds * sin) as f32);
            Some((ClientLocation { x, y, ..start }, heading))
        }
        Shape::Arc(curvature) if curvature.abs() > 1e-15 => {
            let radius = 1.0 / curvature;
            let yaw = heading + ds * curvature;
            let (first, last) = (from_centre(radius, heading), from_centre(radius, yaw));
            let (x, y) = (start.x + first.0 - last.0, start.y + first.1 - last.1);
            Some((ClientLocation { x, y, ..start }, yaw))
        }
        _ => None,
    }
}

fn from_centre(radius: f64, yaw: f64) -> (f32, f32) {
    let (sin, cos) = libm::sincos(yaw + std::f64::consts::FRAC_PI_2);
    ((radius * cos) as f32, (radius * sin) as f32)
}

/// How far to the right of lane 0 a lane's centre is (m).
fn to_the_right(road: &Road, section: usize, id: LaneId, s: f64) -> f64 {
    let lanes = road.sections.get(section).map_or(&[][..], |section| &section.lanes);
    let inner = lanes.iter().filter(|lane| lane.id.signum() == id.signum() && lane.id.abs() <= id.abs());
    let widths = inner.map(|lane| if lane.id == id { 0.5 * lane.width.value(s) } else { lane.width.value(s) });
    -f64::from(id.signum()) * widths.sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::{Carriageway, Node, Street, TownDesign};
    use crate::geometry::Pose;

    #[test]
    fn the_bits_differ_from_ours_by_rounding_only() {
        let node = |x, y| Node { name: String::new(), position: Point::new(x, y), lights: false };
        let street = Street {
            name: String::new(),
            nodes: vec![0, 1, 2],
            speed_limit: None,
            carriageway: Carriageway::default(),
        };
        let nodes = vec![node(-300.0, 0.0), node(0.0, 17.0), node(150.0, 220.0)];
        let town = Town::new(TownDesign { nodes, streets: vec![street], ..TownDesign::default() }.build().unwrap());
        let waypoints = town.generate_waypoints(1.7);
        assert!(waypoints.len() > 100);
        for waypoint in waypoints {
            let exact = town.pose(waypoint).position();
            let ours = ClientLocation::on_lane(&town, waypoint);
            assert!((Point::new(f64::from(ours.x), f64::from(ours.y)) - exact).norm() < 1e-4, "{ours:?} {exact:?}");
        }
    }

    #[test]
    fn an_arc_is_summed_over_its_centre_in_32_bits() {
        let arc = Geometry::arc(0.0, Pose::new(1e5, 0.0, 0.0), 10.0, 0.1);
        let (place, yaw) = on_piece(&arc, 10.0).unwrap();
        assert_eq!(yaw, 1.0);
        // At 100 km neighbouring floats are 8 mm apart.
        assert!((f64::from(place.x) - (1e5 + 10.0 * libm::sin(1.0))).abs() < 0.02);
    }

    #[test]
    fn halves_go_to_even_metres() {
        assert_eq!(ClientLocation::new(Point::new(2.5, -3.5), 0.6).whole(), [2, -4, 1]);
    }
}

//! A view from above, as pixels: lanes, obstacles, vehicles and pedestrians.

use road::geometry::{OrientedBox, Point, Pose, Vector};
use road::{LaneFilter, LaneKind};

use super::world::World;

/// Metres that a picture shows from side to side.
const SPAN: f64 = 60.0;
/// Distance (m) between the places at which lanes are looked up.
const RASTER: f64 = 0.5;

const GROUND: [u8; 3] = [226, 232, 220];
const ROAD: [u8; 3] = [120, 124, 130];
const SIDEWALK: [u8; 3] = [190, 188, 182];
const WALL: [u8; 3] = [92, 78, 66];
const EGO: [u8; 3] = [34, 86, 196];
const BUMPER: [u8; 3] = [250, 214, 64];
const TRAFFIC: [u8; 3] = [70, 160, 180];
const PEDESTRIAN: [u8; 3] = [214, 48, 48];

/// Draws a world, north up, about the middle between the ego and the first pedestrian. Three bytes for each pixel, row by row.
pub fn picture(world: &World, size: usize) -> Vec<u8> {
    let scene = world.simulation().scene();
    let (sim, scenario) = (scene.world, scene.scenario);
    let (ego, first) = (sim.ego().state.pose.position(), sim.pedestrians[0].state.pose.position());
    let middle = Point::from((ego.coords + first.coords) / 2.0);
    let scale = SPAN / size as f64;
    let place = |row: usize, column: usize| {
        let (right, up) = ((column as f64 + 0.5) * scale - SPAN / 2.0, SPAN / 2.0 - (row as f64 + 0.5) * scale);
        middle + Vector::new(right, up)
    };
    let lane = |point: Point| {
        let found = scenario.town.nearest_lane(point, LaneFilter::Any)?;
        let far = (scenario.town.pose(found).position() - point).norm();
        (far <= scenario.town.lane_width(found) / 2.0).then(|| scenario.town.lane_kind(found))
    };
    let cells = (SPAN / RASTER) as usize;
    let step = |index: usize| (index as f64 + 0.5) * RASTER - SPAN / 2.0;
    let ground: Vec<[u8; 3]> = (0..cells * cells)
        .map(|cell| match lane(middle + Vector::new(step(cell % cells), -step(cell / cells))) {
            Some(LaneKind::Sidewalk) => SIDEWALK,
            Some(LaneKind::None) | None => GROUND,
            Some(_) => ROAD,
        })
        .collect();
    let walls: Vec<&OrientedBox> =
        scenario.town.obstacles.iter().filter(|wall| wall.distance_to(middle) < SPAN).collect();
    let mut pixels = Vec::with_capacity(size * size * 3);
    for row in 0..size {
        for column in 0..size {
            let point = place(row, column);
            let inside = |pose: &Pose, length: f64, width: f64| {
                let local = pose.to_local(point);
                (local.x.abs() <= length && local.y.abs() <= width).then_some(local.x)
            };
            let walker = sim.pedestrians.iter().any(|pedestrian| {
                (pedestrian.state.pose.position() - point).norm() <= pedestrian.body.radius.max(1.5 * scale)
            });
            let car = sim.vehicles.iter().enumerate().find_map(|(number, vehicle)| {
                let shape = &vehicle.blueprint;
                let ahead = inside(&vehicle.state.pose, shape.half_length, shape.half_width)?;
                Some(match number {
                    0 if ahead > shape.half_length - 0.5 => BUMPER,
                    0 => EGO,
                    _ => TRAFFIC,
                })
            });
            let cell = (row * cells / size) * cells + column * cells / size;
            let colour = match car {
                _ if walker => PEDESTRIAN,
                Some(colour) => colour,
                None if walls.iter().any(|wall| wall.distance_to(point) <= 0.0) => WALL,
                None => ground[cell],
            };
            pixels.extend(colour);
        }
    }
    pixels
}

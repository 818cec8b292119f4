use crate::Scene;
use road::Place;
use road::geometry::{OrientedBox, Point, Vector};

/// Relaxation time (s), and the greatest speed as a share of the wanted one.
const RELAXATION: f64 = 0.5;
const MAX_SPEED: f64 = 1.3;
/// Strength (m²/s²) and range (m) of the repulsion of pedestrians, and the time (s) of the step that makes it an ellipse.
const PEDESTRIAN: (f64, f64) = (2.1, 0.3);
const STEP: f64 = 2.0;
/// Strength (m²/s²) and range (m) of the repulsion of walls.
const WALL: (f64, f64) = (10.0, 0.2);
/// The cosine of half of the angle of sight, 200°, and the weight of what is outside it.
const SIGHT: f64 = -0.17364817766693033;
const BEHIND: f64 = 0.5;
/// The longest step of the integration (s), and the distance from which on a wall does not count (m).
const MAX_TICK: f64 = 0.05;
const REACH: f64 = 2.0;

/// The mean velocity (m/s) over a time (s) of a pedestrian who wants to walk at a velocity, among others: they repel it, as walls and cars do, which
/// keep their velocities.
///
/// # Source
/// Helbing and Molnár, *Social force model for pedestrian dynamics*, Physical Review E 51 (1995), with its constants. Cars are walls that move here.
pub(super) fn among_others(scene: &Scene<'_>, pedestrian: usize, wanted: Vector, seconds: f64) -> Vector {
    let world = scene.world;
    let state = &world.pedestrians[pedestrian].state;
    let (start, mut place, mut velocity) = (state.pose.position(), state.pose.position(), state.velocity);
    let steps = (seconds / MAX_TICK).ceil().max(1.0);
    let tick = seconds / steps;
    for step in 0..steps as u32 {
        let time = f64::from(step) * tick;
        let mut force = (wanted - velocity) / RELAXATION;
        let is_here = |other: Place| world.town.is_on_level(state.place(), other);
        let others =
            world.pedestrians.iter().enumerate().filter(|(other, each)| *other != pedestrian && each.is_present);
        for (_, other) in others.filter(|(_, each)| is_here(each.state.place())) {
            let there = other.state.pose.position() + other.state.velocity * time;
            let pushed = of_pedestrian(place - there, other.state.velocity);
            let is_seen = wanted.dot(&-pushed) >= SIGHT * wanted.norm() * pushed.norm();
            force += pushed * if is_seen { 1.0 } else { BEHIND };
        }
        for wall in world.obstacles.near(place, REACH) {
            force += of_wall(wall, place);
        }
        for car in world.vehicles.iter().filter(|each| each.is_driven() && is_here(each.state.place())) {
            let mut outline = car.outline();
            let moved = outline.pose.position() + outline.pose.forward() * (car.state.speed * time);
            (outline.pose.x, outline.pose.y) = (moved.x, moved.y);
            force += of_wall(&outline, place);
        }
        velocity += force * tick;
        let greatest = MAX_SPEED * wanted.norm();
        if velocity.norm() > greatest {
            velocity *= greatest / velocity.norm();
        }
        place += velocity * tick;
    }
    (place - start) / seconds
}

/// The force of another pedestrian (m/s²), who walks at a velocity (m/s) and from whom this is the way.
fn of_pedestrian(way: Vector, velocity: Vector) -> Vector {
    let (strength, range) = PEDESTRIAN;
    let step = velocity * STEP;
    let (near, far) = (way.norm(), (way - step).norm());
    let sum = near + far;
    let axis = ((sum * sum - step.norm_squared()).max(0.0)).sqrt() / 2.0;
    if near < 1e-9 || far < 1e-9 || axis < 1e-9 {
        return Vector::zeros();
    }
    // The gradient of the semi-minor axis.
    let gradient = (way / near + (way - step) / far) * (sum / (4.0 * axis));
    gradient * (strength / range * libm::exp(-axis / range))
}

/// The force of a wall on a pedestrian at a place (m/s²); none within it.
fn of_wall(wall: &OrientedBox, place: Point) -> Vector {
    let (strength, range) = WALL;
    let local = wall.pose.to_local(place);
    let nearest = Vector::new(local.x.clamp(-wall.half.x, wall.half.x), local.y.clamp(-wall.half.y, wall.half.y));
    let (away, distance) = (local - nearest, (local - nearest).norm());
    if distance < 1e-9 {
        return Vector::zeros();
    }
    let push = away * (strength / range * libm::exp(-distance / range) / distance);
    wall.pose.forward() * push.x + wall.pose.left() * push.y
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_force_is_the_slope_of_its_potential() {
        let (velocity, way) = (Vector::new(1.2, 0.3), Vector::new(0.8, -0.5));
        let potential = |way: Vector| {
            let step = velocity * 2.0;
            let axis = ((way.norm() + (way - step).norm()).powi(2) - step.norm_squared()).sqrt() / 2.0;
            2.1 * libm::exp(-axis / 0.3)
        };
        let slope = |by: Vector| (potential(way - by) - potential(way + by)) / (2.0 * by.norm());
        let force = of_pedestrian(way, velocity);
        assert!((force.x - slope(Vector::new(1e-5, 0.0))).abs() < 1e-6, "{force}");
        assert!((force.y - slope(Vector::new(0.0, 1e-5))).abs() < 1e-6, "{force}");
        // 0.5 m before a wall.
        let wall = OrientedBox::spanning(Point::new(0.0, 0.0), Point::new(4.0, 1.0));
        let force = of_wall(&wall, Point::new(2.0, -0.5));
        assert!(force.x.abs() < 1e-9 && (force.y + 10.0 / 0.2 * libm::exp(-2.5)).abs() < 1e-9, "{force}");
    }
}

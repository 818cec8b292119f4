//! The signals of an actor of a cast towards another one: `child.gap`, `gap(child, van)`.

use base::signature::{ActorSignal, Variable};
use base::units::Dimension;
use road::Place;
use road::geometry::Pose;
use world::sim::{ActorId, Contact, World};

/// No car reaches this speed (m/s).
pub(super) const FASTEST: f64 = 1000.0;
/// The longest episode: a million ticks of 0.1 s.
pub(super) const MAX_TIME: f64 = 1e5;
pub(crate) const FARTHEST: f64 = FASTEST * MAX_TIME;

/// The signals, in the order of their numbers.
pub(super) fn signals() -> Vec<Variable> {
    let signal =
        |name, dimension, bounds, scale, doc| Variable { name, dimension, bounds, scale, is_condition: false, doc };
    let far = (-FARTHEST, FARTHEST);
    vec![
        signal(
            "gap",
            Dimension::LENGTH,
            (0.0, FARTHEST),
            1.0,
            "Gap between the body of the role and that of the car under test, or of a second role: `gap(child, van)`.",
        ),
        signal("distance", Dimension::LENGTH, (0.0, FARTHEST), 10.0, "Distance between their centres."),
        signal(
            "ahead",
            Dimension::LENGTH,
            far,
            10.0,
            "How far the role is ahead of the centre of the car under test, or of the second role; negative behind it.",
        ),
        signal("aside", Dimension::LENGTH, far, 1.0, "How far the role is to the left of that one's axis."),
        signal("speed", Dimension::SPEED, (0.0, FASTEST), 5.0, "Speed of the role."),
        Variable {
            is_condition: true,
            ..signal(
                "in_sight",
                Dimension::RATIO,
                (0.0, 1.0),
                1.0,
                "Whether the driver's eye can see any of the role; from a second role its driver's eye, or the middle of a pedestrian.",
            )
        },
    ]
}

/// The value of a signal after a tick (SI). What is not in the world is far away and out of sight; whom the car has struck lies there.
pub(crate) fn value(world: &World, ActorSignal { of, to, signal }: ActorSignal, contact: Option<&Contact>) -> f64 {
    let (of, to) = (ActorId::of_code(of), ActorId::of_code(to));
    let ((place, present, own), (origin, there, other)) = (pose(world, of), pose(world, to));
    let local = origin.to_local(place.position());
    let is_near = present && there;
    let is_on_level = || world.town.is_on_level(own, other);
    match signal {
        0 | 1 if !is_near => FARTHEST,
        0 if contact.is_some_and(|contact| [(of, to), (to, of)].contains(&contact.pair)) => 0.0,
        0 if !is_on_level() => FARTHEST,
        0 => gap(world, of, to),
        1 => local.norm(),
        2 => local.x,
        3 => local.y,
        4 => speed(world, of),
        _ => f64::from(world.sees(to, of)),
    }
}

/// The pose of an actor, whether it is in the world, and its place on its level.
fn pose(world: &World, actor: ActorId) -> (Pose, bool, Place) {
    match actor {
        ActorId::Vehicle(number) => {
            let vehicle = &world.vehicles[usize::from(number)];
            (vehicle.state.pose, vehicle.is_present, vehicle.state.place())
        }
        ActorId::Pedestrian(number) => {
            let pedestrian = &world.pedestrians[usize::from(number)];
            (pedestrian.state.pose, pedestrian.is_present || pedestrian.is_struck, pedestrian.state.place())
        }
    }
}

fn speed(world: &World, actor: ActorId) -> f64 {
    match actor {
        ActorId::Vehicle(number) => world.vehicles[usize::from(number)].state.speed.abs(),
        ActorId::Pedestrian(number) => world.pedestrians[usize::from(number)].state.speed(),
    }
}

/// The gap between two bodies (m).
fn gap(world: &World, of: ActorId, to: ActorId) -> f64 {
    match (of, to) {
        (ActorId::Vehicle(a), ActorId::Vehicle(b)) => {
            let [first, second] = [a, b].map(|number| world.vehicles[usize::from(number)].outline());
            first.separation(&second).norm()
        }
        (ActorId::Vehicle(car), ActorId::Pedestrian(walker)) | (ActorId::Pedestrian(walker), ActorId::Vehicle(car)) => {
            let (car, walker) = (&world.vehicles[usize::from(car)], &world.pedestrians[usize::from(walker)]);
            walker.state.gap_to(&car.outline(), &walker.body)
        }
        (ActorId::Pedestrian(a), ActorId::Pedestrian(b)) => {
            let [first, second] = [a, b].map(|number| &world.pedestrians[usize::from(number)]);
            let apart = (first.state.pose.position() - second.state.pose.position()).norm();
            (apart - first.body.radius - second.body.radius).max(0.0)
        }
    }
}

use super::*;
use proptest::prelude::*;
use road::geometry::{OrientedBox, Point, Pose};
use world::sim::{PedestrianState, VehicleState};

const PAIR: Bodies = Bodies { half: Vector::new(2.4, 1.0), radius: 0.2 };
const TICK: f64 = 0.05;

/// A car and a pedestrian at constant velocities: start (m), heading (rad), speed (m/s).
fn straight(car: (Pose, f64), walker: (Point, Vector), ticks: u32) -> Vec<Frame> {
    let frame = |tick: u32| {
        let time = f64::from(tick) * TICK;
        let (place, yaw) = (car.0.position() + car.0.forward() * (car.1 * time), car.0.yaw);
        let ego =
            VehicleState { pose: Pose::new(place.x, place.y, yaw), speed: car.1, age: time, ..VehicleState::default() };
        let at = walker.0 + walker.1 * time;
        Frame {
            ego,
            pedestrian: PedestrianState {
                pose: Pose::new(at.x, at.y, 0.0),
                velocity: walker.1,
                ..PedestrianState::default()
            },
            control: Default::default(),
            mode: Default::default(),
            tick: tick as usize,
        }
    };
    (0..ticks).map(frame).collect()
}

#[test]
fn the_time_to_collision_is_the_gap_over_the_closing_speed() {
    // Bumper at 2.4 m, edge of the pedestrian at 22.2 m: 19.8 m at 9 m/s, and a second later it is a second less.
    let east = Pose::new(0.0, 0.0, 0.0);
    let ahead = (Point::new(22.4, 0.5), Vector::new(1.0, 0.0));
    let least = PAIR.least_time(straight((east, 10.0), ahead, 21).into_iter()).unwrap();
    assert!((least - (19.8 / 9.0 - 1.0)).abs() < 1e-9, "{least}");
    // Beside the way of the car, and behind it: never.
    let beside = (Point::new(22.4, 1.21), Vector::new(1.0, 0.0));
    assert_eq!(PAIR.least_time(straight((east, 10.0), beside, 21).into_iter()), None);
    let behind = (Point::new(-8.0, 0.0), Vector::new(1.0, 0.0));
    assert_eq!(PAIR.least_time(straight((east, 10.0), behind, 21).into_iter()), None);
    // A pedestrian that walks at a standing car is not in its way.
    assert_eq!(
        PAIR.least_time(straight((east, 0.0), (Point::new(9.0, 0.0), Vector::new(-1.0, 0.0)), 21).into_iter()),
        None
    );
}

#[test]
fn the_post_encroachment_time_is_that_from_one_leaving_to_the_other_arriving() {
    // The rear of the car leaves x = 20.2 m after 2.26 s; the edge of the pedestrian reaches its flank after 2.8 / 1 s.
    let car = (Pose::new(0.0, 0.0, 0.0), 10.0);
    let walker = (Point::new(20.0, -4.0), Vector::new(0.0, 1.0));
    let ticks = PAIR.least_lag(straight(car, walker, 100).into_iter()).unwrap();
    assert!((ticks as f64 * TICK - (2.8 - 2.26)).abs() <= 2.0 * TICK, "{ticks}");
    // Paths that do not cross have none.
    assert_eq!(PAIR.least_lag(straight(car, (Point::new(20.0, -4.0), Vector::new(1.0, 0.0)), 100).into_iter()), None);
    let early = (Point::new(20.0, -1.3), Vector::new(0.0, 5.0));
    let ticks = PAIR.least_lag(straight(car, early, 100).into_iter()).unwrap();
    // Here the pedestrian is first: its edge leaves the other flank after 2.5 / 5 s; the bumper arrives after 17.4 / 10 s.
    assert!((ticks as f64 * TICK - (1.74 - 0.5)).abs() <= 2.0 * TICK, "{ticks}");
}

/// The definition, evaluated for every pair.
fn slow_lag(frames: &[Frame]) -> Option<usize> {
    let all = || frames.iter().enumerate();
    let touching = all().flat_map(|(i, car)| {
        let outline = OrientedBox { pose: car.ego.pose, half: PAIR.half };
        let touches = move |other: &&Frame| outline.distance_to(other.pedestrian.pose.position()) <= PAIR.radius;
        all().filter(move |(_, other)| touches(other)).map(move |(j, _)| i.abs_diff(j))
    });
    touching.min()
}

proptest! {
    #[test]
    fn the_least_lag_is_that_of_all_pairs(x in -10.0..25.0f64, y in -8.0..8.0f64, yaw in -3.0..3.0f64, speed in 0.0..9.0f64,
        vx in -2.0..2.0f64, vy in -2.0..2.0f64, standing in 0_usize..80) {
        let mut frames = straight((Pose::new(0.0, 0.0, yaw), speed), (Point::new(x, y), Vector::new(vx, vy)), 100);
        // The car stops for the rest, and the pedestrian continues.
        let stop = frames[standing].ego;
        frames[standing..].iter_mut().for_each(|frame| frame.ego = stop);
        prop_assert_eq!(PAIR.least_lag(frames.iter().copied()), slow_lag(&frames));
    }

    #[test]
    fn the_least_time_is_that_of_small_steps(x in -10.0..25.0f64, y in -8.0..8.0f64, yaw in -3.0..3.0f64, speed in 0.2..9.0f64,
        vx in -2.0..2.0f64, vy in -2.0..2.0f64) {
        let (car, velocity) = (Pose::new(1.0, -2.0, yaw), Vector::new(vx, vy));
        let frames = straight((car, speed), (Point::new(x, y), velocity), 1);
        let touches = |step: u32| {
            let time = f64::from(step) * 1e-3;
            let place = car.position() + car.forward() * (speed * time);
            let outline = OrientedBox { pose: Pose::new(place.x, place.y, yaw), half: PAIR.half };
            outline.distance_to(Point::new(x, y) + velocity * time) <= PAIR.radius
        };
        match (PAIR.least_time(frames.into_iter()), (0..9_999).find(|step| touches(*step))) {
            (Some(fast), Some(step)) => prop_assert!((fast - f64::from(step) * 1e-3).abs() < 1.1e-3, "{fast} {step}"),
            (None, None) => {}
            // A graze may fall between two steps, and a touch between the last step and the horizon.
            (Some(fast), None) => prop_assert!(!touches((fast * 1e3) as u32) || fast > 9.99),
            (None, Some(step)) => prop_assert!(false, "missed one at {step}"),
        }
    }
}

//! How a pedestrian follows its commands, and what stops it.

use proptest::prelude::*;
use road::geometry::{Obstacles, OrientedBox, Pose, Vector, wrap_angle};
use world::sim::{Gait, PedestrianBody, PedestrianState, WalkCommand};

fn walk(state: PedestrianState, command: WalkCommand, body: PedestrianBody, ticks: u32) -> PedestrianState {
    let free = Obstacles::new(&[]);
    (0..ticks).fold(state, |state, _| state.step(command, &body, &free, 0.05))
}

#[test]
fn an_adult_needs_two_seconds_to_any_speed() {
    for speed in [1.0, 3.5] {
        let command = WalkCommand { heading: 1.0, speed };
        let half = walk(PedestrianState::default(), command, PedestrianBody::adult(), 20);
        assert!((half.speed() - speed / 2.0).abs() < 1e-9);
        let full = walk(half, command, PedestrianBody::adult(), 40);
        assert!((full.speed() - speed).abs() < 1e-9 && (full.pose.yaw - 1.0).abs() < 1e-9);
    }
}

#[test]
fn a_nimble_one_is_at_once_where_it_wants() {
    let body = PedestrianBody::adult().nimble();
    let east = walk(PedestrianState::default(), WalkCommand { heading: 0.0, speed: 3.5 }, body, 20);
    assert!((east.pose.x - 3.5).abs() < 1e-12 && east.pose.y.abs() < 1e-12);
    let back = walk(east, WalkCommand { heading: std::f64::consts::PI, speed: 1.0 }, body, 20);
    assert!((back.pose.x - 2.5).abs() < 1e-9);
    assert_eq!(walk(back, WalkCommand { heading: 0.0, speed: 0.0 }, body, 1).speed(), 0.0);
}

/// An adult with inertia.
fn inertial(acceleration: f64, stopping: f64, turn_rate: f64) -> PedestrianBody {
    PedestrianBody { gait: Gait::Inertial { acceleration, stopping, turn_rate }, ..PedestrianBody::adult() }
}

#[test]
fn a_body_with_inertia_reaches_its_command_and_stays_there() {
    let body = inertial(1.65, 3.0, 1.4);
    let (east, north) = (WalkCommand { heading: 0.0, speed: 2.0 }, WalkCommand { heading: 1.5, speed: 2.0 });
    let state = walk(PedestrianState::default(), east, body, 20);
    assert!((state.speed() - 1.65).abs() < 1e-9, "after a second");
    let state = walk(state, east, body, 5);
    assert_eq!(state.velocity, Vector::new(2.0, 0.0));
    let turned = walk(state, north, body, 60);
    assert!((turned.velocity - Vector::new(2.0 * libm::cos(1.5), 2.0 * libm::sin(1.5))).norm() < 1e-9);
    let stopped = walk(turned, WalkCommand { heading: 0.0, speed: 0.0 }, body, 13);
    assert!((stopped.speed() - 0.05).abs() < 1e-9, "3 m/s² for 0.65 s: {}", stopped.speed());
    assert_eq!(walk(stopped, WalkCommand { heading: 0.0, speed: 0.0 }, body, 1).speed(), 0.0);
}

#[test]
fn a_reversed_command_stops_the_body_and_then_sends_it_back_on_the_same_line() {
    let body = inertial(1.65, 1.65, 1.4);
    let state = walk(PedestrianState::default(), WalkCommand { heading: 0.0, speed: 1.65 }, body, 20);
    let back = WalkCommand { heading: std::f64::consts::PI, speed: 1.65 };
    let halfway = walk(state, back, body, 20);
    assert!(halfway.speed() < 1e-9, "{:?}", halfway.velocity);
    let back = walk(halfway, back, body, 20);
    assert!((back.velocity - Vector::new(-1.65, 0.0)).norm() < 1e-9, "{:?}", back.velocity);
}

proptest! {
    #[test]
    fn no_command_sequence_exceeds_a_bound_in_any_tick(
        commands in prop::collection::vec((-3.2..3.2_f64, -0.5..4.0_f64, 1_u32..12), 1..40),
        bounds in (0.2..6.0_f64, 0.2..9.0_f64, 0.1..40.0_f64),
        dt in prop::sample::select(vec![0.01, 0.05, 0.1, 0.5]),
        reverses in any::<bool>(),
    ) {
        let (acceleration, stopping, turn_rate) = bounds;
        let (body, free) = (inertial(acceleration, stopping, turn_rate), Obstacles::new(&[]));
        let fastest = commands.iter().map(|(_, speed, _)| *speed).fold(0.0, f64::max);
        let mut state = PedestrianState::default();
        for (number, (heading, speed, ticks)) in commands.into_iter().enumerate() {
            let turned = if reverses && number % 2 == 1 { std::f64::consts::PI } else { 0.0 };
            for _ in 0..ticks {
                let next = state.step(WalkCommand { heading: heading + turned, speed }, &body, &free, dt);
                let change = next.velocity - state.velocity;
                prop_assert!(change.norm() <= acceleration.max(stopping) * dt * (1.0 + 1e-9) + 1e-12);
                prop_assert!(next.speed() <= fastest * (1.0 + 1e-9));
                if state.speed() > 1e-6 {
                    let ahead = state.velocity.normalize();
                    let (along, across) = (change.dot(&ahead), ahead.perp(&change));
                    let bound = if along < 0.0 { stopping } else { acceleration };
                    let effort = Vector::new(along / bound, across / acceleration).norm();
                    prop_assert!(effort <= dt * (1.0 + 1e-9) + 1e-9);
                    if next.speed() > 1e-6 && turn_rate * dt < std::f64::consts::PI {
                        let turn = libm::atan2(ahead.perp(&next.velocity), ahead.dot(&next.velocity));
                        prop_assert!(turn.abs() <= turn_rate * dt + 1e-6, "{turn} from {state:?} to {next:?}");
                    }
                }
                prop_assert!(next.velocity.x.is_finite() && wrap_angle(next.pose.yaw).is_finite());
                state = next;
            }
        }
    }
}

#[test]
fn a_wall_takes_the_blocked_part_of_any_velocity() {
    let wall = OrientedBox::new(Pose::new(2.0, 0.0, 0.0), 0.5, 50.0);
    let obstacles = Obstacles::new(&[wall]);
    let mut state = PedestrianState::default();
    for _ in 0..100 {
        state = state.step(WalkCommand { heading: 0.6, speed: 2.0 }, &inertial(1.65, 1.65, 1.4), &obstacles, 0.05);
        assert!(wall.distance_to(state.pose.position()) > PedestrianBody::adult().radius - 1e-3);
    }
    assert!(state.velocity.x.abs() < 1e-6 && state.velocity.y > 0.5, "{:?}", state.velocity);
}

#[test]
fn a_wall_stops_a_pedestrian_that_walks_into_it() {
    let wall = OrientedBox::new(Pose::new(5.0, 0.0, 0.0), 0.5, 50.0);
    let obstacles = Obstacles::new(&[wall]);
    for (body, far) in [(PedestrianBody::adult().nimble(), 7.0), (PedestrianBody::adult(), 1.5)] {
        let mut state = PedestrianState::default();
        for _ in 0..200 {
            state = state.step(WalkCommand { heading: 0.3, speed: 3.0 }, &body, &obstacles, 0.05);
            assert!(wall.distance_to(state.pose.position()) > body.radius - 1e-3);
        }
        assert!(state.pose.y > far, "it slides along the wall: {}", state.pose.y);
        assert!(state.velocity.x.abs() < 1e-6 && state.velocity.y > 0.0, "its velocity is that of its motion");
    }
}

#[test]
fn no_pedestrian_walks_through_a_thin_wall() {
    let wall = OrientedBox::new(Pose::new(5.0, 0.0, 0.0), 0.01, 10.0);
    let obstacles = Obstacles::new(&[wall]);
    let body = PedestrianBody::adult().nimble();
    let mut state = PedestrianState::default();
    for _ in 0..100 {
        state = state.step(WalkCommand { heading: 0.0, speed: 20.0 }, &body, &obstacles, 0.1);
    }
    assert!(state.pose.x < 5.0, "{}", state.pose.x);
}

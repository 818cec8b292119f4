//! Parts of a verdict: whether people move so, and how severe an impact is.

use proptest::prelude::*;
use road::geometry::{Obstacles, Vector};
use verdict::{PedestrianMotion, severe_injury_risk};
use world::sim::{Gait, PedestrianBody, PedestrianState, WalkCommand};

fn states(velocities: &[(f64, f64)]) -> Vec<PedestrianState> {
    let state = |(x, y): &(f64, f64)| PedestrianState { velocity: Vector::new(*x, *y), ..Default::default() };
    velocities.iter().map(state).collect()
}

/// A pedestrian with these velocities for as many seconds each, at a tick of 50 ms.
fn walked(legs: &[(f64, (f64, f64))]) -> Vec<PedestrianState> {
    let velocities: Vec<_> =
        legs.iter().flat_map(|(time, velocity)| vec![*velocity; (time / 0.05).round() as usize]).collect();
    states(&velocities)
}

#[test]
fn turning_counts_as_much_as_speeding_up() {
    // A quarter turn at 1.4 m/s in one tick of 50 ms.
    let motion = PedestrianMotion::of(&walked(&[(1.0, (1.4, 0.0)), (1.0, (0.0, 1.4))]), 0.05);
    let change = 1.4 * 2.0_f64.sqrt();
    assert!((motion.peak_speed - 1.4).abs() < 1e-12, "{motion:?}");
    assert!((motion.peak_acceleration - change / 0.5).abs() < 1e-9, "{motion:?}");
    assert!((motion.velocity_change - change).abs() < 1e-12, "{motion:?}");
    assert!(motion.unsteadiness > change / 2.0, "{motion:?}");
    assert!(!motion.is_foreseeable());
    let still = PedestrianMotion::of(&states(&[(0.0, 0.0)]), 0.05);
    assert!(still == PedestrianMotion::default() && still.is_foreseeable());
    assert_eq!(PedestrianMotion::of(&[], 0.05), PedestrianMotion::default());
}

#[test]
fn each_bound_alone_decides() {
    let kept = PedestrianMotion { unsteadiness: 1.0, ..PedestrianMotion::FORESEEABLE };
    assert!(kept.is_foreseeable());
    for motion in [
        PedestrianMotion { peak_speed: 2.23, ..kept },
        PedestrianMotion { peak_acceleration: 2.13, ..kept },
        PedestrianMotion { velocity_change: 1.66, ..kept },
    ] {
        assert!(!motion.is_foreseeable(), "{motion:?}");
    }
    let cyclist = PedestrianMotion { peak_speed: 4.2, peak_acceleration: 1.0, ..kept };
    assert!(cyclist.is_foreseeable() && cyclist.is_fast());
    assert!(!PedestrianMotion { peak_acceleration: 1.01, ..cyclist }.is_foreseeable());
}

#[test]
fn a_motion_is_one_of_half_a_second_in_the_last_three() {
    // A sudden start is one, with a state before it or without.
    for before in [0.05, 1.0] {
        let start = PedestrianMotion::of(&walked(&[(before, (0.0, 0.0)), (1.0, (1.4, 0.0))]), 0.05);
        assert!((start.peak_acceleration - 2.8).abs() < 1e-9 && !start.is_foreseeable(), "{start:?}");
    }
    // A stumble of a tick is none.
    let stumble = walked(&[(1.0, (1.4, 0.0)), (0.05, (0.0, 0.0)), (1.0, (1.4, 0.0))]);
    assert!(PedestrianMotion::of(&stumble, 0.05).is_foreseeable());
    // What is more than three seconds ago is forgotten: a jogger who stopped at once, and now stands.
    for (stands, foreseeable) in [(2.0, false), (3.5, true)] {
        let stopped = PedestrianMotion::of(&walked(&[(2.0, (2.8, 0.0)), (stands, (0.0, 0.0))]), 0.05);
        assert_eq!(stopped.is_foreseeable(), foreseeable, "{stands} s: {stopped:?}");
    }
    // A jogger who keeps the speed or slows down gently is foreseeable, one who changes it at once is not.
    assert!(PedestrianMotion::of(&walked(&[(4.0, (2.8, 0.0))]), 0.05).is_foreseeable());
    let slowing: Vec<_> = (0..60).map(|tick| (3.2 - 0.3 * 0.05 * f64::from(tick), 0.0)).collect();
    assert!(PedestrianMotion::of(&states(&slowing), 0.05).is_foreseeable());
    assert!(!PedestrianMotion::of(&walked(&[(2.0, (2.8, 0.0)), (2.0, (2.0, 0.0))]), 0.05).is_foreseeable());
    // Ticks longer than a second: only neighbours are compared.
    let slow = PedestrianMotion::of(&states(&[(0.0, 0.0), (1.0, 0.0), (2.0, 0.0)]), 1.5);
    assert_eq!(slow.velocity_change, 1.0);
}

proptest! {
    #[test]
    fn the_plausible_pedestrian_is_foreseeable_in_free_space_whatever_it_is_commanded(
        commands in prop::collection::vec((-3.2..3.2_f64, 0.0..=8.0 / 3.6, 1_u32..25), 1..60),
        dt in prop::sample::select(vec![0.01, 0.05, 0.1, 0.25]),
        reverses in any::<bool>(),
    ) {
        // `plausible` of std/pedestrians.scn; a test of the library compares the two.
        let gait = Gait::Inertial { acceleration: 1.65, stopping: 1.65, turn_rate: 80_f64.to_radians() };
        let body = PedestrianBody { gait, ..PedestrianBody::adult() };
        let mut walked = vec![PedestrianState::default()];
        let free = Obstacles::new(&[]);
        for (number, (heading, speed, ticks)) in commands.into_iter().enumerate() {
            let turned = if reverses && number % 2 == 1 { std::f64::consts::PI } else { 0.0 };
            let command = WalkCommand { heading: heading + turned, speed };
            for _ in 0..ticks {
                walked.push(walked[walked.len() - 1].step(command, &body, &free, dt));
            }
        }
        let motion = PedestrianMotion::of(&walked, dt);
        prop_assert!(motion.is_foreseeable(), "{motion:?}");
        // And so in every part of the episode.
        prop_assert!(PedestrianMotion::of(&walked[..walked.len() / 2], dt).is_foreseeable());
    }
}

#[test]
fn the_risk_of_severe_injury_is_that_of_the_published_speeds() {
    for (mph, wanted) in [(17.1, 0.10), (24.9, 0.25), (33.0, 0.50), (40.8, 0.75), (48.1, 0.90)] {
        let found = severe_injury_risk(mph * 0.447_04);
        assert!((found - wanted).abs() < 0.02, "{mph} mph: {found}");
    }
}

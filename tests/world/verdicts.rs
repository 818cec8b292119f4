//! Parts of a verdict: whether people move so, and how severe an impact is.

use proptest::prelude::*;
use world::geometry::{Obstacles, Vector};
use world::judge::{PedestrianMotion, fatality_risk, severe_injury_risk};
use world::sim::{Gait, PedestrianBody, PedestrianState, WalkCommand};

fn states(velocities: &[(f64, f64)]) -> Vec<PedestrianState> {
    let state = |(x, y): &(f64, f64)| PedestrianState { velocity: Vector::new(*x, *y), ..Default::default() };
    velocities.iter().map(state).collect()
}

#[test]
fn turning_counts_as_much_as_speeding_up() {
    // A quarter turn at 1.4 m/s in one tick of 50 ms.
    let motion = PedestrianMotion::of(&states(&[(1.4, 0.0), (1.4, 0.0), (0.0, 1.4)]), 0.05);
    assert_eq!(motion.peak_speed, 1.4);
    assert!((motion.peak_acceleration - 1.4 * 2.0_f64.sqrt() / 0.05).abs() < 1e-9);
    assert!((motion.velocity_change - 1.4 * 2.0_f64.sqrt()).abs() < 1e-12);
    assert!(!motion.is_foreseeable());
    let still = PedestrianMotion::of(&states(&[(0.0, 0.0)]), 0.05);
    assert!(still == PedestrianMotion::default() && still.is_foreseeable());
    assert_eq!(PedestrianMotion::of(&[], 0.05), PedestrianMotion::default());
}

#[test]
fn each_bound_alone_decides() {
    let kept = PedestrianMotion::FORESEEABLE;
    assert!(kept.is_foreseeable());
    for motion in [
        PedestrianMotion { peak_speed: 2.23, ..kept },
        PedestrianMotion { peak_acceleration: 2.13, ..kept },
        PedestrianMotion { velocity_change: 1.66, ..kept },
    ] {
        assert!(!motion.is_foreseeable(), "{motion:?}");
    }
}

#[test]
fn a_detour_within_a_second_is_found_where_its_ends_are_equal() {
    // 0.8 m/s forwards within half a second and back: after a second the velocity is the same.
    let there_and_back: Vec<(f64, f64)> =
        (0..=10).map(|tick| (f64::from(5 - i32::abs(tick - 5)) * 0.16, 0.0)).collect();
    let motion = PedestrianMotion::of(&states(&there_and_back), 0.1);
    assert!((motion.velocity_change - 0.8).abs() < 1e-12, "{motion:?}");
    // Ticks longer than a second: only neighbours are compared.
    let slow = PedestrianMotion::of(&states(&[(0.0, 0.0), (1.0, 0.0), (2.0, 0.0)]), 1.5);
    assert_eq!(slow.velocity_change, 1.0);
}

/// By comparing every pair of states.
fn by_pairs(states: &[PedestrianState], longest: usize) -> f64 {
    let near = |(i, a): (usize, &PedestrianState)| {
        let later = states[i..].iter().take(longest + 1);
        later.map(|b| (b.velocity - a.velocity).norm()).fold(0.0, f64::max)
    };
    states.iter().enumerate().map(near).fold(0.0, f64::max)
}

proptest! {
    #[test]
    fn stretches_give_what_a_comparison_of_all_states_gives(
        steps in prop::collection::vec((-1.0..1.0_f64, -1.0..1.0_f64, any::<bool>()), 0..80),
    ) {
        let mut velocity = (0.0, 0.0);
        let walked: Vec<(f64, f64)> = steps.iter().map(|(x, y, turns)| {
            velocity = if *turns { (*x, *y) } else { velocity };
            velocity
        }).collect();
        let states = states(&walked);
        let motion = PedestrianMotion::of(&states, 0.05);
        prop_assert!((motion.velocity_change - by_pairs(&states, 20)).abs() < 1e-12);
    }

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
fn the_risk_of_death_grows_with_the_speed_as_published() {
    let risk = |kmh: f64| fatality_risk(kmh / 3.6);
    // "more than twice as high as the risk at 40 km/h and more than five times higher than the risk at 30 km/h"
    assert!(risk(50.0) > 2.0 * risk(40.0) && risk(50.0) > 5.0 * risk(30.0));
    assert!((risk(50.0) - 0.083).abs() < 1e-3, "{}", risk(50.0));
}

#[test]
fn the_risk_of_severe_injury_is_that_of_the_published_speeds() {
    for (mph, wanted) in [(17.1, 0.10), (24.9, 0.25), (33.0, 0.50), (40.8, 0.75), (48.1, 0.90)] {
        let found = severe_injury_risk(mph * 0.447_04);
        assert!((found - wanted).abs() < 0.02, "{mph} mph: {found}");
    }
}

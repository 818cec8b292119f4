use proptest::prelude::*;

use super::encounter::Step;
use super::*;
use crate::geometry::{Point, Pose, Vector};

const HALF: Vector = Vector::new(2.2, 0.9);
const RADIUS: f64 = 0.25;

/// A car that drives east at a constant speed (m/s). Its bumper is at this distance (m) from a pedestrian at its left with this velocity
/// (m/s).
fn crossing(speed: f64, gap: f64, aside: f64, velocity: Vector) -> Encounter {
    let path = DrivenPath::new([Pose::new(0.0, 0.0, 0.0), Pose::new(1.0, 0.0, 0.0)]);
    let dt = 0.05;
    let begin = Point::new(HALF.x + gap + RADIUS, aside);
    let steps = (0..400).map(|tick| {
        let position = begin + velocity * (f64::from(tick) * dt);
        Step { position, place: path.place(position, 0.0), velocity }
    });
    Encounter {
        steps: steps.collect(),
        path: path.clone(),
        start: 0.0,
        pace: vec![speed],
        warning: gap / speed,
        impact_speed: speed,
        dt,
        half: HALF,
        radius: RADIUS,
    }
}

fn trial(encounter: &Encounter, reference: Reference) -> Trial {
    Trial::new(encounter, reference.driver().as_mut())
}

#[test]
fn for_somebody_who_stands_in_the_way_the_closed_forms_hold() {
    use crate::av::reference_drivers::DelayedBrake;
    let human = DelayedBrake::careful_human().profile;
    for (reference, profile) in [
        (Reference::CarefulHuman, human),
        (Reference::IdealBrake, DelayedBrake::ideal().profile),
        (Reference::Bound, DelayedBrake::bound().profile),
    ] {
        for speed in [2.0, 5.0, 8.0, 14.0] {
            let needed = profile.stopping_distance(speed);
            let before = trial(&crossing(speed, needed + 0.02, 0.0, Vector::zeros()), reference);
            assert!(before.is_avoided() && (before.least_gap - 0.02).abs() < 5e-3, "{reference:?} {speed}: {before:?}");
            let short = 0.5;
            let hit = trial(&crossing(speed, needed - short, 0.0, Vector::zeros()), reference);
            let wanted = (2.0 * profile.full * short).sqrt();
            // Slower cars stop within the ramp and are softer at the end.
            if speed > profile.full * profile.ramp / 2.0 + wanted {
                assert!((hit.impact_speed.unwrap() - wanted).abs() < 0.05, "{reference:?} {speed}: {hit:?}");
            }
        }
    }
}

#[test]
fn a_careful_human_at_two_seconds_begins_when_the_gap_is_two_seconds() {
    // From 8 m/s it needs 12.2 m and has 16 m. A driver that waits for 1.15 s also has them if it saw the danger at once.
    let far = crossing(8.0, 40.0, 0.0, Vector::zeros());
    let (late, early) = (trial(&far, Reference::CarefulHumanAtTwoSeconds), trial(&far, Reference::CarefulHuman));
    assert!(late.is_avoided() && early.is_avoided());
    assert!(early.least_gap > late.least_gap + 10.0, "{early:?} {late:?}");
    let needed = crate::av::reference_drivers::BrakeProfile::careful_human(0.75).stopping_distance(8.0);
    assert!((late.least_gap - (16.0 - needed)).abs() < 0.1, "{late:?}");
}

#[test]
fn until_it_interferes_a_driver_drives_as_the_recorded_car_did() {
    let mut encounter = crossing(0.0, 12.0, 0.0, Vector::zeros());
    // The recorded car accelerates at 2 m/s², brakes at the end and hits: its braking is not inherited.
    encounter.pace = (0..60).map(|tick| 0.1 * f64::from(tick)).collect();
    let gate = trial(&encounter, Reference::CarefulHumanAtTwoSeconds);
    assert!(gate.time > 2.0 && gate.is_avoided(), "{gate:?}");
    let bound = trial(&encounter, Reference::Bound);
    assert!(bound.is_avoided() && (bound.least_gap - 12.0).abs() < 0.1, "it never starts: {bound:?}");
}

#[test]
fn somebody_who_runs_out_at_the_last_moment_is_hit_by_all() {
    let out = crossing(10.0, 4.0, 1.6, Vector::new(0.0, -3.0));
    for reference in Reference::ALL {
        assert!(!trial(&out, reference).is_avoided(), "{reference:?}");
    }
}

#[test]
fn a_walker_who_crosses_in_time_is_not_hit_and_the_gap_is_that_of_the_passing() {
    // In the lane for 2.3 m at 2 m/s; the car is there after 2 s and does not brake.
    let clear = crossing(8.0, 16.0, 1.0, Vector::new(0.0, 3.0));
    let rss = trial(&clear, Reference::FuzzySafety);
    assert!(rss.is_avoided() && rss.least_gap > 1.0, "{rss:?}");
}

proptest! {
    #[test]
    fn the_bound_judges_no_slower_car_worse(speed in 1.0..20.0f64, slower in 0.0..1.0f64, gap in 0.5..40.0f64) {
        let impact = |speed| {
            trial(&crossing(speed, gap, 0.0, Vector::zeros()), Reference::Bound).impact_speed.unwrap_or(0.0)
        };
        prop_assert!(impact(speed * slower.max(0.05)) <= impact(speed) + 1e-6);
    }

    #[test]
    fn no_brake_that_comes_later_and_softer_does_better_for_somebody_who_stays(speed in 1.0..20.0f64, gap in 0.5..40.0f64) {
        let impact = |reference| {
            trial(&crossing(speed, gap, 0.0, Vector::zeros()), reference).impact_speed.unwrap_or(0.0)
        };
        prop_assert!(impact(Reference::Bound) <= impact(Reference::IdealBrake) + 1e-6);
        prop_assert!(impact(Reference::IdealBrake) <= impact(Reference::CarefulHuman) + 1e-6);
    }
}

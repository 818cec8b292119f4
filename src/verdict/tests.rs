use proptest::prelude::*;

use super::encounter::{CarMotion, Step};
use super::trial::FreeRun;
use super::*;
use road::geometry::{Point, Pose, Vector};
use world::av::reference_drivers::{BrakeProfile, DelayedBrake, Gate, OwnMotion};

const HALF: Vector = Vector::new(2.2, 0.9);
const RADIUS: f64 = 0.25;

/// A car that drives east at a constant speed (m/s). Its bumper is at this distance (m) from a pedestrian at its left with this velocity
/// (m/s).
fn crossing(speed: f64, gap: f64, aside: f64, velocity: Vector) -> Encounter<'static> {
    let path = DrivenPath::new([Pose::new(0.0, 0.0, 0.0), Pose::new(1.0, 0.0, 0.0)]);
    let dt = 0.05;
    let begin = Point::new(HALF.x + gap + RADIUS, aside);
    let steps = (0..400).map(|tick| {
        let position = begin + velocity * (f64::from(tick) * dt);
        Step { position, place: path.place(position, 0.0), velocity }
    });
    Encounter::of_steps(path.clone(), CarMotion::of_speeds(vec![speed], dt), steps.collect(), (HALF, RADIUS), dt)
}

/// A car at a constant speed (m/s) on a dry road.
fn own(speed: f64) -> OwnMotion {
    OwnMotion { speed, acceleration: 0.0, intended: 0.0, length: 2.0 * HALF.x, brake: f64::INFINITY }
}

fn trial(encounter: &Encounter<'static>, reference: Reference) -> Trial {
    Trial::new(&mut encounter.clone(), reference.driver().as_mut())
}

#[test]
fn for_somebody_who_stands_in_the_way_the_closed_forms_hold() {
    let human = DelayedBrake::careful_human().profile;
    for (reference, profile) in [
        (Reference::CarefulHuman, human),
        (Reference::IdealBrake, DelayedBrake::ideal().profile),
        (Reference::Bound, DelayedBrake::bound().profile),
    ] {
        for speed in [2.0, 5.0, 8.0, 14.0] {
            let needed = profile.stopping_distance(speed);
            assert!(needed < Gate::CAREFUL.opens(&own(speed)) * speed, "the gate opens in time");
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
fn a_careful_human_starts_to_react_in_time_to_stop() {
    // At 8 m/s the gate opens 2.277 s ahead, whatever the distance at which the danger started.
    let opens = 1.75 + 8.0 / (2.0 * 0.774 * 9.81);
    assert_eq!(Gate::CAREFUL.opens(&own(8.0)), opens);
    assert_eq!(Gate::CAREFUL.opens(&own(1.0)), 2.0);
    for (reference, wait) in [(Reference::CarefulHuman, 1.15), (Reference::AttentiveHuman, 0.75)] {
        let needed = BrakeProfile::careful_human(wait).stopping_distance(8.0);
        for gap in [20.0, 40.0, 60.0] {
            let found = trial(&crossing(8.0, gap, 0.0, Vector::zeros()), reference);
            assert!(found.is_avoided() && (found.least_gap - (8.0 * opens - needed)).abs() < 0.1, "{gap} m: {found:?}");
        }
    }
    // At any speed it stops before a person who stands in the lane in view.
    for speed in [5.0, 10.0, 14.0, 20.0, 30.0] {
        let standing = trial(&crossing(speed, 150.0, 0.0, Vector::zeros()), Reference::CarefulHuman);
        assert!(standing.is_avoided() && standing.least_gap > 0.3, "{speed}: {standing:?}");
    }
}

#[test]
fn until_it_interferes_a_driver_drives_as_the_recorded_car_did() {
    // The recorded car accelerates at 2 m/s².
    let standing_start = |pause: u32, gap: f64| {
        let of = crossing(0.0, gap, 0.0, Vector::zeros());
        let speeds = (0..90_u32).map(|tick| 0.1 * f64::from(tick.saturating_sub(pause))).collect();
        Encounter::of_steps(of.path, CarMotion::of_speeds(speeds, of.dt), of.steps, (HALF, RADIUS), of.dt)
    };
    let human = trial(&standing_start(0, 12.0), Reference::CarefulHuman);
    assert!(human.moved && human.is_avoided() && human.least_gap < 8.0, "{human:?}");
    let bound = trial(&standing_start(0, 12.0), Reference::Bound);
    assert!(bound.is_avoided() && !bound.moved, "it never drives off: {bound:?}");
    // A driver that is about to pull away knows it, and does not drive off.
    for reference in [Reference::CarefulHuman, Reference::AttentiveHuman] {
        for pause in [0, 30] {
            let found = trial(&standing_start(pause, 0.5), reference);
            assert!(found.is_avoided() && !found.moved, "{reference:?}: {found:?}");
        }
    }
}

#[test]
fn a_pedestrian_who_will_not_meet_the_car_is_let_be() {
    // It comes when the car has passed, stands beside the path, or leaves it before the car is there.
    for (aside, velocity) in [(4.6, Vector::new(0.0, -1.0)), (3.0, Vector::zeros()), (0.0, Vector::new(0.0, 2.0))] {
        let passing = crossing(8.0, 10.0 + 6.0, aside, velocity);
        for human in [Reference::CarefulHuman, Reference::AttentiveHuman, Reference::IdealBrake] {
            let found = trial(&passing, human);
            assert!(found.is_avoided() && !found.braked, "{aside} m, {velocity}: {found:?}");
        }
    }
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

/// The inquiry's way to a trial: the shared run without a brake, and braking from there.
fn shared(encounter: &Encounter<'static>, driver: &DelayedBrake) -> Trial {
    let mut encounter = encounter.clone();
    let free = FreeRun::new(&mut encounter);
    let noticed = free.noticed(&encounter, driver);
    free.braked(&mut encounter, driver.clone(), noticed)
}

proptest! {
    #[test]
    fn drivers_that_share_the_run_up_to_their_braking_fare_as_if_alone(
        speed in 0.0..15.0f64, acceleration in 0.0..3.0f64, gap in 0.5..40.0f64, aside in -6.0..6.0f64,
        across in -3.0..3.0f64, wait in 0.0..2.0f64, gated in proptest::bool::ANY,
    ) {
        let of = crossing(speed, gap, aside, Vector::new(0.0, across));
        let speeds = (0..80).map(|tick| speed + acceleration * 0.05 * f64::from(tick)).collect();
        let motion = CarMotion::of_speeds(speeds, of.dt);
        let encounter = Encounter::of_steps(of.path, motion, of.steps, (HALF, RADIUS), of.dt);
        let driver = DelayedBrake::new(gated.then_some(Gate::CAREFUL), BrakeProfile::careful_human(wait));
        let (alone, shared) = (Trial::new(&mut encounter.clone(), &mut driver.clone()), shared(&encounter, &driver));
        prop_assert!((alone.time - shared.time).abs() < 0.011, "{alone:?} {shared:?}");
        prop_assert!((alone.least_gap - shared.least_gap).abs() < 1e-6, "{alone:?} {shared:?}");
        let speeds = (alone.impact_speed.unwrap_or(0.0), shared.impact_speed.unwrap_or(0.0));
        prop_assert!((speeds.0 - speeds.1).abs() < 1e-6, "{alone:?} {shared:?}");
    }

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

proptest! {
    #[test]
    fn the_nearest_vertex_of_a_path_of_many_laps_is_found(
        seed in 0_u64..1000,
        from in 0.0..4000.0_f64,
        place in (-60.0..60.0_f64, -60.0..60.0_f64),
    ) {
        // Laps of a circle whose radius grows and shrinks.
        let radius = |step: f64| 30.0 + 8.0 * libm::sin(step * 0.013 + seed as f64);
        let pose = |step: f64| Pose::new(radius(step) * libm::cos(0.02 * step), radius(step) * libm::sin(0.02 * step), 0.0);
        let path = DrivenPath::new((0..6000).map(|step| pose(f64::from(step))));
        let point = Point::new(place.0, place.1);
        let first = path.vertices.partition_point(|(at, _)| *at <= from).max(1) - 1;
        let apart = |index: &usize| (point - path.vertices[*index].1.position()).norm_squared();
        let all = first..path.vertices.len();
        let nearest = all.reduce(|best, index| if apart(&index) < apart(&best) { index } else { best });
        prop_assert_eq!(Some(path.nearest_vertex(point, first)), nearest);
    }
}

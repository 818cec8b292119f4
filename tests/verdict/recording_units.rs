//! Units of recordings: those that do not fit each other are refused, with their likely cause.

use std::f64::consts::{FRAC_PI_2, PI};

use base::seed::Seed;
use rand::RngExt;
use road::geometry::{Pose, wrap_angle};
use verdict::{Recording, RecordingError};
use world::sim::{PedestrianState, VehicleState};

const DT: f64 = 0.05;
const DEGREES: &str = "the numbers look like degrees where radians are needed";

/// Whose track it is.
#[derive(Debug, Clone, Copy)]
enum TrackOf {
    Car,
    Pedestrian,
}

const CAR: TrackOf = TrackOf::Car;

#[derive(Debug, Clone, PartialEq)]
enum Misfit {
    Speed { ratio: f64, likely: String },
    Heading { degrees: f64, likely: &'static str },
}

/// What is said of the poses and speeds (m/s) of one of the two; the other stands far away.
fn misfit(track: &[(Pose, f64)], dt: f64, of: TrackOf) -> Option<Misfit> {
    let far = Pose::new(500.0, 500.0, 0.0);
    let car = |(pose, speed): &(Pose, f64)| VehicleState { pose: *pose, speed: *speed, ..VehicleState::default() };
    let walker = |(pose, speed): &(Pose, f64)| PedestrianState::moving(*pose, *speed);
    let all = |pose, speed| vec![(pose, speed); track.len()];
    let (cars, walkers) = match of {
        TrackOf::Car => (track.to_vec(), all(far, 0.0)),
        TrackOf::Pedestrian => (all(far, 0.0), track.to_vec()),
    };
    match Recording::new(dt, cars.iter().map(car).collect(), walkers.iter().map(walker).collect()) {
        Err(RecordingError::Units { ratio, likely, .. }) => Some(Misfit::Speed { ratio, likely }),
        Err(RecordingError::Heading { degrees, likely, .. }) => Some(Misfit::Heading { degrees, likely }),
        Err(error) => panic!("{error}"),
        Ok(_) => None,
    }
}

/// Three seconds at a speed (m/s) along a bend that begins with a heading (rad).
fn driven(speed: f64, heading: f64) -> Vec<(Pose, f64)> {
    let mut pose = Pose::new(40.0, -7.0, heading);
    let mut track = Vec::new();
    for _ in 0..60 {
        track.push((pose, speed));
        let (sin, cos) = libm::sincos(pose.yaw);
        pose = Pose::new(pose.x + speed * DT * cos, pose.y + speed * DT * sin, wrap_angle(pose.yaw + 0.002));
    }
    track
}

fn changed(track: &[(Pose, f64)], mut change: impl FnMut(Pose, f64) -> (Pose, f64)) -> Vec<(Pose, f64)> {
    track.iter().map(|(pose, speed)| change(*pose, *speed)).collect()
}

fn headed(track: &[(Pose, f64)], change: impl Fn(f64) -> f64) -> Vec<(Pose, f64)> {
    changed(track, |pose, speed| (Pose { yaw: change(pose.yaw), ..pose }, speed))
}

#[test]
fn honest_recordings_pass() {
    let mut stream = Seed::root(3).stream();
    for heading in [-3.0, -1.2, 0.0, 0.03, 0.7, 1.57, 2.9] {
        for speed in [1.0, 1.4, 9.0, 30.0] {
            let track = driven(speed, heading);
            for of in [CAR, TrackOf::Pedestrian] {
                assert_eq!(misfit(&track, DT, of), None, "{speed} m/s, {heading} rad");
            }
            let backwards = headed(&track, |yaw| wrap_angle(yaw + PI));
            let found = misfit(&backwards, DT, CAR);
            assert_eq!(found.is_none(), speed < 5.0, "{speed} m/s backwards, {heading} rad: {found:?}");
            assert!(misfit(&backwards, DT, TrackOf::Pedestrian).is_some(), "{speed} m/s");
            let mut draw = |size: f64| stream.random_range(-size..size);
            let noisy: Vec<_> = track
                .iter()
                .map(|(pose, speed)| {
                    let pose = Pose::new(pose.x + draw(0.15), pose.y + draw(0.15), pose.yaw + draw(0.1));
                    (pose, (speed + draw(0.3)).max(0.0))
                })
                .collect();
            assert_eq!(misfit(&noisy, DT, CAR), None, "{speed} m/s with noise, {heading} rad");
        }
    }
    let shaky: Vec<_> =
        (0..2000).map(|_| (Pose::new(stream.random(), stream.random(), stream.random()), 0.0)).collect();
    assert_eq!(misfit(&shaky, DT, CAR), None, "a standing actor");
}

/// Near 45 degrees a compass bearing is nearly the heading, so noise decided which of them fits.
#[test]
fn noise_of_a_few_centimetres_is_not_taken_for_compass_bearings() {
    let mut stream = Seed::root(5).stream();
    for heading in [-2.23, 0.65, 0.785, 0.95] {
        for _ in 0..200 {
            let mut draw = || stream.random_range(-0.05..0.05);
            let noisy = changed(&driven(1.4, heading)[..25], |pose, speed| {
                (Pose::new(pose.x + draw(), pose.y + draw(), pose.yaw), speed)
            });
            let found = misfit(&noisy, DT, TrackOf::Pedestrian);
            assert!(!matches!(found, Some(Misfit::Heading { .. })), "{heading} rad: {found:?}");
        }
    }
}

#[test]
fn a_speed_that_is_wrong_by_a_tenth_is_named() {
    let mut stream = Seed::root(4).stream();
    for factor in [0.8, 0.9, 0.93, 1.07, 1.1, 1.25] {
        for noise in [0.0, 0.02] {
            let mut draw = || stream.random_range(-1.0..1.0) * noise;
            let track = changed(&driven(9.0, 0.4), |pose, speed| {
                (Pose::new(pose.x + draw(), pose.y + draw(), pose.yaw), factor * speed)
            });
            let Some(Misfit::Speed { ratio, likely }) = misfit(&track, DT, CAR) else { panic!("{factor} {noise}") };
            assert!((ratio * factor - 1.0).abs() < 0.02 && likely.starts_with("multiply the speeds by"), "{ratio}");
        }
    }
}

#[test]
fn units_that_do_not_fit_are_named() {
    for heading in [-2.5, 0.4, 1.57] {
        let track = driven(10.0, heading);
        let said = |track: &[(Pose, f64)], dt| match misfit(track, dt, CAR) {
            Some(Misfit::Speed { ratio, likely }) => format!("{ratio:.2}: {likely}"),
            Some(Misfit::Heading { likely, .. }) => likely.to_owned(),
            None => "nothing".to_owned(),
        };
        let scaled = |factor: f64| changed(&track, |pose, speed| (pose, factor * speed));
        assert_eq!(said(&scaled(3.6), DT), "0.28: the speeds look like km/h; give m/s");
        assert_eq!(said(&scaled(1.0 / 0.44704), DT), "0.45: the speeds look like mph; give m/s");
        let step = "with these speeds an instant would be 0.05 s after the one before";
        assert_eq!(said(&track, DT / 10.0), format!("10.00: {step}"));
        assert_eq!(said(&track, DT * 2.0), format!("0.50: {step}"));
        assert_eq!(said(&scaled(0.3048), DT), "3.28: the positions look like feet; give m");
        assert_eq!(said(&scaled(0.01), DT), "100.00: the positions look like centimetres; give m");
        assert!(said(&scaled(0.0), DT).ends_with("its positions move and its speeds are near 0"));
        let degrees = said(&headed(&track, f64::to_degrees), DT);
        assert_eq!(degrees, DEGREES, "{heading}");
        // Also where no reading fits.
        assert_eq!(said(&headed(&track, |_| 90.0), DT), DEGREES, "{heading}");
    }
    for heading in [0.1, -0.2, 0.35, 0.6, 2.9] {
        let mirrored = changed(&driven(10.0, heading), |pose, speed| (Pose { y: -pose.y, ..pose }, speed));
        let Some(Misfit::Heading { likely, .. }) = misfit(&mirrored, DT, CAR) else { panic!("{heading} rad") };
        assert!(likely.starts_with("they look left-handed"), "{heading} rad: {likely}");
    }
    for heading in [0.1, 0.5, -0.6, 2.9] {
        let bearings = headed(&driven(10.0, heading), |yaw| FRAC_PI_2 - yaw);
        let Some(Misfit::Heading { likely, .. }) = misfit(&bearings, DT, CAR) else { panic!("{heading} rad") };
        assert!(likely.starts_with("they look like compass bearings"), "{heading} rad: {likely}");
    }
    for (track, cause) in [
        (changed(&driven(10.0, 0.3), |pose, speed| (pose, -speed)), "its speed is negative"),
        (headed(&driven(10.0, 0.3), |yaw| wrap_angle(yaw + PI)), "a car that reverses has a negative speed"),
    ] {
        let Some(Misfit::Heading { likely, degrees }) = misfit(&track, DT, CAR) else { panic!("{cause}") };
        assert!(likely.starts_with(cause) && degrees > 170.0, "{likely}");
    }
    // A pedestrian who walks for a metre.
    let short = |change: f64, turned: f64| {
        let track =
            changed(&driven(1.4, 0.9)[..20], |pose, speed| (Pose { yaw: pose.yaw + turned, ..pose }, change * speed));
        misfit(&track, DT, TrackOf::Pedestrian)
    };
    assert_eq!(short(1.0, 0.0), None);
    assert!(
        matches!(short(3.6, 0.0), Some(Misfit::Speed { .. }))
            && matches!(short(1.0, 1.5), Some(Misfit::Heading { .. }))
    );
    let along_y = headed(&driven(10.0, 1.57), f64::to_radians);
    let Some(Misfit::Heading { degrees, likely }) = misfit(&along_y, DT, CAR) else { panic!("{along_y:?}") };
    assert_eq!(likely, "the numbers look like radians where degrees are needed");
    assert!((80.0..92.0).contains(&degrees), "{degrees}");
}

//! Reference drivers against closed forms, and in Euro NCAP's crossing tests in steps of a millisecond.

use world::av::reference_drivers::{
    BrakeProfile, DelayedBrake, Gate, OwnMotion, ReferenceDriver, Rss, RssLimits, Threat, lateral_distance,
    longitudinal_distance,
};

/// Width of the car (m).
const WIDTH: f64 = 1.815;
/// From the bumper back to the eye (m).
const EYE: f64 = 1.9;

/// A pedestrian that crosses the path of the car from the right.
struct Crossing {
    /// Share of the width at which the bumper would meet the reference point.
    impact: f64,
    /// Speed (m/s).
    speed: f64,
    /// From the reference point to the front and to the back (m).
    body: (f64, f64),
    /// Extent along the car's way (m).
    breadth: f64,
    /// How far before the reference point (m) the part is that must be in sight; none in the open.
    hidden: Option<f64>,
}

impl Crossing {
    /// The speed at the impact (m/s) of a car with this initial speed (km/h); 0 without an impact.
    fn drive(&self, kmh: f64, driver: &mut dyn ReferenceDriver) -> f64 {
        let dt = 1e-3;
        let (mut speed, mut time, mut acceleration) = (kmh / 3.6, -6.0, 0.0);
        let mut bumper = speed * time;
        let mut seen = false;
        driver.begin();
        while speed > 0.0 && bumper < 10.0 {
            let place = WIDTH * (self.impact - 0.5) + self.speed * time;
            let (front, back) = (place + self.body.0, place - self.body.1);
            if bumper >= 0.0 && bumper <= self.breadth && front >= -WIDTH / 2.0 && back <= WIDTH / 2.0 {
                return speed;
            }
            seen |= self.hidden.is_none_or(|ahead| self.sees(bumper, place + ahead));
            let threat = Threat {
                gap: -bumper,
                length: self.breadth,
                offset: ((front + back) / 2.0).abs(),
                reach: (WIDTH + self.body.0 + self.body.1) / 2.0,
                along: 0.0,
                towards: if front + back < 0.0 { self.speed } else { -self.speed },
            };
            let own = OwnMotion { speed, acceleration, intended: 0.0, length: 4.358, brake: f64::INFINITY };
            let braking = driver.brake(&own, seen.then_some(&threat), dt).unwrap_or(0.0);
            bumper += speed * dt - braking * dt * dt / 2.0;
            speed = (speed - braking * dt).max(0.0);
            acceleration = -braking;
            time += dt;
        }
        0.0
    }

    /// Whether the eye sees a place on the far edge of the walker's way past the corner of the parked car, which is a metre to
    /// the right of the test car and a metre before the near edge of the walker's way.
    fn sees(&self, bumper: f64, aside: f64) -> bool {
        let (eye, corner) = (bumper - EYE, (-1.0, -WIDTH / 2.0 - 1.0));
        eye >= corner.0 || aside * (corner.0 - eye) / (self.breadth - eye) >= corner.1
    }

    /// The greatest speed (km/h), in steps of 5 from 10 to 60, up to which all impacts are avoided.
    fn avoided(&self, driver: &mut dyn ReferenceDriver) -> f64 {
        let speeds = (2..=12).map(|step| f64::from(step) * 5.0);
        speeds.take_while(|kmh| self.drive(*kmh, driver) == 0.0).last().unwrap_or(0.0)
    }

    fn holds(&self, mut driver: DelayedBrake, avoided: f64, impacts: &[(f64, f64)]) {
        assert_eq!(self.avoided(&mut driver), avoided);
        for (kmh, wanted) in impacts {
            let found = self.drive(*kmh, &mut driver);
            assert!((found - wanted).abs() < 0.03, "{kmh} km/h: {found} m/s, not {wanted}");
        }
    }
}

fn adult(impact: f64, kmh: f64) -> Crossing {
    Crossing { impact, speed: kmh / 3.6, body: (0.36, 0.24), breadth: 0.5, hidden: None }
}

fn child(ahead: f64) -> Crossing {
    Crossing { impact: 0.5, speed: 5.0 / 3.6, body: (0.396, 0.315), breadth: 0.298, hidden: Some(ahead) }
}

#[test]
fn a_human_who_looks_two_seconds_ahead_stops_for_adults_in_the_open_as_tabulated() {
    let looks = |wait| {
        let gate = Gate { in_time: false, ..Gate::CAREFUL };
        DelayedBrake::new(Some(gate), BrakeProfile::careful_human(wait))
    };
    let (attentive, careful) = (|| looks(DelayedBrake::ATTENTIVE), || looks(DelayedBrake::CAREFUL));
    let (near, middle, far) = (adult(0.25, 5.0), adult(0.5, 8.0), adult(0.75, 5.0));
    near.holds(attentive(), 50.0, &[(55.0, 3.37), (60.0, 5.99)]);
    for walker in [&middle, &far] {
        walker.holds(attentive(), 55.0, &[(60.0, 5.99)]);
    }
    for walker in [&near, &middle, &far] {
        walker.holds(careful(), 30.0, &[(35.0, 3.41), (50.0, 8.68), (60.0, 11.71)]);
        // In time to stop, from any of the speeds.
        walker.holds(DelayedBrake::attentive_human(), 60.0, &[]);
        walker.holds(DelayedBrake::careful_human(), 60.0, &[]);
    }
}

#[test]
fn a_hidden_child_is_hit_by_a_careful_human_and_not_by_a_good_machine() {
    child(0.0).holds(DelayedBrake::careful_human(), 10.0, &[(15.0, 2.37), (30.0, 7.48), (50.0, 13.27)]);
    child(0.396).holds(DelayedBrake::careful_human(), 20.0, &[(25.0, 3.24), (30.0, 5.19), (50.0, 11.49)]);
    child(0.396).holds(DelayedBrake::attentive_human(), 35.0, &[(40.0, 2.09), (50.0, 6.91)]);
    child(0.396).holds(DelayedBrake::ideal(), 60.0, &[]);
}

fn own(speed: f64, intended: f64) -> OwnMotion {
    OwnMotion { speed, acceleration: 0.0, intended, length: 4.5, brake: f64::INFINITY }
}

fn walker(gap: f64, offset: f64, towards: f64) -> Threat {
    Threat { gap, length: 0.5, offset, reach: 1.25, along: 0.0, towards }
}

#[test]
fn the_time_to_collision_is_that_of_constant_speed_and_of_pulling_away() {
    assert_eq!(walker(16.0, 0.0, 0.0).time_to_collision(&own(8.0, 0.0)), 2.0);
    assert_eq!(walker(4.0, 0.0, 0.0).time_to_collision(&own(0.0, 2.0)), 2.0);
    assert_eq!(walker(4.0, 0.0, 0.0).time_to_collision(&own(0.0, 0.0)), f64::INFINITY);
    assert_eq!(walker(-1.0, 0.0, 0.0).time_to_collision(&own(0.0, 0.0)), 0.0);
    let away = Threat { along: 9.0, ..walker(1.0, 0.0, 0.0) };
    assert_eq!(away.time_to_collision(&own(8.0, 0.0)), f64::INFINITY);
}

#[test]
fn only_a_pedestrian_who_meets_the_car_is_on_course() {
    // The bumper arrives after 2 s and the rear has passed after 2.625 s and a tenth.
    let car = own(8.0, 0.0);
    for (offset, towards, expected, why) in [
        (0.0, 0.0, true, "stands in the path"),
        (1.7, 0.0, false, "stands beside it"),
        (4.0, 1.2, true, "comes in time"),
        (8.0, 1.0, false, "comes too late"),
        (1.75 + 2.724, 1.0, true, "comes within half a metre at the last moment"),
        (1.75 + 2.726, 1.0, false, "does not"),
        (1.0, 2.0, false, "has left on the other side"),
        (1.0, 1.37, true, "has nearly left on the other side"),
        (0.5, -1.0, false, "has turned back and left"),
    ] {
        assert_eq!(walker(16.0, offset, towards).is_on_course(&car), expected, "{why}");
    }
}

/// Distance to standstill in small steps.
fn driven(profile: &BrakeProfile, speed: f64) -> f64 {
    let (mut x, mut v, mut t, dt) = (0.0, speed, 0.0, 1e-4);
    while v > 0.0 {
        let a = profile.deceleration(t, dt);
        x += v * dt - a * dt * dt / 2.0;
        v -= a * dt;
        t += dt;
    }
    x
}

#[test]
fn stopping_distances_are_those_of_the_closed_form_table() {
    let speeds = [10.0, 18.0, 20.0, 24.0, 30.0, 35.0, 40.0, 50.0, 60.0];
    let late = [4.42, 8.78, 9.97, 12.48, 16.54, 20.21, 24.13, 32.73, 42.34];
    let early = [3.31, 6.78, 7.75, 9.81, 13.21, 16.32, 19.68, 27.17, 35.68];
    let times = [1.59, 1.76, 1.80, 1.87, 1.99, 2.08, 2.17, 2.36, 2.54];
    for (i, kmh) in speeds.into_iter().enumerate() {
        let v = kmh / 3.6;
        let found = BrakeProfile::careful_human(1.15).stopping_distance(v);
        assert!((found - late[i]).abs() < 0.0051 && (found / v - times[i]).abs() < 0.0051, "{kmh}: {found}");
        let found = BrakeProfile::careful_human(0.75).stopping_distance(v);
        assert!((found - early[i]).abs() < 0.0051, "{kmh}: {found}");
    }
}

#[test]
fn the_closed_form_is_what_the_steps_add_up_to() {
    let step = BrakeProfile { wait: 0.0, ramp: 0.0, full: 8.3385 };
    for profile in [BrakeProfile::careful_human(0.75), BrakeProfile { wait: 0.35, ramp: 0.6, full: 8.3385 }, step] {
        for speed in [0.5, 2.0, 2.4, 8.0, 16.0] {
            let closed = profile.stopping_distance(speed);
            assert!((driven(&profile, speed) - closed).abs() < 1e-3, "{profile:?} from {speed}: {closed}");
        }
    }
}

#[test]
fn distances_to_a_standing_pedestrian_are_those_of_the_table() {
    let rows = [
        (RssLimits::car(), [15.78, 21.35, 27.57, 53.44]),
        (RssLimits::jrc(), [8.97, 12.48, 16.42, 32.97]),
        (RssLimits::bare(), [4.06, 6.12, 8.50, 19.0]),
    ];
    for (limits, wanted) in rows {
        for (kmh, wanted) in [18.0, 24.0, 30.0, 50.0].into_iter().zip(wanted) {
            let found = longitudinal_distance(kmh / 3.6, 0.0, &limits);
            assert!((found - wanted).abs() < 0.02, "{kmh} km/h: {found}, not {wanted}");
        }
    }
    for behind in [1.0, 5.0] {
        assert_eq!(longitudinal_distance(behind, 30.0, &RssLimits::car()), 0.0, "somebody fast in front may be near");
    }
}

#[test]
fn a_pedestrian_gets_as_far_as_the_table_says() {
    for (speed, wanted) in [(0.0, 0.50), (1.39, 2.37), (2.22, 3.95), (3.5, 7.06)] {
        let found = RssLimits::pedestrian().braking_reach(speed);
        assert!((found - wanted).abs() < 0.006, "{speed} m/s: {found}");
    }
}

#[test]
fn two_side_by_side_need_the_margin_and_both_pushes() {
    // ρ = 1 s, a = 0.2, b = 0.8: each drifts 0.1 m and stops in 0.025 m.
    assert!((lateral_distance(0.0, 0.0, 1.0, 0.2, 0.8, 0.1) - 0.35).abs() < 1e-12);
    assert_eq!(lateral_distance(-3.0, 3.0, 1.0, 0.2, 0.8, 0.1), 0.0, "they part");
}

/// The recorded values of Intel's library; `tests/reference/ad_rss` computes them again where it is installed.
#[test]
fn distances_are_those_of_ad_rss() {
    let text = include_str!("../reference/ad_rss/distances.csv");
    let mut compared = 0;
    for line in text.lines().filter(|line| !line.starts_with('#')).skip(1) {
        let fields: Vec<&str> = line.split(',').collect();
        let number = |field: usize| fields[field].parse::<f64>().unwrap();
        let (first, second, wanted) = (number(2), number(3), number(4));
        let found = match (fields[0], fields[1]) {
            ("longitudinal", "car") => longitudinal_distance(first, second, &RssLimits::car()),
            ("longitudinal", "jrc") => longitudinal_distance(first, second, &RssLimits::jrc()),
            ("longitudinal", "bare") => longitudinal_distance(first, second, &RssLimits::bare()),
            ("longitudinal", "pedestrian") => longitudinal_distance(first, second, &RssLimits::pedestrian()),
            ("lateral", "car") => lateral_distance(first, second, 1.0, 0.2, 0.8, 0.1),
            other => panic!("{other:?}"),
        };
        assert!((found - wanted).abs() < 1e-5, "{line}: {found}");
        compared += 1;
    }
    assert_eq!(compared, 240);
}

#[test]
fn it_brakes_for_a_person_in_the_way_from_the_start() {
    let own = OwnMotion { speed: 5.0, acceleration: 0.0, intended: 0.0, length: 4.5, brake: f64::INFINITY };
    let standing = |gap| Threat { gap, length: 0.4, offset: 0.0, reach: 1.25, along: 0.0, towards: 0.0 };
    let mut rss = Rss::default();
    // 15.78 m of the car and 0.5 m of the pedestrian, which may start towards it.
    assert_eq!(rss.brake(&own, Some(&standing(16.3)), 0.05), None);
    assert_eq!(rss.brake(&own, Some(&standing(16.2)), 0.05), Some(4.0));
    assert_eq!(rss.brake(&own, Some(&standing(16.3)), 0.05), Some(0.0), "safe again, it keeps its speed");
}

#[test]
fn it_goes_on_when_the_pedestrian_was_to_stop() {
    let own = OwnMotion { speed: 8.0, acceleration: 0.0, intended: 0.0, length: 4.5, brake: f64::INFINITY };
    let walking =
        |aside, towards| Threat { gap: 8.0, length: 0.4, offset: 1.25 + aside, reach: 1.25, along: 0.0, towards };
    let mut rss = Rss::default();
    assert_eq!(rss.brake(&own, Some(&walking(3.0, 1.39)), 0.05), None, "it can stop within 2.37 m");
    assert_eq!(rss.brake(&own, Some(&walking(2.0, 1.39)), 0.05), None);
    rss.begin();
    assert_eq!(rss.brake(&own, Some(&walking(2.0, 1.39)), 0.05), Some(4.0), "a danger from the start");
}

//! Euro NCAP's crossing tests, driven by the careful human and the ideal brake, in steps of a millisecond.

use super::{BrakeProfile, DelayedBrake, Gate, OwnMotion, ReferenceDriver, Threat};

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
            let own = OwnMotion { speed, acceleration, intended: 0.0, length: 4.358 };
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

use std::f64::consts::{PI, TAU};

use super::{GRAVITY, OwnMotion, ReferenceDriver, Threat};

/// How far a car is beside the path that it follows.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Aside {
    /// Distance to the left of the path (m).
    pub offset: f64,
    /// Speed to the left (m/s).
    pub speed: f64,
}

/// A reference driver that also steers: once it brakes it moves to one side by a given distance, and brakes with what the tyres have left.
///
/// The lateral acceleration is one period of a sine, `(2π y/T²) sin(2π t/T)`, which moves the car by `y`. `T` is as short as two bounds allow: a
/// lateral acceleration of 0.44 g and of `v² / 5.5 m`, which the car's least turning radius allows, and a lateral jerk of 10 m/s³. The vector of both
/// accelerations stays within 0.774 g, and the car moves to the side by at most half of its speed.
///
/// # Source
/// 0.44 g: mean of 61 drivers who evaded a box that was dropped ahead of them (SAE 766060, quoted from a secondary source). Jerk and least
/// radius: our choice, of a wheel that turns by 520°/s at most. The steering reacts no faster than the brake, although no foot has to move.
pub struct Evading {
    driver: Box<dyn ReferenceDriver>,
    /// The distance that it moves, positive to the left (m).
    wanted: f64,
    aside: Aside,
    /// Since it began to steer, and the period T (s); none before.
    steering: Option<(f64, f64)>,
}

/// The greatest lateral acceleration (m/s²), its change (m/s³), and the least turning radius (m).
const SIDEWAYS: f64 = 0.44 * GRAVITY;
const JERK: f64 = 10.0;
const RADIUS: f64 = 5.5;
/// What the tyres hold together (m/s²).
const TYRES: f64 = 0.774 * GRAVITY;
/// Greatest lateral speed as a share of the car's.
const SLOPE: f64 = 0.5;

impl Evading {
    /// The distances that a driver tries, to either side (m).
    pub const WANTED: [f64; 4] = [1.2, -1.2, 2.2, -2.2];

    /// Makes one of a driver that brakes.
    pub fn new(driver: Box<dyn ReferenceDriver>, wanted: f64) -> Self {
        Self { driver, wanted, aside: Aside::default(), steering: None }
    }

    /// The time (s) in which a car of this speed (m/s) moves to a side by a distance (m).
    fn period(distance: f64, speed: f64) -> f64 {
        let most = SIDEWAYS.min(speed * speed / RADIUS).max(1e-3);
        (TAU * distance / most).sqrt().max((4.0 * PI * PI * distance / JERK).cbrt())
    }

    /// Simulates a step (s) at a speed (m/s); returns the lateral acceleration (m/s²).
    fn steer(&mut self, speed: f64, dt: f64) -> f64 {
        let wanted = self.wanted;
        let (time, period) = self.steering.unwrap_or_else(|| (0.0, Self::period(wanted.abs(), speed)));
        let next = (time + dt).min(period);
        self.steering = Some((next, period));
        // The integral of the acceleration, and of that.
        let planned = |time: f64| wanted / period * (1.0 - libm::cos(TAU * time / period));
        let place = |time: f64| wanted * (time / period - libm::sin(TAU * time / period) / TAU);
        let most = SLOPE * speed;
        let share = if planned(next).abs() > most { most / planned(next).abs() } else { 1.0 };
        self.aside.speed = planned(next) * share;
        self.aside.offset += (place(next) - place(time)) * share;
        TAU * wanted / (period * period) * libm::sin(TAU * time / period) * share
    }
}

impl ReferenceDriver for Evading {
    fn begin(&mut self) {
        self.driver.begin();
        (self.aside, self.steering) = (Aside::default(), None);
    }

    fn brake(&mut self, own: &OwnMotion, threat: Option<&Threat>, dt: f64) -> Option<f64> {
        let braking = self.driver.brake(own, threat, dt);
        if self.steering.is_none() && !braking.is_some_and(|braking| braking > 0.0) {
            return braking;
        }
        let across = self.steer(own.speed, dt);
        let left = (TYRES * TYRES - across * across).max(0.0).sqrt();
        braking.map(|braking| braking.min(left))
    }

    fn noticed_for(&self) -> f64 {
        self.driver.noticed_for()
    }

    fn aside(&self) -> Aside {
        self.aside
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::av::reference_drivers::DelayedBrake;

    /// The ways of the car (m) every hundredth of a second after it began to steer, at a constant speed (m/s).
    fn ways(wanted: f64, speed: f64) -> Vec<f64> {
        let threat = Threat { gap: 10.0, length: 0.5, offset: 0.0, reach: 1.2, along: 0.0, towards: 0.0 };
        let own = OwnMotion { speed, acceleration: 0.0, intended: 0.0, length: 4.5 };
        let mut driver = Evading::new(Box::new(DelayedBrake::bound()), wanted);
        driver.begin();
        let offset = |_| {
            let braking = driver.brake(&own, Some(&threat), 0.01).expect("it brakes at once");
            assert!((0.0..=TYRES).contains(&braking));
            driver.aside().offset
        };
        (0..400).map(offset).collect()
    }

    #[test]
    fn it_moves_by_the_wanted_distance_within_its_bounds() {
        for wanted in Evading::WANTED {
            let ways = ways(wanted, 14.0);
            assert!((ways[399] - wanted).abs() < 1e-9, "{wanted}: {}", ways[399]);
            let differences = |of: &[f64]| of.windows(2).map(|pair| (pair[1] - pair[0]) / 0.01).collect::<Vec<f64>>();
            let speeds = differences(&ways);
            let accelerations = differences(&speeds);
            let most = |of: &[f64]| of.iter().fold(0.0_f64, |most, each| most.max(each.abs()));
            assert!(most(&accelerations) <= SIDEWAYS + 1e-6, "{}", most(&accelerations));
            assert!(most(&differences(&accelerations)) <= JERK + 0.1, "{wanted}");
        }
        // 1.2 m take 1.68 s by the jerk; a slow car takes longer.
        assert!((Evading::period(1.2, 14.0) - 1.68).abs() < 0.01);
        assert!(Evading::period(1.2, 3.0) > 2.0);
    }

    #[test]
    fn a_car_that_hardly_moves_does_not_move_aside() {
        assert!(ways(1.2, 0.1)[399].abs() < 0.2);
    }
}

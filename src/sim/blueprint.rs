use super::Control;

/// Acceleration at one throttle: `at_rest + slope · v`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ThrottleLine {
    /// The throttle, 0 to 1.
    pub throttle: f64,
    /// Acceleration at rest (m/s²).
    pub at_rest: f64,
    /// Change of the acceleration with the speed (1/s).
    pub slope: f64,
}

/// Size and dynamics of a car model.
///
/// Every figure is a parameter because CARLA has them in binary assets. Many independent programs printed the sizes, one program printed
/// masses and torques, and the braking at low speed is from an unexplained report.
#[derive(Debug, Clone, PartialEq)]
pub struct VehicleBlueprint {
    /// Half of its length (m).
    pub half_length: f64,
    /// Half of its width, mirrors included (m).
    pub half_width: f64,
    /// Distance between the axles (m).
    pub wheelbase: f64,
    /// Angle of the front wheels at full steer and no speed (rad).
    pub greatest_wheel_angle: f64,
    /// Share of the wheel angle that the tyres follow; a kinematic bicycle with the full angle turns too sharply.
    pub steering_response: f64,
    /// Share of the greatest angle at each speed: pairs of (m/s, share), sorted.
    pub steering_curve: Vec<(f64, f64)>,
    /// Acceleration over throttle and speed, sorted by throttle; linear in between.
    pub throttle: Vec<ThrottleLine>,
    /// Deceleration at full brake (m/s²); linear in the brake.
    pub full_brake: f64,
    /// Below this speed (m/s) CARLA's cars brake harder than the brake pedal demands.
    pub low_speed: f64,
    /// The factor of that.
    pub low_speed_braking: f64,
    /// Time for which a car stands after it has been placed at rest (s).
    pub start_up_pause: f64,
}

const KMH: f64 = 1.0 / 3.6;

impl VehicleBlueprint {
    /// CARLA's `vehicle.tesla.model3`.
    ///
    /// # Source
    /// Dumps of a running CARLA 0.9.1x by several independent projects; braking 4 × 1500 Nm on 1845 kg and wheels of 0.37 m;
    /// CARLA issues #8112 and #3906 for the low speeds, #1640 for the pause.
    pub fn model3() -> Self {
        Self {
            half_length: 2.395_890,
            half_width: 1.081_725,
            wheelbase: 3.0046,
            throttle: vec![
                ThrottleLine { throttle: 0.0, at_rest: 0.0, slope: -0.1 },
                ThrottleLine { throttle: 1.0, at_rest: 4.69, slope: -0.1 },
            ],
            full_brake: 8.79,
            ..Self::carla()
        }
    }

    /// CARLA's `vehicle.lincoln.mkz_2017`, which LAV and InterFuser drive.
    ///
    /// # Source
    /// As for the Model 3; the throttle is the polynomial that carla_garage fitted at 20 Hz, as lines in the speed.
    pub fn mkz_2017() -> Self {
        let line = |throttle, at_rest, slope| ThrottleLine { throttle, at_rest, slope };
        Self {
            half_length: 2.450_842,
            half_width: 1.064_162,
            wheelbase: 2.871,
            throttle: vec![
                line(0.0, 0.0, -0.134),
                line(0.3, 0.0, -0.134),
                line(0.5, 1.33, -0.093),
                line(0.75, 3.87, -0.123),
                line(1.0, 7.56, -0.257),
            ],
            full_brake: 9.8,
            ..Self::carla()
        }
    }

    /// A middle-class car without CARLA's oddities: no pause, the same brake at every speed.
    pub fn generic() -> Self {
        Self {
            half_length: 2.35,
            half_width: 0.925,
            wheelbase: 2.8,
            greatest_wheel_angle: 35.0_f64.to_radians(),
            steering_response: 1.0,
            steering_curve: vec![(0.0, 1.0)],
            throttle: vec![
                ThrottleLine { throttle: 0.0, at_rest: 0.0, slope: -0.05 },
                ThrottleLine { throttle: 1.0, at_rest: 4.0, slope: -0.05 },
            ],
            full_brake: 9.0,
            low_speed: 5.0,
            low_speed_braking: 1.0,
            start_up_pause: 0.0,
        }
    }

    /// The figures that all of CARLA's cars share.
    fn carla() -> Self {
        Self {
            greatest_wheel_angle: 70.0_f64.to_radians(),
            steering_response: 0.7,
            steering_curve: vec![(0.0, 1.0), (20.0 * KMH, 0.9), (60.0 * KMH, 0.8), (120.0 * KMH, 0.7)],
            low_speed: 5.0,
            low_speed_braking: 2.0,
            start_up_pause: 1.5,
            ..Self::generic()
        }
    }

    /// Angle of the front wheels (rad), positive to the left.
    pub fn wheel_angle(&self, steer: f64, speed: f64) -> f64 {
        let share = interpolate(self.steering_curve.iter().copied(), speed);
        steer.clamp(-1.0, 1.0) * self.greatest_wheel_angle * self.steering_response * share.unwrap_or(1.0)
    }

    /// The steer for an angle of the front wheels (rad).
    pub fn steer_for(&self, wheel_angle: f64, speed: f64) -> f64 {
        (wheel_angle / self.wheel_angle(1.0, speed)).clamp(-1.0, 1.0)
    }

    /// Acceleration along the heading (m/s²).
    pub fn acceleration(&self, control: Control, speed: f64) -> f64 {
        let lines = self.throttle.iter().map(|line| (line.throttle, line.at_rest + line.slope * speed));
        let push = interpolate(lines, control.throttle.clamp(0.0, 1.0)).unwrap_or(0.0);
        let jump = if speed < self.low_speed { self.low_speed_braking } else { 1.0 };
        push - control.brake.clamp(0.0, 1.0) * self.full_brake * jump
    }

    /// The pedals for an acceleration (m/s²), or for the nearest that the car can reach.
    pub fn pedals_for(&self, acceleration: f64, speed: f64) -> Control {
        let at = |line: &ThrottleLine| line.at_rest + line.slope * speed;
        let coasting = self.throttle.first().map_or(0.0, at);
        if acceleration < coasting {
            let full = self.acceleration(Control { brake: 1.0, ..Control::default() }, speed) - coasting;
            return Control { brake: ((acceleration - coasting) / full).clamp(0.0, 1.0), ..Control::default() };
        }
        let mut throttle = 0.0;
        for pair in self.throttle.windows(2) {
            let (low, high) = (at(&pair[0]), at(&pair[1]));
            if acceleration <= low || high <= low {
                continue;
            }
            let share = ((acceleration - low) / (high - low)).min(1.0);
            throttle = pair[0].throttle + share * (pair[1].throttle - pair[0].throttle);
        }
        Control { throttle, ..Control::default() }
    }
}

/// The value at `x` on the broken line through the points, constant beyond both ends; none without points.
fn interpolate(points: impl Iterator<Item = (f64, f64)>, x: f64) -> Option<f64> {
    let mut before: Option<(f64, f64)> = None;
    for (at, value) in points {
        if x <= at {
            return Some(before.map_or(value, |(a, b)| b + (value - b) * (x - a) / (at - a)));
        }
        before = Some((at, value));
    }
    before.map(|(_, value)| value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn emergency_stop_of_the_model_3_is_the_documented_one() {
        let car = VehicleBlueprint::model3();
        let half = Control { brake: 0.5, ..Control::default() };
        assert!((car.acceleration(half, 7.0) + 4.395 + 0.7).abs() < 1e-9);
        assert!((car.acceleration(half, 3.0) + 8.79 + 0.3).abs() < 1e-9, "twice as hard below 5 m/s");
    }

    #[test]
    fn pedals_give_the_acceleration_asked_for() {
        for car in [VehicleBlueprint::model3(), VehicleBlueprint::mkz_2017(), VehicleBlueprint::generic()] {
            for speed in [0.0, 3.0, 8.0, 15.0] {
                for wanted in [-6.0, -2.5, 0.5, 1.5, 3.0] {
                    let got = car.acceleration(car.pedals_for(wanted, speed), speed);
                    assert!((got - wanted).abs() < 1e-9, "{wanted} at {speed}: {got}");
                }
            }
        }
    }

    #[test]
    fn steering_weakens_with_speed() {
        let car = VehicleBlueprint::model3();
        let full = 70.0_f64.to_radians() * 0.7;
        assert!((car.wheel_angle(1.0, 0.0) - full).abs() < 1e-12);
        assert!((car.wheel_angle(-1.0, 40.0 / 3.6) + full * 0.85).abs() < 1e-12);
        assert!((car.steer_for(0.1, 5.0) * car.wheel_angle(1.0, 5.0) - 0.1).abs() < 1e-12);
    }
}

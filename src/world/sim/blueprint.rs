/// Positions of the pedals and the steering wheel.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Control {
    /// Accelerator, 0 to 1.
    pub throttle: f64,
    /// Brake, 0 to 1.
    pub brake: f64,
    /// Steering wheel, −1 to 1, positive to the left (CARLA's is positive to the right).
    pub steer: f64,
}

impl Control {
    /// Full stop with straight wheels.
    pub const FULL_BRAKE: Self = Self { throttle: 0.0, brake: 1.0, steer: 0.0 };
}

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

/// Below this speed (m/s) CARLA's cars brake harder than the brake pedal demands.
const LOW_SPEED: f64 = 5.0;

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
    /// Acceleration over throttle and speed, sorted by throttle; linear in between. The first line, with the pedals released, is the engine's
    /// drag.
    pub throttle: Vec<ThrottleLine>,
    /// Deceleration at full brake (m/s²); linear in the brake.
    pub full_brake: f64,
    /// The factor by which CARLA's cars brake harder below 5 m/s than the brake pedal demands.
    pub low_speed_braking: f64,
    /// Time for which a car stands after it has been placed at rest (s).
    pub start_up_pause: f64,
    /// The greatest acceleration that the tyres transmit in any direction (m/s²): the friction of the road times the acceleration of free
    /// fall. Infinite on CARLA's road, whose friction is in the figures above.
    pub grip: f64,
}

const KMH: f64 = 1.0 / 3.6;

impl VehicleBlueprint {
    /// CARLA's `vehicle.tesla.model3`.
    ///
    /// Throttle, engine drag and brakes are those of PhysX's drive with one gear. With the throttle a, the engine's speed ω = v G / r, its
    /// torque T(ω), its damping d = d₀ + (d₁ − d₀) a and a clutch of strength K, the clutch passes on the torque
    /// K / (K + d) · (a T(ω) − d ω). It drives the car's mass and the engine's inertia J (G / r)². The lines take T as linear up to 9.2 m/s.
    /// Above that T is constant, and the line at full throttle is too high by at most 8 % up to 14 m/s.
    ///
    /// # Source
    /// Dumps of a running CARLA 0.9.1x by several independent projects for the sizes. One dump for the drive: 1845 kg, G = 8, r = 0.37 m,
    /// J = 1 kg m², d₀ = 2 and d₁ = 0.15 kg m²/s, K = 10 kg m²/s, 400 Nm at rest and 500 Nm at 1891 rpm, brakes of 4 × 1500 Nm. The
    /// equation is that of `PxVehicleUpdate.cpp` (PhysX 3, the engine of CARLA 0.9). CARLA issue #3256 reports that this car holds 20 m/s with
    /// a throttle of 0.82, issues #946 and #2172 that cars do not glide; the equation gives 0.67 at 20 m/s. CARLA issues #8112 and #3906 for
    /// the low speeds.
    pub fn model3() -> Self {
        let line = |throttle, at_rest, slope| ThrottleLine { throttle, at_rest, slope };
        Self {
            half_length: 2.395_890,
            half_width: 1.081_725,
            wheelbase: 3.0046,
            throttle: vec![
                line(0.0, 0.0, -0.337),
                line(0.25, 0.81, -0.247),
                line(0.5, 1.69, -0.150),
                line(0.75, 2.64, -0.045),
                line(1.0, 3.68, 0.071),
            ],
            full_brake: 7.01,
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
            low_speed_braking: 1.0,
            start_up_pause: 0.0,
            grip: f64::INFINITY,
        }
    }

    /// The figures that all of CARLA's cars share.
    ///
    /// # Source
    /// The pause: CARLA issue #6477 reports about 2 s for the Model 3 (0.9.10.1), issue #7717 reports 50 ticks (0.9.12). A new car is in
    /// neutral. PhysX's automatic gear box waits for its latency (2 s by default, which Unreal passes on), then changes gear (0.5 s in the dump).
    fn carla() -> Self {
        Self {
            greatest_wheel_angle: 70.0_f64.to_radians(),
            steering_response: 0.7,
            steering_curve: vec![(0.0, 1.0), (20.0 * KMH, 0.9), (60.0 * KMH, 0.8), (120.0 * KMH, 0.7)],
            low_speed_braking: 2.0,
            start_up_pause: 2.0,
            ..Self::generic()
        }
    }

    /// Angle of the front wheels (rad), positive to the left.
    pub fn wheel_angle(&self, steer: f64, speed: f64) -> f64 {
        let share = interpolate(self.steering_curve.iter().copied(), speed);
        steer.clamp(-1.0, 1.0) * self.greatest_wheel_angle * self.steering_response * share.unwrap_or(1.0)
    }

    /// The slip angle at an angle of the front wheels (rad) that the tyres can hold at a speed (m/s), and what is left of the grip for
    /// accelerating and braking (m/s²).
    ///
    /// The lateral acceleration is at most the grip: a car that steers more slides straight on. Steering takes its part of the circle of
    /// friction first, as with an anti-lock brake.
    pub fn slip(&self, wheel_angle: f64, speed: f64) -> (f64, f64) {
        let slip = libm::atan(libm::tan(wheel_angle) / 2.0);
        if self.grip.is_infinite() {
            return (slip, f64::INFINITY);
        }
        let radius_of_one = self.wheelbase / 2.0;
        let held = (self.grip * radius_of_one / (speed * speed).max(1e-9)).min(1.0);
        let slip = slip.clamp(-libm::asin(held), libm::asin(held));
        let lateral = speed * speed * libm::sin(slip) / radius_of_one;
        (slip, (self.grip * self.grip - lateral * lateral).max(0.0).sqrt())
    }

    /// The steer for an angle of the front wheels (rad).
    pub fn steer_for(&self, wheel_angle: f64, speed: f64) -> f64 {
        (wheel_angle / self.wheel_angle(1.0, speed)).clamp(-1.0, 1.0)
    }

    /// Acceleration along the heading on a straight way (m/s²), at most the grip.
    pub fn acceleration(&self, control: Control, speed: f64) -> f64 {
        self.demanded(control, speed).clamp(-self.grip, self.grip)
    }

    /// The greatest deceleration of the brake on this road (m/s²), but for what low speeds add to it.
    pub fn greatest_deceleration(&self) -> f64 {
        self.full_brake.min(self.grip)
    }

    /// The acceleration that the pedals demand, whatever the road (m/s²).
    fn demanded(&self, control: Control, speed: f64) -> f64 {
        let lines = self.throttle.iter().map(|line| (line.throttle, line.at_rest + line.slope * speed));
        let push = interpolate(lines, control.throttle.clamp(0.0, 1.0)).unwrap_or(0.0);
        let jump = if speed < LOW_SPEED { self.low_speed_braking } else { 1.0 };
        push - control.brake.clamp(0.0, 1.0) * self.full_brake * jump
    }

    /// The pedals for an acceleration (m/s²), or for the nearest that the car can reach.
    pub fn pedals_for(&self, acceleration: f64, speed: f64) -> Control {
        let at = |line: &ThrottleLine| line.at_rest + line.slope * speed;
        let coasting = self.throttle.first().map_or(0.0, at);
        if acceleration < coasting {
            let full = self.demanded(Control { brake: 1.0, ..Control::default() }, speed) - coasting;
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

/// The value at `x` on the broken line through the points, constant beyond both ends; `None` without points.
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

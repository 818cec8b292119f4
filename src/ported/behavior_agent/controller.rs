use std::collections::VecDeque;

use super::carla_frame::{Direction, Location};
use super::release::{Pid, ReleaseTraits};
use road::geometry::Pose;

/// Time step of the controllers (s); it does not depend on the simulation's.
const DT: f64 = 0.05;
/// The number of errors that a controller remembers.
const MEMORY: usize = 10;
const MAX_THROTTLE: f64 = 0.75;
const MAX_BRAKE: f64 = 0.3;
const MAX_STEER: f64 = 0.8;
/// Maximum change of the steer per run.
const STEER_RATE: f64 = 0.1;

/// The last errors of a controller.
#[derive(Debug, Clone)]
struct ErrorMemory(VecDeque<f64>);

impl Default for ErrorMemory {
    fn default() -> Self {
        Self(VecDeque::with_capacity(MEMORY))
    }
}

impl ErrorMemory {
    /// Adds an error and returns the controller's output, −1 to 1.
    fn run(&mut self, pid: &Pid, error: f64) -> f64 {
        if self.0.len() == MEMORY {
            self.0.pop_front();
        }
        let last = self.0.back().copied();
        self.0.push_back(error);
        let (difference, integral) =
            last.map_or((0.0, 0.0), |last| ((error - last) / DT, self.0.iter().sum::<f64>() * DT));
        (pid.proportional * error + pid.differential * difference + pid.integral * integral).clamp(-1.0, 1.0)
    }
}

/// Pedals and wheel in CARLA's units.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct CarlaControl {
    pub throttle: f64,
    pub brake: f64,
    /// Positive to the right.
    pub steer: f64,
}

/// The two PID controllers that follow the route.
#[derive(Debug, Clone, Default)]
pub(super) struct Controller {
    longitudinal: ErrorMemory,
    lateral: ErrorMemory,
    steer: f64,
}

impl Controller {
    /// Forgets the past errors.
    pub fn reset(&mut self) {
        self.longitudinal.0.clear();
        self.lateral.0.clear();
        self.steer = 0.0;
    }

    /// Sets the output that replaced its last one; only a forgetful controller needs it.
    pub fn overruled(&mut self, traits: &ReleaseTraits, steer: f64) {
        if traits.forgetful {
            self.steer = steer;
        }
    }

    /// Steers from a pose to a target; speeds in km/h.
    pub fn run(
        &mut self,
        traits: &ReleaseTraits,
        pose: &Pose,
        target: Location,
        speed: f64,
        target_speed: f64,
    ) -> CarlaControl {
        if traits.forgetful {
            self.longitudinal.0.clear();
            self.lateral.0.clear();
        }
        let gains = if target_speed > 50.0 { &traits.fast_gains } else { &traits.gains };
        let pedals = self.longitudinal.run(&gains.longitudinal, target_speed - speed);
        let angle = angle_to(pose, target);
        let wheel = self.lateral.run(&gains.lateral, angle);
        self.steer = wheel.clamp(self.steer - STEER_RATE, self.steer + STEER_RATE).clamp(-MAX_STEER, MAX_STEER);
        let (throttle, brake) =
            if pedals >= 0.0 { (pedals.min(MAX_THROTTLE), 0.0) } else { (0.0, (-pedals).min(MAX_BRAKE)) };
        CarlaControl { throttle, brake, steer: self.steer }
    }
}

/// The angle from the heading to a target (rad), positive to the right; 1 for a target at the ego's very centre.
fn angle_to(pose: &Pose, target: Location) -> f64 {
    let ahead = Direction::new(pose).widened();
    let to_target = Location::new(pose.position(), 0.0).offset(target);
    if to_target == (0.0, 0.0) {
        return 1.0;
    }
    let cross = ahead.0 * to_target.1 - ahead.1 * to_target.0;
    let dot = ahead.0 * to_target.0 + ahead.1 * to_target.1;
    libm::atan2(cross, dot)
}

#[cfg(test)]
mod tests {
    use super::super::Release;
    use super::*;

    const AHEAD: Location = Location { x: 10.0, y: 0.0, z: 0.0 };

    fn run(controller: &mut Controller, release: Release, target: Location, speed: f64, wanted: f64) -> CarlaControl {
        controller.run(&release.traits(), &Pose::default(), target, speed, wanted)
    }

    #[test]
    fn the_integral_starts_with_the_second_run_and_forgets_after_ten() {
        let mut controller = Controller::default();
        let mut drive = |speed| run(&mut controller, Release::V0_9_15, AHEAD, speed, 27.0).throttle;
        assert!((drive(26.8) - 0.2).abs() < 1e-12);
        assert!((drive(26.9) - (0.1 + 0.05 * 0.3 * 0.05)).abs() < 1e-12);
        for _ in 0..9 {
            drive(26.9);
        }
        assert!((drive(26.9) - (0.1 + 0.05 * 1.0 * 0.05)).abs() < 1e-12, "ten errors of 0.1");
    }

    #[test]
    fn pedals_and_wheel_are_limited() {
        let mut controller = Controller::default();
        let right = Location { x: 1.0, y: 10.0, z: 0.0 };
        let first = run(&mut controller, Release::V0_9_15, right, 0.0, 27.0);
        assert_eq!((first.throttle, first.brake, first.steer), (0.75, 0.0, 0.1));
        let control = (0..20).map(|_| run(&mut controller, Release::V0_9_15, right, 40.0, 27.0)).last().unwrap();
        assert_eq!((control.throttle, control.brake, control.steer), (0.0, 0.3, 0.8));
    }

    #[test]
    fn the_wheel_answers_the_change_of_the_angle() {
        let mut controller = Controller::default();
        let at =
            |angle: f64| Location { x: (10.0 * libm::cos(angle)) as f32, y: (10.0 * libm::sin(angle)) as f32, z: 0.0 };
        let first = run(&mut controller, Release::V0_9_15, at(0.01), 27.0, 27.0).steer;
        assert!((first - 0.0195).abs() < 1e-6);
        let second = run(&mut controller, Release::V0_9_15, at(0.015), 27.0, 27.0).steer;
        let expected = 1.95 * 0.015 + 0.2 * 0.005 / 0.05 + 0.05 * 0.025 * 0.05;
        assert!((second - expected).abs() < 1e-6, "{second} instead of {expected}");
    }

    #[test]
    fn the_oldest_release_has_no_memory_and_two_gears() {
        let mut controller = Controller::default();
        for _ in 0..3 {
            let city = run(&mut controller, Release::V0_9_11, AHEAD, 26.0, 27.0);
            assert!((city.throttle - 0.15).abs() < 1e-12);
        }
        let highway = run(&mut controller, Release::V0_9_11, AHEAD, 56.0, 57.0);
        assert!((highway.throttle - 0.37).abs() < 1e-12);
    }
}

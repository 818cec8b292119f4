use super::GRAVITY;

/// Waiting, then a linear ramp, then full braking to standstill.
///
/// With ramp `r`, full deceleration `A` and jerk `j = A / r`, for speeds `v ≥ A r / 2`, stopping after a wait `T` takes
/// `D(v) = v T + v r − j r³/6 + (v − A r/2)² / (2 A)`; slower ones stop within the ramp, after `t = √(2 v / j)` of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BrakeProfile {
    /// Time without braking (s).
    pub wait: f64,
    /// Time from no braking to full braking (s); 0 for a step.
    pub ramp: f64,
    /// Full deceleration (m/s²).
    pub full: f64,
}

impl BrakeProfile {
    /// UN R157's brake: a ramp of 0.6 s to 0.774 g.
    pub fn careful_human(wait: f64) -> Self {
        Self { wait, ramp: 0.6, full: 0.774 * GRAVITY }
    }

    /// The mean deceleration from `time` to `time + dt` after the start of the wait (m/s²).
    pub fn deceleration(&self, time: f64, dt: f64) -> f64 {
        (self.speed_lost(time + dt) - self.speed_lost(time)) / dt
    }

    /// The deceleration `time` (s) after the start of the wait (m/s²).
    pub fn reached(&self, time: f64) -> f64 {
        let braking = time - self.wait;
        if braking >= self.ramp { self.full } else { self.full * (braking / self.ramp).max(0.0) }
    }

    /// The distance to standstill from a speed (m/s), including the wait (m).
    pub fn stopping_distance(&self, speed: f64) -> f64 {
        let (v, r) = (speed, self.ramp);
        let waiting = v * self.wait;
        let lost = self.full * r / 2.0;
        if v >= lost {
            let left = v - lost;
            return waiting + v * r - self.full * r * r / 6.0 + left * left / (2.0 * self.full);
        }
        let jerk = self.full / r;
        let stop = (2.0 * v / jerk).sqrt();
        waiting + v * stop - jerk * stop * stop * stop / 6.0
    }

    fn speed_lost(&self, time: f64) -> f64 {
        let braking = time - self.wait;
        if braking <= 0.0 {
            0.0
        } else if braking < self.ramp {
            self.full / self.ramp * braking * braking / 2.0
        } else {
            self.full * (braking - self.ramp / 2.0)
        }
    }
}

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
    /// UN R157's careful human: a ramp of 0.6 s to 0.774 g.
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

#[cfg(test)]
mod tests {
    use super::*;

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
}

use base::keys;
use verdict::Traffic;

keys! {
    /// What the repaired driver may cost in natural traffic.
    #[derive(Copy)]
    pub struct TrafficRule {
        /// Share of the mean speed in episodes with natural pedestrians that a repair may cost.
        progress: f64 as share() = "5 percent",
        /// What the share of these episodes with hard braking, above 4 m/s^2 over half a second, may rise by.
        comfort: f64 as share() = "5 percent",
    }
}

impl TrafficRule {
    /// How much traffic misses what it demands: 0 when it is kept.
    pub(super) fn excess(&self, traffic: &Traffic, before: &Traffic) -> f64 {
        let (Some(speed), Some(speed_before)) = (traffic.speed(), before.speed()) else { return f64::INFINITY };
        let lost = if speed_before > 0.0 { 1.0 - speed / speed_before } else { 0.0 };
        let braking = traffic.braking_rate().unwrap_or(1.0) - before.braking_rate().unwrap_or(0.0);
        (lost - self.progress).max(0.0) + (braking - self.comfort).max(0.0)
    }
}

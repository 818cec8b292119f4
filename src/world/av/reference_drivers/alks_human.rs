use super::{DelayedBrake, GRAVITY, OwnMotion, ReferenceDriver, Threat};

/// `esmini`'s human for pedestrians, with its automatic brake: it takes anybody ahead who moves towards the path for a risk, at any time to collision, and
/// stops. It does not see who stands still or walks along.
///
/// # Source
/// `esmini/esmini`, `ControllerALKS_R157SM`, model `ReferenceDriver` as in its example for pedestrians; read, not run.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct AlksHuman {
    /// Time since it noticed the pedestrian (s).
    clock: Option<f64>,
    is_automatic: bool,
    braking: f64,
}

impl AlksHuman {
    /// Time of the ramp of both brakes (s).
    const RAMP: f64 = 0.6;
    /// Full deceleration of the human and of the automatic brake (m/s²), and the time to collision at which the latter begins (s).
    const HUMAN: f64 = 0.774 * GRAVITY;
    const AUTOMATIC: f64 = 0.85 * GRAVITY;
    const LATE: f64 = 1.5;
}

impl ReferenceDriver for AlksHuman {
    fn begin(&mut self) {
        *self = Self::default();
    }

    fn noticed_for(&self) -> f64 {
        self.clock.unwrap_or(0.0)
    }

    fn has_noticed(&self) -> bool {
        self.clock.is_some()
    }

    fn brake(&mut self, own: &OwnMotion, threat: Option<&Threat>, dt: f64) -> Option<f64> {
        let sees = |threat: &&Threat| {
            threat.towards > 0.0 && own.speed > threat.along && threat.gap > -(own.length + threat.length) / 2.0
        };
        if self.clock.is_none() && threat.filter(sees).is_none() {
            return None;
        }
        let time = self.clock.unwrap_or(0.0);
        self.clock = Some(time + dt);
        // The whole body is in front of the car.
        self.is_automatic |= threat.is_some_and(|threat| {
            let is_in_front = threat.offset <= threat.reach - threat.length;
            is_in_front && threat.gap < Self::LATE * (own.speed - threat.along)
        });
        let full = if self.is_automatic { Self::AUTOMATIC } else { Self::HUMAN };
        let human = if time >= DelayedBrake::CAREFUL { Self::HUMAN } else { 0.0 };
        let rate = (human + if self.is_automatic { Self::AUTOMATIC } else { 0.0 }) / Self::RAMP;
        self.braking = (self.braking + rate * dt).min(full);
        (self.braking > 0.0).then_some(self.braking)
    }
}

use super::{BrakeProfile, GRAVITY, OwnMotion, ReferenceDriver, Threat};

/// Brakes to standstill a fixed time after a pedestrian moves into the path; with a gate only when it is near enough.
///
/// The automatic brake that UN R157 adds for another road user fully in front is left out: within the careful human's ramp it
/// changes little, and the ideal brake shows what a machine could do.
#[derive(Debug, Clone, PartialEq)]
pub struct DelayedBrake {
    /// The clock starts when the time to collision is at most this (s); without it, at once.
    pub gate: Option<f64>,
    /// The wait and the braking from then on.
    pub profile: BrakeProfile,
    clock: Option<f64>,
}

impl DelayedBrake {
    /// Makes one whose clock has not started.
    pub fn new(gate: Option<f64>, profile: BrakeProfile) -> Self {
        Self { gate, profile, clock: None }
    }

    /// UN R157's careful human, which takes 0.4 s to see the risk and 0.75 s to brake.
    pub fn careful_human() -> Self {
        Self::new(None, BrakeProfile::careful_human(1.15))
    }

    /// UN R157's careful human whose risk evaluation ends when the time to collision falls to 2 s.
    ///
    /// # Source
    /// The gate for pedestrians is `esmini`'s (`ALKS_R157SM`); the regulation has it for cut-ins.
    pub fn careful_human_at_two_seconds() -> Self {
        Self::new(Some(2.0), BrakeProfile::careful_human(0.75))
    }

    /// A good machine: 0.35 s, then in 0.6 s to 0.85 g.
    pub fn ideal() -> Self {
        Self::new(None, BrakeProfile { wait: 0.35, ramp: 0.6, full: 0.85 * GRAVITY })
    }

    /// The bound of all brakes on a dry road: 0.85 g at once.
    pub fn bound() -> Self {
        Self::new(None, BrakeProfile { wait: 0.0, ramp: 0.0, full: 0.85 * GRAVITY })
    }
}

impl ReferenceDriver for DelayedBrake {
    fn begin(&mut self) {
        self.clock = None;
    }

    fn brake(&mut self, own: &OwnMotion, threat: Option<&Threat>, dt: f64) -> Option<f64> {
        let near = |threat: &Threat| self.gate.is_none_or(|gate| threat.time_to_collision(own.speed) <= gate);
        let seen = || threat.is_some_and(|threat| threat.is_on_its_way() && near(threat));
        let time = self.clock.or_else(|| seen().then_some(0.0))?;
        self.clock = Some(time + dt);
        (time + dt > self.profile.wait).then(|| self.profile.deceleration(time, dt))
    }
}

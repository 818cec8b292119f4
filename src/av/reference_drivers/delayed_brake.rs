use super::{BrakeProfile, GRAVITY, OwnMotion, ReferenceDriver, Threat};

/// Brakes to standstill a fixed time after it has noticed a pedestrian; it does not change its mind.
///
/// With a gate it notices one that is on course into the path when the time to collision is short enough, without one any that moves into
/// the path. The automatic brake that UN R157 adds for another road user fully in front is left out: within the careful human's ramp it
/// changes little, and the ideal brake shows what a machine could do.
#[derive(Debug, Clone, PartialEq)]
pub struct DelayedBrake {
    /// The greatest time to collision at which it notices a pedestrian (s); without it, it notices any at once.
    pub gate: Option<f64>,
    /// The wait and the braking from then on.
    pub profile: BrakeProfile,
    clock: Option<f64>,
}

impl DelayedBrake {
    /// The time to collision (s) from which on a human takes a crossing road user for a risk.
    ///
    /// # Source
    /// UN R157 has it for cut-ins, and `esmini` (`ALKS_R157SM`) for pedestrians.
    pub const GATE: f64 = 2.0;

    /// Makes one whose clock has not started.
    pub fn new(gate: Option<f64>, profile: BrakeProfile) -> Self {
        Self { gate, profile, clock: None }
    }

    /// UN R157's careful human: at the gate it starts to evaluate the risk for 0.4 s, and brakes 0.75 s later.
    pub fn careful_human() -> Self {
        Self::new(Some(Self::GATE), BrakeProfile::careful_human(1.15))
    }

    /// UN R157's careful human who has evaluated the risk before the gate opens, and brakes 0.75 s after that.
    pub fn attentive_human() -> Self {
        Self::new(Some(Self::GATE), BrakeProfile::careful_human(0.75))
    }

    /// A good machine: 0.35 s, then in 0.6 s to 0.85 g.
    pub fn ideal() -> Self {
        Self::new(Some(Self::GATE), BrakeProfile { wait: 0.35, ramp: 0.6, full: 0.85 * GRAVITY })
    }

    /// The bound of all brakes on a dry road: 0.85 g at once.
    pub fn bound() -> Self {
        Self::new(None, BrakeProfile { wait: 0.0, ramp: 0.0, full: 0.85 * GRAVITY })
    }
}

impl DelayedBrake {
    /// Whether it notices a pedestrian now.
    pub fn notices(&self, own: &OwnMotion, threat: &Threat) -> bool {
        match self.gate {
            None => threat.is_on_its_way(),
            Some(gate) => threat.time_to_collision(own) <= gate && threat.is_on_course(own),
        }
    }

    /// The same driver, `time` (s) after it has noticed a pedestrian.
    #[must_use]
    pub fn having_noticed(self, time: f64) -> Self {
        Self { clock: Some(time), ..self }
    }
}

impl ReferenceDriver for DelayedBrake {
    fn begin(&mut self) {
        self.clock = None;
    }

    fn brake(&mut self, own: &OwnMotion, threat: Option<&Threat>, dt: f64) -> Option<f64> {
        let seen = || threat.is_some_and(|threat| self.notices(own, threat));
        let time = self.clock.or_else(|| seen().then_some(0.0))?;
        self.clock = Some(time + dt);
        (time + dt > self.profile.wait).then(|| self.profile.deceleration(time, dt))
    }
}

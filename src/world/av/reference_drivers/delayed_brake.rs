use super::{BrakeProfile, GRAVITY, OwnMotion, ReferenceDriver, Threat};

/// When a human takes a pedestrian that is on course into the path for a risk: at a time to collision that depends on the speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gate {
    /// The least of these times (s).
    pub least: f64,
    /// Whether it opens in time to stop.
    pub in_time: bool,
    /// What is added (s).
    pub longer: f64,
    /// Whether it opens for somebody who is in the path only, and not for one who will be.
    pub in_path: bool,
}

impl Gate {
    /// UN R157's 2 s, and in time to stop from any speed.
    ///
    /// # Source
    /// UN R157 has 2 s for cut-ins, and `esmini` (`ALKS_R157SM`) for pedestrians. From more than 30 km/h the careful human cannot stop in 2 s, so
    /// that a person who stands in the lane in full view would be no fault of any driver. A driver that looks ahead sees that person earlier: our choice.
    pub const CAREFUL: Self = Self { least: 2.0, in_time: true, longer: 0.0, in_path: false };

    /// The time to collision (s) at which it opens: at least [`Gate::least`], and time enough for the careful human to stop with this car, with
    /// its evaluation, its reaction, and a ramp in which it does not brake yet.
    pub fn opens(&self, own: &OwnMotion) -> f64 {
        let human = BrakeProfile::careful_human(DelayedBrake::CAREFUL);
        let stop = human.wait + human.ramp + own.speed / (2.0 * human.full.min(own.brake));
        self.longer + if self.in_time { self.least.max(stop) } else { self.least }
    }
}

/// Brakes to standstill a fixed time after it has noticed a pedestrian; it does not change its mind. A car that stands when it notices one does
/// not drive off.
///
/// With a gate it notices one that is on course into the path when the time to collision is short enough, without one any that moves into
/// the path. The automatic brake that UN R157 adds for another road user fully in front is left out: within the careful human's ramp it
/// changes little, and the ideal brake shows what a machine could do.
#[derive(Debug, Clone, PartialEq)]
pub struct DelayedBrake {
    /// When it notices a pedestrian; without a gate it notices any at once.
    pub gate: Option<Gate>,
    /// The wait and the braking from then on.
    pub profile: BrakeProfile,
    clock: Option<f64>,
}

impl DelayedBrake {
    /// Time from the gate to the brake of a human who has yet to evaluate the risk, and of one who has (s).
    pub const CAREFUL: f64 = 1.15;
    /// See [`DelayedBrake::CAREFUL`].
    pub const ATTENTIVE: f64 = 0.75;

    /// Makes one whose clock has not started.
    pub fn new(gate: Option<Gate>, profile: BrakeProfile) -> Self {
        Self { gate, profile, clock: None }
    }

    /// A careful human with UN R157's times and brake: at the gate it starts to evaluate the risk for 0.4 s, and brakes 0.75 s later.
    pub fn careful_human() -> Self {
        Self::new(Some(Gate::CAREFUL), BrakeProfile::careful_human(Self::CAREFUL))
    }

    /// The same who has evaluated the risk before the gate opens, and brakes 0.75 s after that.
    pub fn attentive_human() -> Self {
        Self::new(Some(Gate::CAREFUL), BrakeProfile::careful_human(Self::ATTENTIVE))
    }

    /// A good machine: 0.35 s, then in 0.6 s to 0.85 g.
    pub fn ideal() -> Self {
        Self::new(Some(Gate::CAREFUL), BrakeProfile { wait: 0.35, ramp: 0.6, full: 0.85 * GRAVITY })
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
            Some(gate) => {
                let is_open = threat.time_to_collision(own) <= gate.opens(own) && threat.is_on_course(own);
                is_open && (!gate.in_path || threat.aside() <= 0.0)
            }
        }
    }

    /// The greatest deceleration (m/s²) within the next `dt` (s), for a driver that notices a pedestrian now or does not, in a car that stands or
    /// does not; `None` as long as it does not brake.
    pub fn next(&mut self, notices: bool, stands: bool, dt: f64) -> Option<f64> {
        let first = if stands { self.profile.wait } else { 0.0 };
        let time = self.clock.or_else(|| notices.then_some(first))?;
        self.clock = Some(time + dt);
        (time + dt > self.profile.wait).then(|| self.profile.reached(time + dt))
    }

    /// A notice is at least `time` (s) old: that part of the wait is over.
    pub fn skip(&mut self, time: f64) {
        self.clock = Some(self.clock.unwrap_or(0.0).max(time));
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

    fn noticed_for(&self) -> f64 {
        self.profile.wait
    }

    fn has_noticed(&self) -> bool {
        self.clock.is_some()
    }

    fn brake(&mut self, own: &OwnMotion, threat: Option<&Threat>, dt: f64) -> Option<f64> {
        let seen = || threat.is_some_and(|threat| self.notices(own, threat));
        // A driver that stands needs no reaction time: it does not drive off.
        let first = if own.stands() { self.profile.wait } else { 0.0 };
        let time = self.clock.or_else(|| seen().then_some(first))?;
        self.clock = Some(time + dt);
        (time + dt > self.profile.wait).then(|| self.profile.deceleration(time, dt))
    }
}

use super::{GRAVITY, OwnMotion, ReferenceDriver, RssLimits, Threat};

/// When a model of cut-ins takes another road user for a danger.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum CutIn {
    /// The clear distance from the side of the swept path is at most `aside` (m), and the time to collision at most `longest` (s) and the time
    /// in which this deceleration (m/s²) takes the closing speed away.
    Near { aside: f64, longest: f64, stops_with: f64 },
    /// Both distances are below those of RSS in lanes: these limits along the path, and across it a response of `response` (s), `acceleration`
    /// (m/s²) in and after it, and a margin (m).
    Lanes { limits: RssLimits, acceleration: f64, margin: f64 },
}

impl CutIn {
    fn is_danger(&self, own: &OwnMotion, threat: &Threat) -> bool {
        // Its middle is behind that of the car.
        if threat.gap < -(own.length + threat.length) / 2.0 {
            return false;
        }
        match *self {
            Self::Near { aside, longest, stops_with } => {
                let closing = own.speed - threat.along;
                let allowed = longest + closing / (2.0 * stops_with);
                threat.offset - threat.reach <= aside && (threat.gap / closing).abs() <= allowed
            }
            Self::Lanes { limits, acceleration, margin } => {
                let stopped = threat.along * threat.along / (2.0 * limits.hardest);
                let (across, push) = (threat.towards.abs(), limits.response * acceleration);
                let responds = (2.0 * across + push) * limits.response / 2.0;
                let aside = margin + responds + (across + push) * (across + push) / (2.0 * acceleration);
                threat.gap < limits.braking_reach(own.speed) - stopped && threat.offset - threat.reach < aside
            }
        }
    }
}

/// A model of cut-ins: it waits, and then brakes up to a deceleration as long as there is danger; safe again, it keeps its speed.
///
/// The wait is counted down only in danger, and the brake stays as far applied as it was.
///
/// # Source
/// `ec-jrc/JRC-FSM`, models `CC_human_driver`, `Reg157` and `RSS`.
#[derive(Debug, Clone, PartialEq)]
pub struct CutInBrake {
    /// When it reacts.
    pub cut_in: CutIn,
    /// The time until it brakes (s), and its deceleration meanwhile (m/s²).
    pub wait: f64,
    pub coasting: f64,
    /// Jerk of its brake (m/s³), infinite for a step, and its greatest deceleration (m/s²).
    pub jerk: f64,
    pub full: f64,
    waited: f64,
    braking: Option<f64>,
}

impl CutInBrake {
    const HUMAN: Self = Self {
        cut_in: CutIn::Near { aside: 0.0, longest: 2.0, stops_with: f64::INFINITY },
        wait: 0.75,
        coasting: 0.4,
        jerk: 12.65,
        full: 0.774 * GRAVITY,
        waited: 0.0,
        braking: None,
    };

    /// UN R157's human, who perceives a body at this clear distance (m) from the side of its path at a time to collision of 2 s.
    pub fn human(aside: f64) -> Self {
        Self { cut_in: CutIn::Near { aside, longest: 2.0, stops_with: f64::INFINITY }, ..Self::HUMAN }
    }

    /// The least that UN R157, 5.2.5.2, asks of the system: 6 m/s², 0.35 s after a lateral gap of 0.5 m.
    pub fn regulation() -> Self {
        let cut_in = CutIn::Near { aside: 0.5, longest: 0.45, stops_with: 6.0 };
        Self { cut_in, wait: 0.35, coasting: 0.0, jerk: f64::INFINITY, full: 6.0, ..Self::HUMAN }
    }

    /// RSS in lanes with JRC's parameters.
    pub fn lanes() -> Self {
        let cut_in = CutIn::Lanes { limits: RssLimits::jrc(), acceleration: 1.0, margin: 0.3 };
        Self { cut_in, coasting: 0.0, ..Self::HUMAN }
    }
}

impl ReferenceDriver for CutInBrake {
    fn begin(&mut self) {
        (self.waited, self.braking) = (0.0, None);
    }

    fn noticed_for(&self) -> f64 {
        self.waited
    }

    fn has_noticed(&self) -> bool {
        self.waited > 0.0 || self.braking.is_some()
    }

    fn brake(&mut self, own: &OwnMotion, threat: Option<&Threat>, dt: f64) -> Option<f64> {
        if !threat.is_some_and(|threat| self.cut_in.is_danger(own, threat)) {
            return self.braking.map(|_| 0.0);
        }
        if self.waited < self.wait {
            self.waited += dt;
            if self.coasting > 0.0 {
                self.braking = Some(self.coasting);
            }
            return self.braking;
        }
        self.braking = Some((self.braking.unwrap_or(0.0) + self.jerk * dt).min(self.full));
        self.braking
    }
}

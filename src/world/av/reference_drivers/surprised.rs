use super::{BrakeProfile, DelayedBrake, OwnMotion, ReferenceDriver, Threat};

/// A human whose response depends on how abruptly the situation turns: after Waymo's NIEON, with figures of our own.
///
/// Evidence begins at `T₁`, the first instant at which the pedestrian is in the path or moves towards it in view. It is unmistakable at `T₂`, when
/// the gate of the careful human opens. The brake begins at `max(T₁ + 1 s + (T₂ − T₁)/2, T₂ + 0.2 s)`: a second after a situation that turns at
/// once, and soon after the gate where it was seen coming.
///
/// # Source
/// Engström et al., *Modeling road user response timing in naturalistic traffic conflicts*, arXiv 2208.08651: the response time grows linearly with
/// `T₂ − T₁`. Its coefficients were not at hand. A floor of about 1 s and 0.2 s for the foot are those of arXiv 2506.02215 (with authors of
/// Waymo); the slope of one half is our choice. The braking is that of UN R157's human.
#[derive(Debug, Clone, PartialEq)]
pub struct Surprised {
    gate: DelayedBrake,
    profile: BrakeProfile,
    clock: f64,
    /// The instants T₁ and T₂ (s).
    evidence: Option<f64>,
    certain: Option<f64>,
}

/// The response to what turns at once (s), its share of the time in which evidence gathers, and the time for the foot (s).
const FLOOR: f64 = 1.0;
const SLOPE: f64 = 0.5;
const FOOT: f64 = 0.2;

impl Default for Surprised {
    fn default() -> Self {
        Self {
            gate: DelayedBrake::attentive_human(),
            profile: BrakeProfile::careful_human(0.0),
            clock: 0.0,
            evidence: None,
            certain: None,
        }
    }
}

impl Surprised {
    /// The time (s) at which it begins to brake, for the instants T₁ and T₂ (s).
    pub fn begins(evidence: f64, certain: f64) -> f64 {
        (evidence + FLOOR + SLOPE * (certain - evidence)).max(certain + FOOT)
    }
}

impl ReferenceDriver for Surprised {
    fn begin(&mut self) {
        *self = Self::default();
    }

    fn noticed_for(&self) -> f64 {
        self.certain.map_or(0.0, |certain| self.clock - certain)
    }

    fn brake(&mut self, own: &OwnMotion, threat: Option<&Threat>, dt: f64) -> Option<f64> {
        let now = self.clock;
        self.clock += dt;
        if let Some(threat) = threat {
            if threat.is_on_its_way() {
                self.evidence.get_or_insert(now);
            }
            if self.certain.is_none() && self.gate.notices(own, threat) {
                self.certain = Some(now);
                if own.stands() {
                    // Who stands does not drive off.
                    self.evidence = Some(now - FLOOR);
                    self.certain = Some(now - FLOOR);
                }
            }
        }
        let since = self.clock - Self::begins(self.evidence?, self.certain?);
        (since > 0.0).then(|| self.profile.deceleration(since - dt, dt))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_seen_coming_is_answered_sooner_after_the_gate() {
        assert_eq!(Surprised::begins(0.0, 0.0), 1.0);
        assert_eq!(Surprised::begins(0.0, 1.0), 1.5);
        assert_eq!(Surprised::begins(0.0, 4.0), 4.2);
        let waits: Vec<f64> =
            (0..10).map(|certain| Surprised::begins(0.0, f64::from(certain)) - f64::from(certain)).collect();
        assert!(waits.windows(2).all(|pair| pair[1] <= pair[0]), "{waits:?}");
    }

    #[test]
    fn it_brakes_for_a_person_in_the_lane_a_second_after_the_gate() {
        let mut driver = Surprised::default();
        driver.begin();
        let own = OwnMotion { speed: 8.0, acceleration: 0.0, intended: 0.0, length: 4.5 };
        let threat = Threat { gap: 12.0, length: 0.5, offset: 0.0, reach: 1.2, along: 0.0, towards: 0.0 };
        let begun = (0..300).find(|_| driver.brake(&own, Some(&threat), 0.01).is_some()).unwrap();
        assert!((95..=101).contains(&begun), "{begun}");
    }
}

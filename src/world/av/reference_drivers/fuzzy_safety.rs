use super::{DelayedBrake, GRAVITY, OwnMotion, ReferenceDriver, Threat};

/// The Fuzzy Safety Model: it brakes weakly when the distance starts to be unsafe, and harder the more unsafe it is.
///
/// With the speeds `v` and `u` of car and other along the path, `d` the gap, `x = d − d₁`:
/// the proactive measure `PFS` falls from 1 at `U = v τ + v²/2 b_max − u²/2 b_l` to 0 at `S = v τ + v²/2 b_comf − u²/2 b_l + d₂`
/// in `x`; the critical one `CFS` from 1 at `U = n + (v₁ − u)²/2 b_max` to 0 at `S = n + (v₁ − u)²/2 b_comf` in `d`, with
/// `v₁ = v + a′ τ`, `n = (v + a′ τ/2 − u) τ`, `a′ = max(a, −b_comf)`.
///
/// | symbol | field | unit |
/// |---|---|---|
/// | τ | `reaction` | s |
/// | b_comf, b_max | `comfortable`, `hardest` | m/s² |
/// | b_l | `others` | m/s² |
/// | d₁, d₂ | `margin`, `safe_margin` | m |
///
/// # Source
/// `ec-jrc/JRC-FSM`, whose code uses both margins and counts the reaction time down only while the distance is unsafe.
/// For `v₁ < u` the code divides by the deceleration without its limit, and so do we. It has no rule for a car at rest: like the careful human it does not drive off at
/// somebody who is on course.
#[derive(Debug, Clone, PartialEq)]
pub struct FuzzySafety {
    /// Time until it brakes (s).
    pub reaction: f64,
    /// Its comfortable deceleration (m/s²).
    pub comfortable: f64,
    /// Its greatest deceleration (m/s²).
    pub hardest: f64,
    /// The deceleration that it expects of the other (m/s²).
    pub others: f64,
    /// Margin taken off the gap (m).
    pub margin: f64,
    /// Margin added to the safe distance (m).
    pub safe_margin: f64,
    /// Jerk of its brake (m/s³).
    pub jerk: f64,
    waiting: f64,
    braking: Option<f64>,
}

impl Default for FuzzySafety {
    fn default() -> Self {
        Self {
            reaction: 0.75,
            comfortable: 4.0,
            hardest: 6.0,
            others: 7.0,
            margin: 2.0,
            safe_margin: 2.0,
            jerk: 12.65,
            waiting: 0.75,
            braking: None,
        }
    }
}

impl FuzzySafety {
    /// The proactive measure, 0 to 1: how unsafe a gap (m) is to another road user of speed `along` (m/s).
    pub fn proactive(&self, speed: f64, along: f64, gap: f64) -> f64 {
        let left = along * along / (2.0 * self.others);
        let stop = |braking: f64| speed * self.reaction + speed * speed / (2.0 * braking) - left;
        between(gap - self.margin, stop(self.comfortable) + self.safe_margin, stop(self.hardest))
    }

    /// The critical measure, 0 to 1: how unsafe a gap (m) is when the car keeps its acceleration (m/s²) for its reaction time.
    pub fn critical(&self, speed: f64, acceleration: f64, along: f64, gap: f64) -> f64 {
        let closing = speed - along;
        if closing <= 0.0 {
            return 0.0;
        }
        let kept = acceleration.max(-self.comfortable);
        let after = closing + kept * self.reaction;
        if after < 0.0 {
            return f64::from(gap < closing * closing / (2.0 * acceleration.abs()));
        }
        let near = (closing + kept * self.reaction / 2.0) * self.reaction;
        let stop = |braking: f64| near + after * after / (2.0 * braking);
        between(gap, stop(self.comfortable), stop(self.hardest))
    }

    /// The present wanted deceleration (m/s²).
    pub fn wanted(&self, own: &OwnMotion, threat: &Threat) -> f64 {
        if !crosses_in_time(own, threat) {
            return 0.0;
        }
        let critical = self.critical(own.speed, own.acceleration, threat.along, threat.gap);
        if critical > 0.0 {
            return critical * (self.hardest - self.comfortable) + self.comfortable;
        }
        self.proactive(own.speed, threat.along, threat.gap) * self.comfortable
    }
}

/// Whether the other is in the path, or will be before the car has passed.
fn crosses_in_time(own: &OwnMotion, threat: &Threat) -> bool {
    if threat.aside() <= 0.0 {
        return true;
    }
    let closing = own.speed - threat.along;
    let passed = (threat.gap + own.length + threat.length) / closing;
    threat.towards > 0.0 && closing > 0.0 && threat.aside() / threat.towards <= passed + 0.1
}

/// 0 beyond the safe distance, 1 within the unsafe one, linear in between.
fn between(gap: f64, safe: f64, unsafe_: f64) -> f64 {
    if gap > safe {
        0.0
    } else if gap < unsafe_ {
        1.0
    } else {
        (gap - safe) / (unsafe_ - safe)
    }
}

impl ReferenceDriver for FuzzySafety {
    fn begin(&mut self) {
        self.waiting = self.reaction;
        self.braking = None;
    }

    fn noticed_for(&self) -> f64 {
        self.reaction
    }

    fn has_noticed(&self) -> bool {
        self.waiting < self.reaction
    }

    fn brake(&mut self, own: &OwnMotion, threat: Option<&Threat>, dt: f64) -> Option<f64> {
        let human = DelayedBrake::careful_human();
        if self.braking.is_none() && own.stands() && threat.is_some_and(|threat| human.notices(own, threat)) {
            (self.braking, self.waiting) = (Some(0.0), 0.0);
            return self.braking;
        }
        let wanted = threat.map_or(0.0, |threat| self.wanted(own, threat));
        if wanted <= 0.0 {
            // Safe again: it keeps its speed, and the brake stays as far applied as it was.
            return self.braking.map(|_| 0.0);
        }
        if self.waiting > 0.0 {
            self.waiting -= dt;
            return None;
        }
        let most = wanted.min(0.774 * GRAVITY);
        let braking = (self.braking.unwrap_or(0.0) + self.jerk * dt).min(most);
        self.braking = Some(braking);
        self.braking
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_measures_are_those_of_the_table_for_a_standing_obstacle() {
        let gaps = [8.0, 10.0, 12.0, 15.0, 20.0, 25.0, 30.0, 40.0];
        let rows = [
            (5.0, [0.945, 0.288, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], [0.0; 8]),
            (6.67, [1.0, 1.0, 0.665, 0.0, 0.0, 0.0, 0.0, 0.0], [1.0, 0.304, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
            (8.33, [1.0, 1.0, 1.0, 0.802, 0.0, 0.0, 0.0, 0.0], [1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
            (13.89, [1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.850, 0.0], [1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.564, 0.0]),
        ];
        let model = FuzzySafety::default();
        for (speed, proactive, critical) in rows {
            for (i, gap) in gaps.into_iter().enumerate() {
                let found = (model.proactive(speed, 0.0, gap), model.critical(speed, 0.0, 0.0, gap));
                assert!((found.0 - proactive[i]).abs() < 1e-3, "{speed} m/s, {gap} m: {found:?}");
                assert!((found.1 - critical[i]).abs() < 1e-3, "{speed} m/s, {gap} m: {found:?}");
            }
        }
    }

    #[test]
    fn it_waits_brakes_within_its_jerk_and_then_keeps_its_speed() {
        let mut model = FuzzySafety::default();
        model.begin();
        let own = OwnMotion { speed: 8.33, acceleration: 0.0, intended: 0.0, length: 4.0, brake: f64::INFINITY };
        let near = Threat { gap: 10.0, length: 0.4, offset: 0.0, reach: 1.25, along: 0.0, towards: 0.0 };
        let asked: Vec<Option<f64>> = (0..140).map(|_| model.brake(&own, Some(&near), 0.01)).collect();
        assert!(asked[..75].iter().all(Option::is_none));
        assert!((asked[80].unwrap() - 12.65 * 0.05).abs() < 0.13);
        assert!((asked[139].unwrap() - 6.0).abs() < 1e-12);
        assert_eq!(model.brake(&own, None, 0.01), Some(0.0));
        assert_eq!(FuzzySafety::default().brake(&own, None, 0.01), None);
    }

    #[test]
    fn a_car_at_rest_does_not_drive_off_at_somebody() {
        let rest = OwnMotion { speed: 0.0, acceleration: 0.0, intended: 2.0, length: 4.5, brake: f64::INFINITY };
        let near = Threat { gap: 1.0, length: 0.4, offset: 0.5, reach: 1.25, along: 0.0, towards: 0.2 };
        let mut model = FuzzySafety::default();
        model.begin();
        assert_eq!(model.brake(&rest, Some(&near), 0.01), Some(0.0), "it stays");
        let beside = Threat { offset: 4.0, towards: 0.0, ..near };
        model.begin();
        assert_eq!(model.brake(&rest, Some(&beside), 0.01), None, "nobody is on course");
    }

    #[test]
    fn somebody_who_will_be_too_late_is_let_be() {
        let own = OwnMotion { speed: 10.0, acceleration: 0.0, intended: 0.0, length: 4.5, brake: f64::INFINITY };
        let walker =
            |aside| Threat { gap: 8.0, length: 0.5, offset: 1.25 + aside, reach: 1.25, along: 0.0, towards: 1.0 };
        assert!(crosses_in_time(&own, &walker(1.39)) && !crosses_in_time(&own, &walker(1.41)));
    }
}

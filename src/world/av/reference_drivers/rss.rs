use super::{OwnMotion, ReferenceDriver, RssLimits, Threat};

/// Responsibility-Sensitive Safety towards a pedestrian: the rule for unstructured scenes.
///
/// Each actor has a set `T_b` of places that it may reach when it brakes after its response time, and `T_f` when it continues.
/// The situation is safe when car and pedestrian could both still stop apart: their `T_b` do not meet. Otherwise the car brakes,
/// unless at the last safe instant the pedestrian alone could still have given way (its `T_b` missed the car's `T_f`, while the
/// car's `T_b` met its `T_f`). Then the pedestrian must give way, and the car continues. The car brakes for a danger that exists from the start.
///
/// The rule expects a pedestrian that walks up to the lane to stop; our pedestrians do not. Such a driver hits pedestrians.
///
/// Simplified: the car keeps to its path, so its sets are stretches of the swept path, wider by what it may turn where it may, and driving away is left out. A
/// pedestrian's set is a fan of straight ways around its direction, as wide as the permitted turn, instead of arcs. Each `T_f` lasts
/// as long as its actor's slowest stop. Beyond the far side the swept path has no end.
///
/// # Source
/// `intel/ad-rss-lib`, unstructured scenes, with CARLA's parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct Rss {
    /// The assumptions about the car.
    pub car: RssLimits,
    /// The assumptions about the pedestrian.
    pub pedestrian: RssLimits,
    /// How fast the car may change its yaw rate (rad/s²); 0 of one that keeps to its path.
    pub yaw_rate_change: f64,
    /// The last safe instant, until danger starts.
    safe: Option<(OwnMotion, Threat)>,
    others_turn: bool,
    braked: bool,
}

impl Default for Rss {
    fn default() -> Self {
        Self::new(RssLimits::car(), RssLimits::pedestrian())
    }
}

/// The number of ways of a fan on each side of the middle one.
const RAYS: i32 = 8;

impl Rss {
    /// Makes one with these assumptions.
    pub fn new(car: RssLimits, pedestrian: RssLimits) -> Self {
        Self { car, pedestrian, yaw_rate_change: 0.0, safe: None, others_turn: false, braked: false }
    }

    /// That of a car that may turn, as on free ground.
    pub fn free() -> Self {
        Self { yaw_rate_change: 0.3, ..Self::default() }
    }

    /// How far a car may have turned out of its path when its bumper is this far (m) ahead of where it is now: after its response it keeps to a circle.
    fn spread(&self, own: &OwnMotion, ahead: f64) -> f64 {
        let RssLimits { response, acceleration, turn_radius, .. } = self.car;
        let (rate, after) = (self.yaw_rate_change, own.speed + response * acceleration);
        let way = (own.speed + after) / 2.0 * response;
        let aside = rate * response.powi(3) * (own.speed / 6.0 + acceleration * response / 8.0);
        let (turned, bend) = (rate * response * response / 2.0, (rate * response / after).min(1.0 / turn_radius));
        let (share, rest) = ((ahead / way).clamp(0.0, 1.0), (ahead - way).max(0.0));
        let yaw = turned * share * share + bend * rest;
        aside * share.powi(3) + (turned + bend * rest / 2.0) * rest + own.length / 2.0 * yaw
    }

    /// Whether both could still stop apart.
    pub fn is_safe(&self, own: &OwnMotion, threat: &Threat) -> bool {
        let reach = self.pedestrian.braking_reach(pace(threat));
        !self.meet(own, threat, self.car.braking_reach(own.speed), reach)
    }

    /// Whether the pedestrian could stop clear of a car that continues, and the car could not.
    fn is_others_turn(&self, own: &OwnMotion, threat: &Threat) -> bool {
        let (car, pedestrian) = (&self.car, &self.pedestrian);
        let pace = pace(threat);
        !self.meet(own, threat, car.forward_reach(own.speed), pedestrian.braking_reach(pace))
            && self.meet(own, threat, car.braking_reach(own.speed), pedestrian.forward_reach(pace))
    }

    /// Whether the fan of the pedestrian meets the path from the car's rear to this far (m) ahead of its bumper.
    fn meet(&self, own: &OwnMotion, threat: &Threat, ahead: f64, reach: f64) -> bool {
        let behind = -own.length - threat.length;
        let within = |gap: f64| (behind..=ahead).contains(&gap);
        if threat.aside() <= 0.0 && within(threat.gap) {
            return true;
        }
        let widest = if self.yaw_rate_change > 0.0 { self.spread(own, ahead) } else { 0.0 };
        if threat.aside() > reach + widest || threat.gap - reach > ahead || threat.gap + reach < behind {
            return false;
        }
        let pace = pace(threat);
        let middle = if pace > 0.0 { libm::atan2(-threat.towards, threat.along) } else { 0.0 };
        let turn = self.pedestrian.turn(pace);
        (-RAYS..=RAYS).any(|ray| {
            let (sin, cos) = libm::sincos(middle + turn * f64::from(ray) / f64::from(RAYS));
            let (along, inward) = (cos * reach, -sin * reach);
            if self.yaw_rate_change > 0.0 {
                return (0..=RAYS).map(|part| f64::from(part) / f64::from(RAYS)).any(|part| {
                    let gap = threat.gap + along * part;
                    let aside = (threat.offset - inward * part).abs() - threat.reach;
                    within(gap) && aside <= self.spread(own, gap)
                });
            }
            // The part of the way within the path, as shares of the way.
            let enters = if threat.aside() <= 0.0 { 0.0 } else { threat.aside() / inward };
            if !(0.0..=1.0).contains(&enters) {
                return false;
            }
            let (first, last) = (threat.gap + along * enters, threat.gap + along);
            first.min(last) <= ahead && first.max(last) >= behind
        })
    }
}

fn pace(threat: &Threat) -> f64 {
    (threat.along * threat.along + threat.towards * threat.towards).sqrt()
}

impl ReferenceDriver for Rss {
    fn begin(&mut self) {
        (self.safe, self.others_turn, self.braked) = (None, false, false);
    }

    fn has_noticed(&self) -> bool {
        self.braked
    }

    fn brake(&mut self, own: &OwnMotion, threat: Option<&Threat>, _: f64) -> Option<f64> {
        let kept = self.braked.then_some(0.0);
        let Some(threat) = threat else { return kept };
        if self.is_safe(own, threat) {
            self.safe = Some((*own, *threat));
            return kept;
        }
        // The last safe instant decides who must give way; it is needed only when danger starts.
        if let Some((own, threat)) = self.safe.take() {
            self.others_turn = self.is_others_turn(&own, &threat);
        }
        if self.others_turn {
            return kept;
        }
        self.braked = true;
        Some(self.car.braking)
    }
}

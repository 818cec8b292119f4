use super::crosswalks::CrosswalkKeys;
use super::guarded::{Guarded, LaneGuard};
use super::lane_follower::{Intent, LaneKeys};
use super::reference_drivers::{OwnMotion, Rss, RssLimits, Threat, lateral_distance, longitudinal_distance};
use super::route_trace::{OnTrace, RouteTrace};
use super::{DrivingMode, Perception};
use crate::sim::Control;
use base::{choice, keys};

choice! {
    /// What it assumes of itself.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum Figures {
        AdRss = "ad_rss",
        Jrc = "jrc",
        Bare = "bare",
    }
}

keys! {
    /// A driver that sees no actors, guarded by Responsibility-Sensitive Safety along its lane.
    pub struct RssGuardedKeys = "rss_guarded" {
        ..lane: LaneKeys,
        /// What it assumes of itself: ad-rss-lib's figures (response 1 s, accelerates 3.5, brakes 4 m/s^2), those of
        /// the JRC's comparison (0.75 s, 3, 6), or bare ones (0.5 s, 0, 8). Pedestrians are CARLA's (0.5 s, 2, 2 to 4
        /// m/s^2).
        figures: Figures = "ad_rss",
        ..at_crosswalks: CrosswalkKeys,
    }
}

/// A driver that ignores all road users, guarded by Responsibility-Sensitive Safety. It brakes as soon as car and pedestrian could meet
/// when both brake as late and as weakly as they may.
///
/// For pedestrians it uses [`Rss::is_safe`], the rule for unstructured scenes, with its lane as the path. While their braking sets
/// meet it brakes with the deceleration that it owes, and it releases the brake as soon as they separate. Unlike the reference driver it
/// never leaves the braking to the pedestrian. For vehicles it brakes when both the longitudinal and the lateral distance are unsafe.
///
/// # Source
/// arXiv 1708.06374, with the parameters of ad-rss-lib. Lateral evasion is not included.
#[derive(Debug, Clone)]
pub struct RssGuarded {
    rule: Rss,
}

/// For vehicles beside it: response (s), acceleration and braking (m/s²), margin (m) of ad-rss-lib.
const SIDEWAYS: (f64, f64, f64, f64) = (1.0, 0.2, 0.8, 0.1);

impl RssGuarded {
    pub fn new(keys: RssGuardedKeys) -> Guarded<Self> {
        let car = match keys.figures {
            Figures::AdRss => RssLimits::car(),
            Figures::Jrc => RssLimits::jrc(),
            Figures::Bare => RssLimits::bare(),
        };
        Guarded::new(Self { rule: Rss::new(car, RssLimits::pedestrian()) }, keys.lane, keys.at_crosswalks)
    }

    /// Whether an actor and the car could no longer both stop apart.
    fn is_dangerous(&self, perception: &Perception<'_>, actor: &OnTrace, walks: bool) -> bool {
        let ego = &perception.ego;
        let (speed, side) = (ego.speed(), if actor.place.y > 0.0 { 1.0 } else { -1.0 });
        let threat = Threat {
            gap: actor.place.x - ego.half.x - actor.reach.x,
            length: 2.0 * actor.reach.x,
            offset: actor.place.y.abs(),
            reach: ego.half.y + actor.reach.y,
            along: actor.velocity.x,
            towards: -side * actor.velocity.y,
        };
        if walks {
            return !self.rule.is_safe(
                &OwnMotion { speed, acceleration: 0.0, intended: 0.0, length: 2.0 * ego.half.x, brake: f64::INFINITY },
                &threat,
            );
        }
        let (response, acceleration, braking, margin) = SIDEWAYS;
        let aside = lateral_distance(0.0, -threat.towards, response, acceleration, braking, margin);
        let ahead = longitudinal_distance(speed, threat.along.max(0.0), &self.rule.car);
        actor.place.x > 0.0 && threat.aside() < aside && threat.gap < ahead
    }
}

impl LaneGuard for RssGuarded {
    fn drive(&mut self, intent: &Intent, trace: &RouteTrace, perception: &Perception<'_>) -> (Control, DrivingMode) {
        let people = perception.pedestrians.iter().map(|actor| (actor, true));
        let all = people.chain(perception.vehicles.iter().map(|actor| (actor, false)));
        let mut located = all.filter_map(|(actor, walks)| Some((trace.locate(actor)?, walks)));
        let danger = located.any(|(actor, walks)| self.is_dangerous(perception, &actor, walks));
        let mode = if danger { DrivingMode::EmergencyStop } else { intent.mode };
        let allowed = if danger { -self.rule.car.braking } else { f64::INFINITY };
        (intent.control(intent.acceleration.min(allowed), perception), mode)
    }
}

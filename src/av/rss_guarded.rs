use super::lane_follower::LaneFollower;
use super::rss::{self, RssFigures};
use super::trace::OnTrace;
use super::{DrivingMode, DrivingPolicy, Perception};
use crate::geometry::Vector;
use crate::seed::Stream;
use crate::signature::{Arguments, Param, Signature, Type};
use crate::sim::Control;

/// A driver who sees nobody, guarded by Responsibility-Sensitive Safety: it brakes as soon as both braking as late and as weakly
/// as they may could bring car and pedestrian together.
///
/// The car's braking set T_b is its lane up to [`RssFigures::farthest`], as wide as the car and a margin. A pedestrian's is a fan of
/// three ways: straight on, and turning to either side on a circle of 2 m while it responds, straight afterwards; somebody standing
/// may go anywhere. While the two sets meet, the car brakes with `brakes_least`; braking weakens as soon as they part. For vehicles
/// in the lane the longitudinal distance is kept.
///
/// # Source
/// The unstructured rule of arXiv 1708.06374 as in ad-rss-lib: of its three conditions (c), that the braking sets miss each other,
/// follows from (a) and from (b), so it alone decides what is safe. Left out: the right of way that (b) leaves behind (ad-rss-lib
/// lets the car go on when the pedestrian could still have braked); this driver brakes always. Lateral evasion is no part of it.
#[derive(Debug, Clone)]
pub struct RssGuarded {
    figures: RssFigures,
    driver: LaneFollower,
    mode: DrivingMode,
}

/// A pedestrian slower than this stands (m/s).
const STANDS: f64 = 0.1;

impl RssGuarded {
    /// What it takes in a scenario.
    pub fn signature() -> Signature {
        Signature::new(
            "rss_guarded",
            "A driver who sees nobody, guarded by Responsibility-Sensitive Safety along its lane.",
            vec![
                LaneFollower::param(),
                Param::with_default(
                    "figures",
                    Type::Choice(&["ad_rss", "jrc", "bare"]),
                    "ad_rss",
                    "What it assumes of itself: ad-rss-lib's figures (response 1 s, accelerates 3.5, brakes 4 m/s^2), those of the JRC's comparison (0.75 s, 3, 6), or bare ones (0.5 s, 0, 8). Pedestrians are CARLA's (0.5 s, 2, 2 to 4 m/s^2).",
                ),
            ],
        )
    }

    /// Makes one from checked arguments.
    pub fn new(arguments: &Arguments) -> Self {
        let figures = match arguments.choice("figures") {
            "jrc" => rss::JRC,
            "bare" => rss::BARE,
            _ => rss::AD_RSS,
        };
        Self { figures, driver: LaneFollower::new(arguments), mode: DrivingMode::Cruise }
    }

    /// Whether an actor's braking set meets the car's.
    fn is_dangerous(&self, perception: &Perception<'_>, actor: &OnTrace, walks: bool) -> bool {
        let ego = &perception.ego;
        let speed = ego.speed();
        let aside = ego.half.y + actor.reach.y + rss::MARGIN;
        let gap = actor.place.x - ego.half.x - actor.reach.x;
        if !walks {
            let front = actor.velocity.x.max(0.0);
            let in_lane = actor.place.y.abs() <= aside && actor.place.x > 0.0;
            return in_lane && gap < self.figures.safe_distance(speed, front, self.figures.brakes_most);
        }
        let farthest = self.figures.farthest(speed);
        let (low, high) = (-ego.half.x - actor.reach.x, ego.half.x + actor.reach.x + farthest);
        let ways = Fan::of(actor);
        if actor.velocity.norm() < STANDS {
            let reach = rss::PEDESTRIAN.farthest(0.0);
            let ahead = (low..=high + reach).contains(&actor.place.x);
            return ahead && actor.place.y.abs() <= aside + reach;
        }
        ways.legs().any(|(from, to)| crosses(from, to, low, high, aside))
    }
}

/// Where a moving pedestrian may get to: ways of two straight legs, while it responds and afterwards.
struct Fan {
    start: Vector,
    ends: [(Vector, Vector); 3],
}

impl Fan {
    fn of(actor: &OnTrace) -> Self {
        let figures = rss::PEDESTRIAN;
        let speed = actor.velocity.norm();
        let after = (speed + figures.accelerates * figures.response).min(rss::PEDESTRIAN_TOP_SPEED);
        let responding = (speed + after) / 2.0 * figures.response;
        let braking = after * after / (2.0 * figures.brakes_least);
        let heading = libm::atan2(actor.velocity.y, actor.velocity.x);
        let toward = |angle: f64| Vector::new(libm::cos(angle), libm::sin(angle));
        let ends = [-1.0, 0.0, 1.0].map(|side| {
            let turn = side * responding / rss::PEDESTRIAN_TURN;
            // The chord of an arc points half way between its two tangents.
            let chord =
                if side == 0.0 { responding } else { 2.0 * rss::PEDESTRIAN_TURN * libm::sin((turn / 2.0).abs()) };
            let bend = actor.place + toward(heading + turn / 2.0) * chord;
            (bend, bend + toward(heading + turn) * braking)
        });
        Self { start: actor.place, ends }
    }

    fn legs(&self) -> impl Iterator<Item = (Vector, Vector)> {
        self.ends.iter().flat_map(|(bend, end)| [(self.start, *bend), (*bend, *end)])
    }
}

/// Whether a straight leg meets the lane between two lengths (m) and so far to either side (m).
fn crosses(from: Vector, to: Vector, low: f64, high: f64, aside: f64) -> bool {
    let way = to - from;
    let (mut first, mut last) = (0.0_f64, 1.0_f64);
    for (start, step, low, high) in [(from.x, way.x, low, high), (from.y, way.y, -aside, aside)] {
        if step == 0.0 {
            if start < low || start > high {
                return false;
            }
            continue;
        }
        let (a, b) = ((low - start) / step, (high - start) / step);
        first = first.max(a.min(b));
        last = last.min(a.max(b));
    }
    first <= last
}

impl DrivingPolicy for RssGuarded {
    fn reset(&mut self, perception: &Perception<'_>, stream: Stream) {
        self.driver.reset(perception, stream);
        self.mode = DrivingMode::Cruise;
    }

    fn drive(&mut self, perception: &Perception<'_>) -> Control {
        let intent = self.driver.intend(perception);
        let people = perception.pedestrians.iter().map(|actor| (actor, true));
        let all = people.chain(perception.vehicles.iter().map(|actor| (actor, false)));
        let mut located = all.filter_map(|(actor, walks)| Some((self.driver.trace.locate(actor)?, walks)));
        let danger = located.any(|(actor, walks)| self.is_dangerous(perception, &actor, walks));
        self.mode = if danger { DrivingMode::EmergencyStop } else { intent.mode };
        let allowed = if danger { -self.figures.brakes_least } else { f64::INFINITY };
        intent.control(intent.acceleration.min(allowed), perception)
    }

    fn mode(&self) -> DrivingMode {
        self.mode
    }
}

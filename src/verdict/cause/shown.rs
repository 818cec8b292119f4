use super::Change;
use super::altered::BRAKING;
use super::experiments::Experiments;
use super::profile::{Profile, SPARE};
use world::av::Weakness;

/// Response times above this (s) count as a delay: two ticks of most drivers are none.
const PROMPT: f64 = 0.15;
/// A driver that brakes less hard than this (m/s²) for somebody near brakes weakly: what UN Regulation 152 demands, and what the careful human of UN
/// Regulation 157 does.
const WEAK: (f64, f64) = (5.0, 7.59);
/// A response time above this (s) is a weakness by itself.
const LATE: f64 = 0.4;
/// A brake that reaches this share of the careful human's is not weak.
const STRONG: f64 = 0.9;
/// A brake that takes longer than this to build up (s) is weak: that of the careful human takes 0.6 s.
const SLOW: f64 = 0.6;
/// Shares of the time until the car is there after which people are forecast: a driver begins to brake earlier.
const FORECAST: [f64; 4] = [1.0, 0.75, 0.5, 1.5];
/// A driver that drives faster than the limit by more than this (m/s) on an empty road does not know its speed, or the limit.
const EXCESS: f64 = 1.0;
/// Response times that differ by more than this (s) show that the driver loses somebody.
const FLICKER: f64 = 0.2;
/// Multiples of what is missing that are tried as its repair: the driver's plan is late, too.
const COMPENSATED: [f64; 4] = [1.0, 1.5, 2.0, 3.0];
/// Decelerations that must be enough for somebody far ahead (m/s²): beyond a fixed range (that of AASHTO's stopping sight distance), and at a distance that
/// grows with the speed.
const ENOUGH: (f64, f64) = (3.4, 5.0);
/// A driver that sees less than this share of its half width on one side does not see that side.
const BLIND: f64 = 0.75;
/// Maximum amounts that are tried: how much farther to the middle, and nearer (m).
pub(super) const MAX: (f64, f64) = (6.0, 30.0);

/// What happened, in ticks of the episode.
pub(super) struct Facts {
    pub last: [Option<u32>; 3],
    /// (s)
    pub seen: f64,
    pub reaction: Option<u32>,
    pub braked: Option<u32>,
    pub released: bool,
    pub drove_off: Option<bool>,
    pub profile: Profile,
}

/// A weakness that a driver shows in this encounter.
pub(super) struct Shown {
    pub weakness: Weakness,
    pub amount: Option<f64>,
    /// What shows it, and what repairs it.
    pub what: String,
    pub repair: Repair,
    /// Whether it is one even if its repair does not avoid the failure.
    pub is_certain: bool,
}

/// What repairs a weakness.
pub(super) enum Repair {
    /// No run can.
    Unknown,
    AnyOf(Vec<Change>),
    /// The least amount up to a maximum.
    Least(f64, fn(f64) -> Change),
}

impl Shown {
    fn new(weakness: Weakness, amount: Option<f64>, what: impl Into<String>, repair: Repair) -> Self {
        Self { weakness, amount, what: what.into(), repair, is_certain: false }
    }
}

impl Experiments<'_> {
    /// The weaknesses that the driver shows, in the order of the rules: what it sees, how it brakes, what it expects.
    pub fn shown(&mut self, facts: &Facts) -> Vec<Shown> {
        let mut all = self.of_sight(facts);
        all.extend(self.of_braking(facts));
        if self.run(Change::Standing).is_some_and(|run| Experiments::differs(&self.base, &run).is_none()) {
            let what = "its commands are the same if people seem to stand; a forecast at constant velocity";
            let repair = Repair::AnyOf(FORECAST.map(Change::Forecast).into());
            all.push(Shown::new(Weakness::Anticipation, None, what, repair));
        }
        let repair = Repair::AnyOf(vec![Change::Unseen]);
        all.push(Shown::new(Weakness::Reaction, None, "not seeing the pedestrian", repair));
        all
    }

    /// Whom it sees, and when.
    fn of_sight(&self, facts: &Facts) -> Vec<Shown> {
        let (dt, Profile { latency, loses, .. }) = (self.dt(), facts.profile);
        let mut all = Vec::new();
        if facts.seen + dt < facts.last[0].map_or(0.0, |tick| self.before(tick)) {
            let repair = Repair::AnyOf(vec![Change::SeenThrough]);
            all.push(Shown::new(Weakness::Hidden, Some(facts.seen), "sight through obstacles", repair));
        }
        if let Some((least, most)) = latency {
            if least <= PROMPT && (loses || most - least > FLICKER) {
                let what = format!("somebody near, a little later: reacts in {least:.2} to {most:.2} s");
                let shown = Shown::new(Weakness::Dropouts, None, what, Repair::Unknown);
                all.push(Shown { is_certain: true, ..shown });
            }
            if least > PROMPT {
                let earlier = COMPENSATED.map(|part| Change::Earlier((part * least / dt).round() as u32));
                let repair = Repair::AnyOf(earlier.into());
                let shown = Shown::new(Weakness::Delay, Some(least), format!("{least:.2} s earlier"), repair);
                all.push(Shown { is_certain: least > LATE, ..shown });
            }
        }
        let [left, right] = facts.profile.stands;
        let (_, side, other, edge) = self.sides(facts);
        let width = self.pair().blueprint.half_width;
        let (is_blind, is_narrow) = (side < BLIND * width && other >= width, side < edge && edge <= other);
        if is_blind || is_narrow {
            let what = format!(
                "reacts up to {left:.1} m to the left and {right:.1} m to the right; the same one from the other side"
            );
            // From the other side a pedestrian often misses the way of the car.
            let shown = Shown::new(Weakness::BlindSide, Some(side), what, Repair::AnyOf(vec![Change::Mirrored]));
            all.push(Shown { is_certain: is_blind, ..shown });
        }
        if side.max(other) < edge {
            let what = format!("up to {} m nearer to the middle of its way", MAX.0);
            all.push(Shown::new(Weakness::Corridor, None, what, Repair::Least(MAX.0, Change::Sideways)));
        }
        all
    }

    /// How hard, how long and how early it brakes.
    fn of_braking(&self, facts: &Facts) -> Vec<Shown> {
        let Facts { released, reaction, profile, .. } = facts;
        let Profile { latency, deceleration, rise, releases, excess, reach: [reach, _], gap, .. } = *profile;
        let mut all = Vec::new();
        if excess > EXCESS {
            let what = format!("its speed read {excess:.1} m/s higher");
            let repair = Repair::AnyOf(COMPENSATED.map(|part| Change::Faster(part * excess)).into());
            all.push(Shown::new(Weakness::Speed, Some(excess), what, repair));
        }
        if releases && (*released || reaction.is_none()) {
            let repair = Repair::AnyOf(vec![Change::KeepsBraking]);
            all.push(Shown::new(Weakness::LetsGo, None, "keeps the brake once it brakes", repair));
        }
        let [fixed, growing] = self.needed(profile);
        let is_short = profile.is_fixed() && reach < fixed;
        if is_short {
            let what = format!("notices somebody in its way {reach:.1} m ahead, {fixed:.1} m are needed");
            let repair = Repair::AnyOf(COMPENSATED.map(|part| Change::Nearer(part * (fixed - reach))).into());
            all.push(Shown::new(Weakness::Range, Some(reach), what, repair));
        }
        if let Some(gap) = gap.filter(|gap| !is_short && *gap < growing) {
            let what = format!("brakes for somebody in its way {gap:.1} m ahead, {growing:.1} m are needed");
            let repair = Repair::AnyOf(COMPENSATED.map(|part| Change::Nearer(part * (growing - gap))).into());
            all.push(Shown::new(Weakness::Distance, Some(gap), what, repair));
        }
        let is_weak = deceleration < STRONG * self.pair().blueprint.full_brake.min(WEAK.1);
        if latency.is_some() && (is_weak || rise > SLOW) {
            let what = format!("somebody near: brakes with {deceleration:.1} m/s² after {rise:.2} s; full braking");
            let shown = Shown::new(Weakness::WeakBrake, self.hardest(), what, Repair::AnyOf(vec![Change::BrakesFully]));
            // Of a short range and a weak brake that which lacks more comes first.
            let is_first = !is_short || rise > SLOW || WEAK.0 / deceleration.max(0.1) > fixed / reach.max(0.1);
            let place =
                all.iter().position(|shown| is_first && matches!(shown.weakness, Weakness::Range | Weakness::Distance));
            all.insert(place.unwrap_or(all.len()), shown);
        }
        all
    }

    /// The narrower side from which the pedestrian came while full braking helped; how far beside its axis the driver reacts to somebody there, how far on
    /// the other side, and how far it must (m).
    pub fn sides(&self, facts: &Facts) -> (&'static str, f64, f64, f64) {
        let pair = self.pair();
        let seen = pair.frames().take(facts.last[0].map_or(usize::MAX, |tick| tick as usize + 1));
        let left = seen.map(|frame| frame.ego.pose.to_local(frame.pedestrian.pose.position()).y);
        let was = [1.0, -1.0].map(|side| left.clone().any(|left| side * left > 0.0));
        let [left, right] = facts.profile.stands;
        let edge = pair.blueprint.half_width + pair.body.radius / 2.0;
        let is_left = was[0] && (left <= right || !was[1]);
        if is_left { ("left", left, right, edge) } else { ("right", right, left, edge) }
    }

    /// How far ahead somebody in its way must be noticed if that is at a fixed range, and braked for if the distance grows with the speed (m).
    fn needed(&self, profile: &Profile) -> [f64; 2] {
        let Profile { speed, latency, .. } = profile;
        let reaction = speed * (latency.map_or(0.0, |latency| latency.0) + self.dt()) + SPARE;
        [ENOUGH.0, ENOUGH.1].map(|deceleration| reaction + speed * speed / (2.0 * deceleration))
    }

    /// The hardest deceleration before the end (m/s²).
    fn hardest(&self) -> Option<f64> {
        let frames = self.base.trace.vehicle(0);
        let slower = frames.windows(2).map(|pair| (pair[0].state.speed - pair[1].state.speed) / self.dt());
        slower.max_by(f64::total_cmp).filter(|_| frames.iter().any(|frame| frame.driven.control.brake > BRAKING))
    }
}

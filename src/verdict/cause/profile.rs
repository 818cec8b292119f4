use super::Rerun;
use super::altered::BRAKING;
use super::experiments::Experiments;
use episode::VehicleFrame;
use road::geometry::{Vector, wrap_angle};

/// Distance that is left before somebody who is not hit (m).
pub(super) const SPARE: f64 = 1.0;
/// Distance at which somebody suddenly stands before the bumper and is far away (m).
const FAR: f64 = 40.0;
/// The same, so near that every driver must react at once (m).
const NEAR: f64 = 2.0;
/// The same for somebody beside its way, and the farthest place beside the axis (m).
const BESIDE: (f64, f64) = (5.0, 4.0);
/// A little beside the axis (m): some drivers divide by the bearing.
const ASIDE: f64 = 0.3;
/// Ticks by which somebody appears later.
const SHIFTS: [u32; 5] = [0, 4, 8, 12, 16];
/// The speed that the car seems to have in the second measurement, as a share of its own.
const FASTER: f64 = 1.5;
/// Time over which a deceleration is measured (s).
const STEADY: f64 = 0.3;
/// A brake above this is pressed for somebody.
const PRESSED: f64 = 0.1;
/// A car that is slower (m/s) may let go of the brake.
const MOVING: f64 = 1.0;
/// Time in which a car that is asked does not brake by itself (s), nor turn by more than this (rad).
const FREE: f64 = 1.5;
const STRAIGHT: f64 = 0.05;
/// How long a driver may take to give way to somebody near (s), and how far it then leaves its way at least (m).
const GIVES_WAY: (f64, f64) = (2.0, 0.5);
/// The ratio of distances of reaction, at one and a half times the speed, below which they do not grow with it.
const SAME: f64 = 1.1;
/// Halvings of a distance.
const HALVINGS: u32 = 6;

/// How a driver reacts to somebody who suddenly is in its way or beside it, while nobody else is there.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Profile {
    /// Speed of the car then (m/s).
    pub speed: f64,
    /// How much faster it drives on the empty road than it wants to (m/s), by the speed limit: a driver that keeps limits misreads its speed.
    pub excess: f64,
    /// Until its commands change for somebody near (s), at least and at most; `None` if they never do.
    pub latency: Option<(f64, f64)>,
    /// Whether its commands do not change for somebody near at some ticks, while the car goes straight on.
    pub loses: bool,
    /// How far ahead it reacts at once (m), at its speed and at one and a half times as much.
    pub reach: [f64; 2],
    /// How far beside its axis it reacts at once to somebody who stands there (m), to the left and to the right.
    pub stands: [f64; 2],
    /// Distance from somebody far ahead when it brakes (m); `None` if it does not brake before it is there.
    pub gap: Option<f64>,
    /// Its hardest deceleration (m/s²).
    pub deceleration: f64,
    /// Time from its first braking for somebody near until nine tenths of its hardest (s).
    pub rise: f64,
    /// Whether it lets go of the brake while the car moves and is not there yet.
    pub releases: bool,
    /// Whether it presses its brake harder, or leaves its way, for somebody who is near.
    pub gives_way: bool,
}

/// The reaction of a driver to somebody who suddenly is there.
struct Response {
    /// The tick in which somebody is there, and that in which its commands change.
    from: u32,
    tick: u32,
    rerun: Rerun,
}

/// A place from which a driver is asked: the tick, and what it does on an empty road.
struct Probe<'a, 'b> {
    experiments: &'a mut Experiments<'b>,
    from: u32,
    speed: f64,
    empty: Rerun,
    /// That of [`Profile`].
    gives_way: bool,
}

impl Profile {
    pub fn new(experiments: &mut Experiments<'_>) -> Option<Self> {
        let empty = experiments.appears(0, None, 1.0)?;
        let dt = experiments.dt();
        let (from, first, straight) = unhurried(empty.trace.vehicle(0), experiments.base.outcome.ticks, dt);
        let speed = empty.trace.vehicle(0).get(from as usize)?.state.speed;
        let fastest = empty.trace.vehicle(0).iter().map(|frame| frame.state.speed).fold(0.0, f64::max);
        let mut profile = Self { speed, excess: fastest - experiments.speed_limit(), ..Self::default() };
        let mut probe = Probe { experiments, from, speed: 1.0, empty, gives_way: false };
        for begin in [from, first] {
            if profile.latency.is_some() {
                break;
            }
            for shift in SHIFTS {
                probe.from = begin + shift;
                let Some(response) = probe.ask(NEAR, ASIDE) else {
                    profile.loses |= straight && begin == from;
                    continue;
                };
                let time = f64::from(response.tick - probe.from) * dt;
                let (least, most) = profile.latency.unwrap_or((time, time));
                profile.latency = Some((least.min(time), most.max(time)));
                profile.rise = profile.rise.max(response.rise(dt));
                profile.note(&response, NEAR, dt);
            }
        }
        probe.from = from;
        for (ahead, is_far) in [(BESIDE.0, false), (FAR, true)] {
            let Some(response) = probe.ask(ahead, ASIDE) else { continue };
            let gap = profile.note(&response, ahead, dt);
            profile.gap = gap.filter(|_| is_far);
        }
        let soon = from + 2 + profile.latency.map_or(0, |(_, most)| (most / dt).round() as u32);
        let side = |side: f64| probe.farthest(BESIDE.1, soon, |probe, left| probe.ask(BESIDE.0, side * left));
        profile.stands = [1.0, -1.0].map(side);
        profile.gives_way = probe.gives_way;
        let ahead = |probe: &mut Probe<'_, '_>| probe.farthest(FAR, soon, |probe, ahead| probe.ask(ahead, ASIDE));
        let at_its_speed = ahead(&mut probe);
        probe.speed = FASTER;
        probe.empty = probe.experiments.appears(from, None, FASTER)?;
        profile.reach = [at_its_speed, ahead(&mut probe)];
        Some(profile)
    }

    /// Whether it reacts at a range that does not grow with the speed.
    pub fn is_fixed(&self) -> bool {
        let [reach, faster] = self.reach;
        faster <= SAME * reach + SPARE / 2.0
    }

    /// Notes how hard it brakes, and returns the distance from somebody who stood this far ahead when it brakes first.
    fn note(&mut self, response: &Response, ahead: f64, dt: f64) -> Option<f64> {
        let frames = response.rerun.trace.vehicle(0);
        let after = &frames[(response.tick as usize + 1).min(frames.len())..];
        let steady = (STEADY / dt).round().max(1.0) as usize;
        let slower = after.iter().zip(after.iter().skip(steady));
        let slower = slower.map(|(one, other)| (one.state.speed - other.state.speed) / (steady as f64 * dt));
        self.deceleration = slower.fold(self.deceleration, f64::max);
        let begun = frames.get(response.from as usize)?.state.pose.position();
        let gap = |frame: &VehicleFrame| ahead - (frame.state.pose.position() - begun).norm();
        let mut before = after.iter().take_while(|frame| gap(frame) > 0.0);
        let pressed = before.clone().find(|frame| frame.driven.control.brake > PRESSED).map(gap);
        let brakes = |frame: &VehicleFrame| frame.driven.control.brake > BRAKING;
        before.by_ref().find(|frame| brakes(frame));
        self.releases |= before.take_while(|frame| frame.state.speed > MOVING).any(|frame| !brakes(frame));
        pressed
    }
}

impl Response {
    /// Time from the first braking until nine tenths of the hardest in the next seconds (s).
    fn rise(&self, dt: f64) -> f64 {
        let frames = self.rerun.trace.vehicle(0).iter().skip(self.tick as usize + 1);
        let brakes: Vec<f64> =
            frames.map(|frame| frame.driven.control.brake).take((GIVES_WAY.0 / dt) as usize).collect();
        let hardest = brakes.iter().copied().fold(0.0, f64::max);
        let first = |least: f64| brakes.iter().position(|brake| *brake > least).unwrap_or(0) as f64 * dt;
        first(0.9 * hardest) - first(BRAKING)
    }
}

impl Probe<'_, '_> {
    /// What the driver does if somebody is this far ahead of the bumper along its way and to the left of it (m). `None`
    /// if it does nothing.
    fn ask(&mut self, ahead: f64, left: f64) -> Option<Response> {
        let pair = self.experiments.pair();
        let mut way = pair.blueprint.half_length + pair.body.radius + ahead;
        let frames = self.empty.trace.vehicle(0);
        let mut pose = frames.get(self.from as usize)?.state.pose;
        let along = if ahead > BESIDE.0 { &frames[self.from as usize..] } else { &[] };
        for frame in along {
            let step = (frame.state.pose.position() - pose.position()).norm();
            if step > way {
                break;
            }
            (way, pose) = (way - step, frame.state.pose);
        }
        let place = pose.to_world(Vector::new(way, left));
        let rerun = self.experiments.appears(self.from, Some(place), self.speed)?;
        let tick = Experiments::differs(&self.empty, &rerun).filter(|tick| *tick >= self.from)?;
        self.gives_way |= ahead <= BESIDE.0 && self.is_given_way(&rerun);
        Some(Response { from: self.from, tick, rerun })
    }

    /// Whether the driver soon presses its brake harder than on the empty road and than before, or leaves its way.
    fn is_given_way(&self, rerun: &Rerun) -> bool {
        let (from, dt) = (self.from as usize, self.experiments.dt());
        let frames = [&rerun.trace, &self.empty.trace].map(|trace| &trace.vehicle(0)[from..]);
        let before = frames[1][0].driven.control.brake + BRAKING;
        let mut soon = frames[0].iter().zip(frames[1]).skip(1).take((GIVES_WAY.0 / dt) as usize);
        soon.any(|(here, empty)| {
            let aside = empty.state.pose.to_local(here.state.pose.position()).y.abs();
            here.driven.control.brake > before.max(empty.driven.control.brake + BRAKING) || aside > GIVES_WAY.1
        })
    }

    /// The farthest distance, up to a maximum, at which the driver reacts before a tick.
    fn farthest(&mut self, maximum: f64, soon: u32, mut ask: impl FnMut(&mut Self, f64) -> Option<Response>) -> f64 {
        let mut reacts = |distance| ask(self, distance).is_some_and(|response| response.tick <= soon);
        if reacts(maximum) {
            return maximum;
        }
        let (mut near, mut far) = (0.0, maximum);
        for _ in 0..HALVINGS {
            let middle = (near + far) / 2.0;
            if reacts(middle) { near = middle } else { far = middle }
        }
        near
    }
}

/// The tick from which on the car neither brakes nor turns for a while and has nearly the greatest speed that it has up to an end, or without such a tick that
/// from which on it turns least; the first tick with that speed; and whether it neither brakes nor turns.
fn unhurried(frames: &[VehicleFrame], end: u32, dt: f64) -> (u32, u32, bool) {
    let ahead = (FREE / dt) as usize;
    let greatest = frames.iter().take(end as usize + 1).map(|frame| frame.state.speed).fold(0.0, f64::max);
    let turns = |tick: usize| {
        let after = frames.iter().skip(tick + 1).take(ahead);
        let brakes = after.clone().any(|frame| frame.driven.control.brake > BRAKING);
        let turn = |frame: &VehicleFrame| wrap_angle(frame.state.pose.yaw - frames[tick].state.pose.yaw).abs();
        after.map(turn).fold(if brakes { STRAIGHT } else { 0.0 }, f64::max).max(STRAIGHT / 2.0)
    };
    let ticks = 0..frames.len().saturating_sub(ahead).max(1);
    let mut fast = ticks.filter(|tick| frames[*tick].state.speed >= 0.8 * greatest);
    let least = fast.clone().min_by(|one, other| turns(*one).total_cmp(&turns(*other))).unwrap_or(0);
    (least as u32, fast.next().unwrap_or(0) as u32, turns(least) < STRAIGHT)
}

use super::{DrivenPath, Place};
use episode::{Frame, Pair};
use road::geometry::{Obstacles, OrientedBox, Point, Vector};
use world::av::reference_drivers::{OwnMotion, Threat};
use world::sim::{PedestrianBody, PedestrianState, WalkCommand};

/// Time without danger (s) after which a pedestrian starts a new approach.
const FORGETTING: f64 = 1.0;
/// Up to this speed (m/s) the car stands.
pub(super) const STANDING: f64 = OwnMotion::STANDING;
/// Time (s) that a stop lasts at least.
const STOP: f64 = 0.5;
/// Time after the recorded touch for which the pedestrian continues (s).
const AFTERWARDS: f64 = 5.0;
/// Time between the instants at which an episode without a touch is searched for danger (s).
const EVERY: f64 = 0.2;
/// A pedestrian beyond this distance (m) and the way of this time (s) is of no interest to any reference driver: that of RSS, which looks
/// farthest, is 27 m at 8 m/s, and a pedestrian of 3.5 m/s adds 7 m.
const NEAR: f64 = 15.0;
const FORESEEN: f64 = 3.0;
/// Time before a touch (s) from which drivers look for dangers of their own.
const IN_SIGHT: f64 = 10.0;
/// Time (s) over which a driver knows its own intention.
const FORESIGHT: f64 = 2.0;

/// The pedestrian at a tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    pub position: Point,
    /// Its position relative to the path.
    pub place: Place,
    /// Its velocity (m/s).
    pub velocity: Vector,
}

/// A pedestrian that continues with its last command.
#[derive(Debug, Clone, Copy)]
pub(super) struct Walker<'a> {
    state: PedestrianState,
    command: WalkCommand,
    body: &'a PedestrianBody,
    obstacles: &'a Obstacles,
}

/// How the recorded car moved along its path, tick by tick.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct CarMotion {
    /// Its speed (m/s).
    pub speeds: Vec<f64>,
    /// Its position on the path (m).
    pub ways: Vec<f64>,
}

#[cfg(test)]
impl CarMotion {
    /// A car with these speeds (m/s), tick by tick of `dt` (s): it moves with the mean of the speeds at both ends of a tick.
    pub(super) fn of_speeds(speeds: Vec<f64>, dt: f64) -> Self {
        let moved = speeds.windows(2).map(|pair| (pair[0] + pair[1]) / 2.0 * dt);
        let ways = moved.scan(0.0, |way, moved| {
            *way += moved;
            Some(*way)
        });
        Self { ways: std::iter::once(0.0).chain(ways).collect(), speeds }
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct RecordedCar {
    /// Its position on the path (m).
    pub way: f64,
    /// Its speed (m/s).
    pub speed: f64,
    /// Its acceleration (m/s²).
    pub acceleration: f64,
}

/// The last part of an episode that ended in a touch, from the start of the question. It has the path of the car, the track of the
/// pedestrian and the motion of the car.
#[derive(Debug, Clone)]
pub struct Encounter<'a> {
    /// The path of the car, from the start of the episode.
    pub path: DrivenPath,
    /// The car's position on it when the question starts (m).
    pub start: f64,
    /// The speed of the recorded car, tick by tick up to the recorded touch (m/s). It stays as it is after the touch. No reference driver
    /// is ever faster.
    pub speeds: Vec<f64>,
    /// The pedestrian, tick by tick from the start of the question. What comes after the recording is computed when it is needed.
    pub steps: Vec<Step>,
    /// Time from the start of the question to the recorded touch (s).
    pub warning: f64,
    /// Length of a tick (s).
    pub dt: f64,
    /// Half extents of the car (m).
    pub half: Vector,
    /// Radius of the pedestrian (m).
    pub radius: f64,
    /// The greatest deceleration that the car and the road let a driver reach (m/s²).
    pub brake: f64,
    /// The pedestrian after the recording; `None` if there is nothing after it.
    pub(super) walker: Option<Walker<'a>>,
    /// The number of steps with those after the recording.
    pub(super) step_count: usize,
    /// The recorded car's position on the path, tick by tick (m).
    pub(super) ways: Vec<f64>,
}

impl<'a> Encounter<'a> {
    /// Rewinds an episode to the start of its danger, or to the last instant at which the car stood in it and drove off; `None` if the two
    /// did not touch.
    ///
    /// A car that has stood for half a second has done what a careful human does. To drive off is a new decision, and from there on the question is asked anew.
    pub fn new(pair: &Pair<'a>) -> Option<Self> {
        Self::beginning(pair, 0.0)
    }

    /// The same for drivers who have other dangers than ours: it begins up to ten seconds before the touch, as long as the pedestrian is in sight without a
    /// break.
    pub(super) fn in_sight(pair: &Pair<'a>) -> Option<Self> {
        Self::beginning(pair, IN_SIGHT)
    }

    fn beginning(pair: &Pair<'a>, before: f64) -> Option<Self> {
        let contact = pair.contact?;
        let last = pair.len() - 2;
        let mut encounter = Self::ending_at(pair, last, before);
        encounter.warning += contact.fraction * encounter.dt;
        Some(encounter)
    }

    /// Rewinds an episode in the same way from the sample that decides a violation, with the tick at which the question starts: at the latest the
    /// tick before that sample.
    pub(super) fn before(pair: &Pair<'a>, sample: usize) -> (usize, Self) {
        let last = sample.min(pair.len() - 1).saturating_sub(1);
        let encounter = Self::ending_at(pair, last, 0.0);
        (last - (encounter.warning / encounter.dt).round() as usize, encounter)
    }

    /// The encounter whose danger was under way at this tick. Its warning is the time up to then. It begins with the danger, or earlier if the pedestrian is in sight
    /// `before` (s) that tick.
    fn ending_at(pair: &Pair<'a>, last: usize, before: f64) -> Self {
        let ways = ways(pair);
        let path = DrivenPath::new(pair.frames().map(|frame| frame.ego.pose));
        let danger = Approach { path: &path, pair, ways: &ways }.begins(last);
        let earliest = last.saturating_sub((before / pair.dt()).round() as usize);
        let is_seen = |tick: &usize| pair.in_sight(&pair.frame(*tick));
        let danger = (earliest..danger).rev().take_while(is_seen).last().unwrap_or(danger);
        let begun = (danger..=last).rev().find(|tick| has_stood(pair, *tick)).unwrap_or(danger);
        let mut encounter = Self::between(pair, path, &ways, begun..pair.len());
        encounter.warning = (last - begun) as f64 * encounter.dt;
        // What would have come after a touch is not recorded.
        if let Some(end) = pair.last().filter(|_| pair.contact.is_some()) {
            encounter.walker = Some(Walker {
                state: end.pedestrian,
                command: pair.decisions.last().copied().unwrap_or_default(),
                body: pair.body,
                obstacles: pair.obstacles(),
            });
            encounter.step_count += (AFTERWARDS / encounter.dt) as usize;
        }
        encounter
    }

    /// The approaches of an episode without a touch, each from its start to five seconds after its end. Those in which the pedestrian stays
    /// farther away than any reference driver looks are left out.
    ///
    /// The danger is looked for every fifth of a second.
    pub fn approaches(pair: &Pair<'a>) -> Vec<Self> {
        let every = ((EVERY / pair.dt()).round() as usize).max(1);
        let samples = || (0..pair.len()).step_by(every);
        let is_near = |tick: usize| {
            let frame = pair.frame(tick);
            let apart = frame.ego.pose.position() - frame.pedestrian.pose.position();
            let reach = NEAR + FORESEEN * frame.ego.speed;
            apart.norm_squared() < reach * reach
        };
        if !samples().any(is_near) {
            return Vec::new();
        }
        let path = DrivenPath::new(pair.frames().map(|frame| frame.ego.pose));
        let ways = ways(pair);
        let approach = Approach { path: &path, pair, ways: &ways };
        let (allowed, afterwards) = ((FORGETTING / pair.dt()) as usize, (AFTERWARDS / pair.dt()) as usize);
        let mut ranges: Vec<std::ops::Range<usize>> = Vec::new();
        for tick in samples().filter(|tick| is_near(*tick) && approach.is_dangerous(&pair.frame(*tick), ways[*tick])) {
            match ranges.last_mut() {
                Some(range) if tick <= range.end + allowed => range.end = tick,
                _ => ranges.push(tick..tick),
            }
        }
        let encounter = |range: std::ops::Range<usize>| {
            let end = (range.end + afterwards).min(pair.len() - 1);
            Self::between(pair, path.clone(), &ways, range.start..end + 1)
        };
        ranges.into_iter().map(encounter).collect()
    }

    /// The recorded part of an encounter, without what comes after it.
    fn between(pair: &Pair<'a>, path: DrivenPath, ways: &[f64], ticks: std::ops::Range<usize>) -> Self {
        let frames = || pair.frames().skip(ticks.start).take(ticks.len());
        let start = ways[ticks.start];
        let speeds: Vec<f64> = frames().map(|frame| frame.ego.speed).collect();
        let steps: Vec<Step> = frames().map(|frame| step(&path, &frame.pedestrian, start)).collect();
        let blueprint = pair.blueprint;
        let half = Vector::new(blueprint.half_length, blueprint.half_width);
        let motion = CarMotion { speeds, ways: ways[ticks].to_vec() };
        Self {
            brake: blueprint.greatest_deceleration(),
            ..Self::of_steps(path, motion, steps, (half, pair.body.radius), pair.dt())
        }
    }

    /// An encounter of a car with these half extents and a pedestrian of this radius (m) in ticks of `dt` (s).
    pub(super) fn of_steps(
        path: DrivenPath,
        motion: CarMotion,
        steps: Vec<Step>,
        (half, radius): (Vector, f64),
        dt: f64,
    ) -> Self {
        let CarMotion { speeds, ways } = motion;
        let warning = (steps.len() - 1) as f64 * dt;
        let step_count = steps.len();
        let brake = f64::INFINITY;
        let (start, walker) = (ways[0], None);
        Self { path, start, speeds, steps, warning, dt, half, radius, brake, walker, step_count, ways }
    }

    /// Its last part, up to this time (s) before the touch.
    pub(super) fn last(&self, time: f64) -> Self {
        let mut last = self.clone();
        let skipped = ((self.warning - time) / self.dt).max(0.0) as usize;
        last.speeds.drain(..skipped);
        last.steps.drain(..skipped);
        last.ways.drain(..skipped);
        (last.start, last.step_count) = (last.ways[0], self.step_count - skipped);
        last.warning -= skipped as f64 * self.dt;
        last
    }

    /// The same with the pedestrian moved by this (m).
    pub(super) fn moved(&self, by: Vector) -> Self {
        let mut moved = self.clone();
        for step in &mut moved.steps {
            step.position += by;
            step.place.along += by.dot(&step.place.direction);
            step.place.aside += step.place.direction.perp(&by);
        }
        if let Some(walker) = &mut moved.walker {
            (walker.state.pose.x, walker.state.pose.y) = (walker.state.pose.x + by.x, walker.state.pose.y + by.y);
        }
        moved
    }

    /// Whether there is a pedestrian at this tick, for at most five seconds after the recorded touch.
    pub(super) fn has_step(&mut self, tick: usize) -> bool {
        let Some(walker) = &mut self.walker else { return tick < self.steps.len() };
        while self.steps.len() <= tick.min(self.step_count - 1) {
            walker.state = walker.state.step(walker.command, walker.body, walker.obstacles, self.dt);
            self.steps.push(step(&self.path, &walker.state, self.start));
        }
        tick < self.step_count
    }

    /// The recorded car `share` of a tick after this one. After the recording it keeps its speed.
    pub(super) fn car(&self, tick: usize, share: f64) -> RecordedCar {
        let last = self.speeds.len() - 1;
        if tick >= last {
            let (speed, since) = (self.speeds[last], ((tick - last) as f64 + share) * self.dt);
            return RecordedCar { way: self.ways[last] + speed * since, speed, acceleration: 0.0 };
        }
        let mix = |of: &[f64]| of[tick] + (of[tick + 1] - of[tick]) * share;
        let acceleration = (self.speeds[tick + 1] - self.speeds[tick]) / self.dt;
        RecordedCar { way: mix(&self.ways), speed: mix(&self.speeds), acceleration }
    }

    /// The greatest speed (m/s) of the recorded car between two times from the start of the question (s).
    pub(super) fn fastest_since(&self, from: f64, to: f64) -> f64 {
        let at = |time: f64| {
            let ticks = (time / self.dt).max(0.0);
            self.car(ticks as usize, ticks.fract()).speed
        };
        let between = ((from / self.dt).max(0.0).ceil() as usize)..=((to / self.dt) as usize);
        between.filter_map(|tick| self.speeds.get(tick).copied()).fold(at(from).max(at(to)), f64::max)
    }

    /// The mean acceleration (m/s²) of the recorded car over the next two seconds, at least 0: what its driver intends.
    pub(super) fn intended(&self, tick: usize, share: f64) -> f64 {
        let ticks = FORESIGHT / self.dt + share;
        let now = self.car(tick, share);
        let covered = self.car(tick + ticks as usize, ticks.fract()).way - now.way;
        // `x = v t + a t²/2`; a car that keeps its speed has none, whatever the rounding.
        let gained = covered - now.speed * FORESIGHT;
        if gained > 1e-6 { 2.0 * gained / (FORESIGHT * FORESIGHT) } else { 0.0 }
    }

    /// The pedestrian between a tick and the next one, as seen by a driver who is `way` (m) along the path; `None` if it is behind the car.
    pub fn threat(&self, tick: usize, share: f64, way: f64) -> Option<Threat> {
        let (from, to) = (&self.steps[tick], &self.steps[(tick + 1).min(self.steps.len() - 1)]);
        threat(from, to, share, way, (self.half, self.radius))
    }

    /// The box of a car that is `way` (m) along the path. It drives on: `passed` is that of [`DrivenPath::pose`].
    pub(super) fn outline(&self, way: f64, passed: &mut usize) -> OrientedBox {
        OrientedBox { pose: self.path.pose(way, passed), half: self.half }
    }
}

fn step(path: &DrivenPath, walker: &PedestrianState, start: f64) -> Step {
    let position = walker.pose.position();
    Step { position, place: path.place(position, start), velocity: walker.velocity }
}

fn threat(from: &Step, to: &Step, share: f64, way: f64, (half, radius): (Vector, f64)) -> Option<Threat> {
    let mix = |a: f64, b: f64| a + (b - a) * share;
    let (along, aside) = (mix(from.place.along, to.place.along), mix(from.place.aside, to.place.aside));
    if along + radius < way - half.x {
        return None;
    }
    let side = if aside > 0.0 { 1.0 } else { -1.0 };
    Some(Threat {
        gap: along - radius - way - half.x,
        length: 2.0 * radius,
        offset: aside.abs(),
        reach: half.y + radius,
        along: from.velocity.dot(&from.place.direction),
        towards: -side * from.place.direction.perp(&from.velocity),
    })
}

/// The approach of a pedestrian to the path of a car.
struct Approach<'a> {
    path: &'a DrivenPath,
    pair: &'a Pair<'a>,
    ways: &'a [f64],
}

impl Approach<'_> {
    /// The tick at which the approach that was under way at tick `last` started: at the latest that tick.
    fn begins(&self, last: usize) -> usize {
        let allowed = (FORGETTING / self.pair.dt()).ceil() as usize;
        let mut begun = last;
        for tick in (0..=last).rev() {
            if begun - tick > allowed {
                break;
            }
            if self.is_dangerous(&self.pair.frame(tick), self.ways[tick]) {
                begun = tick;
            }
        }
        begun
    }

    /// Whether the pedestrian is not behind the car, is in its way or moves into it, and can be seen.
    fn is_dangerous(&self, frame: &Frame, way: f64) -> bool {
        let blueprint = self.pair.blueprint;
        let sizes = (Vector::new(blueprint.half_length, blueprint.half_width), self.pair.body.radius);
        let step = step(self.path, &frame.pedestrian, way);
        let threat = threat(&step, &step, 0.0, way, sizes);
        threat.is_some_and(|threat| threat.is_on_its_way()) && self.pair.in_sight(frame)
    }
}

/// Whether the car stands at a tick and has stood for half a second, on average: a single sample of 0 is no stop, also at the start of an episode.
fn has_stood(pair: &Pair<'_>, tick: usize) -> bool {
    let speed = |tick: usize| pair.frame(tick).ego.speed;
    let samples = ((STOP / pair.dt()).round() as usize).max(1);
    let mean = |first: usize| (first..=tick).map(speed).sum::<f64>() / samples as f64;
    speed(tick) <= STANDING && (tick + 1).checked_sub(samples).is_some_and(|first| mean(first) <= STANDING)
}

/// The car's position along its own path at each frame (m).
fn ways(pair: &Pair<'_>) -> Vec<f64> {
    let mut way = 0.0;
    let mut last = pair.frame(0).ego.pose.position();
    let along = pair.frames().map(|frame| {
        let here = frame.ego.pose.position();
        let step = (here - last).norm();
        if step > 1e-9 {
            way += step;
            last = here;
        }
        way
    });
    along.collect()
}

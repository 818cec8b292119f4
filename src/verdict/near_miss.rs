use super::encounter::STANDING;
use episode::{Frame, Pair};
use road::geometry::{Vector, time_to_touch};

/// The longest time to collision (s) that counts.
const HORIZON: f64 = 10.0;
/// Number of footprints in a block that is tested as a whole.
const BLOCK: usize = 16;

/// How near an episode came to a touch.
///
/// | symbol | field | unit |
/// |---|---|---|
/// | TTC = min over t of min { s : the disc touches the box at t + s when both keep the velocities that they have at t } | `min_ttc` | s |
/// | PET = min { \|t₁ − t₂\| : the disc at t₁ touches the box at t₂ } | `pet` | s |
///
/// # Source
/// Hayward, *Near-miss determination through use of a scale of danger*, Highway Research Record 384, 1972. Allen, Shin and
/// Cooper, *Analysis of traffic conflicts and collisions*, Transportation Research Record 667, 1978, who measure PET at one
/// point of conflict; here it is the least over all points that both sweep.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct NearMiss {
    /// Least time to collision at constant velocities (s), over all ticks at which the car moves (more than 0.1 m/s). `None` if they were
    /// never on course to touch within ten seconds. 0 when they touched while the car moved.
    pub min_ttc: Option<f64>,
    /// Post-encroachment time (s) at the ticks, up to two of them too long: the least time between one leaving a place and the other reaching it. `None` if
    /// their paths do not cross, when they touched, and when one was above the other.
    pub pet: Option<f64>,
}

impl NearMiss {
    /// Measures an episode.
    pub fn new(pair: &Pair<'_>) -> Self {
        let half = Vector::new(pair.blueprint.half_length, pair.blueprint.half_width);
        let bodies = Bodies { half, radius: pair.body.radius };
        let has_none = pair.contact.is_some() || pair.frames().any(|frame| !pair.is_on_level(&frame));
        let ticks = if has_none { None } else { bodies.least_lag(pair.frames()) };
        let frames = pair.frames().filter(|frame| pair.is_on_level(frame));
        Self { min_ttc: bodies.least_time(frames), pet: ticks.map(|ticks| ticks as f64 * pair.dt()) }
    }

    /// The time to collision (s) at the last tick, if it is less than three seconds.
    pub fn of_last(pair: &Pair<'_>) -> Option<f64> {
        let half = Vector::new(pair.blueprint.half_length, pair.blueprint.half_width);
        Bodies { half, radius: pair.body.radius }.least_time(pair.last().into_iter()).filter(|time| *time < 3.0)
    }
}

/// The sizes of the box and of the disc (m).
struct Bodies {
    half: Vector,
    radius: f64,
}

impl Bodies {
    /// The least time to collision (s).
    fn least_time(&self, frames: impl Iterator<Item = Frame>) -> Option<f64> {
        let mut least = HORIZON;
        let mut heading = Heading::default();
        for frame in frames.filter(|frame| frame.ego.speed > STANDING) {
            let ego = &frame.ego;
            heading.turn(ego.pose.yaw);
            let place = heading.local(frame.pedestrian.pose.x - ego.pose.x, frame.pedestrian.pose.y - ego.pose.y);
            let velocity = heading.local(frame.pedestrian.velocity.x, frame.pedestrian.velocity.y);
            let closing = velocity - Vector::new(ego.speed, 0.0);
            if let Some(time) = time_to_touch(place, closing, self.half, self.radius, least) {
                least = time;
            }
        }
        (least < HORIZON).then_some(least)
    }

    /// The least number of ticks between the box and the disc occupying the same place.
    fn least_lag(&self, frames: impl ExactSizeIterator<Item = Frame> + Clone) -> Option<usize> {
        let reach = self.half.norm() + self.radius;
        let mut heading = Heading::default();
        let cars = footprints(frames.clone(), |frame| {
            heading.turn(frame.ego.pose.yaw);
            (frame.ego.pose.x, frame.ego.pose.y, heading)
        });
        let walkers =
            footprints(frames, |frame| (frame.pedestrian.pose.x, frame.pedestrian.pose.y, Heading::default()));
        let bounds = |all: &[Footprint]| all.chunks(BLOCK).map(Bounds::new).collect::<Vec<_>>();
        let (car_bounds, walker_bounds) = (bounds(&cars), bounds(&walkers));
        let mut least = usize::MAX;
        for (here, bounds) in cars.chunks(BLOCK).zip(&car_bounds) {
            // Forwards from the same time, and backwards, as long as a smaller lag is possible.
            let same = walker_bounds.partition_point(|others| others.ticks.1 < bounds.ticks.0);
            let mut look = |index: usize| {
                let others = &walker_bounds[index];
                let hopeful = bounds.lag(others) < least;
                if hopeful && bounds.is_within(others, reach) {
                    let there = &walkers[index * BLOCK..walkers.len().min((index + 1) * BLOCK)];
                    least = self.least_of(here, there, reach, least);
                }
                hopeful
            };
            let _ = (same..walker_bounds.len()).all(&mut look);
            let _ = (0..same).rev().all(&mut look);
        }
        (least < usize::MAX).then_some(least)
    }

    /// The least lag of some footprints that touch, if it is less than the least lag so far.
    fn least_of(&self, cars: &[Footprint], walkers: &[Footprint], reach: f64, mut least: usize) -> usize {
        for car in cars {
            for walker in walkers {
                let lag = lag(car.ticks, walker.ticks);
                if lag < least && self.touch(car, walker, reach) {
                    least = lag;
                }
            }
        }
        least
    }

    fn touch(&self, car: &Footprint, walker: &Footprint, reach: f64) -> bool {
        let (dx, dy) = (walker.x - car.x, walker.y - car.y);
        if dx * dx + dy * dy > reach * reach {
            return false;
        }
        let place = car.heading.local(dx, dy);
        let (ahead, aside) = ((place.x.abs() - self.half.x).max(0.0), (place.y.abs() - self.half.y).max(0.0));
        ahead * ahead + aside * aside <= self.radius * self.radius
    }
}

/// A heading with its sine and cosine, computed once while it stays the same.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Heading {
    yaw: f64,
    sin: f64,
    cos: f64,
}

impl Default for Heading {
    fn default() -> Self {
        Self { yaw: 0.0, sin: 0.0, cos: 1.0 }
    }
}

impl Heading {
    fn turn(&mut self, yaw: f64) {
        if yaw != self.yaw {
            let (sin, cos) = libm::sincos(yaw);
            *self = Self { yaw, sin, cos };
        }
    }

    /// A displacement of the world in the frame of this heading: ahead and to the left.
    fn local(&self, x: f64, y: f64) -> Vector {
        Vector::new(self.cos * x + self.sin * y, -self.sin * x + self.cos * y)
    }
}

/// The positions of an actor from one tick to another, both included.
#[derive(Debug, Clone, Copy)]
struct Footprint {
    ticks: (usize, usize),
    x: f64,
    y: f64,
    heading: Heading,
}

/// The positions of an actor in order; ticks without a motion count as one.
fn footprints(
    frames: impl ExactSizeIterator<Item = Frame>,
    mut place: impl FnMut(&Frame) -> (f64, f64, Heading),
) -> Vec<Footprint> {
    let mut all: Vec<Footprint> = Vec::with_capacity(frames.len());
    for (tick, frame) in frames.enumerate() {
        let (x, y, heading) = place(&frame);
        match all.last_mut() {
            Some(last) if (last.x, last.y, last.heading) == (x, y, heading) => last.ticks.1 = tick,
            _ => all.push(Footprint { ticks: (tick, tick), x, y, heading }),
        }
    }
    all
}

/// The ticks between two intervals of time; 0 when they overlap.
fn lag(a: (usize, usize), b: (usize, usize)) -> usize {
    a.0.saturating_sub(b.1).max(b.0.saturating_sub(a.1))
}

/// The bounds of several footprints: their ticks and the box of their centres.
#[derive(Debug, Clone, Copy)]
struct Bounds {
    ticks: (usize, usize),
    low: (f64, f64),
    high: (f64, f64),
}

impl Bounds {
    fn new(footprints: &[Footprint]) -> Self {
        let first = footprints[0];
        let mut bounds = Self { ticks: first.ticks, low: (first.x, first.y), high: (first.x, first.y) };
        for footprint in footprints {
            bounds.ticks.1 = footprint.ticks.1;
            bounds.low = (bounds.low.0.min(footprint.x), bounds.low.1.min(footprint.y));
            bounds.high = (bounds.high.0.max(footprint.x), bounds.high.1.max(footprint.y));
        }
        bounds
    }

    fn lag(&self, other: &Self) -> usize {
        lag(self.ticks, other.ticks)
    }

    /// Whether the distance of the boxes is at most this, on either axis.
    fn is_within(&self, other: &Self, reach: f64) -> bool {
        self.low.0 - reach <= other.high.0
            && other.low.0 - reach <= self.high.0
            && self.low.1 - reach <= other.high.1
            && other.low.1 - reach <= self.high.1
    }
}

#[cfg(test)]
mod tests;

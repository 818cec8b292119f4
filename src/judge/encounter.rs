use super::{DrivenPath, Place};
use crate::av::reference_drivers::Threat;
use crate::env::{Frame, Pair};
use crate::geometry::{OrientedBox, Point, Vector};

/// Time without danger (s) after which a pedestrian starts a new approach.
const FORGETTING: f64 = 1.0;
/// Time after the recorded touch for which the pedestrian continues (s).
const AFTERWARDS: f64 = 5.0;

/// The pedestrian at a tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    /// Its position.
    pub position: Point,
    /// Its position relative to the path.
    pub place: Place,
    /// Its velocity (m/s).
    pub velocity: Vector,
}

/// The last part of an episode that ended in a touch, from the start of the danger. It has the path of the car, the track of the
/// pedestrian and the speed of the car.
#[derive(Debug, Clone)]
pub struct Encounter {
    /// The path of the car, from the start of the episode.
    pub path: DrivenPath,
    /// The car's position on it when the danger starts (m).
    pub start: f64,
    /// The greatest speed of the car since the danger started, tick by tick up to the recorded touch (m/s).
    pub pace: Vec<f64>,
    /// The pedestrian, tick by tick from the start of the danger.
    pub steps: Vec<Step>,
    /// Time from the start of the danger to the recorded touch (s).
    pub warning: f64,
    /// The car's speed at the recorded touch (m/s).
    pub impact_speed: f64,
    /// Length of a tick (s).
    pub dt: f64,
    /// Half extents of the car (m).
    pub half: Vector,
    /// Radius of the pedestrian (m).
    pub radius: f64,
}

impl Encounter {
    /// Rewinds an episode to the start of its danger; none when the two did not touch.
    pub fn new(pair: &Pair<'_>) -> Option<Self> {
        let contact = pair.contact()?;
        let (blueprint, body, dt) = (pair.blueprint(), pair.body(), pair.dt());
        let mut encounter = Self {
            path: DrivenPath::new(pair.frames().map(|frame| frame.ego.pose)),
            start: 0.0,
            pace: Vec::new(),
            steps: Vec::new(),
            warning: 0.0,
            impact_speed: contact.impact_speed,
            dt,
            half: Vector::new(blueprint.half_length, blueprint.half_width),
            radius: body.radius,
        };
        let ways = ways(pair);
        let begun = encounter.rewind(pair, &ways);
        encounter.start = ways[begun];
        encounter.warning = (pair.len() - 2 - begun) as f64 * dt + contact.fraction * dt;
        let mut fastest = 0.0_f64;
        encounter.pace.extend(pair.frames().skip(begun).map(|frame| {
            fastest = fastest.max(frame.ego.speed);
            fastest
        }));
        let command = pair.decisions().last().copied().unwrap_or_default();
        let mut walker = pair.last()?.pedestrian;
        let recorded = pair.frames().skip(begun).map(|frame| frame.pedestrian);
        let afterwards = (0..(AFTERWARDS / dt) as u32).map(|_| {
            walker = walker.step(command, body, &pair.scenario().obstacles, dt);
            walker
        });
        let step = |walker: crate::sim::PedestrianState| Step {
            position: walker.pose.position(),
            place: encounter.path.place(walker.pose.position(), encounter.start),
            velocity: walker.velocity,
        };
        encounter.steps = recorded.chain(afterwards).map(step).collect();
        Some(encounter)
    }

    /// The tick at which the approach that ended in the touch started: at the latest the tick before the touch.
    fn rewind(&self, pair: &Pair<'_>, ways: &[f64]) -> usize {
        let last = pair.len() - 2;
        let patience = (FORGETTING / self.dt).ceil() as usize;
        let mut begun = last;
        for tick in (0..=last).rev() {
            if begun - tick > patience {
                break;
            }
            if self.is_dangerous(&pair.frame(tick), ways[tick], pair) {
                begun = tick;
            }
        }
        begun
    }

    /// Whether the pedestrian is not behind the car, is in its way or moves into it, and can be seen.
    fn is_dangerous(&self, frame: &Frame, way: f64, pair: &Pair<'_>) -> bool {
        let position = frame.pedestrian.pose.position();
        let place = self.path.place(position, way);
        let step = Step { position, place, velocity: frame.pedestrian.velocity };
        let threat = self.threat(&step, &step, 0.0, way);
        threat.is_some_and(|threat| threat.is_on_its_way()) && pair.in_sight(frame)
    }

    /// The pedestrian between two ticks, as seen by a driver who is `way` (m) along the path; none when it is behind the car.
    pub fn threat(&self, from: &Step, to: &Step, share: f64, way: f64) -> Option<Threat> {
        let mix = |a: f64, b: f64| a + (b - a) * share;
        let (along, aside) = (mix(from.place.along, to.place.along), mix(from.place.aside, to.place.aside));
        if along + self.radius < way - self.half.x {
            return None;
        }
        let side = if aside > 0.0 { 1.0 } else { -1.0 };
        Some(Threat {
            gap: along - self.radius - way - self.half.x,
            length: 2.0 * self.radius,
            aside: (aside.abs() - self.half.y - self.radius).max(0.0),
            along: from.velocity.dot(&from.place.direction),
            towards: -side * from.place.direction.perp(&from.velocity),
        })
    }

    /// The box of a car that is `way` (m) along the path.
    pub fn outline(&self, way: f64) -> OrientedBox {
        OrientedBox { pose: self.path.pose(way), half: self.half }
    }
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

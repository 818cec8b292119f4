use serde::Serialize;

use super::super::episode::in_short;
use super::super::town::{Scenery, Surface};
use episode::{Ending, Frame, Scenario, Trace};
use road::geometry::{Point, Pose};
use verdict::{Encountered, Judged, Reference};

/// Scenery is shown up to this distance from the paths of car and pedestrian (m).
const AROUND: f64 = 40.0;
/// A picture opens this long before the danger, but within these times before the end (s).
const BEFORE: f64 = 0.5;
const SHORTEST: f64 = 2.0;
const LONGEST: f64 = 4.0;

/// An episode in the format of the player: integers relative to an origin, so that hundreds of ticks stay small.
///
/// Positions are in centimetres east and north of `origin`, angles in milliradians, speeds in cm/s, pedals in hundredths.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Replay {
    /// The origin of the coordinates (m).
    pub origin: [f64; 2],
    /// Length of a tick (s).
    pub dt: f64,
    /// Half length and half width of the car (cm).
    pub car: [i64; 2],
    /// Radius of the pedestrian (cm).
    pub radius: i64,
    /// Polygons of the scenery, from the ground up: number of the surface, then x and y of each corner, in decimetres.
    pub scenery: Vec<Vec<i64>>,
    /// The car at each tick: x, y, yaw, speed.
    pub ego: Vec<[i64; 4]>,
    /// The pedestrian at each tick: x, y, yaw, speed.
    pub person: Vec<[i64; 4]>,
    /// The other actors.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub others: Vec<OtherTrack>,
    /// The driver's actions: first tick, and name.
    pub modes: Vec<(usize, &'static str)>,
    /// Brake of each tick.
    pub brake: Vec<i64>,
    /// Throttle of each tick.
    pub throttle: Vec<i64>,
    /// Ticks at which the pedestrian comes into sight or is lost from it; before the first it is hidden.
    pub sight: Vec<usize>,
    /// Tick at which the danger started; `None` without a collision.
    pub danger: Option<usize>,
    /// The tick that decides each violated requirement, and its name.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub violations: Vec<(u32, String)>,
    /// The tick at which a picture of it opens: some seconds before the end, with the danger near.
    pub opens: usize,
    pub verdict: Option<&'static str>,
    /// The results of the reference drivers: name, and impact speed (m/s), `None` if they avoid it.
    pub drivers: Vec<(&'static str, Option<f64>)>,
    /// Whether it ends in a touch.
    pub touch: bool,
    /// The episode in a sentence or two, which the card has.
    #[serde(skip)]
    pub short: String,
}

/// Another actor of an episode in that format.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OtherTrack {
    pub name: String,
    pub is_pedestrian: bool,
    /// Half length and half width (cm).
    pub half: [i64; 2],
    /// It at each tick: x, y, yaw, speed; a parked car once.
    pub states: Vec<[i64; 4]>,
}

/// A number in whole units.
fn whole(value: f64, unit: f64) -> i64 {
    (value / unit).round() as i64
}

fn state(origin: Point, pose: &Pose, speed: f64) -> [i64; 4] {
    [whole(pose.x - origin.x, 0.01), whole(pose.y - origin.y, 0.01), whole(pose.yaw, 0.001), whole(speed, 0.01)]
}

impl OtherTrack {
    /// Its state at a tick.
    pub fn at(&self, tick: usize) -> &[i64; 4] {
        &self.states[tick.min(self.states.len() - 1)]
    }
}

impl Replay {
    /// Converts an episode to the player's format.
    pub fn new(scenario: &Scenario, scenery: &Scenery, trace: &Trace, judged: &Judged) -> Self {
        let (outcome, verdict) = (&judged.outcome, judged.verdict.as_ref());
        let pair = trace.main_pair(scenario);
        let frames: Vec<Frame> = pair.frames().collect();
        let last = frames.last().map_or_else(Point::origin, |frame| frame.pedestrian.pose.position());
        let origin = Point::new(last.x.round(), last.y.round());
        let state = |pose: &Pose, speed: f64| state(origin, pose, speed);
        let (mut low, mut high) = (last, last);
        for place in frames.iter().flat_map(|m| [m.ego.pose.position(), m.pedestrian.pose.position()]) {
            (low, high) = (low.inf(&place), high.sup(&place));
        }
        let margin = road::geometry::Vector::new(AROUND, AROUND);
        let polygon = |(surface, corners): &(Surface, Vec<Point>)| {
            let mut numbers = vec![*surface as i64];
            numbers.extend(corners.iter().flat_map(|c| [whole(c.x - origin.x, 0.1), whole(c.y - origin.y, 0.1)]));
            numbers
        };
        let mut modes: Vec<(usize, &'static str)> = Vec::new();
        for (tick, frame) in frames.iter().enumerate() {
            // The first frame is before the driver's first decision.
            let name = frames.get(1).filter(|_| tick == 0).unwrap_or(frame).mode.shown();
            if modes.last().is_none_or(|(_, known)| *known != name) {
                modes.push((tick, name));
            }
        }
        let mut sight = Vec::new();
        for (tick, frame) in frames.iter().enumerate() {
            if pair.in_sight(frame) == (sight.len() % 2 == 0) {
                sight.push(tick);
            }
        }
        let touch = matches!(outcome.ending, Ending::Touch { .. });
        // The touch is within the last tick. The danger started this time before it.
        let ticks = |seconds: f64| (seconds / scenario.episode.tick).ceil() as usize;
        let shown = verdict.map_or(LONGEST, |verdict| (verdict.warning + BEFORE).clamp(SHORTEST, LONGEST));
        let violated = trace.degrees().iter().filter(|degree| degree.is_violated());
        let opens = match violated.map(|degree| degree.sample as usize).min().filter(|_| !touch) {
            Some(sample) => sample.saturating_sub(ticks(SHORTEST)),
            None => (frames.len() - 1).saturating_sub(ticks(shown)),
        };
        Self {
            origin: [origin.x, origin.y],
            dt: scenario.episode.tick,
            car: [whole(pair.blueprint.half_length, 0.01), whole(pair.blueprint.half_width, 0.01)],
            radius: whole(pair.body.radius, 0.01),
            scenery: scenery.within(low - margin, high + margin).polygons.iter().map(polygon).collect(),
            ego: frames.iter().map(|frame| state(&frame.ego.pose, frame.ego.speed)).collect(),
            others: pair
                .others()
                .map(|other| OtherTrack {
                    name: other.name.to_string(),
                    is_pedestrian: other.is_pedestrian(),
                    half: [whole(other.half.x, 0.01), whole(other.half.y, 0.01)],
                    states: (0..if other.is_parked { 1 } else { frames.len() })
                        .map(|tick| other.state(tick))
                        .map(|(pose, speed)| state(&pose, speed))
                        .collect(),
                })
                .collect(),
            person: frames.iter().map(|m| state(&m.pedestrian.pose, m.pedestrian.speed())).collect(),
            modes,
            brake: frames.iter().map(|frame| whole(frame.control.brake, 0.01)).collect(),
            throttle: frames.iter().map(|frame| whole(frame.control.throttle, 0.01)).collect(),
            sight,
            danger: verdict.map(|verdict| (frames.len() - 1).saturating_sub(ticks(verdict.warning))),
            violations: scenario
                .requirements
                .iter()
                .zip(trace.degrees())
                .filter(|(_, degree)| degree.is_violated())
                .map(|(named, degree)| (degree.sample, named.name.to_string()))
                .collect(),
            opens,
            verdict: verdict.map(|verdict| verdict.label.name()),
            drivers: verdict.map_or_else(Vec::new, |verdict| {
                let fared = |driver: Reference| (driver.in_words(), verdict.trial(driver).impact_speed);
                Reference::ALL.map(fared).into()
            }),
            touch,
            short: in_short(scenario, trace, judged),
        }
    }

    /// Converts an episode that is alone on its page, with the scenery around it.
    pub fn of_episode(scenario: &Scenario, trace: &Trace, judged: &Judged) -> Self {
        Self::new(scenario, &Scenery::new(&scenario.town), trace, judged)
    }

    /// Converts a recording from elsewhere. Its brake is what the speeds tell.
    pub fn of_recording(found: &Encountered, short: &str) -> Self {
        let (pair, dt) = (found.trace.pair(&found.scenario, 0, 0), found.scenario.episode.tick);
        let frames: Vec<Frame> = pair.frames().collect();
        let last = frames.last().map_or_else(Point::origin, |frame| frame.pedestrian.pose.position());
        let origin = Point::new(last.x.round(), last.y.round());
        let verdict = found.told();
        let lost = |frames: &[Frame]| (frames[0].ego.speed - frames[1].ego.speed) / dt / pair.blueprint.full_brake;
        let ticks = |seconds: f64| (seconds / dt).ceil() as usize;
        let shown = verdict.map_or(LONGEST, |verdict| (verdict.warning + BEFORE).clamp(SHORTEST, LONGEST));
        let seen = frames.iter().map(|frame| pair.in_sight(frame));
        let changes = std::iter::once(false).chain(seen.clone()).zip(seen).enumerate();
        Self {
            origin: [origin.x, origin.y],
            dt,
            car: [whole(pair.blueprint.half_length, 0.01), whole(pair.blueprint.half_width, 0.01)],
            radius: whole(pair.body.radius, 0.01),
            scenery: Vec::new(),
            ego: frames.iter().map(|frame| state(origin, &frame.ego.pose, frame.ego.speed)).collect(),
            person: frames.iter().map(|m| state(origin, &m.pedestrian.pose, m.pedestrian.speed())).collect(),
            others: Vec::new(),
            modes: vec![(0, "recorded")],
            brake: std::iter::once(0)
                .chain(frames.windows(2).map(|pair| whole(lost(pair).clamp(0.0, 1.0), 0.01)))
                .collect(),
            throttle: vec![0; frames.len()],
            sight: changes.filter(|(_, (before, now))| before != now).map(|(tick, _)| tick).collect(),
            danger: verdict.map(|verdict| (frames.len() - 1).saturating_sub(ticks(verdict.warning))),
            violations: Vec::new(),
            opens: (frames.len() - 1).saturating_sub(ticks(shown)),
            verdict: verdict.map(|verdict| verdict.label.name()),
            drivers: Vec::new(),
            touch: found.touch.is_some(),
            short: short.to_owned(),
        }
    }

    /// A pose and a speed (m/s) in its units.
    pub fn state(&self, pose: &Pose, speed: f64) -> [i64; 4] {
        state(Point::new(self.origin[0], self.origin[1]), pose, speed)
    }

    /// The last tick.
    pub fn end(&self) -> usize {
        self.ego.len().saturating_sub(1)
    }

    /// The driver's action at a tick.
    pub fn mode(&self, tick: usize) -> &'static str {
        self.modes.iter().rev().find(|(from, _)| *from <= tick).map_or("", |(_, name)| name)
    }
}

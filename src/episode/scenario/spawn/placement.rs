use std::fmt;
use std::sync::Arc;

use rand::RngExt;

use super::constraint::is_on_level;
use super::{Spawn, SpawnRule};
use crate::{Cast, Scenario};
use base::seed::{Seed, Stream};
use base::signature::Distribution;
use road::geometry::{Obstacles, OrientedBox, Point, Pose, Vector, wrap_angle};
use road::{LaneFilter, Town};
use world::sim::{ActorId, ActorStart};

/// Where an actor of a cast is at the start of an episode.
#[derive(Debug, Clone, PartialEq)]
pub enum Placement {
    /// Where the spawn rule of the scenario places it: the ego, and the first pedestrian.
    Spawn,
    /// The same start in every episode.
    Fixed(ActorStart),
    /// A pedestrian in the sector about the ego of a spawn rule of its own.
    Sector(Arc<SpawnRule>),
    /// At a distance (m) from another actor, from body to body, in any direction.
    Beside { anchor: ActorId, distance: Distribution },
    /// At a distance (m) ahead of another actor, from body to body, and to the left of its axis (m). A vehicle is as far to the left of the
    /// middle of the lane there, and along it.
    Ahead { anchor: ActorId, distance: Distribution, aside: Distribution },
    /// Behind the ego on its lane, as fast as it, at a time gap (s). It appears with the pedestrians.
    Behind { gap: Distribution },
}

impl Placement {
    /// The actor relative to which it places; `None` if that is not another one.
    pub fn anchor(&self) -> Option<ActorId> {
        match self {
            Self::Spawn | Self::Fixed(_) => None,
            Self::Sector(_) | Self::Behind { .. } => Some(ActorId::EGO),
            Self::Beside { anchor, .. } | Self::Ahead { anchor, .. } => Some(*anchor),
        }
    }
}

/// Names it as the scenario does.
impl fmt::Display for Placement {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Spawn | Self::Fixed(_) => "spawn",
            Self::Sector(rule) => &rule.name,
            Self::Beside { .. } => "beside",
            Self::Ahead { .. } => "ahead_of",
            Self::Behind { .. } => "behind",
        })
    }
}

/// Attempts to place one actor; then the whole start is drawn again.
const TRIES: u32 = 200;
/// Maximum number of starts that are drawn until all actors have a place.
const STARTS: u64 = 1000;
/// Distance that a drawn pedestrian keeps from obstacles and from other actors, unless its own spawn rule states it (m).
const CLEARANCE: f64 = 0.1;
/// A lane that is turned by more than this from the anchor is another way (rad).
const SAME_WAY: f64 = std::f64::consts::FRAC_PI_4;
/// The minimum distance of a follower from the car ahead of it, from bumper to bumper (m).
const MIN_GAP: f64 = 2.0;

/// Where the actors of an episode are at its start, and what draws the places of those that the spawn rule does not place.
#[derive(Debug, Clone)]
pub(crate) struct Placing {
    /// The actors that are drawn, each after the one relative to which it is placed.
    order: Vec<ActorId>,
    pub vehicles: Vec<ActorStart>,
    pub pedestrians: Vec<ActorStart>,
    /// The town's obstacles and the vehicles that have been parked.
    obstacles: Obstacles,
    parked: Vec<OrientedBox>,
}

/// An actor that could not be placed, and the condition that its last place did not satisfy.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{TRIES} places for `{role}` were drawn, and the last one failed `{condition}`")]
pub struct Unplaced {
    pub role: Arc<str>,
    pub condition: String,
}

/// What a place may fail.
const APART: &str = "no other actor there";
const CLEAR: &str = "no obstacle there";
const ON_LEVEL: &str = "on the level of the car";
const ON_LANE: &str = "a lane in the same direction";

impl Placing {
    pub fn new(scenario: &Scenario) -> Self {
        let cast = &scenario.cast;
        let start =
            |place: &Placement| if let Placement::Fixed(start) = place { *start } else { ActorStart::default() };
        Self {
            order: order(cast).collect(),
            vehicles: cast.vehicles.iter().map(|role| start(&role.place)).collect(),
            pedestrians: cast.pedestrians.iter().map(|role| start(&role.place)).collect(),
            obstacles: Obstacles::clone(&scenario.obstacles),
            parked: Vec::new(),
        }
    }

    /// The starts that were drawn; empty for a car and a pedestrian that the spawn rule places.
    pub fn drawn(&self) -> impl Iterator<Item = &ActorStart> {
        self.order.iter().map(|actor| self.start(*actor))
    }

    fn start(&self, actor: ActorId) -> &ActorStart {
        match actor {
            ActorId::Vehicle(number) => &self.vehicles[usize::from(number)],
            ActorId::Pedestrian(number) => &self.pedestrians[usize::from(number)],
        }
    }

    /// Draws the start of an episode, or takes the one that a test states, and places all others around it. If one of them cannot be placed, another
    /// start is drawn. `None` if that helps nowhere; then the actors that could not be placed say why.
    pub fn sample(
        &mut self,
        scenario: &Scenario,
        stated: Option<Spawn>,
        stream: &mut Stream,
        seed: &Seed,
    ) -> (Option<Spawn>, Vec<Unplaced>) {
        let Scenario { cast, town, obstacles, .. } = scenario;
        let first = cast.pedestrian().first_heading;
        let mut unplaced = Vec::new();
        for attempt in 0..STARTS {
            let spawn = stated.unwrap_or_else(|| scenario.spawn.sample(town, obstacles, first, stream));
            self.vehicles[0] = ActorStart { pose: spawn.ego, speed: spawn.ego_speed };
            self.pedestrians[0] = ActorStart::standing(spawn.pedestrian);
            match self.draw(scenario, &seed.index(attempt)) {
                Ok(()) => return (Some(spawn), unplaced),
                Err(error) => unplaced.push(error),
            }
        }
        (None, unplaced)
    }

    /// Places the actors around the ego and the first pedestrian, which are in place. What an actor draws depends on the seed and on its number.
    ///
    /// # Errors
    /// The actor that could not be placed.
    fn draw(&mut self, scenario: &Scenario, seed: &Seed) -> Result<(), Unplaced> {
        let cast = &scenario.cast;
        self.parked.clear();
        self.obstacles.park(std::iter::empty());
        for (place, actor) in self.order.iter().copied().enumerate() {
            let number = actor.number() as u64;
            let stream = &mut match actor {
                ActorId::Vehicle(_) => seed.child("vehicle").index(number).stream(),
                ActorId::Pedestrian(_) => seed.child("pedestrian").index(number).stream(),
            };
            let mut failed = String::new();
            let found = (0..TRIES).find_map(|_| {
                self.attempt(scenario, actor, place, stream).inspect_err(|condition| failed.clone_from(condition)).ok()
            });
            let Some(start) = found else { return Err(Unplaced { role: cast.name(actor).clone(), condition: failed }) };
            match actor {
                ActorId::Vehicle(number) => {
                    let role = &cast.vehicles[usize::from(number)];
                    self.vehicles[usize::from(number)] = start;
                    if role.is_parked {
                        self.parked.push(outline(cast, actor, &start.pose));
                        self.obstacles.park(self.parked.iter().copied());
                    }
                }
                ActorId::Pedestrian(number) => self.pedestrians[usize::from(number)] = start,
            }
        }
        Ok(())
    }

    /// Draws a place for an actor, before which this number of actors have been placed.
    fn attempt(
        &self,
        scenario: &Scenario,
        actor: ActorId,
        placed: usize,
        stream: &mut Stream,
    ) -> Result<ActorStart, String> {
        let (cast, town) = (&scenario.cast, &*scenario.town);
        let place = cast.place(actor);
        let from = place.anchor().unwrap_or(ActorId::EGO);
        let anchor = self.start(from).pose;
        let (own, other) = (half(cast, actor), half(cast, from));
        let pose = match place {
            Placement::Spawn | Placement::Fixed(_) => return Ok(*self.start(actor)),
            // Its place is fixed when it appears.
            Placement::Behind { gap } => {
                return Ok(ActorStart { pose: anchor, speed: gap.quantile(stream.random()) });
            }
            Placement::Sector(rule) => {
                let first = cast.pedestrians[actor.number()].first_heading;
                let spawn = rule.complete(&anchor, rule.place(&anchor, stream), first, stream);
                let failed = rule.constraints.iter().find(|each| !each.admits(&spawn, town, &self.obstacles));
                failed.map_or(Ok(spawn.pedestrian), |each| Err(each.to_string()))?
            }
            Placement::Beside { distance, .. } => {
                let turn = stream.random_range(-std::f64::consts::PI..std::f64::consts::PI);
                let reach = distance.quantile(stream.random());
                let direction = Vector::new(libm::cos(turn), libm::sin(turn));
                let apart = reach + extent(other, direction) + extent(own, direction);
                facing(anchor.to_world(direction * apart), anchor.yaw)
            }
            Placement::Ahead { distance, aside, .. } => {
                let ahead = distance.quantile(stream.random()) + other.x + own.x;
                let aside = aside.quantile(stream.random());
                match actor {
                    ActorId::Pedestrian(_) => facing(anchor.to_world(Vector::new(ahead, aside)), anchor.yaw),
                    ActorId::Vehicle(_) => {
                        let lane = lane_at(town, &anchor, ahead).ok_or(ON_LANE)?;
                        facing(lane.to_world(Vector::new(0.0, aside)), lane.yaw)
                    }
                }
            }
        };
        self.check(scenario, actor, &pose, placed)?;
        Ok(ActorStart::standing(pose))
    }

    /// Whether an actor has room at a pose.
    fn check(&self, scenario: &Scenario, actor: ActorId, pose: &Pose, placed: usize) -> Result<(), String> {
        let cast = &scenario.cast;
        let start = Spawn { ego: self.vehicles[0].pose, ego_speed: 0.0, pedestrian: *pose };
        if matches!(actor, ActorId::Pedestrian(_)) && !is_on_level(&start, &scenario.town) {
            return Err(ON_LEVEL.into());
        }
        let own = outline(cast, actor, pose);
        let is_placed = |other: &ActorId| {
            let place = self.order.iter().position(|each| each == other);
            *other != actor
                && place.is_none_or(|place| place < placed)
                && !matches!(cast.place(*other), Placement::Behind { .. })
        };
        let touches =
            |other: ActorId| outline(cast, other, &self.start(other).pose).separation(&own).norm() < CLEARANCE;
        if cast.actors().filter(is_placed).any(touches) {
            return Err(APART.into());
        }
        let clearance = match cast.place(actor) {
            Placement::Sector(_) => 0.0,
            _ => own.half.y + if matches!(actor, ActorId::Pedestrian(_)) { CLEARANCE } else { 0.0 },
        };
        // Discs along its axis cover it.
        let ends = (own.half.x - own.half.y).max(0.0);
        let steps = (ends / own.half.y).ceil() as i32;
        let is_free = |step: i32| {
            let along = ends * f64::from(step) / f64::from(steps.max(1));
            self.obstacles.clearance(pose.to_world(Vector::new(along, 0.0)), clearance) >= clearance
        };
        if (-steps..=steps).all(is_free) { Ok(()) } else { Err(CLEAR.into()) }
    }
}

/// How many starts have room for a whole cast.
#[derive(Debug, Clone, PartialEq)]
pub struct CastSurvey {
    /// The number of starts of the ego and the first pedestrian that were drawn.
    pub tried: u32,
    /// Those around which all others had a place.
    pub accepted: u32,
    /// Each actor and condition for which one had none, with the number of starts.
    pub refused: Vec<(Unplaced, u32)>,
}

/// Starts with room that a survey looks for, and the minimum share of them.
const ENOUGH: u32 = 20;
const MIN_SHARE: u32 = 50;

impl CastSurvey {
    /// Draws starts until 20 have room, and each case of a test has, or 1,000.
    pub fn new(scenario: &Scenario, seed: &Seed) -> Self {
        let (mut placing, mut stream) = (Placing::new(scenario), seed.stream());
        let mut survey = Self { tried: 0, accepted: 0, refused: Vec::new() };
        let cases = scenario.spawn.target_walk.as_ref().map_or(0, |walk| walk.cases.len() as u32);
        while survey.accepted < ENOUGH.max(cases) && survey.tried < ENOUGH.max(cases) * MIN_SHARE {
            let number = u64::from(survey.tried);
            let test =
                scenario.spawn.target_walk.as_ref().map(|walk| walk.spawn(number, 1.0, &scenario.cast.ego().blueprint));
            let (spawn, unplaced) = placing.sample(scenario, test, &mut stream, &seed.index(number));
            survey.tried += unplaced.len() as u32 + u32::from(spawn.is_some());
            survey.accepted += u32::from(spawn.is_some());
            for each in unplaced {
                match survey.refused.iter_mut().find(|(known, _)| *known == each) {
                    Some((_, count)) => *count += 1,
                    None => survey.refused.push((each, 1)),
                }
            }
        }
        survey
    }

    /// Whether drawing a start is quick.
    ///
    /// # Errors
    /// Fewer than one in fifty starts have room: the survey.
    pub fn check(self) -> Result<(), Self> {
        if self.accepted * MIN_SHARE >= self.tried { Ok(()) } else { Err(self) }
    }
}

impl fmt::Display for CastSurvey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} of {} starts have room for the whole cast", self.accepted, self.tried)?;
        let worst = self.refused.iter().max_by_key(|(_, count)| *count);
        worst.map_or(Ok(()), |(each, count)| {
            write!(f, "; in {count} of the others `{}` had none (`{}`)", each.role, each.condition)
        })
    }
}

/// The actors whose places are drawn, each after its anchor. The compiler has refused circles.
fn order(cast: &Cast) -> impl Iterator<Item = ActorId> + use<> {
    let is_drawn = |actor: &ActorId| !matches!(cast.place(*actor), Placement::Spawn | Placement::Fixed(_));
    let (mut waiting, mut ordered): (Vec<ActorId>, Vec<ActorId>) =
        (cast.actors().filter(is_drawn).collect(), Vec::new());
    while !waiting.is_empty() {
        let is_ready = |actor: &ActorId| cast.place(*actor).anchor().is_none_or(|anchor| !waiting.contains(&anchor));
        let ready: Vec<ActorId> = waiting.iter().copied().filter(is_ready).collect();
        assert!(!ready.is_empty(), "checked: no circle of placements");
        waiting.retain(|actor| !ready.contains(actor));
        ordered.extend(ready);
    }
    ordered.into_iter()
}

/// Half extents of an actor (m).
fn half(cast: &Cast, actor: ActorId) -> Vector {
    match actor {
        ActorId::Vehicle(number) => {
            let car = &cast.vehicles[usize::from(number)].blueprint;
            Vector::new(car.half_length, car.half_width)
        }
        ActorId::Pedestrian(number) => cast.pedestrians[usize::from(number)].body.half(),
    }
}

fn outline(cast: &Cast, actor: ActorId, pose: &Pose) -> OrientedBox {
    OrientedBox { pose: *pose, half: half(cast, actor) }
}

/// How far a box reaches in a direction (m).
fn extent(half: Vector, direction: Vector) -> f64 {
    half.x * direction.x.abs() + half.y * direction.y.abs()
}

fn facing(place: Point, yaw: f64) -> Pose {
    Pose::new(place.x, place.y, yaw)
}

/// The middle of the lane at this distance (m) ahead of a pose; `None` if no lane in the same direction is there.
fn lane_at(town: &Town, from: &Pose, ahead: f64) -> Option<Pose> {
    let place = from.to_world(Vector::new(ahead, 0.0));
    let lane = town.pose(town.nearest_lane(town.place_from(town.place_of_car(from), place), LaneFilter::Driving)?);
    (wrap_angle(lane.yaw - from.yaw).abs() < SAME_WAY).then_some(lane)
}

/// The start of a vehicle behind another one of this state at a time gap (s): as fast, on its lane if there is one.
pub(crate) fn behind(town: &Town, leader: &ActorStart, lengths: f64, gap: f64) -> ActorStart {
    let back = lengths + (gap * leader.speed).max(MIN_GAP);
    let straight = leader.pose.to_world(Vector::new(-back, 0.0));
    let pose = lane_at(town, &leader.pose, -back).unwrap_or(facing(straight, leader.pose.yaw));
    ActorStart { pose, speed: leader.speed }
}

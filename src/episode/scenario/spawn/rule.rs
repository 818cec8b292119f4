use rand::RngExt;

use super::constraint::is_on_level;
use super::constraint::placed;
use super::{Constraint, EgoSpeed, EgoStart, GivenPath, Rarity, RoadShape, Spawn, SpawnError, Survey, TargetWalk};
use crate::FirstHeading;
use base::choice;
use base::seed::Stream;
use base::signature::Distribution;
use road::geometry::{Obstacles, Point, Pose, Vector, wrap_angle};
use road::{RoadOption, Town, lane_route};
use world::sim::WalkCommand;

choice! {
    /// The measure that is uniform when a place in the sector is drawn.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum Measure {
        /// The distance has its distribution. If that is uniform, places near the ego are denser.
        Range = "range",
        /// The area: the same number of places per square metre everywhere in the sector. The distance must be a range.
        Area = "area",
    }
}

/// The rule that draws the start of an episode.
#[derive(Debug, Clone, PartialEq)]
pub struct SpawnRule {
    /// Its name in the scenario.
    pub name: String,
    /// Bearing of the pedestrian from the ego's heading, positive to the left (rad).
    pub bearing: Distribution,
    /// Distance between the centres (m).
    pub distance: Distribution,
    /// The measure that is uniform.
    pub measure: Measure,
    /// The rule for the ego's start.
    pub ego_start: EgoStart,
    /// The stretches of road on which the ego may start.
    pub road_shape: RoadShape,
    /// The width of the ego's lane at the start (m) at least, unless the pose is given: that of the car.
    pub lane_width: f64,
    /// Speed of the ego at the start.
    pub ego_speed: EgoSpeed,
    /// The speed that the driver is to hold before the start (m/s); `None` if it comes at its own speed.
    pub test_speed: Option<f64>,
    /// The turns that the driver takes at the next forks, in order; afterwards, and without any, it finds its own way.
    pub ego_route: Vec<RoadOption>,
    /// Heading of the pedestrian from the ego's heading, positive to the left (rad); without it the cast decides.
    pub heading: Option<Distribution>,
    /// Further conditions.
    pub constraints: Vec<Constraint>,
    /// The test that places the ego and the pedestrian, instead of the sector.
    pub target_walk: Option<TargetWalk>,
    /// The path of the pedestrian, which starts at its first point instead of in the sector.
    pub given_path: Option<GivenPath>,
}

/// Starts that must be accepted for [`SpawnRule::probe`] to pass.
const ENOUGH: u32 = 4;
/// Number of tries in which they are found, unless they are rare.
const FEW_PROBES: u32 = 400;
/// Number of starts that measure their rate, if they are rare.
const RARE: u32 = 40;
/// Most tries for each listed pose of the ego, and most tries in total for many poses.
const MAX_PROBES: u32 = 40_000;
const ALL_PROBES: u32 = 400_000;
/// A probe that finds enough within this number of tries does not check the poses of the ego.
const QUICK_PROBES: u32 = 10 * ENOUGH;
/// Number of starts that a probe draws if that may take long, and the number of tries for each below which there is no report.
const DRAWN: u32 = 8;
const FEW_TRIES: u32 = 2000;
/// Number of places that one [`SpawnRule::sample`] tries around one pose of the ego; then it draws another pose.
const TRIES: u32 = 1000;
/// Poses of the ego around which one [`SpawnRule::sample`] tries this often; then it draws a new pose with every try.
const EGOS: u32 = 20;
/// Most tries of the latter kind: with one in ten thousand accepted, all of them fail once in 10⁴³⁴ starts.
const LAST_TRIES: u32 = 10_000_000;
/// Most poses that are drawn to find one on a stretch of road that the rule admits.
const MAX_POSES: u32 = 1_000_000;

impl SpawnRule {
    /// Checks that the rule can place a pedestrian with this first heading. About one start in ten thousand must satisfy all constraints,
    /// around every listed pose. Returns a report if it is less than about one in a hundred.
    ///
    /// # Errors
    /// The reason why none can be placed.
    pub fn probe(
        &self,
        town: &Town,
        obstacles: &Obstacles,
        first: FirstHeading,
        stream: &mut Stream,
    ) -> Result<Option<Rarity>, SpawnError> {
        self.ego_start.check(town)?;
        self.check_route(town)?;
        let poses = if let EgoStart::Poses(poses) = &self.ego_start { poses.len() as u32 } else { 1 };
        let most = (ALL_PROBES / poses).clamp(FEW_PROBES, MAX_PROBES);
        let mut around = |ego: &mut dyn FnMut(&mut Stream) -> Pose| {
            let mut survey = |most: u32, enough| self.survey_from(ego, town, obstacles, first, (most, enough), stream);
            let few = survey(FEW_PROBES, ENOUGH);
            if few.accepted >= ENOUGH {
                return Ok((few, None));
            }
            let survey = survey(most, RARE);
            if survey.accepted * FEW_PROBES >= survey.tried * ENOUGH {
                return Ok((survey, None));
            }
            let rarity = survey.rarity();
            if survey.accepted >= ENOUGH { Ok((survey, Some(rarity))) } else { Err(SpawnError::Crowded(rarity)) }
        };
        match &self.ego_start {
            EgoStart::Poses(poses) => {
                let found = poses.iter().map(|pose| around(&mut |_| *pose)).collect::<Result<Vec<_>, _>>()?;
                Ok(found.into_iter().filter_map(|(_, rarity)| rarity).max_by_key(|rarity| rarity.tried))
            }
            start => {
                let (survey, rarity) = around(&mut |stream| start.sample(town, stream))?;
                Ok(rarity.or_else(|| self.toil(&survey, town, obstacles, first, stream)))
            }
        }
    }

    /// Checks that the turns of the ego can be taken from each of its listed poses.
    fn check_route(&self, town: &Town) -> Result<(), SpawnError> {
        let EgoStart::Poses(poses) = &self.ego_start else { return Ok(()) };
        for pose in poses.iter().filter(|_| !self.ego_route.is_empty()) {
            let lane = town.lane_under(pose).ok_or(SpawnError::NoLane)?;
            lane_route(town, lane, &self.ego_route).map_err(|missing| SpawnError::NoTurn {
                number: missing.index + 1,
                x: pose.x,
                y: pose.y,
                why: if missing.road_ends { "the road ends before it" } else { "no branch of the fork leads there" },
            })?;
        }
        Ok(())
    }

    /// A report on a rule that accepts enough starts when pose and place are drawn together, but none around most poses of the ego. Each
    /// such pose costs a thousand tries.
    fn toil(
        &self,
        survey: &Survey,
        town: &Town,
        obstacles: &Obstacles,
        first: FirstHeading,
        stream: &mut Stream,
    ) -> Option<Rarity> {
        if survey.tried <= QUICK_PROBES {
            return None;
        }
        let (mut accepted, mut tried) = (0, 0);
        while accepted < DRAWN && tried <= DRAWN * FEW_TRIES {
            tried += self.sample_counting(town, obstacles, first, stream).1;
            accepted += 1;
        }
        (tried > DRAWN * FEW_TRIES).then(|| Rarity { accepted, tried, barren: true, ..survey.rarity() })
    }

    /// The first command that leads the pedestrian as the rule's test or path states; `None` if the rule has neither.
    pub fn scripted(&self) -> Option<WalkCommand> {
        let target = self.target_walk.as_ref().map(TargetWalk::command);
        target.or_else(|| self.given_path.as_ref().map(GivenPath::command))
    }

    /// The speed that the driver is to hold before an episode (m/s); `None` if it comes at its own speed.
    pub fn test_speed(&self, episode: u64) -> Option<f64> {
        let case = self.target_walk.as_ref().map(|walk| walk.case(episode).test_speed);
        case.or(self.test_speed)
    }

    /// Whether the ego can start in a town; otherwise nothing can be drawn there.
    pub fn begins_in(&self, town: &Town) -> bool {
        self.ego_start.check(town).is_ok()
    }

    /// Draws a start; the rule must have passed [`SpawnRule::probe`].
    ///
    /// The ego's pose is drawn once, so crowded places are as likely as open ones. It is drawn again only when none of a thousand starts
    /// is accepted. After twenty such poses it is drawn anew for every try.
    pub fn sample(&self, town: &Town, obstacles: &Obstacles, first: FirstHeading, stream: &mut Stream) -> Spawn {
        self.sample_counting(town, obstacles, first, stream).0
    }

    /// Draws a start as [`SpawnRule::sample`], and counts the tries.
    fn sample_counting(
        &self,
        town: &Town,
        obstacles: &Obstacles,
        first: FirstHeading,
        stream: &mut Stream,
    ) -> (Spawn, u32) {
        let mut tried = 0;
        let mut search = |egos, tries| self.search((egos, tries), town, obstacles, first, stream, &mut tried);
        let start = search(EGOS, TRIES).or_else(|| search(LAST_TRIES, 1));
        (start.expect("checked: of ten thousand starts one is accepted"), tried)
    }

    /// Tries places around poses of the ego.
    pub(super) fn search(
        &self,
        (egos, tries): (u32, u32),
        town: &Town,
        obstacles: &Obstacles,
        first: FirstHeading,
        stream: &mut Stream,
        tried: &mut u32,
    ) -> Option<Spawn> {
        (0..egos).find_map(|_| {
            let mut poses = (0..MAX_POSES).map(|_| self.ego_start.sample(town, stream));
            let ego = poses.find(|ego| self.has_room(town, ego) && self.road_shape.admits(town, ego))?;
            (0..tries).find_map(|_| {
                *tried += 1;
                let place = self.place(&ego, stream);
                let stands = Spawn { ego, ..placed(place) };
                let (places, rest) = (|c: &&Constraint| c.is_about_places(), |c: &&Constraint| !c.is_about_places());
                let admitted = self.constraints.iter().filter(places).all(|each| each.admits(&stands, town, obstacles));
                if !admitted || !is_on_level(&stands, town) {
                    return None;
                }
                let spawn = self.complete(&ego, place, first, stream);
                let all = self.constraints.iter().filter(rest).all(|each| each.admits(&spawn, town, obstacles));
                all.then_some(spawn)
            })
        })
    }

    /// Whether the lane at a pose of the ego has room for the car.
    pub(super) fn has_room(&self, town: &Town, ego: &Pose) -> bool {
        let lane = || town.lane_under(ego);
        self.lane_width <= 0.0
            || matches!(self.ego_start, EgoStart::Poses(_))
            || lane().is_some_and(|lane| town.lane_width(lane) >= self.lane_width)
    }

    /// Draws a place in the sector about the ego.
    pub(super) fn place(&self, ego: &Pose, stream: &mut Stream) -> Point {
        if let Some(path) = &self.given_path {
            return path.start().position();
        }
        let bearing = self.bearing.quantile(stream.random());
        let distance = by_area(self.measure, &self.distance, stream.random());
        ego.to_world(Vector::new(distance * libm::cos(bearing), distance * libm::sin(bearing)))
    }

    /// Draws the values that do not depend on the town.
    pub(super) fn complete(&self, ego: &Pose, place: Point, first: FirstHeading, stream: &mut Stream) -> Spawn {
        let turn = stream.random_range(-std::f64::consts::PI..std::f64::consts::PI);
        let towards = libm::atan2(ego.y - place.y, ego.x - place.x);
        let yaw = match (&self.heading, first) {
            _ if self.given_path.is_some() => self.given_path.as_ref().map_or(0.0, |path| path.start().yaw),
            (Some(heading), _) => {
                let share = (turn / std::f64::consts::PI + 1.0) / 2.0;
                wrap_angle(ego.yaw + heading.quantile(share))
            }
            (None, FirstHeading::Random) => wrap_angle(turn),
            (None, FirstHeading::TowardsEgo) => towards,
        };
        let share = stream.random();
        let ego_speed = match &self.ego_speed {
            EgoSpeed::Drawn(speed) => speed.quantile(share),
            EgoSpeed::Steady => 0.0,
        };
        Spawn { ego: *ego, ego_speed, pedestrian: Pose::new(place.x, place.y, yaw) }
    }
}

/// The value of a distance below which a share of all draws lies.
pub(super) fn by_area(measure: Measure, distance: &Distribution, share: f64) -> f64 {
    match (measure, distance) {
        (Measure::Area, Distribution::Uniform(near, far)) => {
            let (near, far) = (near * near, far * far);
            (near + (far - near) * share).sqrt()
        }
        (_, distance) => distance.quantile(share),
    }
}

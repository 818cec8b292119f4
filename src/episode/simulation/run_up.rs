use crate::{EgoSpeed, Scenario};
use base::seed::Stream;
use rand::RngExt;
use road::geometry::{OrientedBox, Pose, wrap_angle};
use road::{RoadOption, Town, Waypoint, lane_route};
use world::av::Fault;
use world::sim::{LightCycle, VehicleBlueprint, VehicleState};

/// The way on which the driver reaches its steady state before an episode starts: a stretch of road that ends at the pose of the ego's
/// start, the *goal*.
///
/// The way goes back along the lanes from the goal. Where lanes merge, one of them is drawn. It depends on the stream and not on the
/// driver, so all drivers come the same way. It is shorter where the road begins nearer to the goal.
#[derive(Debug, Clone)]
pub(super) struct RunUp {
    /// The length of the way (m).
    length: f64,
    pub goal: Pose,
    /// The lanes from the start of the way to the goal and, with turns, those of the route after it; each as a place on it.
    lanes: Vec<Waypoint>,
    /// The index of the goal's place among them.
    at_goal: usize,
    /// The limit of the last speed sign before the start of the way (m/s); `None` if the last 500 m of road have no sign.
    pub limit: Option<f64>,
    /// The greatest speed that an average driver has at the start of the way after the bends before it (m/s).
    pub speed: f64,
    branches: Vec<Waypoint>,
    pub(super) stage: Stage,
    /// The ticks of it up to now.
    pub(super) ticks: u32,
}

/// The stage of an episode.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Stage {
    /// The driver drives alone.
    RunUp,
    /// A driver failed in the run-up.
    Failed(Fault),
    /// The pedestrians are there.
    Encounter,
}

/// The length of the way (m).
///
/// # Source
/// Measured in 7,800 starts: 13 drivers (all of `scenarios/lib/drivers.scn` but six variants, and CARLA's with destinations), 150 starts each
/// in `harbour`, `village` and both outlines of CARLA's towns, lights off. The speed at the goal was within 0.1 m/s of that after twice the
/// way in 81 % of starts for 20 m, 92 % for 40 m, 95 % for 60 m, 96 % for 80 m and 97 % for 120 m. The rest is mostly `lav` (87 % at
/// 80 m), whose speed follows its last bend for long. The run-up took 219 ticks of 0.05 s on average.
pub(super) const LENGTH: f64 = 80.0;
/// The ego reaches the goal when it passes it at most this far aside (m).
const ASIDE: f64 = 5.0;
/// Time for the run-up (s), and the number of turns of traffic lights that are added where they work: a whole cycle of a crossing.
const TIME_LIMIT: f64 = 60.0;
const TURNS: f64 = 4.0;
/// Maximum number of ticks of a run-up.
const MAX_TICKS: f64 = 20_000.0;
/// Maximum number of lanes of the way, a guard against lanes without length.
const MAX_LANES: usize = 512;
/// The step back along the lanes (m).
const STEP: f64 = 2.0;
/// How far before the way the last speed sign and bends are looked for (m).
const SIGNS: f64 = 500.0;
const BENDS: f64 = 100.0;
/// Acceleration in bends and out of them (m/s²).
const LATERAL: f64 = 2.0;
const PULL: f64 = 1.5;

impl RunUp {
    /// Makes one with a length (m).
    pub fn new(length: f64) -> Self {
        let room = || Vec::with_capacity(16);
        Self {
            length,
            goal: Pose::default(),
            lanes: room(),
            at_goal: 0,
            limit: None,
            speed: f64::INFINITY,
            branches: room(),
            stage: Stage::Encounter,
            ticks: 0,
        }
    }

    /// Finds the way to a goal on a driving lane.
    pub fn plan(&mut self, town: &Town, goal: Pose, blueprint: &VehicleBlueprint, stream: &mut Stream) {
        (self.goal, self.stage) = (goal, Stage::RunUp);
        (self.limit, self.speed) = (None, f64::INFINITY);
        self.lanes.clear();
        let Some(mut here) = town.lane_under(&goal) else { return };
        self.lanes.push(here);
        let mut walked = 0.0;
        while walked < self.length && self.lanes.len() < MAX_LANES {
            let known = self.lanes.len();
            let Some(before) = self.step_back(town, here, stream, true) else { break };
            // A lane that begins narrower than the car begins where the car has room.
            if town.lane_width(before) < 2.0 * blueprint.half_width {
                self.lanes.truncate(known);
                break;
            }
            (here, walked) = (before, walked + STEP);
        }
        self.lanes.push(here);
        self.lanes.reverse();
        self.at_goal = self.lanes.len() - 1;
        self.look_back(town, here, blueprint, stream);
    }

    /// Adds the turns that the ego takes at the forks after the goal. Turns that a fork does not have end the route.
    pub fn lead_on(&mut self, town: &Town, goal: &Pose, turns: &[RoadOption]) {
        if turns.is_empty() {
            return;
        }
        if self.lanes.is_empty() {
            self.lanes.extend(town.lane_under(goal));
            self.at_goal = 0;
        }
        let Some(here) = self.lanes.last().copied() else { return };
        if let Ok(route) = lane_route(town, here, turns) {
            self.lanes.extend(route.into_iter().skip(1));
        }
    }

    /// Forgets the way: a start without a run-up.
    pub fn clear(&mut self) {
        self.lanes.clear();
        self.at_goal = 0;
        (self.stage, self.ticks) = (Stage::Encounter, 0);
    }

    /// Whether the driver drives alone.
    #[inline]
    pub fn is_running(&self) -> bool {
        self.stage == Stage::RunUp
    }

    /// The lanes that the ego is to take; from the goal on none, if the driver finds its own way from there.
    #[inline]
    pub fn route(&self) -> &[Waypoint] {
        if self.is_running() {
            return &self.lanes;
        }
        let after = self.lanes.get(self.at_goal..).unwrap_or_default();
        if after.len() > 1 { after } else { &[] }
    }

    /// Finds the limit and the bends on the road that leads to the start of the way.
    fn look_back(&mut self, town: &Town, start: Waypoint, blueprint: &VehicleBlueprint, stream: &mut Stream) {
        let (mut here, mut after, mut walked) = (start, town.pose(start), 0.0);
        let mut allowed = f64::INFINITY;
        let unknown = |limit: Option<f64>| limit.is_none() && !town.speed_signs.is_empty();
        while walked < BENDS || walked < SIGNS && unknown(self.limit) {
            let Some(before) = self.step_back(town, here, stream, false) else { break };
            (here, walked) = (before, walked + STEP);
            let pose = town.pose(here);
            let curvature = wrap_angle(after.yaw - pose.yaw).abs() / STEP;
            if curvature > 1e-4 {
                allowed = allowed.min(LATERAL / curvature + 2.0 * PULL * walked);
            }
            if unknown(self.limit) {
                self.limit = sign_at(town, pose, blueprint);
            }
            after = pose;
        }
        self.speed = allowed.sqrt();
    }

    /// The place one step back along the lanes; `None` if the road begins. A branch is drawn where lanes merge.
    fn step_back(&mut self, town: &Town, from: Waypoint, stream: &mut Stream, record: bool) -> Option<Waypoint> {
        let (mut here, mut left) = (from, STEP);
        for _ in 0..MAX_LANES {
            let start = town.lane_start(here)?;
            let room = (here.s - start.s).abs();
            if room >= left {
                return Some(town.moved(here, -left));
            }
            left -= room;
            self.branches.clear();
            self.branches.extend(town.predecessors(here));
            here = match *self.branches.as_slice() {
                [] => return None,
                [only] => only,
                ref several => several[stream.random_range(0..several.len())],
            };
            if record {
                self.lanes.push(here);
            }
        }
        None
    }

    /// The pose at the start of the way.
    pub fn start(&self, town: &Town) -> Pose {
        self.lanes.first().map_or(self.goal, |start| town.pose(*start))
    }

    /// Whether a vehicle is as near to the goal as it gets with ticks of this length (s): at most half a tick's way before or after it.
    pub fn is_reached(&self, state: &VehicleState, dt: f64) -> bool {
        let (place, step) = (self.goal.to_local(state.pose.position()), state.speed * dt);
        let turned = wrap_angle(state.pose.yaw - self.goal.yaw).abs();
        (-0.5 * step..ASIDE + step).contains(&place.x) && place.y.abs() < ASIDE && turned < std::f64::consts::FRAC_PI_2
    }
}

impl Scenario {
    /// Maximum number of ticks of an episode's run-up; 0 where episodes have none.
    pub fn most_run_up(&self) -> u32 {
        match self.spawn.ego_speed {
            EgoSpeed::Steady => {
                let rule = &self.episode;
                most_ticks(rule.tick, rule.traffic_lights.then_some(rule.light_cycle()))
            }
            EgoSpeed::Drawn(_) => 0,
        }
    }
}

/// Maximum number of ticks of this length (s) that a run-up takes, with or without traffic lights.
fn most_ticks(dt: f64, lights: Option<LightCycle>) -> u32 {
    ((TIME_LIMIT + lights.map_or(0.0, |cycle| TURNS * cycle.turn())) / dt).ceil().min(MAX_TICKS) as u32
}

/// The limit of the speed sign that a vehicle obeys at a pose.
fn sign_at(town: &Town, pose: Pose, blueprint: &VehicleBlueprint) -> Option<f64> {
    let reach = blueprint.half_length + 4.0;
    let outline = OrientedBox::new(pose, blueprint.half_length, blueprint.half_width);
    let found = town.speed_signs.iter().rev().find(|sign| {
        let offset = sign.trigger.pose.position() - pose.position();
        offset.norm_squared() < reach * reach && sign.trigger.overlaps(&outline)
    });
    found.map(|sign| sign.limit)
}

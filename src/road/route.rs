use rand::RngExt;

use super::{Town, Waypoint};
use crate::geometry::{Pose, wrap_angle};
use base::choice;
use base::seed::Stream;

choice! {
    /// The turn that a point of a route belongs to, with the names of CARLA's planners.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum RoadOption {
        /// Along the lane.
        LaneFollow = "lane_follow",
        /// To the left at a junction.
        Left = "left",
        /// To the right at a junction.
        Right = "right",
        /// Straight on at a junction.
        Straight = "straight",
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RoutePoint {
    /// The place on the lane.
    pub waypoint: Waypoint,
    /// Centre of the lane, heading along its driving direction.
    pub pose: Pose,
    /// Width of the lane (m).
    pub lane_width: f64,
    /// Whether it lies inside a junction.
    pub is_junction: bool,
    /// The turn it belongs to.
    pub option: RoadOption,
}

impl RoutePoint {
    /// Looks a waypoint up in its town.
    pub fn new(town: &Town, waypoint: Waypoint, option: RoadOption) -> Self {
        Self {
            waypoint,
            pose: town.pose(waypoint),
            lane_width: town.lane_width(waypoint),
            is_junction: town.is_junction(waypoint),
            option,
        }
    }
}

/// Turns below this angle are straight on (rad).
const STRAIGHT: f64 = 35.0 * std::f64::consts::PI / 180.0;
/// How far past a fork CARLA's planner looks ahead to name the turn (m).
const LOOK_PAST: f64 = 3.0;
/// Step of the search for the end of a junction (m), and the number of steps.
const LOOK_THROUGH: (f64, u32) = (3.0, 30);

/// How a random walk chooses at a fork.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ForkRule {
    /// Every branch is equally likely, and the turn is named by where the branch leaves the junction. Driving to far
    /// destinations amounts to the same.
    #[default]
    AnyBranch,
    /// CARLA's rule without a destination: turns are named by the first metres of a branch, each name is equally likely, and
    /// the first of the branches with that name is taken. In CARLA's Town01 and Town02 every branch starts straight, so
    /// the car always takes the first one.
    NamedTurn,
}

/// A walk through a town without a destination. Where lanes are given it takes these first; then it draws a branch at every fork.
///
/// # Source
/// CARLA 0.9.15 `agents/navigation/local_planner.py`, for [`ForkRule::NamedTurn`].
#[derive(Debug, Clone, Default)]
pub struct RandomWalk {
    rule: ForkRule,
    /// The lanes that it must take, in order, each as a place on it.
    lanes: Vec<Waypoint>,
    /// The index of the present lane among them.
    reached: usize,
    branches: Vec<Waypoint>,
    past: Vec<Waypoint>,
    options: Vec<RoadOption>,
}

impl RandomWalk {
    /// Makes a walk that chooses by a rule.
    pub fn new(rule: ForkRule) -> Self {
        // Room for any junction, so that the walk allocates nothing.
        let room = 16;
        Self {
            rule,
            lanes: Vec::with_capacity(room),
            reached: 0,
            branches: Vec::with_capacity(room),
            past: Vec::with_capacity(room),
            options: Vec::with_capacity(room),
        }
    }

    /// Sets the lanes that it must take from its next start on: in order, each as a place on it, the first one that of the start. After the
    /// last of them, or when they do not follow each other, it draws as it does without.
    pub fn take(&mut self, lanes: &[Waypoint]) {
        self.lanes.clear();
        self.lanes.extend_from_slice(lanes);
        self.reached = 0;
    }

    /// The index of the branch on the lanes that it must take; `None` if it may draw.
    fn given_branch(&mut self) -> Option<usize> {
        let ahead = self.lanes.get(self.reached..)?;
        let on_lane = |branch: &Waypoint| ahead.iter().position(|lane| lane.is_on_lane_of(branch));
        let found = self.branches.iter().enumerate().filter_map(|(index, branch)| Some((on_lane(branch)?, index)));
        let Some((steps, branch)) = found.min() else {
            self.lanes.clear();
            return None;
        };
        self.reached += steps;
        Some(branch)
    }

    /// The point `step` (m) further along the reference line; `None` at the end of the road.
    pub fn next(&mut self, town: &Town, from: &RoutePoint, step: f64, stream: &mut Stream) -> Option<RoutePoint> {
        self.branches.clear();
        town.next(from.waypoint, step, &mut self.branches);
        let given = self.given_branch();
        if self.branches.len() < 2 {
            let mut next = RoutePoint::new(town, *self.branches.first()?, RoadOption::LaneFollow);
            if self.rule == ForkRule::AnyBranch && from.is_junction && next.is_junction {
                next.option = from.option;
            }
            return Some(next);
        }
        match self.rule {
            ForkRule::AnyBranch => {
                let chosen = given.unwrap_or_else(|| stream.random_range(0..self.branches.len()));
                let branch = self.branches[chosen];
                let turned = wrap_angle(self.way_out(town, branch).yaw - from.pose.yaw);
                let option = match turned {
                    turned if turned > STRAIGHT => RoadOption::Left,
                    turned if turned < -STRAIGHT => RoadOption::Right,
                    _ => RoadOption::Straight,
                };
                Some(RoutePoint::new(town, branch, option))
            }
            ForkRule::NamedTurn => {
                self.options.clear();
                for branch in &self.branches {
                    self.past.clear();
                    town.next(*branch, LOOK_PAST, &mut self.past);
                    let beyond = self.past.first().unwrap_or(branch);
                    self.options.push(turn(&from.pose, &town.pose(*beyond)));
                }
                let chosen = match given {
                    Some(given) => given,
                    None => {
                        let option = self.options[stream.random_range(0..self.options.len())];
                        self.options.iter().position(|each| *each == option)?
                    }
                };
                Some(RoutePoint::new(town, self.branches[chosen], self.options[chosen]))
            }
        }
    }

    /// The pose at which a branch leaves its junction.
    fn way_out(&mut self, town: &Town, branch: Waypoint) -> Pose {
        let mut here = branch;
        for _ in 0..LOOK_THROUGH.1 {
            if !town.is_junction(here) {
                break;
            }
            self.past.clear();
            town.next(here, LOOK_THROUGH.0, &mut self.past);
            let Some(beyond) = self.past.first() else { break };
            here = *beyond;
        }
        town.pose(here)
    }
}

/// Names the turn from one pose to another.
///
/// As in CARLA, the difference is taken modulo 180°: a turn of more than 90° counts as a turn to the other side.
pub fn turn(before: &Pose, after: &Pose) -> RoadOption {
    let clockwise = (before.yaw - after.yaw).rem_euclid(std::f64::consts::PI);
    if !(STRAIGHT..=std::f64::consts::PI - STRAIGHT).contains(&clockwise) {
        RoadOption::Straight
    } else if clockwise > std::f64::consts::FRAC_PI_2 {
        RoadOption::Left
    } else {
        RoadOption::Right
    }
}

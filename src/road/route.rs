use rand::RngExt;

use super::{Town, Waypoint};
use crate::geometry::Pose;
use crate::seed::Stream;

/// The turn that a point of a route belongs to, as CARLA's planners name them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RoadOption {
    /// Along the lane.
    LaneFollow,
    /// To the left at a junction.
    Left,
    /// To the right at a junction.
    Right,
    /// Straight on at a junction.
    Straight,
}

/// A point of a route.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RoutePoint {
    /// The place on the lane.
    pub waypoint: Waypoint,
    /// Centre of the lane, heading along its driving direction.
    pub pose: Pose,
    /// Width of the lane [m].
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

/// Turns below this angle are straight on [rad].
const STRAIGHT: f64 = 35.0 * std::f64::consts::PI / 180.0;
/// How far past a fork one looks to name the turn [m].
const LOOK_PAST: f64 = 3.0;

/// A walk through a town that takes any turn at a fork, each named turn as likely.
///
/// # Source
/// CARLA 0.9.15 `agents/navigation/local_planner.py`, the planner's way without a destination.
#[derive(Debug, Clone, Default)]
pub struct RandomWalk {
    branches: Vec<Waypoint>,
    past: Vec<Waypoint>,
    options: Vec<RoadOption>,
}

impl RandomWalk {
    /// The point `step` [m] further along the reference line; none at the end of the road.
    pub fn next(&mut self, town: &Town, from: &RoutePoint, step: f64, stream: &mut Stream) -> Option<RoutePoint> {
        self.branches.clear();
        town.next(from.waypoint, step, &mut self.branches);
        if self.branches.len() < 2 {
            return self.branches.first().map(|only| RoutePoint::new(town, *only, RoadOption::LaneFollow));
        }
        self.options.clear();
        for branch in &self.branches {
            self.past.clear();
            town.next(*branch, LOOK_PAST, &mut self.past);
            let beyond = self.past.first().unwrap_or(branch);
            self.options.push(turn(&from.pose, &town.pose(*beyond)));
        }
        let option = self.options[stream.random_range(0..self.options.len())];
        let chosen = self.options.iter().position(|each| *each == option)?;
        Some(RoutePoint::new(town, self.branches[chosen], option))
    }
}

/// Names the turn from one pose to another.
///
/// As in CARLA, the difference is taken modulo 180°: a turn of more than 90° counts as one to the other side.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turns_are_named_by_their_side() {
        let heading = |degrees: f64| Pose::new(0.0, 0.0, degrees.to_radians());
        assert_eq!(turn(&heading(0.0), &heading(30.0)), RoadOption::Straight);
        assert_eq!(turn(&heading(170.0), &heading(-130.0)), RoadOption::Left);
        assert_eq!(turn(&heading(10.0), &heading(-60.0)), RoadOption::Right);
    }
}

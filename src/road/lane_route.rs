use super::{RoadOption, Town, Waypoint};
use crate::geometry::wrap_angle;

/// Turns below this angle are straight on (rad), as for drivers without a route.
const STRAIGHT: f64 = 35.0 * std::f64::consts::PI / 180.0;
/// Maximum number of lanes of a route, a guard against lanes without length.
const MAX_LANES: usize = 4096;

/// A turn that no branch takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MissingTurn {
    /// Its index among the turns.
    pub index: usize,
    /// Whether the road ends before the fork.
    pub road_ends: bool,
}

/// The lanes from a place on, with one turn at each fork, up to the end of the last junction: each as a place on it, the first one the place
/// itself. A turn is named by the angle between the branch's start and the place where it leaves its junction.
///
/// # Errors
/// The first turn that cannot be taken.
pub fn lane_route(town: &Town, from: Waypoint, turns: &[RoadOption]) -> Result<Vec<Waypoint>, MissingTurn> {
    let mut lanes = vec![from];
    let mut here = from;
    let mut open = turns.iter().enumerate().peekable();
    while lanes.len() < MAX_LANES {
        if open.peek().is_none() && !town.is_junction(here) {
            return Ok(lanes);
        }
        let branches: Vec<Waypoint> = town.successors(here).collect();
        here = match (branches.as_slice(), open.peek()) {
            ([], None) => return Ok(lanes),
            ([], Some((index, _))) => return Err(MissingTurn { index: *index, road_ends: true }),
            ([only], _) => *only,
            ([first, ..], None) => *first,
            (several, Some((index, turn))) => {
                let found = several.iter().copied().find(|branch| option(town, *branch) == **turn);
                let branch = found.ok_or(MissingTurn { index: *index, road_ends: false })?;
                open.next();
                branch
            }
        };
        lanes.push(here);
    }
    Err(MissingTurn { index: open.peek().map_or(0, |(index, _)| *index), road_ends: true })
}

/// The turn that a branch takes, from its start up to where it leaves its junction.
fn option(town: &Town, branch: Waypoint) -> RoadOption {
    let mut here = branch;
    for _ in 0..MAX_LANES {
        if !town.is_junction(here) {
            break;
        }
        let Some(next) = town.successors(here).next() else { break };
        here = next;
    }
    let turned = wrap_angle(town.pose(here).yaw - town.pose(branch).yaw);
    match turned {
        turned if turned > STRAIGHT => RoadOption::Left,
        turned if turned < -STRAIGHT => RoadOption::Right,
        _ => RoadOption::Straight,
    }
}

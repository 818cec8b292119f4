use super::{EgoSpeed, SpawnRule, Survey};
use crate::FirstHeading;
use base::seed::Stream;
use road::geometry::{Obstacles, Point};
use road::{LaneFilter, Town};

/// The car may drive at so many times the highest limit of a speed sign,
const BEYOND_LIMIT: f64 = 2.0;
/// and at this speed (m/s) in any town.
const MIN_SPEED: f64 = 20.0;
/// Length that bodies and half a lane may take of a distance between middles (m).
const BODIES: f64 = 5.0;
/// The number of starts that are drawn first.
const FEW: u32 = 4;
/// The number that is drawn if none of these is within reach; [`ENOUGH`] of them must satisfy all constraints.
const MANY: u32 = 200;
const ENOUGH: usize = 20;

impl SpawnRule {
    /// Whether no pedestrian of this greatest speed (m/s) can meet the car within a time (s), as far as drawn starts tell.
    ///
    /// A start is within reach where the pedestrian can get to a driving lane, and together with a car of 20 m/s, or
    /// of twice the highest speed limit, can cover the distance between them. A rule that states the pedestrian's walk is always within reach.
    pub fn is_out_of_reach(
        &self,
        town: &Town,
        obstacles: &Obstacles,
        first: FirstHeading,
        (walking, time): (f64, f64),
        stream: &mut Stream,
    ) -> bool {
        if self.scripted().is_some() {
            return false;
        }
        let limit = limits(town).map(|limit| BEYOND_LIMIT * limit).fold(MIN_SPEED, f64::max);
        let driven = limit.max(self.greatest_given_speed().unwrap_or(0.0));
        let walked = walking * time + BODIES;
        let lane_in_reach = |place: Point| {
            let lane = town.nearest_lane(place, LaneFilter::Driving);
            lane.is_some_and(|lane| (town.pose(lane).position() - place).norm() <= walked)
        };
        let none_in_reach = |count: u32, stream: &mut Stream| {
            let Survey { spawns, .. } = self.survey(town, obstacles, first, count, stream);
            let in_reach = spawns.iter().any(|start| {
                let apart = (start.pedestrian.position() - start.ego.position()).norm();
                apart <= driven * time + walked && lane_in_reach(start.pedestrian.position())
            });
            (!in_reach).then_some(spawns.len())
        };
        none_in_reach(FEW, stream).is_some() && none_in_reach(MANY, stream).is_some_and(|found| found >= ENOUGH)
    }

    /// The highest speed that the rule or a limit of the town gives the car (m/s); `None` if neither does.
    pub fn greatest_limit(&self, town: &Town) -> Option<f64> {
        limits(town).chain(self.greatest_given_speed()).reduce(f64::max)
    }

    /// The highest speed that the rule itself gives the car (m/s).
    fn greatest_given_speed(&self) -> Option<f64> {
        let drawn = if let EgoSpeed::Drawn(speed) = &self.ego_speed { Some(speed.support().1) } else { None };
        drawn.into_iter().chain(self.test_speed).reduce(f64::max)
    }
}

/// The speed limits of a town's lanes and signs (m/s).
fn limits(town: &Town) -> impl Iterator<Item = f64> + '_ {
    let lanes = town.roads.iter().flat_map(|road| &road.sections).flat_map(|section| &section.lanes);
    let of_lanes = lanes.flat_map(|lane| &lane.limits).filter_map(|(_, limit)| *limit);
    town.speed_signs.iter().map(|sign| sign.limit).chain(of_lanes)
}

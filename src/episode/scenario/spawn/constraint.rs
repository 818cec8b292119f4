use std::fmt;

use crate::Situation;
use base::choice;
use base::signature::Formula;
use road::geometry::{Obstacles, Point, Pose};
use road::{LEVEL, LaneFilter, LaneKind, Place, Town, Waypoint};
use world::sim::PedestrianBody;

use super::Spawn;

choice! {
    /// The kind of ground at a place.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum Ground {
        /// A driving lane.
        Driving = "driving",
        Sidewalk = "sidewalk",
        /// Another lane: shoulder, parking, biking, …
        Beside = "beside",
        /// No lane at all.
        OffRoad = "off_road",
    }
}

impl Ground {
    /// The ground at a place.
    pub fn at(town: &Town, place: Place) -> Self {
        let kinds = [(LaneFilter::Driving, Self::Driving), (LaneFilter::Sidewalk, Self::Sidewalk)];
        let within = |filter| {
            let is_here = |lane: &Waypoint| place.ground.is_none_or(|own| (town.elevation(*lane) - own).abs() < LEVEL);
            let lane = town.nearest_lane(place, filter).filter(is_here)?;
            let aside = town.pose(lane).to_local(place.point);
            (aside.norm() <= town.lane_width(lane) / 2.0).then(|| town.lane_kind(lane))
        };
        for (filter, ground) in kinds {
            if within(filter).is_some() {
                return ground;
            }
        }
        match within(LaneFilter::Any) {
            Some(kind) if kind != LaneKind::None => Self::Beside,
            _ => Self::OffRoad,
        }
    }
}

/// A condition on a start that sampling alone cannot ensure.
#[derive(Debug, Clone, PartialEq)]
pub enum Constraint {
    /// The pedestrian's centre is at least this far from every obstacle (m).
    Clearance(f64),
    /// The pedestrian stands on one of these grounds.
    Ground(Vec<Ground>),
    /// Whether any of an adult in the pedestrian's place can be seen from the middle of the ego.
    Sight(bool),
    /// A formula over the variables of `begin`, with its text.
    Require {
        /// It must not be 0.
        condition: Formula,
        /// The text in the scenario.
        text: String,
    },
}

impl Constraint {
    /// Whether a start satisfies it.
    pub fn admits(&self, spawn: &Spawn, town: &Town, obstacles: &Obstacles) -> bool {
        let place = spawn.pedestrian.position();
        match self {
            Self::Clearance(least) => obstacles.clearance(place, *least) >= *least,
            Self::Ground(grounds) => grounds.contains(&Ground::at(town, stand(spawn, town))),
            Self::Sight(seen) => {
                let target = (place, PedestrianBody::adult().radius);
                obstacles.shows(spawn.ego.position(), target, std::iter::empty()) == *seen
            }
            Self::Require { condition, .. } => {
                Situation::at_start(&spawn.ego, spawn.ego_speed, &spawn.pedestrian).satisfies(condition)
            }
        }
    }

    /// Whether it can be checked before the rest of the start is drawn.
    pub(super) fn is_about_places(&self) -> bool {
        !matches!(self, Self::Require { .. })
    }
}

/// Names it as the scenario does.
impl fmt::Display for Constraint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Clearance(least) => write!(f, "clearance: {least} m"),
            Self::Ground(grounds) => {
                let name = |ground: &Ground| ground.name();
                write!(f, "ground: [{}]", grounds.iter().map(name).collect::<Vec<_>>().join(", "))
            }
            Self::Sight(true) => f.write_str("sight: visible"),
            Self::Sight(false) => f.write_str("sight: hidden"),
            Self::Require { text, .. } => write!(f, "require: {text}"),
        }
    }
}

/// Where the pedestrian of a start stands: where lanes lie above each other, on the level of the ego.
fn stand(spawn: &Spawn, town: &Town) -> Place {
    let place = spawn.pedestrian.position();
    if !town.has_levels() {
        return place.into();
    }
    Place::on(place, town.ground_beside(town.place_of_car(&spawn.ego), place))
}

/// Whether ego and pedestrian start on one level. Always so in a town without levels.
pub(super) fn is_on_level(spawn: &Spawn, town: &Town) -> bool {
    !town.has_levels() || town.is_on_level(town.place_of_car(&spawn.ego), stand(spawn, town))
}

/// A pedestrian at a place, with the ego at the origin: for constraints on the place alone.
pub(super) fn placed(place: Point) -> Spawn {
    Spawn { ego: Pose::default(), ego_speed: 0.0, pedestrian: Pose::new(place.x, place.y, 0.0) }
}

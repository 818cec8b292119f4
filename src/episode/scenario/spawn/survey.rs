use super::constraint::is_on_level;
use super::{Rarity, Spawn, SpawnRule};
use crate::FirstHeading;
use base::seed::Stream;
use road::Town;
use road::geometry::{Obstacles, Pose};

/// The number of drawn starts that satisfy the constraints.
#[derive(Debug, Clone, PartialEq)]
pub struct Survey {
    /// The number of drawn starts.
    pub tried: u32,
    /// The number that satisfied all constraints.
    pub accepted: u32,
    /// Each constraint as the scenario names it, with the number of starts that satisfied it, whether or not they satisfied others.
    pub constraints: Vec<(String, u32)>,
    /// The starts that satisfied all.
    pub spawns: Vec<Spawn>,
}

impl Survey {
    /// The constraint that most starts failed, and the number that satisfied it.
    pub fn worst(&self) -> Option<(&str, u32)> {
        let worst = self.constraints.iter().min_by_key(|(_, passed)| *passed);
        worst.map(|(name, passed)| (name.as_str(), *passed))
    }

    pub(super) fn rarity(&self) -> Rarity {
        let (worst, worst_passed) = self.worst().unwrap_or_default();
        let (accepted, tried, worst) = (self.accepted, self.tried, worst.to_string());
        Rarity { accepted, tried, worst, worst_passed, barren: false }
    }
}

impl SpawnRule {
    /// Draws starts and checks every constraint for each.
    pub fn survey(
        &self,
        town: &Town,
        obstacles: &Obstacles,
        first: FirstHeading,
        count: u32,
        stream: &mut Stream,
    ) -> Survey {
        let each = |stream: &mut Stream| self.ego_start.sample(town, stream);
        self.survey_from(&mut { each }, town, obstacles, first, (count, count), stream)
    }

    /// As [`SpawnRule::survey`], with the ego at the given poses; ends early when enough starts are accepted.
    pub(super) fn survey_from(
        &self,
        ego: &mut dyn FnMut(&mut Stream) -> Pose,
        town: &Town,
        obstacles: &Obstacles,
        first: FirstHeading,
        (count, enough): (u32, u32),
        stream: &mut Stream,
    ) -> Survey {
        let shaped = self.road_shape != super::RoadShape::Any;
        let mut names: Vec<String> = Vec::new();
        if shaped {
            names.push(format!("ego_road: {}", self.road_shape.name()));
        }
        names.extend(self.constraints.iter().map(ToString::to_string));
        let mut passed = vec![0; names.len()];
        let mut spawns = Vec::new();
        let (mut tried, mut with_room, mut above) = (0, 0, 0);
        while tried < count && (spawns.len() as u32) < enough {
            tried += 1;
            let ego = ego(stream);
            let place = self.place(&ego, stream);
            let spawn = self.complete(&ego, place, first, stream);
            let road = shaped.then(|| self.road_shape.admits(town, &ego));
            let others = self.constraints.iter().map(|constraint| constraint.admits(&spawn, town, obstacles));
            let mut all = self.has_room(town, &ego);
            with_room += u32::from(all);
            for (count, admitted) in passed.iter_mut().zip(road.into_iter().chain(others)) {
                *count += u32::from(admitted);
                all &= admitted;
            }
            if all && !is_on_level(&spawn, town) {
                above += 1;
            } else if all {
                spawns.push(spawn);
            }
        }
        let narrow = (with_room < tried).then(|| ("lane as wide as the car".to_owned(), with_room));
        let apart = (above > 0).then(|| ("pedestrian on the level of the car".to_owned(), spawns.len() as u32));
        let constraints = narrow.into_iter().chain(apart).chain(names.into_iter().zip(passed)).collect();
        Survey { tried, accepted: spawns.len() as u32, constraints, spawns }
    }
}

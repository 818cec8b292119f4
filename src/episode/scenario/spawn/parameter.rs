use super::rule::by_area;
use super::{EgoSpeed, EgoStart, Measure, SpawnRule};
use crate::{FirstHeading, Scenario};
use base::choice;
use base::seed::Stream;
use base::signature::Distribution;
use road::Town;
use road::geometry::Obstacles;

choice! {
    /// A quantity that a spawn rule draws, or that the first command of a target states.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
    #[serde(rename_all = "snake_case")]
    pub enum StartParameter {
        /// Bearing of the pedestrian from the heading of the car, positive to the left (rad).
        Bearing = "bearing",
        /// Distance between the centres (m).
        Distance = "distance",
        /// First heading of the pedestrian from that of the car, positive to the left (rad).
        Heading = "heading",
        /// Speed of the car at the start (m/s).
        EgoSpeed = "ego_speed",
        /// The share of its way that a target starts from.
        Approach = "approach",
        /// The time for which the pedestrian stands at the start of its path (s).
        Delay = "delay",
        /// The speed of a target or of a pedestrian on a path (m/s).
        WalkingSpeed = "walking_speed",
        /// The angle by which the line of a target is turned about the meeting, positive to the left (rad).
        Turn = "turn",
    }
}

impl StartParameter {
    /// Its unit, as reports print it, and the factor from SI to it.
    pub fn unit(self) -> (&'static str, f64) {
        match self {
            Self::Bearing | Self::Heading | Self::Turn => ("deg", 180.0 / std::f64::consts::PI),
            Self::Distance => ("m", 1.0),
            Self::EgoSpeed | Self::WalkingSpeed => ("m/s", 1.0),
            Self::Approach => ("", 1.0),
            Self::Delay => ("s", 1.0),
        }
    }
}

/// A parameter with what it is drawn from.
#[derive(Debug, Clone, PartialEq)]
pub struct DrawnParameter {
    pub parameter: StartParameter,
    pub distribution: Distribution,
    /// The measure of a distance.
    measure: Measure,
}

impl DrawnParameter {
    /// The value below which this share of the draws lies.
    pub fn value(&self, share: f64) -> f64 {
        by_area(self.measure, &self.distribution, share)
    }
}

/// Poses of the car that are tried for one point of a box of parameters.
const POSES: u32 = 2_000;

impl Scenario {
    /// The parameters of its starts that are ranges, in a fixed order: the box of a `cover`. Where the walk of a target is stated, the speeds and headings
    /// that the pedestrian can choose belong to it. Positions on the road, the phase of traffic lights and all that drivers draw are chance.
    pub fn start_parameters(&self) -> Vec<DrawnParameter> {
        let spawn = &self.spawn;
        let action = &self.cast.pedestrian().action;
        let range = |(low, high): (f64, f64)| Distribution::Uniform(low, high);
        let sector = spawn.target_walk.is_none() && spawn.given_path.is_none();
        let speed = match &spawn.ego_speed {
            EgoSpeed::Drawn(speed) if spawn.target_walk.is_none() => Some(speed.clone()),
            _ => None,
        };
        let walks = spawn.target_walk.as_ref().is_some_and(|walk| walk.speed > 0.0);
        let all = [
            (StartParameter::Bearing, sector.then(|| spawn.bearing.clone())),
            (StartParameter::Distance, sector.then(|| spawn.distance.clone())),
            (StartParameter::Heading, spawn.heading.clone().filter(|_| sector)),
            (StartParameter::EgoSpeed, speed),
            (StartParameter::Approach, spawn.target_walk.as_ref().map(|walk| walk.approach.clone())),
            (StartParameter::Delay, spawn.given_path.as_ref().map(|path| path.delay.clone())),
            (StartParameter::WalkingSpeed, walks.then(|| range(action.speed))),
            (StartParameter::Turn, (walks && !action.is_any_heading()).then(|| range(action.heading))),
        ];
        let is_range = |distribution: &Distribution| {
            let (low, high) = distribution.support();
            low < high
        };
        let drawn = all.into_iter().filter_map(|(parameter, distribution)| {
            let distribution = distribution.filter(is_range)?;
            let measure = if parameter == StartParameter::Distance { spawn.measure } else { Measure::Range };
            Some(DrawnParameter { parameter, distribution, measure })
        });
        drawn.collect()
    }
}

impl SpawnRule {
    /// The rule with parameters fixed at these values (SI). Those of the first command change nothing of it.
    pub fn fixed(&self, values: &[(StartParameter, f64)]) -> Self {
        let mut rule = self.clone();
        for (parameter, value) in values {
            let fixed = Distribution::Constant(*value);
            match parameter {
                StartParameter::Bearing => rule.bearing = fixed,
                StartParameter::Distance => rule.distance = fixed,
                StartParameter::Heading => rule.heading = Some(fixed),
                StartParameter::EgoSpeed => rule.ego_speed = EgoSpeed::Drawn(fixed),
                StartParameter::Approach => rule.target_walk.iter_mut().for_each(|walk| walk.approach = fixed.clone()),
                StartParameter::Delay => rule.given_path.iter_mut().for_each(|path| path.delay = fixed.clone()),
                StartParameter::WalkingSpeed | StartParameter::Turn => {}
            }
        }
        rule
    }

    /// The rule with one pose of the car, drawn among those around which it can place the pedestrian; `None` if none of two thousand is such a pose.
    /// A rule with a test or a path stays as it is.
    pub fn settled(
        &self,
        town: &Town,
        obstacles: &Obstacles,
        first: FirstHeading,
        stream: &mut Stream,
    ) -> Option<Self> {
        if self.target_walk.is_some() {
            return Some(self.clone());
        }
        let found = self.search((POSES, 1), town, obstacles, first, stream, &mut 0)?;
        Some(Self { ego_start: EgoStart::Poses(vec![found.ego]), ..self.clone() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_distance_by_area_has_its_share_of_the_ground() {
        let distribution = Distribution::Uniform(3.0, 5.0);
        let drawn = |measure| DrawnParameter {
            parameter: StartParameter::Distance,
            distribution: distribution.clone(),
            measure,
        };
        assert_eq!(drawn(Measure::Range).value(0.5), 4.0);
        // Half of the ground between 3 m and 5 m is within the root of (9 + 25) / 2.
        assert!((drawn(Measure::Area).value(0.5) - 17_f64.sqrt()).abs() < 1e-12);
    }
}

use std::f64::consts::PI;

use serde::Serialize;

use super::observation::{ROAD, UNITS};
use crate::{ActionSpec, Cast, EpisodeRule, ObservationSpec, ObservedSpeed, PedestrianRole, ReferenceFrame, Scaling};
use world::sim::Gait;

/// A number of a state or of an action, for people and for the headers of networks.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Component {
    pub name: String,
    /// The unit; the divisor where the number has none.
    pub unit: String,
    /// The least value; `None` without a bound.
    pub low: Option<f64>,
    /// The greatest value; `None` without a bound.
    pub high: Option<f64>,
    pub meaning: &'static str,
}

/// The numbers about another actor: name, whether it is a length or a speed, and meaning.
const OTHER: [(&str, Option<bool>, &str); ObservationSpec::OTHER_DIM] = [
    ("present", None, "1 if there is such an actor, the nearest first; otherwise all numbers about it are 0"),
    ("vehicle", None, "1 for a car, 0 for a pedestrian"),
    ("ahead", Some(true), "how far it is in the direction of angle 0"),
    ("left", Some(true), "how far it is to the left of that"),
    ("velocity_ahead", Some(false), "its velocity in the direction of angle 0"),
    ("velocity_left", Some(false), "its velocity to the left"),
    ("half_length", Some(true), "half of its length"),
    ("half_width", Some(true), "half of its width"),
];

/// The numbers about the road: name, unit and meaning.
const OF_THE_ROAD: [(&str, &str, &str); ObservationSpec::ROAD_DIM] = [
    (
        "lane_along",
        "m",
        "how far the pedestrian is along the car's lane from the car: the lane that fits place and direction of the car best, at forks straight on, not where its driver will turn",
    ),
    ("lane_left", "m", "how far the pedestrian is to the left of that lane's centre, in driving direction"),
    ("lane_beyond", "m", "how far the pedestrian is beyond the edge of that lane; negative within it"),
    ("road_inside", "m", "how far the pedestrian is inside the nearest driving lane; negative outside of all"),
    ("lane_cos", "", "cosine of the direction of the car's lane beside the pedestrian"),
    ("lane_sin", "", "sine of that direction"),
    ("car_left", "m", "how far the car is to the left of its lane's centre"),
    ("car_turn", "rad", "direction of the car less that of its lane"),
];

impl ObservationSpec {
    /// The names of the numbers about another actor.
    pub fn other_names() -> [&'static str; Self::OTHER_DIM] {
        OTHER.map(|(name, ..)| name)
    }

    /// The numbers of a state in their order.
    pub fn components(&self) -> Vec<Component> {
        let first = match self.frame {
            ReferenceFrame::LineOfSight => ("heading", "direction that the pedestrian faces"),
            _ => ("bearing", "direction from the pedestrian to the middle of the car"),
        };
        let speed = match self.speed {
            ObservedSpeed::Ego => "speed of the car",
            ObservedSpeed::Relative => "length of the difference of the velocities of car and pedestrian",
        };
        let (turn, distance, pace) = UNITS;
        let numbers = [
            (first.0, "rad", "π rad", (Some(-PI), Some(PI)), turn, first.1),
            (
                "distance",
                "m",
                "30 m",
                (Some(0.0), None),
                distance,
                "distance between the middles of car and pedestrian",
            ),
            ("relative_heading", "rad", "π rad", (Some(-PI), Some(PI)), turn, "direction that the car faces"),
            ("speed", "m/s", "8 m/s", (Some(0.0), None), pace, speed),
        ];
        let reach = Self::REACH;
        let ray = "how far the view is free of obstacles in that direction: rays go evenly around, counterclockwise, the first one at angle 0";
        let rays = (0..self.rays).map(|number| {
            let (unit, high) = match self.scaling {
                Scaling::Natural => ("m".into(), reach),
                Scaling::Unit => (format!("{reach} m"), 1.0),
            };
            Component { name: format!("ray_{number}"), unit, low: Some(0.0), high: Some(high), meaning: ray }
        });
        let road = OF_THE_ROAD.iter().zip(ROAD).take(self.seen_road()).map(|((name, unit, meaning), most)| {
            let (unit, bound) = match self.scaling {
                Scaling::Unit if !unit.is_empty() => (format!("{most} {unit}"), 1.0),
                _ => ((*unit).into(), most),
            };
            Component { name: (*name).into(), unit, low: Some(-bound), high: Some(bound), meaning }
        });
        let of_the_ego = numbers.map(|(name, unit, scaled, (low, high), divisor, meaning)| {
            let (unit, divisor) = match self.scaling {
                Scaling::Natural => (unit, 1.0),
                Scaling::Unit => (scaled, divisor),
            };
            let over = |bound: Option<f64>| bound.map(|bound| bound / divisor);
            Component { name: name.into(), unit: unit.into(), low: over(low), high: over(high), meaning }
        });
        let (length, speed) = match self.scaling {
            Scaling::Natural => ("m", "m/s"),
            Scaling::Unit => ("30 m", "8 m/s"),
        };
        let others = (0..self.others).flat_map(move |number| {
            OTHER.map(|(name, unit, meaning)| {
                let unit = match unit {
                    Some(true) => length,
                    Some(false) => speed,
                    None => "",
                };
                let bound = |at: f64| unit.is_empty().then_some(at);
                Component {
                    name: format!("other_{number}_{name}"),
                    unit: unit.into(),
                    low: bound(0.0),
                    high: bound(1.0),
                    meaning,
                }
            })
        });
        of_the_ego.into_iter().chain(road).chain(rays).chain(others).collect()
    }
}

impl ActionSpec {
    /// The numbers of an action in their order.
    pub fn components(&self) -> [Component; Self::DIM] {
        let [heading, speed] = self.bounds();
        let (turn, pace) = match self.scaling {
            Scaling::Natural => ("rad", "m/s"),
            Scaling::Unit => ("-1 to 1 over the headings", "-1 to 1 over the speeds"),
        };
        let component = |name: &str, unit: &str, (low, high), meaning| Component {
            name: name.into(),
            unit: unit.into(),
            low: Some(low),
            high: Some(high),
            meaning,
        };
        [
            component("heading", turn, heading, "direction in which the pedestrian is to walk"),
            component("speed", pace, speed, "speed that the pedestrian is to have"),
        ]
    }
}

impl Cast {
    /// The state, the action and the time of a decision as entries for the header of a network, with the components as JSON. Those of further
    /// pedestrians have their number in the name.
    pub fn interface(&self, rule: &EpisodeRule) -> Vec<(&'static str, String)> {
        let json = |components: Vec<Component>| {
            serde_json::to_string(&components).expect("names and finite bounds have a form in JSON")
        };
        let state = self.controlled().flat_map(|(number, role)| of(number, role.observation.components()));
        let action = self.controlled().flat_map(|(number, role)| of(number, role.action.components()));
        let role = self.controlled().next().map_or(self.pedestrian(), |(_, role)| role);
        vec![
            ("state", json(state.collect())),
            ("state_frame", role.observation.frame.name().into()),
            ("action", json(action.collect())),
            ("action_frame", role.action.frame.name().into()),
            ("body", body(role)),
            ("tick_s", rule.tick.to_string()),
            ("decision_ticks", rule.hold.to_string()),
            ("decision_s", (rule.tick * f64::from(rule.hold)).to_string()),
        ]
    }
}

/// The size, the speeds and the limits of a pedestrian, in words.
fn body(role: &PedestrianRole) -> String {
    let (slowest, fastest) = role.action.speed;
    let limits = match role.body.gait {
        Gait::Carla { .. } => "CARLA's gait".to_string(),
        Gait::Inertial { acceleration, .. } => format!("{acceleration:.2} m/s^2"),
    };
    format!("{:.3} m wide at {slowest:.2} to {fastest:.2} m/s with {limits}", 2.0 * role.body.radius)
}

fn of(number: usize, components: impl IntoIterator<Item = Component>) -> impl Iterator<Item = Component> {
    components.into_iter().map(move |component| match number {
        0 => component,
        _ => Component { name: format!("{}_{number}", component.name), ..component },
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use road::geometry::{Point, Pose};

    #[test]
    fn states_lie_within_the_stated_bounds_and_reach_them() {
        use crate::Observation;
        let frames =
            [ReferenceFrame::Heading, ReferenceFrame::Initial, ReferenceFrame::LineOfSight, ReferenceFrame::World];
        for (frame, scaling) in frames.into_iter().flat_map(|frame| [(frame, Scaling::Natural), (frame, Scaling::Unit)])
        {
            let spec = ObservationSpec { frame, scaling, speed: ObservedSpeed::Ego, road: false, rays: 0, others: 0 };
            let components = spec.components();
            let mut extremes = [(f64::MAX, f64::MIN); ObservationSpec::DIM];
            for step in 0..2000 {
                let turn = f64::from(step) * 0.37;
                let pedestrian = Pose::new(0.0, 0.0, turn * 1.7);
                let ego = Pose::new(12.0 * libm::cos(turn), 12.0 * libm::sin(turn), turn * 0.6);
                let seen = Observation::new(&pedestrian, 0.0, &ego, 8.0, ObservedSpeed::Ego);
                let state = spec.encode(&seen, &pedestrian, 0.3, Point::new(ego.x, ego.y));
                for ((value, component), extreme) in state.into_iter().zip(&components).zip(&mut extremes) {
                    assert!(
                        component.low.is_none_or(|low| value >= low) && component.high.is_none_or(|high| value <= high)
                    );
                    *extreme = (extreme.0.min(value), extreme.1.max(value));
                }
            }
            for number in [0, 2] {
                let (low, high) = (components[number].low.unwrap(), components[number].high.unwrap());
                let room = (high - low) * 0.01;
                assert!(extremes[number].0 < low + room && extremes[number].1 > high - room, "{frame:?} {extremes:?}");
            }
            let natural = if scaling == Scaling::Natural { (12.0, 8.0) } else { (0.4, 1.0) };
            assert!((extremes[1].0 - natural.0).abs() < 1e-9 && extremes[3].0 == natural.1, "{extremes:?}");
        }
    }
}

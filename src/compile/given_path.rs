use base::diagnostic::Diagnostic;
use base::keys;
use base::signature::Distribution;
use episode::{Constraint, EgoSpeed, EgoStart, GivenPath, Measure, PathPoint, RoadShape, SpawnRule};
use lang::diagnostics;
use lang::hir::{Block, Declaration};
use road::RoadOption;
use road::geometry::{Point, Pose};

keys! {
    /// The way of the ego.
    pub struct RouteKeys {
        /// Turns that the driver takes at the next forks of its road, in order, whatever driver it is. Afterwards, and without
        /// it, the driver finds its own way.
        ego_route: Option<Vec<RoadOption>> as Step(&["left", "straight", "right"]),
    }
}

impl RouteKeys {
    /// The turns, in order.
    pub fn turns(self) -> Vec<RoadOption> {
        self.ego_route.unwrap_or_default()
    }
}

keys! {
    /// The pedestrian walks a stated path, whatever the car does. `scripted` follows it as it is given; other pedestrians choose
    /// its pace and turn it about its first point by their first command.
    pub struct GivenPathKeys = "given_path" {
        /// Poses of which the ego takes one.
        ego_poses: Vec<[f64; 3]>,
        /// Speed of the ego at the start. Without it the driver is in its steady state.
        ego_speed: Option<Distribution> as drawn(SPEED, 0.0, 60.0),
        /// Speed that the driver holds before the start, instead of its own.
        test_speed: Option<f64> as positive(SPEED),
        ..route: RouteKeys,
        /// The points of the path, two at least. The pedestrian starts at the first and stands at the last.
        through: Vec<[f64; 2]>,
        /// The speed on each piece between two points, or one for all pieces.
        speeds: Option<Vec<f64>> as positive(SPEED),
        /// Instead of `speeds`: when it is at each point, the first at 0 s. A point that stands twice is a stop.
        times: Option<Vec<f64>> as non_negative(TIME),
        /// How long it stands at the first point, drawn for each episode.
        delay: Distribution as drawn(TIME, 0.0, 3600.0) = "0 s",
    }
}

/// The rule for a declaration of this kind; `None` after reporting what is wrong.
pub fn lower(declaration: &Declaration, said: &mut Vec<Diagnostic>) -> Option<SpawnRule> {
    let block = &declaration.block;
    let keys: GivenPathKeys = block.keys();
    let through: Vec<Point> = keys.through.into_iter().map(Point::from).collect();
    let times = times(block, &through, keys.speeds, keys.times, said)?;
    if keys.ego_speed.is_some() && keys.test_speed.is_some() {
        said.push(diagnostics::two_speeds(block.place("test_speed")));
        return None;
    }
    let egos: Vec<Pose> = keys.ego_poses.into_iter().map(Pose::from).collect();
    let apart = egos.iter().map(|ego| (ego.position() - through[0]).norm()).fold(f64::INFINITY, f64::min);
    let points = through.iter().zip(times).map(|(place, time)| PathPoint { place: *place, time }).collect();
    Some(SpawnRule {
        name: declaration.name.clone(),
        bearing: Distribution::Constant(0.0),
        distance: Distribution::Constant(apart),
        measure: Measure::Range,
        ego_start: EgoStart::Poses(egos),
        test_speed: keys.test_speed,
        ego_route: keys.route.turns(),
        road_shape: RoadShape::Any,
        lane_width: 0.0,
        ego_speed: keys.ego_speed.map_or(EgoSpeed::Steady, EgoSpeed::Drawn),
        heading: None,
        constraints: vec![Constraint::Clearance(CLEARANCE)],
        target_walk: None,
        given_path: Some(GivenPath { points, delay: keys.delay }),
    })
}

/// When the pedestrian is at each point of the path; `None` after reporting what is wrong.
fn times(
    block: &Block,
    through: &[Point],
    speeds: Option<Vec<f64>>,
    times: Option<Vec<f64>>,
    said: &mut Vec<Diagnostic>,
) -> Option<Vec<f64>> {
    let mut wrong = |key: &str, message: String, help: &str| {
        said.push(diagnostics::contradiction(block.place(key), message).help(help.to_string()));
    };
    let length = |ends: &[Point]| (ends[1] - ends[0]).norm();
    if through.len() < 2 || through.windows(2).all(|ends| length(ends) == 0.0) {
        wrong("through", "this path leads nowhere".into(), "give two different points at least");
        return None;
    }
    let pieces = through.len() - 1;
    match (speeds, times) {
        (Some(_), Some(_)) => {
            wrong("times", "a path has either `speeds` or `times`".into(), "remove one of them");
            None
        }
        (None, None) => {
            let head = block.head;
            let message = "the path does not state how fast the pedestrian walks".to_string();
            said.push(diagnostics::contradiction(head, message).help("add `speeds: [5 km/h]`, or `times`"));
            None
        }
        (None, Some(times)) => {
            let falls = times.windows(2).zip(through.windows(2));
            let late =
                |(times, ends): (&[f64], &[Point])| times[1] < times[0] || times[1] == times[0] && length(ends) > 0.0;
            if times.len() != through.len() || times.first() != Some(&0.0) || falls.into_iter().any(late) {
                let message = format!("{} points need as many times that grow from 0 s", through.len());
                wrong("times", message, "give one time for each point of `through`, such as `[0 s, 2.5 s]`");
                return None;
            }
            Some(times)
        }
        (Some(speeds), None) => {
            if speeds.len() != 1 && speeds.len() != pieces {
                let message = format!(
                    "{} speeds for a path of {pieces} piece{}",
                    speeds.len(),
                    if pieces == 1 { "" } else { "s" }
                );
                wrong("speeds", message, "give one speed for all pieces, or one for each");
                return None;
            }
            if through.windows(2).any(|ends| length(ends) == 0.0) {
                wrong("through", "a point stands twice in a row".into(), "a stop needs `times` instead of `speeds`");
                return None;
            }
            let mut times = vec![0.0];
            for (ends, speed) in through.windows(2).zip(speeds.iter().cycle()) {
                times.push(times[times.len() - 1] + length(ends) / speed);
            }
            Some(times)
        }
    }
}

/// The least distance from the first point to an obstacle (m): room for the largest body.
const CLEARANCE: f64 = 0.3;

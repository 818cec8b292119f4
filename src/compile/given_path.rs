use super::spawn::{ego_route, ego_route_param};
use super::target_walk::numbers;
use base::diagnostic::Diagnostic;
use base::signature::{Distribution, Param, Signature, Type, Value};
use base::units::Dimension;
use lang::diagnostics;
use lang::hir::Declaration;
use world::env::{Constraint, EgoSpeed, EgoStart, GivenPath, Measure, PathPoint, RoadShape, SpawnRule};
use world::geometry::{Point, Pose};

/// The word of a `spawn` with a given path of the pedestrian.
pub const GIVEN_PATH: &str = "given_path";

/// The kind of `spawn` with a given path of the pedestrian.
pub fn signature() -> Signature {
    Signature::new(
        GIVEN_PATH,
        "The pedestrian walks a stated path, whatever the car does. `scripted` follows it as it is given; other controllers choose its pace and turn it about its first point by their first command.",
        vec![
            Param::required("ego_poses", Type::List(Box::new(Type::Pose)), "Poses of which the ego takes one."),
            Param::optional(
                "ego_speed",
                Type::Distribution { dimension: Dimension::SPEED, min: 0.0, max: 60.0 },
                "Speed of the ego at the start. Without it the driver is in its steady state.",
            ),
            Param::optional(
                "test_speed",
                Type::positive(Dimension::SPEED),
                "Speed that the driver holds before the start, instead of its own.",
            ),
            ego_route_param(),
            Param::required(
                "through",
                Type::List(Box::new(Type::Point)),
                "The points of the path, two at least. The pedestrian starts at the first and stands at the last.",
            ),
            Param::optional(
                "speeds",
                Type::List(Box::new(Type::positive(Dimension::SPEED))),
                "The speed on each piece between two points, or one for all pieces.",
            ),
            Param::optional(
                "times",
                Type::List(Box::new(Type::non_negative(Dimension::TIME))),
                "Instead of `speeds`: when it is at each point, the first at 0 s. A point that stands twice is a stop.",
            ),
            Param::with_default(
                "delay",
                Type::Distribution { dimension: Dimension::TIME, min: 0.0, max: 3600.0 },
                "0 s",
                "How long it stands at the first point, drawn for each episode.",
            ),
        ],
    )
}

/// The rule for a declaration of this kind; none after reporting what is wrong.
pub fn lower(declaration: &Declaration, said: &mut Vec<Diagnostic>) -> Option<SpawnRule> {
    let (block, arguments) = (&declaration.block, &declaration.block.arguments);
    let place = |value: &Value| match *value {
        Value::Point(x, y) => Point::new(x, y),
        ref other => panic!("checked: a point, not {other:?}"),
    };
    let through: Vec<Point> = arguments.list("through").iter().map(place).collect();
    let given = |key: &str| arguments.has(key).then(|| numbers(arguments, key));
    let mut wrong = |key: &str, message: String, help: &str| {
        said.push(diagnostics::contradiction(block.place(key), message).help(help.to_string()));
    };
    let length = |ends: &[Point]| (ends[1] - ends[0]).norm();
    if through.len() < 2 || through.windows(2).all(|ends| length(ends) == 0.0) {
        wrong("through", "this path leads nowhere".into(), "give two different points at least");
        return None;
    }
    let pieces = through.len() - 1;
    let times = match (given("speeds"), given("times")) {
        (Some(_), Some(_)) => {
            wrong("times", "a path has either `speeds` or `times`".into(), "remove one of them");
            return None;
        }
        (None, None) => {
            let head = block.head;
            let message = "the path does not state how fast the pedestrian walks".to_string();
            said.push(diagnostics::contradiction(head, message).help("add `speeds: [5 km/h]`, or `times`"));
            return None;
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
            times
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
            times
        }
    };
    if arguments.has("ego_speed") && arguments.has("test_speed") {
        wrong("test_speed", "the ego has either an `ego_speed` or a `test_speed`".into(), "remove one of them");
        return None;
    }
    let pose = |value: &Value| match *value {
        Value::Pose(x, y, yaw) => Pose::new(x, y, yaw),
        ref other => panic!("checked: a pose, not {other:?}"),
    };
    let egos: Vec<Pose> = arguments.list("ego_poses").iter().map(pose).collect();
    let apart = egos.iter().map(|ego| (ego.position() - through[0]).norm()).fold(f64::INFINITY, f64::min);
    let points = through.iter().zip(times).map(|(place, time)| PathPoint { place: *place, time }).collect();
    let speed = arguments.has("ego_speed").then(|| arguments.distribution("ego_speed").clone());
    Some(SpawnRule {
        name: declaration.name.clone(),
        bearing: Distribution::Constant(0.0),
        distance: Distribution::Constant(apart),
        measure: Measure::Range,
        ego_start: EgoStart::Poses(egos),
        test_speed: arguments.has("test_speed").then(|| arguments.number("test_speed")),
        ego_route: ego_route(arguments),
        road_shape: RoadShape::Any,
        ego_speed: speed.map_or(EgoSpeed::Steady, EgoSpeed::Drawn),
        heading: None,
        constraints: vec![Constraint::Clearance(CLEARANCE)],
        target_walk: None,
        given_path: Some(GivenPath { points, delay: arguments.distribution("delay").clone() }),
    })
}

/// The least distance from the first point to an obstacle (m): room for the largest body.
const CLEARANCE: f64 = 0.3;

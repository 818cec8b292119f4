use std::f64::consts::PI;

use super::sector::{self, Sector};
use super::{given_path, target_walk};
use base::diagnostic::{Diagnostic, Sources};
use base::signature::{Arguments, Distribution, Form, Param, Signature, Type, Value, Vocabulary};
use base::units::Dimension;
use lang::diagnostics;
use lang::hir::{Block, Declaration};
use world::env::{Constraint, EgoSpeed, EgoStart, Ground, LanePiece, Measure, RoadShape, SpawnRule};
use world::geometry::Pose;
use world::road::RoadOption;

/// The form `spawn`.
pub fn form() -> Form {
    let params = vec![
        Param::with_default(
            "bearing",
            Type::Distribution { dimension: Dimension::ANGLE, min: -PI, max: PI },
            "-60 deg .. 60 deg",
            "Bearing of the pedestrian from the ego's heading, positive to the left.",
        ),
        Param::with_default(
            "distance",
            Type::Distribution { dimension: Dimension::LENGTH, min: 4.0, max: 1000.0 },
            "7 m .. 30 m",
            "Distance between the middles of ego and pedestrian.",
        ),
        Param::with_default(
            "measure",
            Type::Choice(&["range", "area"]),
            "range",
            "What is uniform: the distance (`range`), or the ground (`area`), for which the distance must be a range.",
        ),
        Param::with_default(
            "clearance",
            Type::non_negative(Dimension::LENGTH),
            "0.5 m",
            "Least distance from the pedestrian's middle to an obstacle.",
        ),
        Param::optional(
            "ground",
            Type::List(Box::new(Type::Choice(&["driving", "sidewalk", "beside", "off_road"]))),
            "Where the pedestrian may stand: driving lanes, sidewalks, other lanes (shoulder, parking, …), no lane; anywhere without it.",
        ),
        Param::with_default(
            "sight",
            Type::Choice(&["any", "visible", "hidden"]),
            "any",
            "Whether what stands in the town (buildings, walls, trees, parked cars) must or must not hide the pedestrian from the middle of the ego.",
        ),
        Param::optional(
            "heading",
            Type::Distribution { dimension: Dimension::ANGLE, min: -PI, max: PI },
            "Where the pedestrian looks, from the ego's heading, positive to the left; without it the adversary's `first_heading` decides.",
        ),
        Param::optional(
            "ego_poses",
            Type::List(Box::new(Type::Pose)),
            "Poses of which the ego takes one; without them and without `ego_lane` it begins anywhere on the driving lanes outside junctions, uniform in length.",
        ),
        Param::with_default(
            "ego_road",
            Type::Choice(&["any", "straight", "bend"]),
            "any",
            "Which stretches of road the ego may begin on: all, those that run straight for the next 10 m, or the others.",
        ),
        Param::optional(
            "ego_speed",
            Type::Distribution { dimension: Dimension::SPEED, min: 0.0, max: 60.0 },
            "Speed of the ego at the start, such as `0 m/s`. Without it the driver is in its steady state: it has driven its lane alone up to there.",
        ),
        Param::optional(
            "test_speed",
            Type::positive(Dimension::SPEED),
            "Speed that the driver holds before the start, instead of its own: its speed limit is set so that it drives this speed. So drivers are compared at equal speeds.",
        ),
        ego_route_param(),
        Param::optional(
            "require",
            Type::List(Box::new(Type::Condition("begin"))),
            "Conditions on `bearing`, `distance`, `ahead`, `aside`, `facing`, `ego_speed`. Bounds of what is drawn are sampled directly; the rest is rejected.",
        ),
    ];
    let lane = Signature::new(
        "ego_lane",
        "A piece of a driving lane on which the ego begins, uniform in length over all pieces.",
        vec![
            Param::required("from", Type::Pose, "Where it begins: near the middle of the lane and along it."),
            Param::required("length", Type::positive(Dimension::LENGTH), "How far it reaches, in driving direction."),
        ],
    );
    Form {
        name: "spawn",
        doc: "Where an episode begins.",
        plain: Some(Signature { children: vec![lane], ..Signature::new("spawn", "", params) }),
        multiplies: false,
        kinds: target_walk::signatures().into_iter().chain([given_path::signature()]).collect(),
    }
}

/// The rule; none after reporting that its constraints contradict each other.
pub fn lower(
    declaration: &Declaration,
    vocabulary: &Vocabulary,
    sources: &Sources,
    said: &mut Vec<Diagnostic>,
) -> Option<SpawnRule> {
    let (name, block) = (&declaration.name, &declaration.block);
    match declaration.kind {
        "spawn" => {}
        given_path::GIVEN_PATH => return given_path::lower(declaration, said),
        _ => return target_walk::lower(declaration, said),
    }
    let arguments = &block.arguments;
    let with_place = |key: &str| (arguments.distribution(key), block.place(key));
    let (bearing, distance) = (with_place("bearing"), with_place("distance"));
    let steady = !arguments.has("ego_speed");
    let at_rest = Distribution::Constant(0.0);
    if !steady && arguments.has("test_speed") {
        let message = "the ego has either an `ego_speed` or a `test_speed`".to_string();
        said.push(diagnostics::contradiction(block.place("test_speed"), message).help("remove one of them"));
        return None;
    }
    let speed = if steady { (&at_rest, block.head) } else { with_place("ego_speed") };
    let area = arguments.choice("measure") == "area";
    let before = said.len();
    if area && !matches!(distance.0, Distribution::Uniform(..)) {
        let message = "places are uniform over the ground only when the distance is a range `low .. high`".to_string();
        said.push(diagnostics::contradiction(block.place("measure"), message).label(distance.1, "this is no range"));
    }
    let mut constraints = vec![Constraint::Clearance(arguments.number("clearance"))];
    if arguments.has("ground") {
        constraints.push(Constraint::Ground(arguments.words("ground").into_iter().map(ground).collect()));
    }
    match arguments.choice("sight") {
        "visible" => constraints.push(Constraint::Sight(true)),
        "hidden" => constraints.push(Constraint::Sight(false)),
        _ => {}
    }
    let mut sector = Sector::new(vocabulary, bearing, distance, speed);
    let conditions = arguments.conditions("require").into_iter().cloned();
    let all = conditions.zip(block.members("require").iter().copied());
    let (unknown, mut left): (Vec<_>, Vec<_>) =
        all.partition(|(condition, _)| steady && sector::names(condition, vocabulary, "ego_speed"));
    said.extend(unknown.into_iter().map(|(_, span)| {
        let message = "`ego_speed` is not drawn here: the driver comes at its own speed".to_string();
        diagnostics::contradiction(span, message).help("draw it, as in `ego_speed: 5 m/s .. 8 m/s`")
    }));
    // The part of the sector that one condition leaves may contradict another condition, in either order.
    for _ in 0..2 {
        let mut kept = Vec::new();
        for (condition, span) in left {
            match sector.require(&condition, span) {
                Ok(rest) => kept.extend(rest.map(|rest| (rest, span))),
                Err(diagnostic) => said.push(*diagnostic),
            }
        }
        left = kept;
    }
    if said.len() == before {
        said.extend(sector.require_together(&left).err().map(|diagnostic| *diagnostic));
    }
    constraints.extend(left.into_iter().map(|(condition, span)| {
        let text = sources.plain_text(span);
        Constraint::Require { condition, text }
    }));
    let ego_start = ego_start(block, said);
    let [bearing, distance, ego_speed] = sector.into_distributions();
    (said.len() == before).then(|| SpawnRule {
        name: name.to_string(),
        bearing,
        distance,
        measure: if area { Measure::Area } else { Measure::Range },
        ego_start,
        ego_route: ego_route(arguments),
        road_shape: match arguments.choice("ego_road") {
            "straight" => RoadShape::Straight,
            "bend" => RoadShape::Bend,
            _ => RoadShape::Any,
        },
        test_speed: arguments.has("test_speed").then(|| arguments.number("test_speed")),
        ego_speed: if steady { EgoSpeed::Steady } else { EgoSpeed::Drawn(ego_speed) },
        heading: arguments.has("heading").then(|| arguments.distribution("heading").clone()),
        constraints,
        target_walk: None,
        given_path: None,
    })
}

/// The key `ego_route`.
pub(super) fn ego_route_param() -> Param {
    Param::optional(
        "ego_route",
        Type::List(Box::new(Type::Step(&["left", "straight", "right"]))),
        "Turns that the driver takes at the next forks of its road, in order, whatever driver it is. Afterwards, and without it, the driver finds its own way.",
    )
}

/// The turns of the ego.
pub(super) fn ego_route(arguments: &Arguments) -> Vec<RoadOption> {
    let turn = |word: &str| match word {
        "left" => RoadOption::Left,
        "right" => RoadOption::Right,
        _ => RoadOption::Straight,
    };
    let words = if arguments.has("ego_route") { arguments.words("ego_route") } else { Vec::new() };
    words.into_iter().map(turn).collect()
}

fn ego_start(block: &Block, said: &mut Vec<Diagnostic>) -> EgoStart {
    let arguments = &block.arguments;
    let piece = |inner: &Block| LanePiece {
        from: pose(inner.arguments.value("from")),
        length: inner.arguments.number("length"),
    };
    let pieces: Vec<LanePiece> = block.nested("ego_lane").map(piece).collect();
    match (arguments.has("ego_poses"), pieces.is_empty()) {
        (true, false) => {
            let message = "the ego begins either on `ego_poses` or on an `ego_lane`, not on both".to_string();
            let lane = block.nested("ego_lane").next().expect("there is a piece");
            said.push(
                diagnostics::contradiction(block.place("ego_poses"), message).label(lane.head, "the lane is here"),
            );
            EgoStart::Anywhere
        }
        (true, true) => EgoStart::Poses(poses(arguments)),
        (false, false) => EgoStart::Pieces(pieces),
        (false, true) => EgoStart::Anywhere,
    }
}

fn poses(arguments: &Arguments) -> Vec<Pose> {
    arguments.list("ego_poses").iter().map(pose).collect()
}

fn pose(value: &Value) -> Pose {
    match value {
        Value::Pose(x, y, yaw) => Pose::new(*x, *y, *yaw),
        other => panic!("checked: a pose, not {other:?}"),
    }
}

fn ground(word: &str) -> Ground {
    match word {
        "driving" => Ground::Driving,
        "sidewalk" => Ground::Sidewalk,
        "beside" => Ground::Beside,
        _ => Ground::OffRoad,
    }
}

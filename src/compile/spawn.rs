use std::f64::consts::PI;

use super::given_path::{GivenPathKeys, RouteKeys};
use super::target_walk::{AlongTestKeys, CrossingTestKeys};
use super::{given_path, sector, target_walk};
use base::diagnostic::{Diagnostic, Sources};
use base::signature::{Distribution, Form, Formula, Keys, Signature, Vocabulary};
use base::{choice, keys};
use episode::{Constraint, EgoSpeed, EgoStart, Ground, LanePiece, Measure, RoadShape, SpawnRule};
use lang::diagnostics;
use lang::hir::{Block, Declaration};
use road::geometry::Pose;

choice! {
    /// Whether something must hide the pedestrian.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum Sight {
        Any = "any",
        Visible = "visible",
        Hidden = "hidden",
    }
}

keys! {
    /// Where an episode begins.
    pub struct SpawnKeys = "spawn" {
        /// Bearing of the pedestrian from the ego's heading, positive to the left.
        bearing: Distribution as drawn(ANGLE, -PI, PI) = "-60 deg .. 60 deg",
        /// Distance between the middles of ego and pedestrian.
        distance: Distribution as drawn(LENGTH, 4.0, 1000.0) = "7 m .. 30 m",
        /// What is uniform: the distance (`range`), or the ground (`area`), for which the distance must be a range.
        measure: Measure = "range",
        /// Least distance from the pedestrian's middle to an obstacle.
        clearance: f64 as non_negative(LENGTH) = "0.5 m",
        /// Where the pedestrian may stand: driving lanes, sidewalks, other lanes (shoulder, parking, …), no lane; anywhere
        /// without it.
        ground: Option<Vec<Ground>>,
        /// Whether what stands in the town (buildings, walls, trees, parked cars) must or must not hide the pedestrian from the
        /// middle of the ego.
        sight: Sight = "any",
        /// Where the pedestrian looks, from the ego's heading, positive to the left; without it the body's
        /// `first_heading` decides.
        heading: Option<Distribution> as drawn(ANGLE, -PI, PI),
        /// Poses of which the ego takes one; without them and without `ego_lane` it begins anywhere on the driving lanes
        /// outside junctions, uniform in length.
        ego_poses: Option<Vec<[f64; 3]>>,
        /// Which stretches of road the ego may begin on: all, those that run straight for the next 10 m, or the others.
        ego_road: RoadShape = "any",
        /// Speed of the ego at the start, such as `0 m/s`. Without it the driver is in its steady state: it has driven its lane
        /// alone up to there.
        ego_speed: Option<Distribution> as drawn(SPEED, 0.0, 60.0),
        /// Speed that the driver holds before the start, instead of its own: its speed limit is set so that it drives this
        /// speed. So drivers are compared at equal speeds.
        test_speed: Option<f64> as positive(SPEED),
        ..route: RouteKeys,
        /// Conditions on `bearing`, `distance`, `ahead`, `aside`, `facing`, `ego_speed`. Bounds of what is drawn are sampled
        /// directly; the rest is rejected.
        require: Option<Vec<Formula>> as Condition("begin"),
    }
}

keys! {
    /// A piece of a driving lane on which the ego begins, uniform in length over all pieces.
    pub struct EgoLaneKeys = "ego_lane" {
        /// Where it begins: near the middle of the lane and along it.
        from: [f64; 3],
        /// How far it reaches, in driving direction.
        length: f64 as positive(LENGTH),
    }
}

/// A kind of start in which the pedestrian's walk is stated: its keys, and its rule; `None` after reporting what is wrong.
type WalkKind = (fn() -> Signature, fn(&Declaration, &mut Vec<Diagnostic>) -> Option<SpawnRule>);

/// All such kinds; a new one is a line here.
const KINDS: [WalkKind; 3] = [
    (CrossingTestKeys::signature, target_walk::crossing),
    (AlongTestKeys::signature, target_walk::along),
    (GivenPathKeys::signature, given_path::lower),
];

/// The form `spawn`.
pub fn form() -> Form {
    let plain = SpawnKeys::signature().holding(vec![EgoLaneKeys::signature()]);
    Form { kinds: KINDS.iter().map(|(signature, _)| signature()).collect(), ..Form::plain(plain) }
}

/// The rule; `None` after reporting what is wrong with it.
pub fn lower(
    declaration: &Declaration,
    vocabulary: &Vocabulary,
    sources: &Sources,
    said: &mut Vec<Diagnostic>,
) -> Option<SpawnRule> {
    if let Some((_, lower)) = KINDS.iter().find(|(signature, _)| signature().name == declaration.kind) {
        return lower(declaration, said);
    }
    let block = &declaration.block;
    let keys: SpawnKeys = block.keys();
    let steady = keys.ego_speed.is_none();
    let at_rest = Distribution::Constant(0.0);
    if !steady && keys.test_speed.is_some() {
        said.push(diagnostics::two_speeds(block.place("test_speed")));
        return None;
    }
    let before = said.len();
    if keys.measure == Measure::Area && !matches!(keys.distance, Distribution::Uniform(..)) {
        said.push(diagnostics::no_area(block.place("measure"), block.place("distance")));
    }
    let mut constraints = vec![Constraint::Clearance(keys.clearance)];
    constraints.extend(keys.ground.map(Constraint::Ground));
    match keys.sight {
        Sight::Any => {}
        Sight::Visible => constraints.push(Constraint::Sight(true)),
        Sight::Hidden => constraints.push(Constraint::Sight(false)),
    }
    let speed = keys.ego_speed.unwrap_or(at_rest);
    let mut drawn = [("bearing", keys.bearing), ("distance", keys.distance), ("ego_speed", speed)];
    for (condition, span) in keys.require.into_iter().flatten().zip(block.members("require").iter().copied()) {
        if steady && sector::names(&condition, vocabulary, "ego_speed") {
            said.push(diagnostics::own_speed(span));
            continue;
        }
        let left = sector::narrow(&mut drawn, &condition, vocabulary);
        constraints.extend(left.map(|condition| Constraint::Require { condition, text: sources.plain_text(span) }));
    }
    let ego_start = ego_start(block, keys.ego_poses, said);
    let [bearing, distance, ego_speed] = drawn.map(|(_, distribution)| distribution);
    (said.len() == before).then(|| SpawnRule {
        name: declaration.name.clone(),
        bearing,
        distance,
        measure: keys.measure,
        ego_start,
        ego_route: keys.route.turns(),
        road_shape: keys.ego_road,
        lane_width: 0.0,
        test_speed: keys.test_speed,
        ego_speed: if steady { EgoSpeed::Steady } else { EgoSpeed::Drawn(ego_speed) },
        heading: keys.heading,
        constraints,
        target_walk: None,
        given_path: None,
    })
}

fn ego_start(block: &Block, poses: Option<Vec<[f64; 3]>>, said: &mut Vec<Diagnostic>) -> EgoStart {
    let lanes = block.inside::<EgoLaneKeys>();
    let pieces: Vec<LanePiece> =
        lanes.map(|(_, keys)| LanePiece { from: keys.from.into(), length: keys.length }).collect();
    match (poses, block.nested(EgoLaneKeys::KIND).next()) {
        (Some(_), Some(lane)) => {
            said.push(diagnostics::two_starts(block.place("ego_poses"), lane.head));
            EgoStart::Anywhere
        }
        (Some(poses), None) => EgoStart::Poses(poses.into_iter().map(Pose::from).collect()),
        (None, Some(_)) => EgoStart::Pieces(pieces),
        (None, None) => EgoStart::Anywhere,
    }
}

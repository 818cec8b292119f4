mod site;
mod objects;
mod drawn;
mod map;

use std::f64::consts::SQRT_2;
use std::path::Path;
use std::sync::Arc;

use base::diagnostic::{Diagnostic, Sources, Span};
use base::signature::{Form, Keys, Signature};
use drawn::TownKeys;
use lang::hir::{Block, Declaration};
use lang::{Reader, diagnostics};
use map::OpenDriveKeys;
use objects::{BusStopKeys, CrosswalkKeys, SpeedSignKeys};
use road::geometry::{OrientedBox, Point, Pose, Vector};
use road::{LaneFilter, Road, Shape, SpeedSign, Town, TownParts, crosswalk, opendrive};
use site::{Drawn, Site};

/// Half size of the box in which a speed sign takes effect (m): 0.35 of CARLA's lanes.
const SIGN_HALF_SIZE: f64 = 1.4;
/// An object farther than this from all streets is neither met nor seen (m).
const FAR: f64 = 500.0;
/// Step of the search for lanes under an obstacle (m).
const UNDER_STEP: f64 = 1.0;
/// Maximum number of steps along one side of an obstacle.
const MAX_STEPS: f64 = 1e9;
/// Allowance for the difference between a lane and the straight pieces that the search uses (m).
const UNDER_SLACK: f64 = 5.0;

/// A kind of town: the keys that it takes, and how its parts are made.
#[derive(Clone)]
pub struct TownKind {
    /// Its name, its keys and its documentation.
    pub signature: Signature,
    /// Makes its parts; `None` after reporting what is wrong.
    build: Build,
}

type Build = Arc<dyn Fn(&Declaration, &mut Site<'_>) -> Option<Drawn> + Send + Sync>;

impl TownKind {
    /// A kind with these keys. `make` gives the same parts for the same keys, or the reason why the town is impossible.
    pub fn new<K: Keys>(make: impl Fn(K) -> Result<TownParts, String> + Send + Sync + 'static) -> Self {
        Self::reporting::<K>(move |declaration, site| match make(declaration.block.keys()) {
            Ok(parts) => {
                let parts = TownParts { name: declaration.name.clone(), ..parts };
                Some(Drawn { parts, half_width: f64::INFINITY })
            }
            Err(reason) => {
                site.said.push(diagnostics::unbuildable_town(declaration.block.head, &reason));
                None
            }
        })
    }

    /// A kind with these keys that reads files, or reports mistakes at their places.
    fn reporting<K: Keys>(
        build: impl Fn(&Declaration, &mut Site<'_>) -> Option<Drawn> + Send + Sync + 'static,
    ) -> Self {
        Self { signature: K::signature(), build: Arc::new(build) }
    }
}

/// All kinds that have a name; a new one is a line here.
pub fn kinds() -> Vec<TownKind> {
    vec![TownKind::reporting::<OpenDriveKeys>(map::build)]
}

/// The kind without a name, which is written in the file.
pub fn drawn() -> TownKind {
    TownKind::reporting::<TownKeys>(drawn::build)
}

/// The signature of a kind with the objects that may stand in every town.
pub(super) fn with_objects(mut signature: Signature) -> Signature {
    signature.children.extend(objects::signatures());
    signature
}

/// The form `town`.
pub fn form() -> Form {
    Form::plain(with_objects(TownKeys::signature()))
}

/// Builds a town and reports what is wrong with it. A map given here replaces its own roads and signs.
pub fn lower(
    kinds: &[TownKind],
    declaration: &Declaration,
    map: Option<&Path>,
    sources: &Sources,
    read: &dyn Reader,
    said: &mut Vec<Diagnostic>,
) -> Option<Town> {
    let block = &declaration.block;
    let kind = kinds.iter().find(|kind| kind.signature.name == declaration.kind);
    let mut site = Site { map, sources, read, said };
    let Drawn { parts: own, half_width } =
        (kind.expect("checked: the kind is in the catalogue").build)(declaration, &mut site)?;
    let mut parts = match map {
        None => own,
        Some(map) => {
            let path = map.display().to_string();
            let real = map::read(declaration, map, (&path, "the folder that you are in"), read, said)?;
            let obstacles = own.obstacles.into_iter().chain(real.obstacles.iter().copied()).collect();
            TownParts { obstacles, ..real }
        }
    };
    let before = said.len();
    let standing = objects::standing(block, said);
    // Rows of houses leave out houses that would stand where an obstacle is placed by hand.
    parts.obstacles.retain(|row| !standing.iter().any(|(_, own)| own.overlaps(row)));
    parts.obstacles.extend(standing.iter().map(|(_, own)| *own));
    parts.bus_stops.extend(block.inside().map(|(_, BusStopKeys { at })| Point::from(at)));
    // A real map has signs of its own.
    for (_, SpeedSignKeys { at, limit }) in block.inside().filter(|_| map.is_none()) {
        let trigger = OrientedBox::new(at.into(), SIGN_HALF_SIZE, SIGN_HALF_SIZE);
        opendrive::add_speed_sign(&mut parts, SpeedSign { limit, trigger });
    }
    if map.is_some() {
        // An obstacle beside the outline of a street may reach into the street of the map.
        let roads = Town::new(TownParts { obstacles: Vec::new(), ..parts.clone() });
        parts.obstacles.retain(|own| road_under(&roads, own).is_none());
        return Some(Town::new(parts));
    }
    let mut town = Town::new(parts);
    let mut crosswalks = Vec::new();
    for (walk, CrosswalkKeys { at, width }) in block.inside() {
        match crosswalk::across(&town, at.into(), width) {
            Ok(corners) => crosswalks.push(corners),
            Err(error) => {
                said.push(diagnostics::unbuildable_town(walk.head, &format!("no crosswalk fits here: {error}")));
            }
        }
    }
    town.add_crosswalks(crosswalks);
    said.extend(on_lanes(&town, &standing, UNDER_SLACK + half_width));
    let whole = said.len() == before;
    said.extend(idle(&town, block, &standing));
    whole.then_some(town)
}

/// Reports what stands on a driving lane, where it is within reach of a road (m).
fn on_lanes(town: &Town, standing: &[(Span, OrientedBox)], reach: f64) -> Vec<Diagnostic> {
    // The first look-up of a lane is expensive, and in a described town most objects stand far from every street.
    let near = |own: &OrientedBox| town.roads.iter().any(|road| comes_near(road, own, reach));
    // One message for a row or a grove.
    let (mut reported, mut found) = (None, Vec::new());
    for (place, own) in standing.iter().filter(|(_, own)| near(own)) {
        if let Some(road) = road_under(town, own).filter(|_| reported != Some(*place)) {
            reported = Some(*place);
            let whose = match road.name.as_str() {
                "" => format!("road {}", road.id),
                name => format!("`{name}`"),
            };
            found.push(diagnostics::unbuildable_town(*place, &format!("this stands on a driving lane of {whose}")));
        }
    }
    found
}

/// Reports objects that have no effect where they stand.
fn idle(town: &Town, block: &Block, standing: &[(Span, OrientedBox)]) -> Vec<Diagnostic> {
    let far = |own: &OrientedBox| !town.roads.iter().any(|road| comes_near(road, own, FAR));
    let lost = standing.iter().filter(|(_, own)| far(own)).map(|(place, _)| diagnostics::far_from_streets(*place, FAR));
    let unseen = |(_, sign): &(&Block, SpeedSignKeys)| {
        let at = Pose::from(sign.at).position();
        town.nearest_lane(at, LaneFilter::Driving).is_none_or(|lane| {
            let reach = town.lane_width(lane) / 2.0 + SIGN_HALF_SIZE * SQRT_2;
            town.pose(lane).to_local(at).norm() > reach
        })
    };
    let passed_by_none = block.inside().filter(unseen).map(|(sign, _)| diagnostics::sign_off_lanes(sign.head));
    lost.chain(passed_by_none).collect()
}

/// Whether the middle of a road may be this near to a box (m); true if that cannot be decided quickly.
fn comes_near(road: &Road, own: &OrientedBox, reach: f64) -> bool {
    road.plan_view.pieces().iter().any(|piece| {
        // How far the piece deviates from the straight line between its ends.
        let sag = match piece.shape {
            Shape::Line => 0.0,
            Shape::Arc(curvature) => curvature.abs() * piece.length * piece.length / 8.0,
            _ => piece.length,
        };
        let around = OrientedBox::new(own.pose, own.half.x + reach + sag, own.half.y + reach + sag);
        around.is_crossed_by(piece.start.position(), piece.pose(piece.length).position())
    })
}

/// The road on one of whose driving lanes a box stands. It checks places less than a metre apart, after whole parts of the
/// box that lie far from all lanes have been excluded.
fn road_under<'a>(town: &'a Town, own: &OrientedBox) -> Option<&'a Road> {
    let steps = (own.half * 2.0 / UNDER_STEP).map(|steps| steps.ceil().clamp(1.0, MAX_STEPS));
    let far = town.widest_driving_lane() / 2.0 + UNDER_SLACK;
    let mut open = vec![(Vector::zeros(), steps)];
    while let Some((first, last)) = open.pop() {
        let place =
            |step: Vector| own.pose.to_world(own.half.component_mul(&(step * 2.0).component_div(&steps)) - own.half);
        let middle = place((first + last) / 2.0);
        let lane = town.nearest_lane(middle, LaneFilter::Driving)?;
        let beside = town.pose(lane).to_local(middle);
        if first == last {
            if beside.y.abs() < town.lane_width(lane) / 2.0 && beside.x.abs() < UNDER_STEP {
                return town.roads.get(lane.road.0 as usize);
            }
        } else if beside.norm() <= far + (place(last) - middle).norm() && beside.norm().is_finite() {
            let (side, extent) = (last - first).argmax();
            let (mut end, mut begin) = (last, first);
            end[side] = first[side] + (extent / 2.0).floor();
            begin[side] = end[side] + 1.0;
            open.extend([(begin, last), (first, end)]);
        }
    }
    None
}

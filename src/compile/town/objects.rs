//! What stands in towns of every kind.

use base::diagnostic::{Diagnostic, Span};
use base::keys;
use base::signature::{Keys, Signature};
use lang::diagnostics;
use lang::hir::Block;
use road::geometry::{OrientedBox, Point, Pose, Vector};

/// Maximum number of trees of a grove.
const MAX_TREES: f64 = 20_000.0;
/// Maximum number of cars of a row.
const MAX_CARS: f64 = 1000.0;

/// The boxes that an obstacle fills, or why it cannot stand.
type Boxes = Result<Vec<OrientedBox>, String>;

/// A kind of obstacle: its keys, and its boxes.
struct ObstacleKind {
    word: &'static str,
    signature: fn() -> Signature,
    boxes: Box<dyn Fn(&Block) -> Boxes>,
}

impl ObstacleKind {
    fn new<K: Keys>(boxes: impl Fn(K) -> Boxes + 'static) -> Self {
        Self { word: K::KIND, signature: K::signature, boxes: Box::new(move |block| boxes(block.keys())) }
    }
}

/// All kinds of obstacles; a new one is a line here.
fn kinds() -> [ObstacleKind; 7] {
    [
        ObstacleKind::new(building),
        ObstacleKind::new(wall),
        ObstacleKind::new(|TreeKeys { at, trunk }| Ok(vec![tree(at.into(), &trunk)])),
        ObstacleKind::new(grove),
        ObstacleKind::new(|ParkedCarKeys { at, length, width }| Ok(vec![vehicle(at.into(), length, width)])),
        ObstacleKind::new(parked_row),
        ObstacleKind::new(|BusKeys { at, length, width }| Ok(vec![vehicle(at.into(), length, width)])),
    ]
}

/// The blocks of all objects.
pub(super) fn signatures() -> Vec<Signature> {
    let obstacles = kinds().into_iter().map(|kind| (kind.signature)());
    obstacles.chain([CrosswalkKeys::signature(), BusStopKeys::signature(), SpeedSignKeys::signature()]).collect()
}

/// All obstacles of the town, each with the place of its declaration.
pub(super) fn standing(block: &Block, said: &mut Vec<Diagnostic>) -> Vec<(Span, OrientedBox)> {
    let (kinds, mut all) = (kinds(), Vec::new());
    for child in &block.children {
        let boxes = kinds.iter().find(|kind| kind.word == child.word).map(|kind| (kind.boxes)(child));
        match boxes.unwrap_or_else(|| Ok(Vec::new())) {
            Ok(boxes) => all.extend(boxes.into_iter().map(|own| (child.head, own))),
            Err(reason) => said.push(diagnostics::unbuildable_town(child.head, &reason)),
        }
    }
    all
}

keys! {
    /// A house: it blocks walkers and sight.
    struct BuildingKeys = "building" {
        /// One corner.
        corner: [f64; 2],
        /// The opposite corner.
        opposite: [f64; 2],
    }
}

fn building(BuildingKeys { corner, opposite }: BuildingKeys) -> Boxes {
    let own = OrientedBox::spanning(corner.into(), opposite.into());
    if own.half.min() < 0.05 { Err("this building is thinner than 0.1 m".into()) } else { Ok(vec![own]) }
}

keys! {
    /// A wall or a fence along a straight line.
    struct WallKeys = "wall" {
        /// One end.
        from: [f64; 2],
        /// The other end.
        to: [f64; 2],
        /// Its thickness.
        thickness: f64 as positive(LENGTH) = "0.3 m",
    }
}

fn wall(WallKeys { from, to, thickness }: WallKeys) -> Boxes {
    let (from, to) = (Point::from(from), Point::from(to));
    let (middle, along) = (nalgebra::center(&from, &to), to - from);
    let heading = libm::atan2(along.y, along.x);
    Ok(vec![OrientedBox::new(Pose::new(middle.x, middle.y, heading), along.norm() / 2.0, thickness / 2.0)])
}

keys! {
    /// The trunk of a tree.
    struct TrunkKeys {
        /// Its thickness.
        trunk: f64 as positive(LENGTH) = "0.4 m",
    }
}

keys! {
    /// A tree, a pole, a lamp post.
    struct TreeKeys = "tree" {
        /// Its place.
        at: [f64; 2],
        ..trunk: TrunkKeys,
    }
}

fn tree(at: Point, TrunkKeys { trunk }: &TrunkKeys) -> OrientedBox {
    OrientedBox::new(Pose::new(at.x, at.y, 0.0), trunk / 2.0, trunk / 2.0)
}

keys! {
    /// Trees in rows over a rectangle.
    struct GroveKeys = "grove" {
        /// One corner.
        corner: [f64; 2],
        /// The opposite corner.
        opposite: [f64; 2],
        /// Distance between two trees.
        spacing: f64 as within(LENGTH, 1.0, 1000.0) = "7 m",
        ..trunk: TrunkKeys,
    }
}

fn grove(GroveKeys { corner, opposite, spacing, trunk }: GroveKeys) -> Boxes {
    let (a, b) = (Point::from(corner), Point::from(opposite));
    let (low, high) = (a.inf(&b), a.sup(&b));
    let count = |extent: f64| (extent / spacing).floor() + 1.0;
    let (columns, rows) = (count(high.x - low.x), count(high.y - low.y));
    if columns * rows > MAX_TREES {
        return Err(format!("this grove has {} trees; at most {MAX_TREES} grow", columns * rows));
    }
    let place = |index: u32| {
        let (column, row) = (f64::from(index) % columns, (f64::from(index) / columns).floor());
        tree(Point::new(low.x + column * spacing, low.y + row * spacing), &trunk)
    };
    Ok((0..(columns * rows) as u32).map(place).collect())
}

keys! {
    /// A car that stands for good.
    struct ParkedCarKeys = "parked_car" {
        /// Its middle and its heading.
        at: [f64; 3],
        /// Its length.
        length: f64 as positive(LENGTH) = "4.5 m",
        /// Its width.
        width: f64 as positive(LENGTH) = "1.9 m",
    }
}

fn vehicle(at: Pose, length: f64, width: f64) -> OrientedBox {
    OrientedBox::new(at, length / 2.0, width / 2.0)
}

keys! {
    /// Cars that stand one behind another along a straight line, looking along it. The first touches `from` with its rear; the
    /// row has as many cars as there is room for up to `to`.
    struct ParkedRowKeys = "parked_row" {
        /// One end of the row, on the middle of the cars.
        from: [f64; 2],
        /// The other end.
        to: [f64; 2],
        /// Distance between two cars.
        gap: f64 as within(LENGTH, 0.0, 1000.0) = "1 m",
        /// Length of a car.
        length: f64 as positive(LENGTH) = "4.5 m",
        /// Width of a car.
        width: f64 as positive(LENGTH) = "1.9 m",
    }
}

fn parked_row(ParkedRowKeys { from, to, gap, length, width }: ParkedRowKeys) -> Boxes {
    let from = Point::from(from);
    let along: Vector = Point::from(to) - from;
    let pitch = length + gap;
    let count = ((along.norm() - length) / pitch + 1.0 + 1e-9).floor();
    if count < 1.0 {
        return Err(format!("this row of {:.1} m has no room for a car of {length} m", along.norm()));
    }
    if count > MAX_CARS {
        return Err(format!("this row has {count} cars; at most {MAX_CARS} stand in one"));
    }
    let direction = along / along.norm();
    let heading = libm::atan2(along.y, along.x);
    let car = |index: u32| {
        let middle = from + direction * (length / 2.0 + f64::from(index) * pitch);
        vehicle(Pose::new(middle.x, middle.y, heading), length, width)
    };
    Ok((0..count as u32).map(car).collect())
}

keys! {
    /// A bus that stands for good, such as at its stop. The default is the maximum size of a bus with two axles before 2002
    /// (Directive 96/53/EC). Like all obstacles it may not stand on a driving lane, since drivers look for road users there.
    struct BusKeys = "bus" {
        /// Its middle and its heading.
        at: [f64; 3],
        /// Its length.
        length: f64 as positive(LENGTH) = "12 m",
        /// Its width.
        width: f64 as positive(LENGTH) = "2.55 m",
    }
}

keys! {
    /// A marked crosswalk over the whole carriageway, at a right angle to the street.
    pub struct CrosswalkKeys = "crosswalk" {
        /// Its middle, on a street outside junctions.
        at: [f64; 2],
        /// Its extent along the street.
        width: f64 as within(LENGTH, 1.0, 20.0) = "4 m",
    }
}

keys! {
    /// A bus stop: where a pedestrian with `destination: bus_stop` waits.
    pub struct BusStopKeys = "bus_stop" {
        /// Where people wait.
        at: [f64; 2],
    }
}

keys! {
    /// A limit that a car takes over when it passes.
    pub struct SpeedSignKeys = "speed_sign" {
        /// The middle of the lane where it takes effect, and the lane's heading.
        at: [f64; 3],
        /// The limit.
        limit: f64 as positive(SPEED),
    }
}

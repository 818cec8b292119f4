use super::layout::{Joint, Layout, MAX_FAULTS};
use super::network::Network;
use super::{DesignError, TownDesign};
use crate::geometry::{OrientedBox, Point, Pose, Vector};
use crate::{Geometry, Road, RoadEnd, Shape};

/// Tiles that overlap by less only touch (m).
const TOUCH: f64 = 1e-6;
/// Maximum angle that one tile of an arc turns (rad).
const TILE_TURN: f64 = 0.05;
/// The longest tile of an arc (m).
const TILE_LENGTH: f64 = 2.0;

/// A rectangle, ready to be tested against many others.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tile {
    centre: Point,
    axes: [Vector; 2],
    half: Vector,
    radius: f64,
}

impl Tile {
    pub fn new(shape: &OrientedBox) -> Self {
        Self::along(shape.pose.axes(), shape.pose.position(), shape.half)
    }

    /// The rectangle whose sides have these directions, unit vectors, and these half lengths (m).
    fn along(axes: [Vector; 2], centre: Point, half: Vector) -> Self {
        Self { centre, axes, half, radius: half.norm() }
    }

    /// Whether two tiles have more than their edges in common.
    pub fn overlaps(&self, other: &Self) -> bool {
        let between = other.centre - self.centre;
        let reach = self.radius + other.radius;
        if between.norm_squared() >= reach * reach {
            return false;
        }
        let extent = |tile: &Self, axis: &Vector| {
            (0..2).map(|side| tile.half[side] * tile.axes[side].dot(axis).abs()).sum::<f64>()
        };
        // Two rectangles are apart if and only if they are apart along one of their sides.
        let apart = |axis: &Vector| between.dot(axis).abs() > extent(self, axis) + extent(other, axis) - TOUCH;
        !self.axes.iter().chain(&other.axes).any(apart)
    }
}

/// The area that every road covers, including sidewalks.
#[derive(Debug)]
pub(super) struct Surfaces {
    roads: Vec<Vec<Tile>>,
    /// Upright rectangles around the roads: opposite corners.
    around: Vec<(Point, Point)>,
    /// The middles of the junctions, with the node's place in the design.
    middles: Vec<(usize, Tile)>,
}

impl Surfaces {
    pub fn new(design: &TownDesign, layout: &Layout, network: &Network) -> Self {
        let roads: Vec<Vec<Tile>> = network.roads.iter().map(tiles).collect();
        Self { around: roads.iter().map(|road| around(road)).collect(), roads, middles: middles(design, layout) }
    }

    /// Whether a road or the middle of a junction lies under a tile.
    pub fn lie_under(&self, tile: &Tile) -> bool {
        let here = around(std::slice::from_ref(tile));
        let near = self.roads.iter().zip(&self.around).filter(|(_, around)| !apart(here, **around));
        near.flat_map(|(road, _)| road).any(|own| own.overlaps(tile))
            || self.middles.iter().any(|(_, middle)| middle.overlaps(tile))
    }

    /// Finds roads on top of each other that have no node in common.
    pub fn find_overlaps(&self, network: &Network, faults: &mut Vec<DesignError>) {
        for first in 0..self.roads.len() {
            for second in first + 1..self.roads.len() {
                if apart(self.around[first], self.around[second]) {
                    continue;
                }
                let nodes = network.nodes[second];
                if network.nodes[first].iter().any(|node| nodes.contains(node)) {
                    continue;
                }
                let names = [first, second].map(|road| network.roads[road].name.as_str());
                if let Some(place) = common_place(&self.roads[first], &self.roads[second])
                    && !is_known(faults, names)
                {
                    if faults.len() >= MAX_FAULTS {
                        return;
                    }
                    let [first, second] = names.map(str::to_owned);
                    faults.push(DesignError::Overlap { first, second, x: place.x, y: place.y });
                }
            }
        }
    }

    /// Finds buildings on roads.
    pub fn find_buildings(&self, design: &TownDesign, network: &Network, faults: &mut Vec<DesignError>) {
        for (building, shape) in design.buildings.iter().enumerate() {
            let tile = Tile::new(shape);
            let on_road = self.roads.iter().position(|road| road.iter().any(|own| own.overlaps(&tile)));
            let on_middle = self.middles.iter().find(|(_, middle)| middle.overlaps(&tile));
            let road = match (on_road, on_middle) {
                (Some(road), _) => &network.roads[road].name,
                (None, Some((node, _))) => &design.nodes[*node].name,
                (None, None) => continue,
            };
            faults.push(DesignError::BuildingOnLane { building, road: road.clone() });
        }
    }
}

/// Whether a crossing or an overlap of two streets has been found before.
fn is_known(faults: &[DesignError], names: [&str; 2]) -> bool {
    faults.iter().any(|fault| match fault {
        DesignError::Crossing { first, second, .. } | DesignError::Overlap { first, second, .. } => {
            names == [first, second] || names == [second, first]
        }
        _ => false,
    })
}

/// Opposite corners of an upright rectangle around tiles.
fn around(tiles: &[Tile]) -> (Point, Point) {
    let none = (Point::new(f64::INFINITY, f64::INFINITY), Point::new(f64::NEG_INFINITY, f64::NEG_INFINITY));
    tiles.iter().fold(none, |(low, high), tile| {
        let reach = Vector::new(tile.radius, tile.radius);
        (low.inf(&(tile.centre - reach)), high.sup(&(tile.centre + reach)))
    })
}

fn apart(first: (Point, Point), second: (Point, Point)) -> bool {
    (0..2).any(|axis| first.1[axis] < second.0[axis] || second.1[axis] < first.0[axis])
}

fn common_place(first: &[Tile], second: &[Tile]) -> Option<Point> {
    let pairs = first.iter().flat_map(|a| second.iter().map(move |b| (a, b)));
    pairs.filter(|(a, b)| a.overlaps(b)).map(|(a, b)| if a.radius < b.radius { a.centre } else { b.centre }).next()
}

fn tiles(road: &Road) -> Vec<Tile> {
    let (mut left, mut right) = (0.0, 0.0);
    for lane in &road.sections[0].lanes {
        *(if lane.id > 0 { &mut left } else { &mut right }) += lane.width.value(0.0);
    }
    // The offset of the lanes moves from one value to the other.
    let ends = [0.0, road.length].map(|s| road.lane_offset.value(s));
    let (left, right) = (left + ends[0].max(ends[1]), right - ends[0].min(ends[1]));
    road.plan_view.pieces().iter().flat_map(|piece| piece_tiles(piece, left, right)).collect()
}

fn piece_tiles(piece: &Geometry, left: f64, right: f64) -> Vec<Tile> {
    let turn = match piece.shape {
        Shape::Arc(curvature) => curvature * piece.length,
        _ => 0.0,
    };
    let count = if turn == 0.0 { 1.0 } else { (turn.abs() / TILE_TURN).max(piece.length / TILE_LENGTH).ceil() };
    let half_turn = turn.abs() / count / 2.0;
    let half_length = piece.length / count / 2.0;
    // The outer edge of an arc is longer than its middle, and its ends lie nearer to the arc's centre.
    let half_outer = half_length + libm::tan(half_turn) * if turn > 0.0 { right } else { left };
    let sag = half_outer * libm::tan(half_turn / 2.0);
    let (left, right) = if turn > 0.0 { (left + sag, right) } else { (left, right + sag) };
    (0..count as usize)
        .map(|index| {
            let middle = piece.point((2.0 * index as f64 + 1.0) * half_length);
            let axes = [middle.forward, Vector::new(-middle.forward.y, middle.forward.x)];
            Tile::along(axes, middle.beside((left - right) / 2.0), Vector::new(half_outer, (left + right) / 2.0))
        })
        .collect()
}

/// The carriageway of every leg up to its junction's node. The area between the connecting roads is not a place for a building
/// either.
fn middles(design: &TownDesign, layout: &Layout) -> Vec<(usize, Tile)> {
    let mut middles = Vec::new();
    for (node, legs) in layout.legs.iter().enumerate().filter(|(node, _)| layout.joints[*node] == Joint::Junction) {
        for leg in legs {
            let edge = &layout.edges[leg.edge];
            let cut = edge.cuts[usize::from(leg.end == RoadEnd::End)];
            let half_width = design.streets[edge.street].carriageway.half_width(&design.profile);
            let centre =
                design.nodes[node].position + Vector::new(libm::cos(leg.heading), libm::sin(leg.heading)) * (cut / 2.0);
            let pose = Pose::new(centre.x, centre.y, leg.heading);
            middles.push((node, Tile::new(&OrientedBox::new(pose, cut / 2.0, half_width))));
        }
    }
    middles
}

#[cfg(test)]
mod tests {
    use super::*;

    fn covered(tiles: &[Tile], place: Point) -> bool {
        tiles.iter().any(|tile| {
            let local = place - tile.centre;
            (0..2).all(|side| local.dot(&tile.axes[side]).abs() <= tile.half[side] + 1e-9)
        })
    }

    #[test]
    fn tiles_cover_an_arc_up_to_its_edges_and_hardly_more() {
        let (left, right) = (4.0, 8.3);
        for curvature in [-1.0 / 9.0, 1.0 / 9.0, 1e-3] {
            let arc = Geometry::arc(0.0, Pose::new(3.0, -2.0, 0.4), 14.0, curvature);
            let tiles = piece_tiles(&arc, left, right);
            for pose in (0..=2800).map(|i| arc.pose(f64::from(i) * 0.005)) {
                let beside = |t: f64| pose.position() + pose.left() * t;
                assert!([left, 0.0, -right].iter().all(|&t| covered(&tiles, beside(t))), "{curvature} {pose:?}");
                assert!(
                    [left + 0.02, -right - 0.02].iter().all(|&t| !covered(&tiles, beside(t))),
                    "{curvature} {pose:?}"
                );
            }
        }
    }
}

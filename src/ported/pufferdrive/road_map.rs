use std::collections::BTreeMap;

use road::geometry::{OrientedBox, Point, Pose, Vector};
use road::{Town, Waypoint};

/// The best distance of a goal (m).
const AHEAD: f64 = 30.0;

/// Points of a map, one joined to the next, and what they are: 0 the middle of a lane, along its driving direction; 1 a marking beside a lane;
/// 2 an edge of the road, which is to the right of it.
pub type Polyline = (u8, Vec<Point>);

/// Two consecutive points.
pub(super) type Piece = (u8, [Point; 2]);

/// A map as PufferDrive looks at it: pieces in the cells of a grid.
#[derive(Debug)]
pub struct RoadMap {
    corners: [Point; 2],
    cells: BTreeMap<(i64, i64), Vec<Piece>>,
    lane_points: Vec<Point>,
}

impl RoadMap {
    /// A map of polylines, whose order decides in a cell and among equally good goals.
    pub fn new(polylines: &[Polyline]) -> Self {
        let far = Point::new(f64::INFINITY, f64::INFINITY);
        let points = polylines.iter().flat_map(|(_, points)| points);
        let corners = points.fold([far, -far], |[low, high], point| [low.inf(point), high.sup(point)]);
        let lanes = polylines.iter().filter(|(kind, _)| *kind == 0);
        let lane_points = lanes.flat_map(|(_, points)| points.iter().copied()).collect();
        let mut map = Self { corners, cells: BTreeMap::new(), lane_points };
        for (kind, points) in polylines {
            for pair in points.windows(2) {
                let cell = map.cell(pair[0] + (pair[1] - pair[0]) / 2.0);
                map.cells.entry(cell).or_default().push((*kind, [pair[0], pair[1]]));
            }
        }
        map
    }

    /// The cell of a place: 5 m wide, from the lowest corner on.
    fn cell(&self, place: Point) -> (i64, i64) {
        let cell = ((place - self.corners[0]) / 5.0).map(f64::floor);
        (cell.x as i64, cell.y as i64)
    }

    /// The pieces around a place, in a square spiral of cells with this number of rings; none off the grid.
    pub(super) fn around(&self, place: Point, rings: i64) -> impl Iterator<Item = &Piece> {
        let (at, last) = (self.cell(place), self.cell(self.corners[1]));
        let is_on_grid = (0..=last.0).contains(&at.0) && (0..=last.1).contains(&at.1);
        let sides = (0..=4 * rings).filter(move |_| is_on_grid).flat_map(move |side| {
            let way = [(1, 0), (0, 1), (-1, 0), (0, -1)][(side % 4) as usize];
            std::iter::repeat_n(way, (side / 2 + 1).min(2 * rings + 1) as usize)
        });
        let cells = sides.scan(at, |at, way| {
            let next = (at.0 + way.0, at.1 + way.1);
            Some(std::mem::replace(at, next))
        });
        cells.filter_map(|cell| self.cells.get(&cell)).flatten()
    }

    /// The point of a lane ahead, whatever its direction, whose distance is nearest to 30 m; straight ahead if there is none.
    pub fn next_goal(&self, ego: &Pose) -> Point {
        let (here, heading) = (ego.position(), ego.forward());
        let miss = |point: &Point| ((point - here).norm() - AHEAD).abs();
        let ahead = self.lane_points.iter().filter(|point| (*point - here).dot(&heading) > 0.0);
        ahead.min_by(|a, b| miss(a).total_cmp(&miss(b))).map_or(here + heading * AHEAD, |point| *point)
    }

    /// Whether an edge of the road meets a car. Pieces of up to 16 m belong to the cell of their middle.
    pub fn touches_edge(&self, outline: &OrientedBox) -> bool {
        let mut near = self.around(outline.pose.position(), 3);
        near.any(|(kind, [from, to])| *kind == 2 && outline.is_crossed_by(*from, *to))
    }
}

/// The map of a town, thinned: all driving lanes, the borders of those outside junctions, and the outline of all.
pub fn polylines(town: &Town) -> Vec<Polyline> {
    let mut by_lane: BTreeMap<_, Vec<Waypoint>> = BTreeMap::new();
    for place in town.generate_waypoints(1.0) {
        by_lane.entry((place.road, place.section, place.lane)).or_default().push(place);
    }
    let mut found = [Vec::new(), Vec::new(), Vec::new()];
    for ((road, section, lane), mut places) in by_lane {
        let road = &town.roads[road.0 as usize];
        places.push(Waypoint { s: road.sections[section as usize].end, ..places[0] });
        if !road.is_forward(lane) {
            places.reverse();
        }
        let border = |is_left: bool| -> Vec<Point> {
            let side = usize::from(is_left != road.is_forward(lane));
            places.iter().filter_map(|place| Some(town.lane_edges(*place)?[side])).collect()
        };
        found[0].push(places.iter().map(|place| town.pose(*place).position()).collect());
        if road.junction.is_none() {
            found[1].extend([border(true), border(false)]);
        }
        for border in [border(true), border(false).into_iter().rev().collect()] {
            let parts = border.chunk_by(|from, to| is_edge(town, *from, *to));
            found[2].extend(parts.filter(|part| part.len() > 1).map(<[Point]>::to_vec));
        }
    }
    (0..).zip(found).flat_map(|(kind, lines)| lines.into_iter().map(move |line| (kind, thinned(line)))).collect()
}

/// Whether there is no driving lane 0.25 m to the left of a straight line.
fn is_edge(town: &Town, from: Point, to: Point) -> bool {
    let left = Vector::new(from.y - to.y, to.x - from.x).try_normalize(1e-9).unwrap_or_default();
    town.lane_around(from + (to - from) / 2.0 + left * 0.25).is_none_or(|lane| lane.inside < 0.0)
}

/// A polyline with fewer points, if it has over ten: passes over triples drop the middle of flat ones, until there are none.
fn thinned(mut points: Vec<Point>) -> Vec<Point> {
    let mut before = if points.len() > 10 { usize::MAX } else { points.len() };
    while points.len() < before {
        before = points.len();
        let (mut kept, mut at) = (vec![points[0]], 0);
        while let Some([a, b, c]) = points.get(at..at + 3) {
            let is_flat = (b - a).perp(&(c - a)).abs() < 0.2 && (c - a).norm_squared() <= 250.0;
            at += if is_flat { 2 } else { 1 };
            kept.push(points[at]);
        }
        kept.extend(&points[at + 1..]);
        points = kept;
    }
    points
}

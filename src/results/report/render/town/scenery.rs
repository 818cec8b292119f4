use base::choice;
use road::geometry::Point;
use road::{LaneKind, LaneSection, Road, RoadIndex, Town, Waypoint};

/// Least spacing of the points from which a lane's outline is made (m).
const STEP: f64 = 1.0;
/// About the most such points of a town, and the most of an edge.
const MAX_POINTS: (f64, f64) = (300_000.0, 4_000.0);
/// Width of a border on each of its lanes (m).
const MARKING: f64 = 0.08;
/// Largest distance between an outline and the lane's edge (m).
const TOLERANCE: f64 = 0.04;

choice! {
    /// The parts of a town that are visible from above, from the ground up, with their classes in a style sheet.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum Surface {
        /// A sidewalk, a shoulder: a lane that is not for driving.
        Walk = "walk",
        /// A lane for driving.
        Lane = "lane",
        /// The borders of a lane for driving.
        Marking = "marking",
        /// A crosswalk.
        Zebra = "zebra",
        /// Obstacles, which block pedestrians and sight.
        House = "house",
    }
}

/// A town from above: polygons, from the ground up.
#[derive(Debug, Clone, Default)]
pub struct Scenery {
    /// The kind of each, and its corners (m).
    pub polygons: Vec<(Surface, Vec<Point>)>,
}

impl Scenery {
    /// Outlines all surfaces of a town.
    pub fn new(town: &Town) -> Self {
        let mut polygons = Vec::new();
        let step = step(town);
        for surface in [Surface::Walk, Surface::Lane] {
            polygons.extend(lanes(town, surface).map(|lane| (surface, outline(town, lane, step))));
        }
        // Those of a junction cross each other.
        let on_roads = lanes(town, Surface::Lane).filter(|lane| lane.road.junction.is_none());
        polygons.extend(on_roads.flat_map(|lane| markings(town, lane, step)).map(|strip| (Surface::Marking, strip)));
        polygons.extend(town.crosswalks.iter().map(|corners| (Surface::Zebra, corners.to_vec())));
        polygons.extend(town.obstacles.iter().map(|each| (Surface::House, each.corners().to_vec())));
        Self { polygons }
    }

    /// The polygons that overlap an axis-parallel box between two corners.
    pub fn within(&self, low: Point, high: Point) -> Self {
        let overlaps = |corners: &[Point]| {
            let least = corners.iter().fold(Point::new(f64::MAX, f64::MAX), |a, b| a.inf(b));
            let most = corners.iter().fold(Point::new(f64::MIN, f64::MIN), |a, b| a.sup(b));
            least.x <= high.x && least.y <= high.y && most.x >= low.x && most.y >= low.y
        };
        Self { polygons: self.polygons.iter().filter(|(_, corners)| overlaps(corners)).cloned().collect() }
    }
}

/// A lane of one section of a road.
#[derive(Debug, Clone, Copy)]
pub struct SectionLane<'a> {
    pub road: &'a Road,
    pub section: &'a LaneSection,
    /// Where the lane starts, in the direction of the road's reference line.
    pub start: Waypoint,
    /// Its use.
    pub kind: LaneKind,
}

/// The lanes of a surface, road by road.
pub fn lanes(town: &Town, surface: Surface) -> impl Iterator<Item = SectionLane<'_>> {
    let wanted =
        move |kind: LaneKind| (kind == LaneKind::Driving) == (surface == Surface::Lane) && kind != LaneKind::None;
    town.roads.iter().zip(0..).flat_map(move |(road, index)| {
        road.sections.iter().zip(0..).flat_map(move |(section, number)| {
            section.lanes.iter().filter(move |lane| lane.id != 0 && wanted(lane.kind)).map(move |lane| SectionLane {
                road,
                section,
                start: Waypoint { road: RoadIndex(index), section: number, lane: lane.id, s: section.start },
                kind: lane.kind,
            })
        })
    })
}

impl SectionLane<'_> {
    /// Places on the lane, from the start of its section to the end, at most this far apart (m).
    pub fn places(&self, step: f64) -> impl Iterator<Item = Waypoint> + use<> {
        let (start, from, to) = (self.start, self.section.start, self.section.end);
        let steps = ((to - from) / step).ceil().clamp(1.0, MAX_POINTS.1);
        (0..=steps as u32).map(move |i| Waypoint { s: from + (to - from) * f64::from(i) / steps, ..start })
    }
}

/// The spacing of the points from which the lanes of a town are drawn (m).
pub fn step(town: &Town) -> f64 {
    let sections = town.roads.iter().flat_map(|road| &road.sections);
    let metres: f64 = sections.map(|section| (section.end - section.start) * section.lanes.len() as f64).sum();
    STEP.max(2.0 * metres / MAX_POINTS.0)
}

/// The corners of the borders of a lane.
fn markings(town: &Town, lane: SectionLane<'_>, step: f64) -> [Vec<Point>; 2] {
    let edges: Vec<[Point; 2]> = lane.places(step).filter_map(|place| town.lane_edges(place)).collect();
    [0, 1].map(|side| {
        let outer: Vec<Point> = edges.iter().map(|edge| edge[side]).collect();
        let kept = needed(&outer);
        let inner = |index: &usize| {
            let across = edges[*index][1 - side] - edges[*index][side];
            edges[*index][side] + across * (MARKING / across.norm().max(MARKING))
        };
        kept.iter().map(|index| outer[*index]).chain(kept.iter().rev().map(inner)).collect()
    })
}

/// The corners of a lane: its left edge forwards, its right edge backwards.
pub fn outline(town: &Town, lane: SectionLane<'_>, step: f64) -> Vec<Point> {
    let edges = lane.places(step).filter_map(|place| town.lane_edges(place));
    let (left, right): (Vec<Point>, Vec<Point>) = edges.map(|[left, right]| (left, right)).unzip();
    let mut corners = thinned(&left);
    corners.extend(thinned(&right).iter().rev());
    corners
}

/// The points of a line that are needed to keep its shape.
///
/// # Source
/// Douglas and Peucker, *Cartographica* 10, 1973.
fn thinned(line: &[Point]) -> Vec<Point> {
    needed(line).into_iter().map(|index| line[index]).collect()
}

/// The indices of the points that [`thinned`] keeps: the ends of a line that is not empty, and its bends.
pub fn needed(line: &[Point]) -> Vec<usize> {
    if line.is_empty() {
        return Vec::new();
    }
    let mut kept = vec![false; line.len()];
    let mut open = vec![(0, line.len() - 1)];
    while let Some((from, to)) = open.pop() {
        let chord = line[to] - line[from];
        let length = chord.norm();
        let off = |point: &Point| {
            let beside = point - line[from];
            if length > 1e-9 { (chord.perp(&beside) / length).abs() } else { beside.norm() }
        };
        let farthest = (from + 1..to).max_by(|a, b| off(&line[*a]).total_cmp(&off(&line[*b])));
        if let Some(middle) = farthest.filter(|middle| off(&line[*middle]) > TOLERANCE) {
            kept[middle] = true;
            open.extend([(from, middle), (middle, to)]);
        }
    }
    let last = line.len() - 1;
    let between = (1..last).filter(|index| kept[*index]);
    // A single point is both ends.
    std::iter::once(0).chain(between).chain([last]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_thinned_line_keeps_its_corners_and_its_bends() {
        let straight: Vec<Point> = (0..50).map(|x| Point::new(f64::from(x), 0.0)).collect();
        assert_eq!(thinned(&straight), [Point::new(0.0, 0.0), Point::new(49.0, 0.0)]);
        let arc: Vec<Point> = (0..=90)
            .map(|deg| f64::from(deg).to_radians())
            .map(|a| Point::new(libm::cos(a), libm::sin(a)) * 20.0)
            .collect();
        let thin = thinned(&arc);
        assert!((6..25).contains(&thin.len()), "{}", thin.len());
        for pair in thin.windows(2) {
            let middle = (pair[0].coords + pair[1].coords) / 2.0;
            assert!(20.0 - middle.norm() <= TOLERANCE + 1e-3);
        }
        assert!(thinned(&[]).is_empty());
    }
}

use crate::geometry::Point;
use crate::road::{LaneKind, Road, RoadIndex, Town, Waypoint};

/// Least spacing of the points from which a lane's outline is made (m).
const STEP: f64 = 1.0;
/// About the most such points of a town, and the most of an edge.
const MOST_POINTS: (f64, f64) = (300_000.0, 4_000.0);
/// Largest distance between an outline and the lane's edge (m).
const TOLERANCE: f64 = 0.04;

/// The parts of a town that are visible from above.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Surface {
    /// A sidewalk, a shoulder: a lane that is not for driving.
    Walk,
    /// A lane for driving.
    Lane,
    /// A crosswalk.
    Zebra,
    /// Obstacles, which block pedestrians and sight.
    House,
}

impl Surface {
    /// All of them, from the ground up.
    pub const ALL: [Self; 4] = [Self::Walk, Self::Lane, Self::Zebra, Self::House];

    /// Its class in a style sheet.
    pub fn class(self) -> &'static str {
        match self {
            Self::Walk => "walk",
            Self::Lane => "lane",
            Self::Zebra => "zebra",
            Self::House => "house",
        }
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
        let sections = town.roads.iter().flat_map(|road| &road.sections);
        let metres: f64 = sections.map(|section| (section.end - section.start) * section.lanes.len() as f64).sum();
        let step = STEP.max(2.0 * metres / MOST_POINTS.0);
        for surface in [Surface::Walk, Surface::Lane] {
            for (road, index) in town.roads.iter().zip(0..) {
                outline(&mut polygons, town, (RoadIndex(index), road), step, surface);
            }
        }
        polygons.extend(town.crosswalks.iter().map(|corners| (Surface::Zebra, corners.clone())));
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

fn outline(
    polygons: &mut Vec<(Surface, Vec<Point>)>,
    town: &Town,
    (index, road): (RoadIndex, &Road),
    step: f64,
    surface: Surface,
) {
    let wanted = |kind: LaneKind| (kind == LaneKind::Driving) == (surface == Surface::Lane) && kind != LaneKind::None;
    for (section, number) in road.sections.iter().zip(0..) {
        let steps = ((section.end - section.start) / step).ceil().clamp(1.0, MOST_POINTS.1);
        for lane in section.lanes.iter().filter(|lane| lane.id != 0 && wanted(lane.kind)) {
            let places = (0..=steps as u32).filter_map(|i| {
                let s = section.start + (section.end - section.start) * f64::from(i) / steps;
                town.lane_edges(Waypoint { road: index, section: number, lane: lane.id, s })
            });
            let (left, right): (Vec<Point>, Vec<Point>) = places.map(|[left, right]| (left, right)).unzip();
            let mut corners = thinned(&left);
            corners.extend(thinned(&right).iter().rev());
            polygons.push((surface, corners));
        }
    }
}

/// The points of a line that are needed to keep its shape.
///
/// # Source
/// Douglas and Peucker, *Cartographica* 10, 1973.
fn thinned(line: &[Point]) -> Vec<Point> {
    let (Some(first), Some(last)) = (line.first(), line.last()) else { return Vec::new() };
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
    let between = line.iter().zip(&kept).filter(|(_, kept)| **kept).map(|(point, _)| *point);
    let mut points = vec![*first];
    points.extend(between);
    points.push(*last);
    points
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

//! An index over chords as seen from above that is quick to build.

use rstar::primitives::{GeomWithData, Line};
use rstar::{PointDistance, RTree};

use super::chord::Chord;
use crate::geometry::Point;

type Leaf = GeomWithData<Line<[f64; 2]>, u32>;

/// A chord is checked exactly when the tree puts it at most this much farther than the nearest one (m).
const SLACK: f64 = 1e-6;

pub(super) struct ChordTree(RTree<Leaf>);

impl ChordTree {
    /// Indexes the chords of a list.
    pub fn new(chords: &[Chord]) -> Self {
        let leaf = |(chord, index): (&Chord, u32)| {
            let to = chord.end();
            Leaf::new(Line::new([chord.from.x, chord.from.y], [to.x, to.y]), index)
        };
        Self(RTree::bulk_load(chords.iter().zip(0..).map(leaf).collect()))
    }

    /// Opposite corners of the smallest upright rectangle around all of them; `None` without chords.
    pub fn around(&self) -> Option<(Point, Point)> {
        (self.0.size() > 0).then(|| {
            let around = self.0.root().envelope();
            (Point::from(around.lower()), Point::from(around.upper()))
        })
    }

    /// How far the nearest of them is (m); `None` without chords.
    pub fn distance(&self, point: Point) -> Option<f64> {
        let point = [point.x, point.y];
        self.0.nearest_neighbor(point).map(|leaf| leaf.distance_2(&point).sqrt())
    }

    /// Those within a distance (m), in no order.
    pub fn within(&self, point: Point, reach: f64) -> impl Iterator<Item = u32> {
        self.0.locate_within_distance([point.x, point.y], reach * reach).map(|leaf| leaf.data)
    }

    /// The nearest of the chords, by its place in the list; of two equally near the first one.
    pub fn nearest(&self, chords: &[Chord], point: Point) -> Option<u32> {
        let reach = self.distance(point)? + SLACK;
        first_nearest(chords, self.within(point, reach), point)
    }
}

/// The nearest of some chords, given by their places in the list; of two equally near the first one in the list.
pub(super) fn first_nearest(chords: &[Chord], some: impl Iterator<Item = u32>, point: Point) -> Option<u32> {
    let distances = some.map(|index| (chords[index as usize].distance_squared(point), index));
    distances.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))).map(|(_, index)| index)
}

use road::geometry::{Point, Pose, Vector, wrap_angle};

/// A position relative to a path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// Distance along the path (m).
    pub along: f64,
    /// Distance to the left of the path (m).
    pub aside: f64,
    /// The direction of the path there, of length 1.
    pub direction: Vector,
}

/// The minimum number of vertices between those that are looked at first.
const MIN_STRIDE: usize = 16;
/// Lengths and distances are exact to this (m).
const ROUNDING: f64 = 1e-6;

/// The path of the middle of a car, with its heading. It continues straight beyond its end.
#[derive(Debug, Clone, PartialEq)]
pub struct DrivenPath {
    vertices: Vec<(f64, Pose)>,
}

impl DrivenPath {
    /// Makes a path through the poses, in order; repeated poses of a standing car count once.
    ///
    /// # Panics
    /// Without any pose.
    pub fn new(poses: impl IntoIterator<Item = Pose>) -> Self {
        let mut vertices: Vec<(f64, Pose)> = Vec::new();
        for pose in poses {
            match vertices.last() {
                None => vertices.push((0.0, pose)),
                Some((along, last)) => {
                    let step = (pose.position() - last.position()).norm();
                    if step > 1e-9 {
                        vertices.push((along + step, pose));
                    }
                }
            }
        }
        assert!(!vertices.is_empty(), "a path has a start");
        Self { vertices }
    }

    /// The pose of a car at a length along the path (m), which drives on from one call to the next: `passed` is the number of vertices that it has
    /// passed, 0 at first.
    pub fn pose(&self, along: f64, passed: &mut usize) -> Pose {
        *passed += self.vertices[*passed..].iter().take_while(|(at, _)| *at <= along).count();
        let next = *passed;
        let (before, pose) = self.vertices[next.max(1) - 1];
        let past = (along - before).max(0.0);
        let Some((after, end)) = self.vertices.get(next.max(1)) else {
            let place = pose.position() + pose.forward() * past;
            return Pose { x: place.x, y: place.y, yaw: pose.yaw };
        };
        let share = past / (after - before);
        let mix = |a: f64, b: f64| a + (b - a) * share;
        Pose::new(mix(pose.x, end.x), mix(pose.y, end.y), pose.yaw + wrap_angle(end.yaw - pose.yaw) * share)
    }

    /// The place on the path nearest to a point, from the length `from` (m) onwards. A point behind `from` is measured from the straight
    /// line backwards.
    pub fn place(&self, point: Point, from: f64) -> Place {
        let first = self.vertices.partition_point(|(at, _)| *at <= from).max(1) - 1;
        let vertices = &self.vertices[first..];
        let apart = |(_, pose): &(f64, Pose)| (point - pose.position()).norm_squared();
        let sampled = vertices.iter().step_by(MIN_STRIDE.max(vertices.len().isqrt()));
        let mut least = sampled.map(apart).fold(f64::INFINITY, f64::min);
        let mut nearest = (f64::INFINITY, first);
        let mut place = 0;
        while let Some(vertex) = vertices.get(place) {
            let apart = apart(vertex);
            if apart < nearest.0 {
                nearest = (apart, first + place);
                least = least.min(apart);
            }
            // No vertex before this length is as near as the nearest one: the way there is too short.
            let next = vertex.0 + apart.sqrt() - least.sqrt() - ROUNDING;
            place += 1;
            if vertices.get(place).is_some_and(|(at, _)| *at < next) {
                place += vertices[place..].partition_point(|(at, _)| *at < next);
            }
        }
        // One of the two segments that meet there is the nearest.
        let index = nearest.1;
        let ahead = self.seen_from(index, point);
        if index == first || ahead.along >= self.vertices[index].0 {
            return ahead;
        }
        self.seen_from(index - 1, point)
    }

    /// A point relative to the segment of the path that starts at a vertex, extended at both ends.
    fn seen_from(&self, index: usize, point: Point) -> Place {
        let (along, pose) = self.vertices[index];
        let start = pose.position();
        let direction = match self.vertices.get(index + 1) {
            Some((next, end)) => (end.position() - start) / (next - along),
            None => pose.forward(),
        };
        let offset = point - start;
        Place { along: along + offset.dot(&direction), aside: direction.perp(&offset), direction }
    }
}

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

/// The numbers of vertices in a part of the path and in a part of a part, whose bounds tell which vertices are near.
const PARTS: [usize; 2] = [1024, 32];

/// The path of the middle of a car, with its heading. It continues straight beyond its end.
#[derive(Debug, Clone, PartialEq)]
pub struct DrivenPath {
    pub(super) vertices: Vec<(f64, Pose)>,
    /// The bounds of the parts of each size.
    bounds: [Vec<Bounds>; 2],
}

/// The least and the greatest coordinates of some vertices.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Bounds {
    low: Point,
    high: Point,
}

impl Bounds {
    fn of(vertices: &[(f64, Pose)]) -> Self {
        let mut points = vertices.iter().map(|(_, pose)| pose.position());
        let first = points.next().expect("a part has a vertex");
        points.fold(Self { low: first, high: first }, |all, point| Self {
            low: all.low.inf(&point),
            high: all.high.sup(&point),
        })
    }

    /// The square of the distance to a point (m²); 0 within.
    fn apart(&self, point: Point) -> f64 {
        (self.low - point).sup(&(point - self.high)).sup(&Vector::zeros()).norm_squared()
    }
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
        let bounds = PARTS.map(|size| vertices.chunks(size).map(Bounds::of).collect());
        Self { vertices, bounds }
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
        let index = self.nearest_vertex(point, first);
        // One of the two segments that meet there is the nearest.
        let ahead = self.seen_from(index, point);
        if index == first || ahead.along >= self.vertices[index].0 {
            return ahead;
        }
        self.seen_from(index - 1, point)
    }

    /// The vertex nearest to a point, from the vertex `first` onwards; the first of equally near ones.
    pub(super) fn nearest_vertex(&self, point: Point, first: usize) -> usize {
        let apart = |index: usize| (point - self.vertices[index].1.position()).norm_squared();
        let [parts, small_parts] = &self.bounds;
        let parts = (first / PARTS[0]..parts.len()).map(|part| (parts[part].apart(point), part));
        let nearest_part = parts.clone().min_by(|one, other| one.0.total_cmp(&other.0)).map_or(0, |(_, part)| part);
        // A vertex of the nearest part: no other one is looked at whose part is farther.
        let sample = (nearest_part * PARTS[0]..self.vertices.len()).take(PARTS[0]).step_by(PARTS[1]);
        let mut least = sample.map(|index| apart(index.max(first))).fold(f64::INFINITY, f64::min);
        let mut nearest = (f64::INFINITY, first);
        for (bound, part) in parts {
            if bound > least {
                continue;
            }
            let each = PARTS[0] / PARTS[1];
            for (small, bounds) in small_parts.iter().enumerate().skip(part * each).take(each) {
                if bounds.apart(point) > least {
                    continue;
                }
                let end = ((small + 1) * PARTS[1]).min(self.vertices.len());
                for index in (small * PARTS[1]).max(first)..end {
                    let apart = apart(index);
                    if apart < nearest.0 {
                        nearest = (apart, index);
                        least = least.min(apart);
                    }
                }
            }
        }
        nearest.1
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

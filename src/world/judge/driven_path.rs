use crate::geometry::{Point, Pose, Vector, wrap_angle};

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

/// Number of vertices in a block that is skipped as a whole.
const BLOCK: usize = 16;
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
        let apart = |(_, pose): &(f64, Pose)| (point - pose.position()).norm_squared();
        let blocks = || self.vertices[first..].chunks(BLOCK);
        let bound = blocks().map(|block| apart(&block[0])).fold(f64::INFINITY, f64::min).sqrt() + ROUNDING;
        let mut nearest = (f64::INFINITY, first);
        for (number, block) in blocks().enumerate() {
            // No point of a block is nearer than its first vertex less the block's length.
            let reach = bound + block[block.len() - 1].0 - block[0].0;
            if apart(&block[0]) > reach * reach {
                continue;
            }
            for (place, vertex) in block.iter().enumerate() {
                let apart = apart(vertex);
                if apart < nearest.0 {
                    nearest = (apart, first + number * BLOCK + place);
                }
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

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    /// A quarter circle of 20 m to the left, in steps of half a degree; the car stands for a while in its middle.
    fn bend() -> DrivenPath {
        let angles = (0..=180).flat_map(|i| std::iter::repeat_n(i, if i == 90 { 5 } else { 1 }));
        DrivenPath::new(angles.map(|i| {
            let yaw = FRAC_PI_2 * f64::from(i) / 180.0;
            Pose::new(20.0 * libm::sin(yaw), 20.0 * (1.0 - libm::cos(yaw)), yaw)
        }))
    }

    fn length(path: &DrivenPath) -> f64 {
        path.vertices.last().unwrap().0
    }

    #[test]
    fn places_and_poses_are_inverse_in_a_bend_and_beyond_it() {
        let path = bend();
        assert!((length(&path) - 10.0 * std::f64::consts::PI).abs() < 1e-3);
        for along in [0.0, 3.3, 15.0, 31.0, 40.0] {
            let pose = path.pose(along, &mut 0);
            for aside in [-4.0, 0.0, 3.0] {
                let place = path.place(pose.to_world(Vector::new(0.0, aside)), 0.0);
                assert!((place.along - along).abs() < 0.05 && (place.aside - aside).abs() < 0.01, "{along} {place:?}");
                assert!((place.direction - pose.forward()).norm() < 0.01);
            }
        }
    }

    #[test]
    fn the_nearest_vertex_is_found_without_looking_at_all() {
        let path = bend();
        for (x, y) in [(-5.0, 3.0), (0.0, 20.0), (3.0, 17.0), (20.0, 5.0), (21.0, 40.0), (14.0, 6.0), (500.0, -300.0)] {
            let point = Point::new(x, y);
            let distances = path.vertices.iter().map(|(_, pose)| (point - pose.position()).norm());
            let least = distances.fold(f64::INFINITY, f64::min);
            let place = path.place(point, 0.0);
            let inside = (0.0..=length(&path)).contains(&place.along);
            assert!(!inside || (place.aside.abs() - least).abs() < 0.02, "{point}: {place:?}, {least} m");
        }
    }

    #[test]
    fn a_car_that_stood_has_a_straight_path() {
        let path = DrivenPath::new([Pose::new(1.0, 2.0, FRAC_PI_2); 3]);
        assert_eq!(length(&path), 0.0);
        assert!((path.pose(5.0, &mut 0).y - 7.0).abs() < 1e-12);
        assert!((path.place(Point::new(0.0, 6.0), 0.0).aside - 1.0).abs() < 1e-12);
        assert!((path.place(Point::new(0.0, -1.0), 0.0).along + 3.0).abs() < 1e-12, "behind");
    }
}

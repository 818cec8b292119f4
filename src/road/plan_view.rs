use super::Profile;
use super::curve_table::CurveTable;
use super::spiral::{integral, spiral};
use crate::geometry::{Point, Pose, Vector, wrap_angle};

/// A piece of a reference line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Geometry {
    /// Where it starts along the road (m).
    pub s: f64,
    /// Where it starts in the world, and its heading there.
    pub start: Pose,
    /// Its length (m).
    pub length: f64,
    /// Its form.
    pub shape: Shape,
    direction: Vector,
    /// The heading in the file, not wrapped.
    heading: f64,
}

/// The form of a piece of a reference line.
///
/// # Source
/// OpenDRIVE 1.4, section 5.3.4. Coefficients are in the order a, b, c, d.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shape {
    /// Straight.
    Line,
    /// Part of a circle; a positive curvature (1/m) bends to the left.
    Arc(f64),
    /// An Euler spiral: the curvature changes linearly from the first value to the second (1/m).
    Spiral(f64, f64),
    /// A cubic of the distance straight ahead; positions are by arc length.
    Poly3([f64; 4]),
    /// Two cubics of a parameter, ahead and to the left; positions are by arc length.
    ParamPoly3 {
        /// Ahead (m).
        u: [f64; 4],
        /// To the left (m).
        v: [f64; 4],
        /// Whether the parameter goes from 0 to 1 instead of to the piece's length.
        normalized: bool,
    },
}

/// A point of a curve with its direction, both as an angle and as a unit vector, so that neither is computed from the other again.
#[derive(Debug, Clone, Copy)]
pub(super) struct CurvePoint {
    pub position: Point,
    pub forward: Vector,
    /// Not wrapped.
    pub yaw: f64,
}

impl CurvePoint {
    /// The point at a lateral distance, positive to the left (m).
    pub fn beside(&self, t: f64) -> Point {
        Point::new(self.position.x - self.forward.y * t, self.position.y + self.forward.x * t)
    }

    /// The heading of a lane whose centre moves sideways with a slope.
    ///
    /// # Source
    /// CARLA `road/Lane.cpp`, `ComputeTransform`: the slope is added as if it were the angle. For a slope m beside a line of curvature κ
    /// the exact angle is atan(m / (1 − κ t)), so the difference is at most |m|³/3 beside a straight line.
    pub fn lane_heading(&self, forward: bool, slope: f64) -> f64 {
        wrap_angle(if forward { self.yaw + slope } else { self.yaw + slope + std::f64::consts::PI })
    }
}

impl Geometry {
    /// A straight piece.
    pub fn line(s: f64, start: Pose, length: f64) -> Self {
        Self::new(s, start, length, Shape::Line)
    }

    /// A part of a circle; a positive curvature (1/m) bends to the left.
    pub fn arc(s: f64, start: Pose, length: f64, curvature: f64) -> Self {
        Self::new(s, start, length, Shape::Arc(curvature))
    }

    /// A piece of any form.
    pub fn new(s: f64, start: Pose, length: f64, shape: Shape) -> Self {
        Self { s, start, length, shape, direction: start.forward(), heading: start.yaw }
    }

    /// The same piece with a start heading that is not wrapped, so that CARLA's rounding of it can be repeated.
    pub(super) fn with_heading(self, heading: f64) -> Self {
        Self { heading, ..self }
    }

    /// The pose `ds` (m) after its start.
    pub fn pose(&self, ds: f64) -> Pose {
        let point = self.point(ds);
        Pose { x: point.position.x, y: point.position.y, yaw: wrap_angle(point.yaw) }
    }

    /// The point `ds` (m) after its start.
    pub(super) fn point(&self, ds: f64) -> CurvePoint {
        match self.shape {
            Shape::Line => self.straight(ds),
            Shape::Arc(curvature) if curvature.abs() < 1e-12 => self.straight(ds),
            Shape::Arc(curvature) => {
                let turn = curvature * ds;
                let (sin, cos) = libm::sincos(turn);
                self.placed(Vector::new(sin / curvature, (1.0 - cos) / curvature), Vector::new(cos, sin), turn)
            }
            Shape::Spiral(first, last) => {
                let (local, turn) = spiral(first, (last - first) / self.length.max(f64::MIN_POSITIVE), ds);
                let (sin, cos) = libm::sincos(turn);
                self.placed(local, Vector::new(cos, sin), turn)
            }
            Shape::Poly3(cubic) => {
                let u = parameter(ds, 1.0, self.length, |u| Vector::new(1.0, slope(cubic, u)).norm());
                self.along(Vector::new(u, value(cubic, u)), Vector::new(1.0, slope(cubic, u)))
            }
            Shape::ParamPoly3 { u, v, normalized } => {
                let range = if normalized { 1.0 } else { self.length };
                let p = parameter(ds, range / self.length, range, |p| Vector::new(slope(u, p), slope(v, p)).norm());
                self.along(Vector::new(value(u, p), value(v, p)), Vector::new(slope(u, p), slope(v, p)))
            }
        }
    }

    fn straight(&self, ds: f64) -> CurvePoint {
        let position = Point::new(self.start.x + self.direction.x * ds, self.start.y + self.direction.y * ds);
        CurvePoint { position, forward: self.direction, yaw: self.heading }
    }

    fn along(&self, local: Vector, tangent: Vector) -> CurvePoint {
        let speed = tangent.norm();
        let forward = if speed > 1e-12 { tangent / speed } else { Vector::new(1.0, 0.0) };
        self.placed(local, forward, libm::atan2(forward.y, forward.x))
    }

    fn table(&self) -> Option<CurveTable> {
        match self.shape {
            Shape::Poly3(cubic) => {
                let curve = |u| (Vector::new(u, value(cubic, u)), Vector::new(1.0, slope(cubic, u)));
                Some(CurveTable::ahead(self.length, curve))
            }
            Shape::ParamPoly3 { u, v, normalized } => {
                let curve = |p| (Vector::new(value(u, p), value(v, p)), Vector::new(slope(u, p), slope(v, p)));
                Some(CurveTable::new(self.length, if normalized { 1.0 } else { self.length }, curve))
            }
            Shape::Line | Shape::Arc(_) | Shape::Spiral(..) => None,
        }
    }

    fn placed(&self, local: Vector, forward: Vector, turn: f64) -> CurvePoint {
        let (cos, sin) = (self.direction.x, self.direction.y);
        let turned = |v: Vector| Vector::new(cos * v.x - sin * v.y, sin * v.x + cos * v.y);
        CurvePoint {
            position: self.start.position() + turned(local),
            forward: turned(forward),
            yaw: self.heading + turn,
        }
    }
}

fn value([a, b, c, d]: [f64; 4], x: f64) -> f64 {
    a + x * (b + x * (c + x * d))
}

fn slope([_, b, c, d]: [f64; 4], x: f64) -> f64 {
    b + x * (2.0 * c + x * 3.0 * d)
}

/// The parameter at which a curve is `ds` (m) long, given its speed over the parameter; `share` is the first guess per metre.
///
/// # Source
/// CARLA `road/element/Geometry.cpp` also uses the length of the curve, whatever `pRange` says.
fn parameter(ds: f64, share: f64, range: f64, speed: impl Fn(f64) -> f64) -> f64 {
    let mut p = ds * share;
    for _ in 0..12 {
        let rate = speed(p);
        if rate <= 1e-9 || rate.is_nan() {
            break;
        }
        let step = (integral(p, &speed) - ds) / rate;
        // A curve may be a little shorter than the file says; then it continues beyond its end.
        p = (p - step).max(0.0).min(1.1 * range);
        if step.abs() * rate < 1e-9 {
            break;
        }
    }
    p
}

/// The reference line of a road: a curve in the plane, and its height.
///
/// Pieces of form [`Shape::Poly3`] and [`Shape::ParamPoly3`] are drawn as CARLA draws them, with straight lines between places
/// less than half a metre apart. They are a few millimetres off the exact curve of [`Geometry::pose`]. If the file's lengths
/// leave a gap after such a piece, it continues straight on; other pieces are clamped at their ends.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PlanView {
    pieces: Vec<Geometry>,
    tables: Vec<Option<CurveTable>>,
    elevation: Profile,
}

impl PlanView {
    /// Puts pieces in order.
    pub fn new(mut pieces: Vec<Geometry>) -> Self {
        pieces.sort_by(|a, b| a.s.total_cmp(&b.s));
        let tables = pieces.iter().map(Geometry::table).collect();
        Self { pieces, tables, elevation: Profile::default() }
    }

    /// The same line at a height (m) over the distance along it, for the whole width of the road.
    pub fn with_elevation(self, elevation: Profile) -> Self {
        Self { elevation, ..self }
    }

    /// Its height (m); an empty profile is level at 0.
    pub fn elevation(&self) -> &Profile {
        &self.elevation
    }

    pub fn pieces(&self) -> &[Geometry] {
        &self.pieces
    }

    /// The pose at `s` (m), clamped at both ends.
    pub fn pose(&self, s: f64) -> Pose {
        let point = self.point(s);
        Pose { x: point.position.x, y: point.position.y, yaw: wrap_angle(point.yaw) }
    }

    fn index_at(&self, s: f64) -> usize {
        self.pieces.partition_point(|piece| piece.s <= s).saturating_sub(1)
    }

    /// The piece that contains `s` (m).
    pub fn piece_at(&self, s: f64) -> Option<&Geometry> {
        self.pieces.get(self.index_at(s))
    }

    /// The point at `s` (m), clamped at both ends.
    pub(super) fn point(&self, s: f64) -> CurvePoint {
        let index = self.index_at(s);
        let Some(piece) = self.pieces.get(index) else {
            return CurvePoint { position: Point::origin(), forward: Vector::new(1.0, 0.0), yaw: 0.0 };
        };
        let ds = (s - piece.s).max(0.0);
        match &self.tables[index] {
            None => piece.point(ds.min(piece.length)),
            Some(table) => {
                let (local, tangent) = table.at(ds);
                piece.along(local, tangent)
            }
        }
    }
}

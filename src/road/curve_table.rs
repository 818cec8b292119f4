//! Cubic curves as CARLA draws them: a table of places less than half a metre apart, and straight lines between.

use crate::geometry::Vector;

/// The distance between two places of a curve over a parameter (m).
const INTERVAL: f64 = 0.5;
/// How many intervals such a table has at least and at most.
const INTERVALS: (f64, f64) = (5.0, 20_000.0);
/// The step straight ahead between two places of a cubic (m).
const STEP_AHEAD: f64 = 0.3;

/// A place of the table.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Entry {
    distance: f64,
    place: Vector,
    tangent: Vector,
}

/// The places of a curve over its length.
///
/// # Source
/// CARLA `road/element/Geometry.cpp`, `PreComputeSpline` of `GeometryParamPoly3` and `GeometryPoly3`.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct CurveTable {
    entries: Vec<Entry>,
}

impl CurveTable {
    /// Tabulates a curve, given its place and tangent over a parameter from 0 to `range`.
    pub fn new(length: f64, range: f64, curve: impl Fn(f64) -> (Vector, Vector)) -> Self {
        let count = (length / INTERVAL).floor().clamp(INTERVALS.0, INTERVALS.1);
        let mut table = Self { entries: Vec::with_capacity(count as usize + 1) };
        (0..=count as u32).for_each(|index| table.push(curve(range * f64::from(index) / count)));
        table
    }

    /// Tabulates a curve, given its place and tangent over the distance straight ahead, until it is long enough.
    pub fn ahead(length: f64, curve: impl Fn(f64) -> (Vector, Vector)) -> Self {
        let step = STEP_AHEAD.max(length / INTERVALS.1);
        let mut table = Self { entries: Vec::new() };
        table.push(curve(0.0));
        let mut index = 0_u32;
        while index == 0 || table.entries[index as usize].distance < length + step {
            index += 1;
            table.push(curve(step * f64::from(index)));
        }
        table
    }

    fn push(&mut self, (place, tangent): (Vector, Vector)) {
        let distance = self.entries.last().map_or(0.0, |last| last.distance + (place - last.place).norm());
        self.entries.push(Entry { distance, place, tangent });
    }

    /// The place and the tangent at a distance (m); beyond the end it goes straight on.
    pub fn at(&self, distance: f64) -> (Vector, Vector) {
        // The entries are almost evenly spaced, so the first guess is hardly ever more than one off.
        let last = self.entries.len() - 2;
        let whole = self.entries[last + 1].distance;
        let mut index = ((distance / whole * (last + 1) as f64).max(0.0) as usize).min(last);
        while index > 0 && self.entries[index].distance > distance {
            index -= 1;
        }
        while index < last && self.entries[index + 1].distance < distance {
            index += 1;
        }
        let (from, to) = (self.entries[index], self.entries[index + 1]);
        let step = to.distance - from.distance;
        let share = if step > 0.0 { (distance - from.distance) / step } else { 0.0 };
        (from.place + (to.place - from.place) * share, from.tangent + (to.tangent - from.tangent) * share)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_circle_is_followed_to_a_few_millimetres() {
        let radius = 10.0;
        let circle = |p: f64| {
            let (sin, cos) = libm::sincos(p / radius);
            (Vector::new(radius * sin, radius * (1.0 - cos)), Vector::new(cos, sin))
        };
        let table = CurveTable::new(12.0, 12.0, circle);
        for distance in [0.0, 0.2, 5.7, 11.9] {
            let ((place, tangent), (exact, along)) = (table.at(distance), circle(distance));
            assert!((place - exact).norm() < 5e-3, "{place} {exact}");
            assert!((tangent.normalize() - along).norm() < 1e-3);
        }
    }

    #[test]
    fn a_slanted_line_is_followed_by_its_length() {
        let table = CurveTable::ahead(10.0, |u| (Vector::new(u, 0.75 * u), Vector::new(1.0, 0.75)));
        for distance in [0.0, 1.0, 9.99] {
            assert!((table.at(distance).0 - Vector::new(0.8, 0.6) * distance).norm() < 1e-12);
        }
    }

    #[test]
    fn a_curve_without_length_stays_where_it_is() {
        let table = CurveTable::new(3.0, 1.0, |_| (Vector::new(1.0, 2.0), Vector::zeros()));
        assert_eq!(table.at(2.0).0, Vector::new(1.0, 2.0));
    }
}

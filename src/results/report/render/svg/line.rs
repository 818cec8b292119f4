use std::fmt::Write;

use super::Digits;

/// The `d` of a path through points; each number has this number of digits after the point.
pub fn line(points: impl IntoIterator<Item = (f64, f64)>, digits: usize) -> String {
    let mut path = String::new();
    for (place, (x, y)) in points.into_iter().enumerate() {
        let _ = write!(path, "{}{} {}", if place == 0 { 'M' } else { 'L' }, Digits(x, digits), Digits(y, digits));
    }
    path
}

/// The same, closed.
pub fn outline(points: impl IntoIterator<Item = (f64, f64)>, digits: usize) -> String {
    line(points, digits) + "Z"
}

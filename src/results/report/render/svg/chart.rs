use maud::html;

use super::{Digits, Panel, line, px};

/// A curve of a chart.
#[derive(Debug, Clone, Default)]
pub struct Curve {
    pub colour: usize,
    /// Whether it is one of several that a thicker curve summarises.
    pub thin: bool,
    pub points: Vec<(f64, f64)>,
    /// Low and high ends of a band around it, at the points' abscissas; empty without one.
    pub band: Vec<(f64, f64)>,
}

/// A chart: the ranges of its axes, and the format of their numbers.
#[derive(Debug, Clone)]
pub struct Chart {
    /// Width and height.
    pub size: (f64, f64),
    /// The range of the horizontal axis.
    pub x: (f64, f64),
    /// The range of the vertical axis.
    pub y: (f64, f64),
    /// The name of the horizontal axis.
    pub x_label: String,
    /// Formats a number of the vertical axis.
    pub y_text: fn(f64) -> String,
    /// Formats a number of the horizontal axis.
    pub x_text: fn(f64) -> String,
}

/// The space for the axes: left, right, top, bottom.
const ROOM: (f64, f64, f64, f64) = (40.0, 14.0, 6.0, 34.0);

impl Chart {
    /// Width and height of one of several charts.
    pub const SMALL: (f64, f64) = (286.0, 176.0);

    fn place(&self, (x, y): (f64, f64)) -> (f64, f64) {
        let share = |value: f64, (low, high): (f64, f64)| (value - low) / (high - low).max(1e-12);
        let (width, height) = (self.size.0 - ROOM.0 - ROOM.1, self.size.1 - ROOM.2 - ROOM.3);
        (ROOM.0 + share(x, self.x) * width, ROOM.2 + (1.0 - share(y, self.y)) * height)
    }

    /// Draws the curves, the last on top.
    pub fn panel(&self, title: String, says: String, curves: &[Curve]) -> Panel {
        let (right, floor) = (self.size.0 - ROOM.1, self.size.1 - ROOM.3);
        let body = html! {
            @for y in ticks(self.y, 4) {
                @let (left, at) = self.place((self.x.0, y));
                path.grid d={ "M" (px(left)) " " (px(at)) "H" (px(right)) } {}
                text.muted.end x=(px(left - 6.0)) y=(px(at + 3.6)) { ((self.y_text)(y)) }
            }
            @for x in ticks(self.x, 4) {
                @let at = px(self.place((x, 0.0)).0);
                path.axis d={ "M" (at) " " (px(floor)) "v4" } {}
                text.muted.middle x=(at) y=(px(floor + 15.0)) { ((self.x_text)(x)) }
            }
            path.axis d={ "M" (ROOM.0) " " (px(floor)) "H" (px(right)) } {}
            text.muted.end x=(px(right)) y=(px(self.size.1 - 4.0)) { (self.x_label) }
            @for curve in curves.iter().filter(|curve| !curve.band.is_empty()) {
                @let upper = curve.points.iter().zip(&curve.band).map(|(point, band)| (point.0, band.1));
                @let lower = curve.points.iter().zip(&curve.band).rev().map(|(point, band)| (point.0, band.0));
                path class={ "band f" (curve.colour) } d={ (self.path(upper.chain(lower))) "Z" } {}
            }
            @for curve in curves {
                path class={ "line s" (curve.colour) @if curve.thin { " thin" } } d=(self.path(curve.points.iter().copied())) {}
            }
        };
        Panel { title, says, size: self.size, body }
    }

    /// A path through points, which the chart clips above and below.
    fn path(&self, points: impl Iterator<Item = (f64, f64)>) -> String {
        line(points.map(|(x, y)| self.place((x, y.clamp(self.y.0, self.y.1)))), 1)
    }
}

/// Round numbers within a range, about `about` of them.
pub fn ticks((low, high): (f64, f64), about: u32) -> Vec<f64> {
    let rough = (high - low) / f64::from(about);
    if !rough.is_finite() || rough <= 0.0 {
        return vec![low];
    }
    let power = libm::pow(10.0, libm::log10(rough).floor());
    let step = [1.0, 2.0, 2.5, 5.0, 10.0].map(|each| each * power).into_iter().find(|step| *step >= rough * 0.999);
    let step = step.unwrap_or(10.0 * power);
    let first = (low / step - 1e-9).ceil() as i64;
    let last = (high / step + 1e-9).floor() as i64;
    (first..=last).map(|number| number as f64 * step).collect()
}

/// A round number without unnecessary digits.
pub fn short(number: f64) -> String {
    Digits(number, 2).to_string().replace('-', "−")
}

/// Thousands as `20k`.
pub fn thousands(number: f64) -> String {
    match number.abs() {
        n if n >= 1e6 => format!("{}M", short(number / 1e6)),
        n if n >= 1e3 => format!("{}k", short(number / 1e3)),
        _ => short(number),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_within() {
        assert_eq!(ticks((0.0, 1.0), 4), [0.0, 0.25, 0.5, 0.75, 1.0]);
        assert_eq!(ticks((-3.0, 9.0), 4), [0.0, 5.0]);
        assert_eq!(ticks((0.0, 71_680.0), 4), [0.0, 20_000.0, 40_000.0, 60_000.0]);
        assert_eq!(ticks((2.0, 2.0), 4), [2.0]);
        assert_eq!([0.0, -0.001, 0.25, 12.0, -3.5].map(short), ["0", "0", "0.25", "12", "−3.5"]);
        assert_eq!([900.0, 20_000.0, 1_500_000.0].map(thousands), ["900", "20k", "1.5M"]);
    }
}

//! Drivers on a picture: faults against progress.

use crate::report::price::DriverPrice;
use crate::report::render::svg::{Chart, Curve, Figure, short};
use crate::report::{DriverResult, Findings, Rate};
use crate::tables::Metric;

/// The places of the legend's colours; a driver beyond them has the last one.
const COLOURS: usize = 6;
/// The size of the picture.
const SIZE: (f64, f64) = (338.0, 210.0);

/// Half of the mark of a driver, as a share of an axis.
const MARK: f64 = 0.018;

/// The drivers by their progress and their rate of faults in their worst cell; `None` below two that have both.
pub fn front(found: &Findings<'_>, faults: &Metric) -> Option<Figure> {
    let point = |result: &DriverResult| {
        let cell = &found.cells[result.cell?];
        let rate = cell.rate(faults);
        (!cell.is_fixed_cases()).then_some((result.driver.name.clone(), result.price?, rate.value?, rate))
    };
    let drivers: Vec<_> = found.drivers.iter().filter_map(point).collect();
    if drivers.len() < 2 {
        return None;
    }
    let high = |rate: &Rate| rate.interval.map_or(0.0, |(_, high)| high);
    let most = drivers.iter().fold(0.01, |most: f64, (.., value, rate)| most.max(*value).max(high(rate)));
    let fastest = drivers
        .iter()
        .fold(1.0, |most: f64, (_, price, ..)| most.max(price.ends().map_or(price.progress, |(_, high)| high)));
    let best = Curve {
        colour: COLOURS,
        thin: true,
        points: best(drivers.iter().map(|(_, price, value, _)| (price.progress, *value)).collect()),
        ..Curve::default()
    };
    let curves: Vec<Curve> = std::iter::once(best)
        .chain(drivers.iter().enumerate().flat_map(|(place, driver)| cross(place, driver, (fastest, most))))
        .collect();
    let chart = Chart {
        size: SIZE,
        x: (0.0, fastest),
        y: (0.0, most),
        x_label: "progress".into(),
        y_text: short,
        x_text: short,
    };
    let says =
        drivers.iter().map(|(name, price, value, _)| format!("{name}: progress {:.2}, {value:.3}. ", price.progress));
    let says: String = says.collect();
    Some(Figure {
        name: "front".into(),
        title: "Share of episodes with a fault, in the worst place of each driver, against its progress.".into(),
        notes: vec![
            "Lines are 95 % intervals, and cross at the driver. Below and to the right is better.".into(),
            "The thin line joins the drivers than which no other has both fewer faults and more progress.".into(),
        ],
        legend: drivers
            .iter()
            .enumerate()
            .map(|(place, (name, ..))| (format!("s{}", place.min(COLOURS)), name.clone()))
            .collect(),
        panels: vec![chart.panel("Faults and progress".into(), says.trim_end().into(), &curves)],
        ..Figure::default()
    })
}

/// A driver, with its intervals, on axes that end here.
fn cross(place: usize, (_, price, value, rate): &(String, DriverPrice, f64, Rate), ends: (f64, f64)) -> [Curve; 3] {
    let (x, y) = (price.progress, *value);
    let (slow, fast) = price.ends().unwrap_or((x, x));
    let (low, high) = rate.interval.unwrap_or((y, y));
    let (wide, tall) = (MARK * ends.0, MARK * ends.1);
    let mark = vec![(x - wide, y), (x, y + tall), (x + wide, y), (x, y - tall), (x - wide, y)];
    let line = |points| Curve { colour: place.min(COLOURS), points, ..Curve::default() };
    [vec![(slow, y), (fast, y)], vec![(x, low), (x, high)], mark].map(line)
}

/// The points than which no other has both more of the first and less of the second, by the first.
fn best(mut points: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    points.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.total_cmp(&b.1)));
    let mut front: Vec<(f64, f64)> = Vec::new();
    for point in points {
        if front.last().is_none_or(|last| point.1 < last.1) {
            front.push(point);
        }
    }
    front
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nobody_on_the_front_is_slower_and_worse_than_another() {
        let drivers = vec![(0.3, 0.0), (0.9, 0.02), (0.9, 0.05), (0.8, 0.04), (0.95, 0.1), (0.2, 0.0)];
        assert_eq!(best(drivers), [(0.95, 0.1), (0.9, 0.02), (0.3, 0.0)]);
    }
}

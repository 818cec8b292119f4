use super::identity::{Named, places};
use super::markup::percent;
use super::tally::{CellTally, Tally};
use crate::report::render::svg::{Chart, Curve, Figure, short};

/// Times of near misses are shown up to this (s).
const HORIZON: f64 = 5.0;

/// The share of episodes that end in an impact at a speed or above; none without a collision.
pub fn severity(tally: &Tally, cells: &[Named<'_>]) -> Option<Figure> {
    let figure = Distribution {
        name: "figure-impact-speed",
        title: "Share of all episodes that end in a collision with the car at this speed or faster.",
        x_label: "impact speed, m/s",
        example: (5.0, "end in an impact at 5 m/s or faster"),
        horizon: f64::MAX,
        curve: |cell| cell.speeds.at_least(cell.episodes),
    };
    figure.draw(tally, cells)
}

/// How near episodes without a collision came to one; none when the table of episodes has no such columns.
pub fn near_misses(tally: &Tally, cells: &[Named<'_>]) -> Vec<Figure> {
    let time = Distribution {
        name: "figure-near-ttc",
        title: "Share of all episodes that end without a collision, but whose least time to collision was below this.",
        x_label: "least time to collision, s",
        example: (1.0, "came within 1 s of a collision"),
        horizon: HORIZON,
        curve: |cell| cell.times.below(cell.episodes),
    };
    let lag = Distribution {
        name: "figure-near-pet",
        title: "Share of all episodes that end without a collision, but with a post-encroachment time below this.",
        x_label: "post-encroachment time, s",
        example: (1.0, "had a post-encroachment time below 1 s"),
        horizon: HORIZON,
        curve: |cell| cell.lags.below(cell.episodes),
    };
    [time, lag].iter().filter_map(|figure| figure.draw(tally, cells)).collect()
}

/// A figure of the distribution of a quantity, one curve for each cell.
struct Distribution {
    name: &'static str,
    title: &'static str,
    x_label: &'static str,
    /// A value of the quantity, and the words for the episodes that reach it.
    example: (f64, &'static str),
    /// Values above are not shown.
    horizon: f64,
    curve: fn(&CellTally) -> Vec<(f64, f64)>,
}

impl Distribution {
    fn draw(&self, tally: &Tally, cells: &[Named<'_>]) -> Option<Figure> {
        let found = |named: &Named<'_>| tally.cells.iter().find(|cell| cell.key == named.cell.key);
        let curves: Vec<_> = cells.iter().filter_map(|named| Some((named, (self.curve)(found(named)?)))).collect();
        let all = || curves.iter().flat_map(|(_, curve)| curve).filter(|point| point.0 <= self.horizon);
        let (right, most) = all().fold((0.0, 0.0), |(x, y): (f64, f64), point| (x.max(point.0), y.max(point.1)));
        if right == 0.0 || most == 0.0 {
            return None;
        }
        let chart = Chart {
            size: Chart::SMALL,
            x: (0.0, right),
            y: (0.0, (most * 1.04).min(1.0)),
            x_label: self.x_label.into(),
            x_text: short,
            y_text: percent,
        };
        let mut legend: Vec<(String, String)> = Vec::new();
        for named in cells {
            let entry = (format!("s{}", named.colour), named.who.clone());
            if !legend.contains(&entry) {
                legend.push(entry);
            }
        }
        let panels = places(cells).into_iter().map(|(place, members)| {
            let mut shares: Vec<String> = Vec::new();
            let mut drawn: Vec<Curve> = Vec::new();
            for named in members {
                let Some((_, curve)) = curves.iter().find(|(other, _)| other.cell.key == named.cell.key) else {
                    continue;
                };
                let points: Vec<(f64, f64)> = curve.iter().copied().filter(|point| point.0 <= right).collect();
                let there = points.iter().find(|point| point.0 >= self.example.0).or(points.last());
                shares.push(format!("{} {}", named.who, percent(there.map_or(0.0, |point| point.1))));
                drawn.push(Curve { colour: named.colour, thin: false, points, band: Vec::new() });
            }
            // The first cell of the table is on top.
            drawn.reverse();
            chart.panel(
                place.to_string(),
                format!("Share of episodes that {}: {}.", self.example.1, shares.join(", ")),
                &drawn,
            )
        });
        Some(Figure {
            name: self.name.into(),
            title: self.title.into(),
            legend,
            panels: panels.collect(),
            ..Figure::default()
        })
    }
}

use crate::report::failure_modes::{CellModes, accumulated};
use crate::report::render::svg::{Chart, Curve, Figure, SERIES, short, thousands};

/// Draws the expected number of kinds of collisions over the number of episodes; none without any collision.
///
/// It draws one cell for each available colour: those with the most kinds.
pub fn accumulation_figure(cells: &[CellModes<'_>]) -> Option<Figure> {
    let mut shown: Vec<&CellModes<'_>> = cells.iter().filter(|cell| !cell.counts.is_empty()).collect();
    let all = shown.len();
    shown.sort_by_key(|cell| std::cmp::Reverse(cell.richness.seen));
    shown.truncate(SERIES);
    let curve = |(colour, cell): (usize, &&CellModes<'_>)| {
        let points = accumulated(cell).into_iter().map(|(episodes, kinds)| (episodes as f64, kinds)).collect();
        Curve { colour, points, ..Curve::default() }
    };
    let curves: Vec<Curve> = shown.iter().enumerate().map(curve).collect();
    let ends = || curves.iter().filter_map(|curve| curve.points.last());
    let (right, most) = ends().fold((0.0, 0.0), |(x, y): (f64, f64), end| (x.max(end.0), y.max(end.1)));
    let chart = Chart {
        size: (600.0, 320.0),
        x: (0.0, right),
        y: (0.0, most * 1.04),
        x_label: "episodes".into(),
        y_text: short,
        x_text: thousands,
    };
    let says: Vec<String> = shown.iter().map(|cell| format!("{}: {} kinds", cell.key, cell.richness.seen)).collect();
    let title = match all {
        all if all > shown.len() => format!("Kinds of collisions seen: {} of {all} cells", shown.len()),
        _ => "Kinds of collisions seen".into(),
    };
    (!curves.is_empty()).then(|| Figure {
        name: "mode_accumulation".into(),
        title,
        legend: shown.iter().enumerate().map(|(place, cell)| (format!("s{place}"), cell.key.to_string())).collect(),
        panels: vec![chart.panel("Expected kinds".into(), says.join("; "), &curves)],
        ..Figure::default()
    })
}

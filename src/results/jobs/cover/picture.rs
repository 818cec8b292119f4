use maud::html;

use super::Row;
use super::section::statement;
use crate::report::svg::{Figure, Panel, px, short};
use episode::DrawnParameter;

/// Cells along a side of a picture: of a box of two parameters, and of a larger one, whose cells are averages.
const SIDES: (usize, usize) = (48, 32);
/// The extent of a picture, and the room for its axes: left, below.
const EXTENT: f64 = 226.0;
const ROOM: (f64, f64) = (48.0, 36.0);
const MARGIN: f64 = 12.0;
const TOP: f64 = 6.0;
/// The height of a picture of one parameter.
const STRIP: f64 = 40.0;
/// The shares at which an axis has a number.
const MARKS: [f64; 5] = [0.0, 0.25, 0.5, 0.75, 1.0];

/// Where starts pass and fail: a picture for each cover that has one.
pub fn pictures(rows: &[Row<'_>]) -> Option<Figure> {
    let panels: Vec<Panel> = rows.iter().filter_map(panel).collect();
    let steps = ["passes", "up to 20 %", "up to 40 %", "up to 60 %", "up to 80 %", "more fail"];
    (!panels.is_empty()).then(|| Figure {
        name: "covers".into(),
        title: "Share of starts that fail, over two parameters of the box.".into(),
        notes: vec![
            "Axes have equal parts of the draws.".into(),
            "Further parameters are averaged over their ranges.".into(),
            "Rings: episodes of the check that failed where the picture says that they pass.".into(),
        ],
        legend: steps.iter().enumerate().map(|(step, text)| (format!("h{step}"), (*text).to_string())).collect(),
        panels,
        ..Figure::default()
    })
}

fn panel(row: &Row<'_>) -> Option<Panel> {
    let (cover, coverage) = (row.0, &row.1.coverage);
    let parameters = cover.scenario.start_parameters();
    let look = coverage.best()?;
    let picture = coverage.picture(look);
    let (first, second) = (*cover.picture.first()?, cover.picture.get(1).copied());
    let side = if parameters.len() > 1 + usize::from(second.is_some()) { SIDES.1 } else { SIDES.0 };
    let cells = picture.chart((first, second), side);
    let height = if second.is_some() { EXTENT } else { STRIP };
    let (left, floor) = (ROOM.0, TOP + height);
    let cell = (EXTENT / side as f64, height / (cells.len() / side) as f64);
    let step = |share: f64| if share <= 0.0 { 0 } else { ((share * 5.0).ceil() as usize).clamp(1, 5) };
    let place =
        |at: &[f64]| (left + at[first] * EXTENT, second.map_or(floor - 0.5 * height, |axis| floor - at[axis] * height));
    let end = (look.learnt + look.points) as usize;
    let missed: Vec<(f64, f64)> = coverage.points[look.learnt as usize..end]
        .iter()
        .filter(|point| point.failed && !picture.fails(&point.at))
        .map(|point| place(&point.at))
        .collect();
    let across = &parameters[first];
    let upward = second.map(|axis| &parameters[axis]);
    // Neighbours of one colour in a row are one rectangle.
    let mut runs: Vec<(usize, usize, usize, usize)> = Vec::new();
    for (number, share) in cells.iter().enumerate() {
        let (line, column, step) = (number / side, number % side, step(*share));
        match runs.last_mut() {
            Some((row, _, last, same)) if *row == line && *same == step => *last = column,
            _ => runs.push((line, column, column, step)),
        }
    }
    let body = html! {
        @for (line, from, to, step) in &runs {
            rect class={ "h" (step) } x=(px(left + *from as f64 * cell.0)) y=(px(floor - (line + 1) as f64 * cell.1))
                width=(px((to + 1 - from) as f64 * cell.0)) height=(px(cell.1)) {}
        }
        @for (x, y) in &missed { circle.whisker cx=(px(*x)) cy=(px(*y)) r="3.5" {} }
        path.axis d={ "M" (px(left)) " " (px(floor)) "H" (px(left + EXTENT)) } {}
        @for mark in MARKS {
            text.muted.middle x=(px(left + mark * EXTENT)) y=(px(floor + 14.0)) { (value(across, mark)) }
            @if let Some(upward) = upward {
                text.muted.end x=(px(left - 5.0)) y=(px(floor - mark * height + 3.6)) { (value(upward, mark)) }
            }
        }
        text.muted.end x=(px(left + EXTENT)) y=(px(floor + ROOM.1 - 7.0)) { (named(across)) }
        @if let Some(upward) = upward {
            text.muted x="0" y=(px(floor + ROOM.1 - 7.0)) { "↑ " (named(upward)) }
        }
    };
    Some(Panel {
        title: format!("{} in {}, {}", cover.policy, cover.town, cover.spawn),
        says: format!("{}.", statement(row)),
        size: (left + EXTENT + MARGIN, floor + ROOM.1),
        body,
    })
}

/// The value of a parameter at a share of its draws, in the unit of the axis.
fn value(drawn: &DrawnParameter, share: f64) -> String {
    short(drawn.value(share) * drawn.parameter.unit().1)
}

/// A parameter with its unit.
fn named(drawn: &DrawnParameter) -> String {
    let (name, unit) = (drawn.parameter.name().replace('_', " "), drawn.parameter.unit().0);
    if unit.is_empty() { name } else { format!("{name}, {unit}") }
}

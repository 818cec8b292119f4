use kuva::prelude::*;

use crate::report::failure_modes::{CellModes, accumulated};
use crate::report::render::svg::COLOURS;

/// Draws how many kinds of collisions have been seen after so many episodes; none without any collision.
///
/// As many cells as there are colours, those with the most kinds.
pub fn accumulation_figure(cells: &[CellModes<'_>]) -> Option<String> {
    let mut shown: Vec<&CellModes<'_>> = cells.iter().filter(|cell| !cell.counts.is_empty()).collect();
    let all = shown.len();
    shown.sort_by_key(|cell| std::cmp::Reverse(cell.richness.seen));
    shown.truncate(COLOURS.len());
    if shown.is_empty() {
        return None;
    }
    let line = |(cell, colour): (&&CellModes<'_>, &&str)| {
        let points = accumulated(cell).into_iter().map(|(episodes, kinds)| (episodes as f64, kinds));
        LinePlot::new().with_data(points).with_color(*colour).with_legend(cell.key.to_string()).into()
    };
    let plots: Vec<Plot> = shown.iter().zip(&COLOURS).map(line).collect();
    let title = match all {
        all if all > shown.len() => format!("FailureModes of collisions seen: {} of {all} cells", shown.len()),
        _ => "FailureModes of collisions seen".into(),
    };
    let layout =
        Layout::auto_from_plots(&plots).with_title(title).with_x_label("episodes").with_y_label("expected kinds");
    Some(render_to_svg(plots, layout))
}

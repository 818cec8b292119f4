use kuva::prelude::*;

use super::cell::CellKinds;
use super::tables::accumulated;
use super::words::label;
use crate::report::svg::COLOURS;

/// Draws how many kinds of collisions have been seen after so many episodes; none without any collision.
///
/// As many cells as there are colours, those with the most kinds.
pub(super) fn accumulation_figure(cells: &[CellKinds<'_>]) -> Option<String> {
    let mut shown: Vec<&CellKinds<'_>> = cells.iter().filter(|cell| !cell.counts.is_empty()).collect();
    let all = shown.len();
    shown.sort_by_key(|cell| std::cmp::Reverse(cell.richness.seen));
    shown.truncate(COLOURS.len());
    if shown.is_empty() {
        return None;
    }
    let line = |(cell, colour): (&&CellKinds<'_>, &&str)| {
        let points = accumulated(cell).into_iter().map(|(episodes, kinds)| (episodes as f64, kinds));
        LinePlot::new().with_data(points).with_color(*colour).with_legend(label(cell.evaluation)).into()
    };
    let plots: Vec<Plot> = shown.iter().zip(&COLOURS).map(line).collect();
    let title = match all {
        all if all > shown.len() => format!("Kinds of collisions seen: {} of {all} cells", shown.len()),
        _ => "Kinds of collisions seen".into(),
    };
    let layout =
        Layout::auto_from_plots(&plots).with_title(title).with_x_label("episodes").with_y_label("expected kinds");
    Some(render_to_svg(plots, layout))
}

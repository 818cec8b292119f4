use maud::html;

use super::EpisodeView;
use super::sheet::{EDGE, HEAD, Sheet};
use crate::report::render::svg::px;
use episode::{Scenario, Trace};
use verdict::Verdict;

/// Frames in a row, frames in all, and the width of one (px).
const COLUMNS: usize = 3;
const FRAMES: usize = 6;
const WIDE: f64 = 300.0;
/// Between frames (px), and for the two lines below a frame.
const GAP: f64 = 14.0;
const CAPTION: f64 = 42.0;
/// Height of the speeds (px).
const SPEEDS: f64 = 110.0;

/// Draws an episode as six frames from a little before the danger to the touch, with the speeds of both below.
///
/// `title` and `subtitle` name the episode.
pub fn strip(scenario: &Scenario, trace: &Trace, verdict: Option<&Verdict>, title: &str, subtitle: &str) -> String {
    let view = EpisodeView::new(scenario, trace, verdict);
    let ((first, last), tall) = (view.span(), view.height(WIDE));
    let width = COLUMNS as f64 * WIDE + (COLUMNS - 1) as f64 * GAP;
    let height = FRAMES.div_ceil(COLUMNS) as f64 * (tall + CAPTION + GAP) - GAP;
    let sheet = Sheet::new(&view, (width, height), SPEEDS);
    let ticks: Vec<usize> = (0..FRAMES).map(|frame| first + (last - first) * frame / (FRAMES - 1)).collect();
    let mode = |tick: usize| view.frame(tick).mode.shown().replace('_', " ");
    let speeds = |tick: usize| {
        let frame = view.frame(tick);
        format!("car {:.1} m/s, pedestrian {:.1} m/s", frame.ego.speed, frame.pedestrian.speed())
    };
    let place = |frame: usize| {
        let (row, column) = (frame / COLUMNS, frame % COLUMNS);
        (EDGE + column as f64 * (WIDE + GAP), HEAD + row as f64 * (tall + CAPTION + GAP))
    };
    let scenes = html! {
        defs { g #ground { (view.draw_ground()) } }
        @for (frame, tick) in ticks.iter().copied().enumerate() {
            @let (x, y) = place(frame);
            svg x=(px(x)) y=(px(y)) width=(WIDE) height=(px(tall)) viewBox=(view.view_box()) {
                use href="#ground" {}
                (view.draw_ways(tick, 0.75))
                (view.draw_sight(view.frame(tick)))
                (view.draw_actors(tick))
                @if frame == 0 { (view.draw_scale()) }
            }
            rect.frame x=(px(x)) y=(px(y)) width=(WIDE) height=(px(tall)) {}
            text.ink x=(px(x)) y=(px(y + tall + 17.0)) {
                tspan font-weight="600" { (format!("{:.2} s", view.time(tick))) }
                tspan.muted dx="8" { "driver: " (mode(tick)) }
            }
            text.muted x=(px(x)) y=(px(y + tall + 33.0)) { (speeds(tick)) }
        }
    };
    let marks = html! { @for tick in &ticks { (sheet.mark(*tick, &html! {})) } };
    sheet.draw((title, subtitle), &scenes, &ticks, &marks)
}

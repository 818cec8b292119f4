use std::fmt::Write;

use super::view::{EDGE, EpisodeView, opening};
use crate::env::{Recording, Scenario};
use crate::judge::Verdict;

/// Frames beside and below each other, and the width of one (px).
const COLUMNS: usize = 3;
const FRAMES: usize = 6;
const WIDE: f64 = 300.0;
/// Between frames (px), and for the line below a frame.
const GAP: f64 = 14.0;
const CAPTION: f64 = 26.0;
/// Height of the titles and of the speeds below (px).
const HEAD: f64 = 62.0;
const CHART: f64 = 110.0;

/// Draws an episode as six frames from a little before the danger to the touch, with the speeds of both below.
///
/// `title` and `subtitle` say which it is.
pub fn strip(
    scenario: &Scenario,
    recording: &Recording,
    verdict: Option<&Verdict>,
    title: &str,
    subtitle: &str,
) -> String {
    let view = EpisodeView::new(scenario, recording, verdict);
    let (first, last) = view.span();
    let tall = WIDE * view.size().y / view.size().x;
    let width = 2.0 * EDGE + COLUMNS as f64 * WIDE + (COLUMNS - 1) as f64 * GAP;
    let rows = FRAMES.div_ceil(COLUMNS);
    let chart = HEAD + rows as f64 * (tall + CAPTION + GAP) + 28.0;
    let height = chart + CHART + 44.0;
    let mut page = opening(width, height, (title, subtitle));
    page.push_str("<defs><g id=\"ground\">\n");
    view.ground(&mut page);
    page.push_str("</g></defs>\n");
    let (left, wide) = (EDGE + 26.0, width - 2.0 * EDGE - 26.0);
    let across = |tick: usize| left + wide * (tick - first) as f64 / (last - first).max(1) as f64;
    let ticks: Vec<usize> = (0..FRAMES).map(|frame| first + (last - first) * frame / (FRAMES - 1)).collect();
    for (frame, tick) in ticks.iter().copied().enumerate() {
        let moment = &recording.moments()[tick];
        let x = EDGE + (frame % COLUMNS) as f64 * (WIDE + GAP);
        let y = HEAD + (frame / COLUMNS) as f64 * (tall + CAPTION + GAP);
        let _ = writeln!(
            page,
            "<svg x=\"{x:.1}\" y=\"{y:.1}\" width=\"{WIDE}\" height=\"{tall:.1}\" viewBox=\"{}\">\n<use href=\"#ground\"/>",
            view.view_box()
        );
        view.ways(&mut page, tick, 0.75);
        view.sight(&mut page, moment);
        view.actors(&mut page, moment);
        if frame == 0 {
            view.scale(&mut page);
        }
        let _ = writeln!(
            page,
            "</svg>\n<rect class=\"frame\" x=\"{x:.1}\" y=\"{y:.1}\" width=\"{WIDE}\" height=\"{tall:.1}\"/>\n\
             <text class=\"small\" x=\"{x:.1}\" y=\"{0:.1}\"><tspan font-weight=\"600\">{1:.2} s</tspan>\
             <tspan class=\"faint\" dx=\"8\">car {2:.1} m/s, {3}; pedestrian {4:.1} m/s</tspan></text>",
            y + tall + 17.0,
            view.time(tick),
            moment.ego.speed,
            moment.mode.name().replace('_', " "),
            moment.pedestrian.speed(),
        );
    }
    let _ = writeln!(page, "<text class=\"small faint\" x=\"{EDGE}\" y=\"{:.1}\">speed (m/s)</text>", chart - 12.0);
    EpisodeView::legend(&mut page, width - EDGE, chart - 12.0);
    view.speeds(&mut page, left, chart, wide, CHART);
    for tick in ticks {
        let x = across(tick);
        let _ = writeln!(
            page,
            "<path class=\"mark\" d=\"M{x:.1} {chart:.1}v{CHART}\"/>\
             <text class=\"small faint\" x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{:.2} s</text>",
            chart + CHART + 25.0,
            view.time(tick)
        );
    }
    page.push_str("</svg>\n");
    page
}

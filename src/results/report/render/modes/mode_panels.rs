use maud::html;

use super::names::percent;
use crate::analysis::{Approach, Station};
use crate::report::failure_modes::{CellModes, Mode};
use crate::report::render::svg::{Digits, Figure, Panel, line, px};
use world::geometry::Vector;

/// Most modes in the picture; the most frequent are drawn.
const MOST: usize = 12;
/// Panels in a row.
const COLUMNS: usize = 4;
/// Size of a panel's picture, and height of the words above it (px).
const PICTURE: (f64, f64) = (230.0, 260.0);
const WORDS: f64 = 34.0;
/// Ground shown behind the middle of the car (m).
const BEHIND: f64 = 7.0;
/// Least and most ground shown ahead of it and to each side (m).
const AHEAD: (f64, f64) = (7.0, 40.0);
/// Share of the stations that are within the picture.
const SEEN: f64 = 0.97;

/// Draws the most frequent modes of a cell side by side: the paths of pedestrians in the frame of the car, which faces up the page.
pub fn mode_panels(cell: &CellModes<'_>) -> Figure {
    let modes = &cell.modes[..cell.modes.len().min(MOST)];
    let scale = scale(modes);
    let cut = match cell.modes.len() {
        all if all > MOST => format!(" The {MOST} commonest of {all} modes."),
        _ => String::new(),
    };
    Figure {
        title: cell.key.to_string(),
        notes: vec![
            format!(
                "Ways of the pedestrian to the touch in the frame of the car: the last {:.0} s, a dot every {} s.",
                Approach::WINDOW,
                Approach::STEP
            ),
            format!("Thick: the medoid. Circles about the car: every 5 m.{cut}"),
        ],
        columns: COLUMNS,
        panels: modes.iter().enumerate().map(|(index, mode)| panel(index, mode, cell.car, scale)).collect(),
        ..Figure::default()
    }
}

/// The scale (px/m) at which nearly all paths are visible; a few leave the picture.
fn scale(modes: &[Mode]) -> f64 {
    let stations = || modes.iter().flat_map(|mode| mode.medoid.iter().chain(&mode.others)).flat_map(|way| way.stations);
    let reach = |of: fn(Station) -> f64| {
        let mut values: Vec<f64> = stations().map(of).collect();
        values.sort_by(f64::total_cmp);
        let place = (SEEN * values.len() as f64) as usize;
        values.get(place).map_or(AHEAD.0, |value| value.clamp(AHEAD.0, AHEAD.1))
    };
    let (ahead, aside) = (reach(|station| station.ahead), reach(|station| station.left.abs()));
    (PICTURE.0 / (2.0 * aside)).min(PICTURE.1 / (ahead + BEHIND))
}

fn panel(index: usize, mode: &Mode, car: Vector, scale: f64) -> Panel {
    let kind = &mode.mode.kind;
    let [slow, median, fast] = mode.mode.impact_speed;
    let cluster = match mode.mode.clusters {
        1 => String::new(),
        clusters => format!(", cluster {} of {clusters}", mode.mode.cluster + 1),
    };
    let speeds = format!("{median:.1} m/s ({slow:.1} to {fast:.1})");
    let words = [format!("{kind}{cluster}"), format!("{speeds}, {}", mode.example_name())];
    // Long names shrink, so that they do not overlap the next panel.
    let size = |text: &str| Digits((PICTURE.0 / (text.chars().count() as f64 * 0.52)).min(11.0), 1);
    let middle = (PICTURE.0 / 2.0, PICTURE.1 - BEHIND * scale);
    let place = |station: &Station| (middle.0 - station.left * scale, middle.1 - station.ahead * scale);
    let way = |way: &Approach| line(way.stations.iter().map(place), 1);
    let (half, bumper) = (car * scale, middle.1 - car.x * scale);
    let body = html! {
        @for (line, text) in words.iter().enumerate() {
            text.muted y=(px(10.0 + 14.0 * line as f64)) style={ "font-size:" (size(text)) "px" } { (text) }
        }
        svg y=(WORDS) width=(PICTURE.0) height=(PICTURE.1) {
            rect.ground width="100%" height="100%" {}
            @for ring in 1..=8 {
                circle.ring cx=(px(middle.0)) cy=(px(middle.1)) r=(px(f64::from(ring) * 5.0 * scale)) {}
            }
            rect.car x=(px(middle.0 - half.y)) y=(px(bumper)) width=(px(2.0 * half.y)) height=(px(2.0 * half.x)) rx="2" {}
            path.glass d={
                "M" (px(middle.0)) " " (px(bumper + 2.0)) "l" (px(-half.y * 0.6)) " " (px(half.y * 0.8)) "h" (px(half.y * 1.2)) "z"
            } {}
            @for other in &mode.others { path class="line thin s1" d=(way(other)) {} }
            @if let Some(medoid) = &mode.medoid {
                path class="line s1" stroke-width="2.6" d=(way(medoid)) {}
                @for (x, y) in medoid.stations.iter().map(place) {
                    circle class="f1" cx=(px(x)) cy=(px(y)) r="2.6" {}
                }
            }
        }
    };
    Panel {
        title: format!("{}. {} of the collisions", index + 1, percent(mode.mode.share)),
        says: words.join(", "),
        size: (PICTURE.0, WORDS + PICTURE.1),
        body,
    }
}

use std::fmt::Write;

use super::words::percent;
use crate::analysis::{Approach, Station};
use crate::geometry::Vector;
use crate::report::failure_modes::{CellModes, Mode};
use crate::report::render::svg::escape;

/// Most modes that are drawn, the commonest.
const MOST: usize = 12;
/// Panels in a row.
const COLUMNS: usize = 4;
/// Size of a panel's picture, and height of the words above it (px).
const PANEL: (f64, f64) = (230.0, 260.0);
const WORDS: f64 = 52.0;
/// Space between panels, and above all (px).
const SPACE: f64 = 14.0;
const TITLE: f64 = 62.0;
/// Ground shown behind the middle of the car (m).
const BEHIND: f64 = 7.0;
/// Least and most ground shown ahead of it and to each side (m).
const AHEAD: (f64, f64) = (7.0, 40.0);
/// Share of the stations that is within the picture.
const SEEN: f64 = 0.97;

/// Draws the commonest modes of a cell side by side: the ways of pedestrians in the frame of the car, which looks up the page.
pub fn mode_panels(cell: &CellModes<'_>) -> String {
    let modes = &cell.modes[..cell.modes.len().min(MOST)];
    let scale = scale(modes);
    let columns = modes.len().min(COLUMNS);
    let rows = modes.len().div_ceil(COLUMNS);
    let (step_x, step_y) = (PANEL.0 + SPACE, PANEL.1 + WORDS + SPACE);
    let (width, height) = ((columns as f64 * step_x + SPACE).max(760.0), TITLE + rows as f64 * step_y);
    let mut page = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width:.0} {height:.0}\" width=\"{width:.0}\" height=\"{height:.0}\" font-family=\"sans-serif\" \
         font-size=\"11\" fill=\"#222\">\n<title>Failure modes</title>\n\
         <style>.ground{{fill:#f4f4f1;stroke:#d5d5d0}}.car{{fill:#c9ced3;stroke:#5b6670}}.other{{fill:none;stroke-width:1;stroke-opacity:.3}}\
         .medoid{{fill:none;stroke-width:2.6}}.moving{{stroke:#b2182b}}.standing{{stroke:#2166dc}}\
         .dot.moving{{fill:#b2182b;stroke:none}}.dot.standing{{fill:#2166dc;stroke:none}}.grid{{stroke:#deded8;fill:none}}</style>\n\
         <rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n\
         <text x=\"{SPACE}\" y=\"22\" font-size=\"15\" font-weight=\"bold\">{}</text>\n\
         <text x=\"{SPACE}\" y=\"39\">Ways of the pedestrian to the touch as the car sees them, the last {:.0} s, a dot every {} s; thick: the medoid. \
         </text>\n<text x=\"{SPACE}\" y=\"54\"><tspan fill=\"#b2182b\">Red</tspan>: the car moves at the touch, <tspan \
         fill=\"#2166dc\">blue</tspan>: it stands. Circles about the car: every 5 m.{}</text>\n",
        escape(&cell.key.to_string()),
        Approach::WINDOW,
        Approach::STEP,
        if cell.modes.len() > MOST {
            format!(" The {MOST} commonest of {} modes.", cell.modes.len())
        } else {
            String::new()
        },
    );
    for (index, mode) in modes.iter().enumerate() {
        let (x, y) = ((index % COLUMNS) as f64 * step_x + SPACE, TITLE + (index / COLUMNS) as f64 * step_y);
        panel(&mut page, index, mode, cell.car, scale, (x, y));
    }
    page.push_str("</svg>\n");
    page
}

/// As many pixels a metre as let nearly all of the ways be seen; a few run out of the picture.
fn scale(modes: &[Mode]) -> f64 {
    let stations = || modes.iter().flat_map(|mode| mode.medoid.iter().chain(&mode.others)).flat_map(|way| way.stations);
    let reach = |of: fn(Station) -> f64| {
        let mut values: Vec<f64> = stations().map(of).collect();
        values.sort_by(f64::total_cmp);
        let place = (SEEN * values.len() as f64) as usize;
        values.get(place).map_or(AHEAD.0, |value| value.clamp(AHEAD.0, AHEAD.1))
    };
    let (ahead, aside) = (reach(|station| station.ahead), reach(|station| station.left.abs()));
    (PANEL.0 / (2.0 * aside)).min(PANEL.1 / (ahead + BEHIND))
}

fn panel(page: &mut String, index: usize, mode: &Mode, car: Vector, scale: f64, (x, y): (f64, f64)) {
    let kind = &mode.mode.kind;
    let [slow, median, fast] = mode.mode.impact_speed;
    let cluster = match mode.mode.clusters {
        1 => String::new(),
        clusters => format!(", cluster {} of {clusters}", mode.mode.cluster + 1),
    };
    let speeds = if kind.moving { format!("{median:.1} m/s ({slow:.1} to {fast:.1}), ") } else { String::new() };
    let lines = [
        (true, format!("{}. {} of the collisions{cluster}", index + 1, percent(mode.mode.share))),
        (false, kind.to_string()),
        (false, format!("{speeds}{}", mode.example_name())),
    ];
    for (line, (bold, text)) in lines.iter().enumerate() {
        let weight = if *bold { " font-weight=\"bold\"" } else { "" };
        let below = y + 13.0 + 14.0 * line as f64;
        // Long names shrink rather than run into the next panel.
        let size = (PANEL.0 / (text.chars().count() as f64 * 0.52)).min(11.0);
        let _ = writeln!(
            page,
            "<text x=\"{x:.1}\" y=\"{below:.1}\" font-size=\"{size:.1}\"{weight}>{}</text>",
            escape(text)
        );
    }
    let (left, top) = (x, y + WORDS - 4.0);
    let middle = (PANEL.0 / 2.0, PANEL.1 - BEHIND * scale);
    let place = |station: &Station| (middle.0 - station.left * scale, middle.1 - station.ahead * scale);
    let _ = writeln!(
        page,
        "<svg x=\"{left:.1}\" y=\"{top:.1}\" width=\"{:.0}\" height=\"{:.0}\"><rect class=\"ground\" width=\"100%\" height=\"100%\"/>",
        PANEL.0, PANEL.1
    );
    for ring in 1..=8 {
        let radius = f64::from(ring) * 5.0 * scale;
        let _ =
            writeln!(page, "<circle class=\"grid\" cx=\"{:.1}\" cy=\"{:.1}\" r=\"{radius:.1}\"/>", middle.0, middle.1);
    }
    let (half, bumper) = (car * scale, middle.1 - car.x * scale);
    let _ = writeln!(
        page,
        "<rect class=\"car\" x=\"{:.1}\" y=\"{bumper:.1}\" width=\"{:.1}\" height=\"{:.1}\" rx=\"2\"/><path class=\"car\" d=\"M{:.1} {:.1}l{:.1} \
         {:.1}h{:.1}z\"/>",
        middle.0 - half.y,
        2.0 * half.y,
        2.0 * half.x,
        middle.0,
        bumper + 2.0,
        -half.y * 0.6,
        half.y * 0.8,
        half.y * 1.2,
    );
    let motion = kind.motion();
    let mut draw = |way: &Approach, class: &str| {
        let points: Vec<String> = way.stations.iter().map(&place).map(|(x, y)| format!("{x:.1},{y:.1}")).collect();
        let _ = writeln!(page, "<polyline class=\"{class} {motion}\" points=\"{}\"/>", points.join(" "));
    };
    mode.others.iter().for_each(|way| draw(way, "other"));
    mode.medoid.iter().for_each(|way| draw(way, "medoid"));
    for (x, y) in mode.medoid.iter().flat_map(|way| way.stations.iter().map(place).collect::<Vec<_>>()) {
        let _ = writeln!(page, "<circle class=\"dot {motion}\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"2.6\"/>");
    }
    page.push_str("</svg>\n");
}

use std::fmt::Write;

use super::super::town::Surface;
use super::replay::Replay;

/// Width and height of a frame.
const SIZE: (f64, f64) = (176.0, 150.0);
/// How many frames an episode has.
const FRAMES: usize = 5;
/// Least ground that a frame shows (m).
const LEAST: f64 = 22.0;

/// An episode as a strip of still pictures from above, the last at the touch: what is printed, and seen without scripts.
///
/// `id` names the ground, once in a page.
pub fn frames(replay: &Replay, id: &str) -> String {
    let first = first_tick(replay);
    let span = replay.end() - first;
    let ticks: Vec<usize> = (0..FRAMES).map(|frame| first + span * frame / (FRAMES - 1)).collect();
    // All frames show the same ground.
    let places = || ticks.iter().flat_map(|tick| [replay.ego[*tick], replay.person[*tick]]).map(|state| metres(&state));
    let (mut low, mut high) = ((f64::MAX, f64::MAX), (f64::MIN, f64::MIN));
    for (x, y) in places() {
        (low, high) = ((low.0.min(x), low.1.min(y)), (high.0.max(x), high.1.max(y)));
    }
    let centre = ((low.0 + high.0) / 2.0, (low.1 + high.1) / 2.0);
    let extent = ((high.0 - low.0 + 9.0).max(LEAST) / SIZE.0).max((high.1 - low.1 + 9.0).max(LEAST * 0.8) / SIZE.1);
    let scale = 1.0 / extent;
    let mut html = String::from("<div class=\"strip\">");
    for (place, tick) in ticks.iter().enumerate() {
        let time = *tick as f64 * replay.dt;
        let _ = write!(
            html,
            "<div><svg class=\"panel\" viewBox=\"0 0 {w:.0} {h:.0}\" aria-hidden=\"true\"><rect class=\"ground\" width=\"{w:.0}\" \
             height=\"{h:.0}\"/><g transform=\"translate({:.1} {:.1}) scale({scale:.3} {:.3}) translate({:.2} {:.2})\">",
            SIZE.0 / 2.0,
            SIZE.1 / 2.0,
            -scale,
            -centre.0,
            -centre.1,
            w = SIZE.0,
            h = SIZE.1,
        );
        // The ground is drawn once and shown again.
        match place {
            0 => ground(&mut html, replay, id),
            _ => html.push_str(&format!("<use href=\"#{id}\"/>")),
        }
        actors(&mut html, replay, first, *tick);
        let _ = write!(
            html,
            "</g></svg><p>{time:.1} s · {:.1} m/s<br>{}</p></div>",
            replay.ego[*tick][3] as f64 / 100.0,
            replay.mode(*tick).replace('_', " ")
        );
    }
    html.push_str("</div>");
    html
}

/// Where the strip begins: two seconds before the danger, or ten before the end.
fn first_tick(replay: &Replay) -> usize {
    let ticks = |seconds: f64| (seconds / replay.dt) as usize;
    let before = replay.danger.map_or(replay.end().saturating_sub(ticks(10.0)), |tick| tick.saturating_sub(ticks(1.0)));
    before.max(replay.end().saturating_sub(ticks(12.0)))
}

fn metres(state: &[i64; 4]) -> (f64, f64) {
    (state[0] as f64 / 100.0, state[1] as f64 / 100.0)
}

fn ground(html: &mut String, replay: &Replay, id: &str) {
    let _ = write!(html, "<g id=\"{id}\">");
    for polygon in &replay.scenery {
        let Some(surface) = Surface::ALL.get(polygon[0] as usize) else { continue };
        let _ = write!(html, "<path class=\"{}\" d=\"", surface.class());
        for (place, corner) in polygon[1..].chunks_exact(2).enumerate() {
            let (x, y) = (corner[0] as f64 / 10.0, corner[1] as f64 / 10.0);
            let _ = write!(html, "{}{x:.1} {y:.1}", if place == 0 { 'M' } else { 'L' });
        }
        html.push_str("Z\"/>");
    }
    html.push_str("</g>");
}

fn actors(html: &mut String, replay: &Replay, first: usize, tick: usize) {
    for (class, states) in [("way", &replay.ego), ("trail", &replay.person)] {
        let _ = write!(html, "<path class=\"{class}\" stroke-width=\".35\" d=\"");
        for (place, state) in states[first..=tick].iter().step_by(4).chain([&states[tick]]).enumerate() {
            let (x, y) = metres(state);
            let _ = write!(html, "{}{x:.1} {y:.1}", if place == 0 { 'M' } else { 'L' });
        }
        html.push_str("\"/>");
    }
    let (ego, person) = (&replay.ego[tick], &replay.person[tick]);
    let ((x, y), (px, py)) = (metres(ego), metres(person));
    let (length, width) = (replay.car[0] as f64 / 100.0, replay.car[1] as f64 / 100.0);
    let _ = write!(
        html,
        "<g transform=\"translate({x:.2} {y:.2}) rotate({:.1})\"><rect class=\"car\" x=\"{:.2}\" y=\"{:.2}\" width=\"{:.2}\" \
         height=\"{:.2}\" rx=\".5\"/><rect class=\"glass\" x=\"{:.2}\" y=\"{:.2}\" width=\".8\" height=\"{:.2}\" rx=\".2\"/></g>\
         <circle class=\"person\" cx=\"{px:.2}\" cy=\"{py:.2}\" r=\".55\"/>",
        (ego[2] as f64 / 1000.0).to_degrees(),
        -length,
        -width,
        2.0 * length,
        2.0 * width,
        length * 0.25,
        -width * 0.8,
        width * 1.6,
    );
}

use maud::{Markup, html};

use super::replay::Replay;
use crate::report::render::svg::{Digits, fine, line, outline, px};
use crate::report::render::town::Surface;

/// Width and height of a frame.
const SIZE: (f64, f64) = (176.0, 150.0);
/// Number of frames of an episode.
const FRAMES: usize = 5;
/// Least ground that a frame shows (m).
const LEAST: f64 = 22.0;

/// An episode as a strip of still pictures from above, the last at the touch. It is for print, and for readers without scripts.
///
/// `id` names the ground, and is unique in a page.
pub fn frames(replay: &Replay, id: &str) -> Markup {
    let first = replay.opens;
    let span = replay.end() - first;
    let ticks: Vec<usize> = (0..FRAMES).map(|frame| first + span * frame / (FRAMES - 1)).collect();
    // All frames show the same ground.
    let places = ticks.iter().flat_map(|tick| [replay.ego[*tick], replay.person[*tick]]).map(|state| metres(&state));
    let (mut low, mut high) = ((f64::MAX, f64::MAX), (f64::MIN, f64::MIN));
    for (x, y) in places {
        (low, high) = ((low.0.min(x), low.1.min(y)), (high.0.max(x), high.1.max(y)));
    }
    let extent = ((high.0 - low.0 + 9.0).max(LEAST) / SIZE.0).max((high.1 - low.1 + 9.0).max(LEAST * 0.8) / SIZE.1);
    let scale = Digits(1.0 / extent, 3);
    let ground_place = format!(
        "translate({} {}) scale({scale} -{scale}) translate({} {})",
        px(SIZE.0 / 2.0),
        px(SIZE.1 / 2.0),
        fine(-(low.0 + high.0) / 2.0),
        fine(-(low.1 + high.1) / 2.0)
    );
    html! {
        div.strip {
            @for (place, tick) in ticks.iter().copied().enumerate() {
                div {
                    svg.panel viewBox={ "0 0 " (SIZE.0) " " (SIZE.1) } aria-hidden="true" {
                        rect.ground width=(SIZE.0) height=(SIZE.1) {}
                        g transform=(ground_place) {
                            // The ground is drawn once and reused.
                            @if place == 0 { (ground(replay, id)) } @else { use href={ "#" (id) } {} }
                            (actors(replay, first, tick))
                        }
                    }
                    p {
                        (format!("{:.1} s · {:.1} m/s", tick as f64 * replay.dt, replay.ego[tick][3] as f64 / 100.0))
                        br;
                        (replay.mode(tick).replace('_', " "))
                    }
                }
            }
        }
    }
}

fn metres(state: &[i64; 4]) -> (f64, f64) {
    (state[0] as f64 / 100.0, state[1] as f64 / 100.0)
}

fn ground(replay: &Replay, id: &str) -> Markup {
    let corners = |polygon: &[i64]| {
        let corners = polygon.chunks_exact(2).map(|corner| (corner[0] as f64 / 10.0, corner[1] as f64 / 10.0));
        outline(corners, 1)
    };
    html! {
        g id=(id) {
            @for polygon in &replay.scenery {
                @if let Some(surface) = Surface::ALL.get(polygon[0] as usize) {
                    path class=(surface.name()) d=(corners(&polygon[1..])) {}
                }
            }
        }
    }
}

fn actors(replay: &Replay, first: usize, tick: usize) -> Markup {
    let way = |states: &[[i64; 4]]| {
        let shown = states[first..=tick].iter().step_by(4).chain([&states[tick]]);
        line(shown.map(metres), 1)
    };
    let (ego, person) = (&replay.ego[tick], &replay.person[tick]);
    let ((x, y), (px, py)) = (metres(ego), metres(person));
    let (length, width) = (replay.car[0] as f64 / 100.0, replay.car[1] as f64 / 100.0);
    let turned = Digits((ego[2] as f64 / 1000.0).to_degrees(), 1);
    html! {
        @for other in &replay.others {
            @let (state, [length, width]) = (other.at(tick), other.half.map(|half| half as f64 / 100.0));
            @let (x, y) = metres(state);
            @let turned = Digits((state[2] as f64 / 1000.0).to_degrees(), 1);
            @if other.is_pedestrian { circle.person cx=(fine(x)) cy=(fine(y)) r=".45" fill-opacity=".55" {} } @else {
                rect.car transform={ "translate(" (fine(x)) " " (fine(y)) ") rotate(" (turned) ")" } x=(fine(-length)) y=(fine(-width)) width=(fine(2.0 * length)) height=(fine(2.0 * width)) rx=".3" fill-opacity=".45" {}
            }
        }
        path.way stroke-width=".35" d=(way(&replay.ego)) {}
        path.trail stroke-width=".35" d=(way(&replay.person)) {}
        g transform={ "translate(" (fine(x)) " " (fine(y)) ") rotate(" (turned) ")" } {
            rect.car x=(fine(-length)) y=(fine(-width)) width=(fine(2.0 * length)) height=(fine(2.0 * width)) rx=".5" {}
            rect.glass x=(fine(length * 0.25)) y=(fine(-width * 0.8)) width=".8" height=(fine(width * 1.6)) rx=".2" {}
        }
        circle.person cx=(fine(px)) cy=(fine(py)) r=".55" {}
    }
}

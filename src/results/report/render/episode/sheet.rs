use maud::{Markup, html};

use super::EpisodeView;
use super::narrative::BRAKING;
use crate::report::render::svg::{Digits, Document, line, px};
use episode::Frame;

/// Space at the edges of a picture (px).
pub const EDGE: f64 = 24.0;
/// Height of the titles (px).
pub const HEAD: f64 = 62.0;
/// Room for the numbers of the speeds (px).
const AXIS: f64 = 26.0;
/// Space between the scenes and the speeds, and below the speeds (px).
const ABOVE: f64 = 40.0;
const BELOW: f64 = 44.0;
/// Rules in addition to those of figures.
const STYLE: &str = ".panel text{font-size:12px}.panel text.title{font-size:17px;font-weight:600}\
.paper{fill:var(--paper)}.lamp{fill:var(--brake)}.way,.trail{stroke-linecap:round;stroke-linejoin:round}\
.sight{stroke:var(--ink);stroke-dasharray:.7 .7;stroke-width:.12}.hidden{stroke:var(--paper);stroke-opacity:.7;stroke-dasharray:.7 .7;stroke-width:.12}\
.car{stroke:var(--edge);stroke-width:.16}.person{stroke:var(--edge)}.frame{fill:none;stroke:var(--grid)}.bar{stroke:var(--ink)}.mark{stroke:var(--ink);stroke-dasharray:2 3}\
.car-line,.person-line{fill:none;stroke-width:2}.car-line{stroke:var(--car)}.person-line{stroke:var(--person)}\
.braking{fill:var(--brake);fill-opacity:.13}.unseen{fill:var(--ink);fill-opacity:.18}";

/// The common parts of every picture of an episode: titles at the top, and the speeds of both over time below the scenes.
pub struct Sheet<'a> {
    view: &'a EpisodeView<'a>,
    width: f64,
    /// Top and height of the speeds (px).
    speeds: (f64, f64),
}

impl<'a> Sheet<'a> {
    /// A sheet for scenes of a width and a height (px), with speeds of a height.
    pub fn new(view: &'a EpisodeView<'a>, (width, height): (f64, f64), speeds: f64) -> Self {
        Self { view, width: width + 2.0 * EDGE, speeds: (HEAD + height + ABOVE, speeds) }
    }

    /// The x of a tick in the speeds (px).
    pub fn across(&self, tick: usize) -> f64 {
        let (first, last) = self.view.span();
        let (left, width) = (EDGE + AXIS, self.width - 2.0 * EDGE - AXIS);
        left + width * (tick - first) as f64 / (last - first).max(1) as f64
    }

    /// A dashed line across the speeds at a tick, with its animation.
    pub fn mark(&self, tick: usize, animation: &Markup) -> Markup {
        let (top, height) = self.speeds;
        html! { path.mark d={ "M" (px(self.across(tick))) " " (px(top)) "v" (px(height)) } { (animation) } }
    }

    /// The file: titles, scenes, speeds with the times of some ticks, and marks on them.
    pub fn draw(&self, (title, subtitle): (&str, &str), scenes: &Markup, times: &[usize], marks: &Markup) -> String {
        let (top, height) = self.speeds;
        let body = html! {
            text.ink.title x=(EDGE) y="30" { (title) }
            text.muted x=(EDGE) y="49" { (subtitle) }
            (scenes)
            text.muted x=(EDGE) y=(px(top - 12.0)) { "speed (m/s)" }
            (legend(self.width - EDGE, top - 12.0))
            (self.draw_speeds())
            @for tick in times {
                text.muted.middle x=(px(self.across(*tick))) y=(px(top + height + 25.0)) { (format!("{:.2} s", self.view.time(*tick))) }
            }
            (marks)
        };
        let view = [0.0, 0.0, self.width, (top + height + BELOW).ceil()];
        Document { title, view, width: self.width, style: STYLE }.with(&body)
    }

    /// The speeds of both over time, the times of braking, and the times in which the driver could not see the pedestrian.
    fn draw_speeds(&self) -> Markup {
        let ((top, height), view) = (self.speeds, self.view);
        let fastest = view.shown().map(|(_, frame)| frame.ego.speed.max(frame.pedestrian.speed()));
        let most = (fastest.fold(1.0, f64::max) / 2.0).ceil() * 2.0;
        let up = |speed: f64| top + height * (1.0 - speed / most);
        let steps = if most > 8.0 { 4 } else { 2 };
        let curve =
            |speed: fn(&Frame) -> f64| line(view.shown().map(|(tick, each)| (self.across(tick), up(speed(each)))), 1);
        let (left, right) = (px(self.across(view.span().0)), px(self.across(view.span().1)));
        html! {
            (self.bars("braking", (top, height), &|frame| frame.control.brake > BRAKING))
            (self.bars("unseen", (top + height + 4.0, 5.0), &|frame| !view.pair().in_sight(frame)))
            @for step in 0..=steps {
                @let speed = most * f64::from(step) / f64::from(steps);
                path.grid d={ "M" (left) " " (px(up(speed))) "H" (right) } {}
                text.muted.end x=(px(left.0 - 6.0)) y=(px(up(speed) + 4.0)) { (Digits(speed, 1)) }
            }
            path.person-line d=(curve(|frame| frame.pedestrian.speed())) {}
            path.car-line d=(curve(|frame| frame.ego.speed)) {}
        }
    }

    /// A bar for every interval of ticks in which a condition is true.
    fn bars(&self, class: &str, (top, height): (f64, f64), is_true: &dyn Fn(&Frame) -> bool) -> Markup {
        let last = self.view.span().1;
        let shown: Vec<(usize, bool)> = self.view.shown().map(|(tick, frame)| (tick, is_true(frame))).collect();
        html! {
            @for same in shown.chunk_by(|one, next| one.1 == next.1).filter(|same| same[0].1) {
                @let (from, to) = (self.across(same[0].0), self.across((same[same.len() - 1].0 + 1).min(last)));
                rect class=(class) x=(px(from)) y=(px(top)) width=(px((to - from).max(1.0))) height=(px(height)) {}
            }
        }
    }
}

/// The colours of the speeds, ending at a place of the page (px).
fn legend(right: f64, top: f64) -> Markup {
    let entries =
        [("car-line", "car"), ("person-line", "pedestrian"), ("braking", "car brakes"), ("unseen", "out of sight")];
    let mut at = right - 350.0;
    let placed: Vec<_> = entries
        .into_iter()
        .map(|(class, text)| {
            let here = at;
            at += 34.0 + 6.2 * text.len() as f64;
            (here, class, text)
        })
        .collect();
    html! {
        @for (at, class, text) in placed {
            g transform={ "translate(" (px(at)) " " (px(top)) ")" } {
                @if class.ends_with("line") { path class=(class) d="M0 -4h18" {} }
                @else { rect class=(class) y="-10" width="18" height="12" {} }
                text.muted x="23" { (text) }
            }
        }
    }
}

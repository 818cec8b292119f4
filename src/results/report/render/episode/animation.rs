use maud::{Markup, html};

use super::EpisodeView;
use super::narrative::BRAKING;
use super::sheet::{EDGE, HEAD, Sheet};
use crate::report::render::svg::{Digits, fine, px};
use episode::{Frame, Scenario, Trace};
use verdict::Verdict;

/// Width of the scene (px).
const WIDE: f64 = 760.0;
/// Height of the speeds (px).
const SPEEDS: f64 = 90.0;
/// Pause on the last frame before the animation restarts (s).
const PAUSE: f64 = 1.5;

/// Draws an episode as an animation, in real time. It plays in a browser, without a script.
///
/// `title` and `subtitle` name the episode.
pub fn animation(scenario: &Scenario, trace: &Trace, verdict: Option<&Verdict>, title: &str, subtitle: &str) -> String {
    let view = EpisodeView::new(scenario, trace, verdict);
    let ((first, last), tall) = (view.span(), view.height(WIDE));
    let sheet = Sheet::new(&view, (WIDE, tall), SPEEDS);
    let clock = Clock::new(&view);
    let scenes = html! {
        svg x=(EDGE) y=(HEAD) width=(WIDE) height=(px(tall)) viewBox=(view.view_box()) {
            (view.draw_ground())
            (view.draw_ways(last, 0.35))
            (clock.sight())
            (clock.others())
            (clock.car())
            (clock.person())
            (view.draw_scale())
        }
        rect.frame x=(EDGE) y=(HEAD) width=(WIDE) height=(px(tall)) {}
    };
    let times = [0, 1, 2, 3, 4].map(|part| first + (last - first) * part / 4);
    let mark = sheet.mark(first, &clock.sweep(sheet.across(last) - sheet.across(first)));
    sheet.draw((title, subtitle), &scenes, &times, &mark)
}

/// The times of the frames: the episode, and a pause at its end.
struct Clock<'a> {
    view: &'a EpisodeView<'a>,
    /// Duration of one cycle (s).
    round: f64,
    /// The share of it in which actors move.
    moving: f64,
    /// The shares of the cycle at which the frames are shown.
    key_times: String,
}

impl<'a> Clock<'a> {
    fn new(view: &'a EpisodeView<'a>) -> Self {
        let (first, last) = view.span();
        let length = view.time(last) - view.time(first);
        let round = length + PAUSE;
        let times = (first..=last).map(|tick| Digits((view.time(tick) - view.time(first)) / round, 5).to_string());
        let key_times = times.chain(["1".to_string()]).collect::<Vec<_>>().join(";");
        Self { view, round, moving: length / round, key_times }
    }

    fn duration(&self) -> String {
        format!("{}s", fine(self.round))
    }

    /// The values of an animation: one for every frame, and the last one again for the pause.
    fn values(&self, value: impl FnMut(&Frame) -> String) -> String {
        let mut values: Vec<String> = self.view.shown().map(|(_, frame)| frame).map(value).collect();
        values.extend(values.last().cloned());
        values.join(";")
    }

    /// Animates an attribute; `discrete` values jump, others are interpolated.
    fn attribute(&self, name: &str, discrete: bool, value: impl FnMut(&Frame) -> String) -> Markup {
        let mode = if discrete { "discrete" } else { "linear" };
        html! {
            animate attributeName=(name) calcMode=(mode) values=(self.values(value)) keyTimes=(self.key_times)
                dur=(self.duration()) repeatCount="indefinite" {}
        }
    }

    /// Animates a transformation: `translate` or `rotate`.
    fn transform(&self, kind: &str, value: impl FnMut(&Frame) -> String) -> Markup {
        html! {
            animateTransform attributeName="transform" type=(kind) values=(self.values(value)) keyTimes=(self.key_times)
                dur=(self.duration()) repeatCount="indefinite" {}
        }
    }

    /// Moves the mark over the speeds, by this distance (px).
    fn sweep(&self, width: f64) -> Markup {
        let width = px(width);
        html! {
            animateTransform attributeName="transform" type="translate" values={ "0 0;" (width) " 0;" (width) " 0" }
                keyTimes={ "0;" (Digits(self.moving, 5)) ";1" } dur=(self.duration()) repeatCount="indefinite" {}
        }
    }

    fn car(&self) -> Markup {
        let moved = |frame: &Frame| format!("{} {}", fine(frame.ego.pose.x), fine(-frame.ego.pose.y));
        // An angle that jumps by a full turn would spin the car.
        let mut last: Option<f64> = None;
        let turned = |frame: &Frame| {
            let yaw = -frame.ego.pose.yaw.to_degrees();
            let yaw = last.map_or(yaw, |last| last + (yaw - last + 540.0).rem_euclid(360.0) - 180.0);
            last = Some(yaw);
            px(yaw).to_string()
        };
        let lit = |frame: &Frame| if frame.control.brake > BRAKING { "1" } else { "0" }.to_string();
        html! {
            g {
                (self.transform("translate", moved))
                g {
                    (self.transform("rotate", turned))
                    (self.view.draw_car("1", &self.attribute("opacity", true, lit)))
                }
            }
        }
    }

    fn person(&self) -> Markup {
        let moved = |frame: &Frame| {
            let place = frame.pedestrian.pose.position();
            format!("{} {}", fine(place.x), fine(-place.y))
        };
        html! { @let radius = self.view.person_radius();
        circle.person r=(fine(radius)) stroke-width=(fine(radius * 0.25)) { (self.transform("translate", moved)) } }
    }

    /// The other actors; those that do not move are drawn once.
    fn others(&self) -> Markup {
        let (first, last) = self.view.span();
        html! {
            @for other in self.view.pair().others() {
                @let places = (first..=last).map(|tick| other.state(tick).0).map(|pose| format!("{} {}", fine(pose.x), fine(-pose.y)));
                @let places: Vec<String> = places.collect();
                @let turned = px(-other.state(last).0.yaw.to_degrees()).to_string();
                @let drawn = html! { g transform={ "rotate(" (turned) ")" } { (self.view.draw_other(&other)) } };
                @if places.windows(2).all(|pair| pair[0] == pair[1]) {
                    g transform={ "translate(" (places[0]) ")" } { (drawn) }
                } @else {
                    g {
                        animateTransform attributeName="transform" type="translate" values={ (places.join(";")) ";" (places[places.len() - 1]) }
                            keyTimes=(self.key_times) dur=(self.duration()) repeatCount="indefinite" {}
                        (drawn)
                    }
                }
            }
        }
    }

    fn sight(&self) -> Markup {
        let seen = |frame: &Frame| if self.view.pair().in_sight(frame) { "1" } else { ".15" }.to_string();
        html! {
            path.sight {
                (self.attribute("d", false, |frame| self.view.line_of_sight(frame)))
                (self.attribute("stroke-opacity", true, seen))
            }
        }
    }
}

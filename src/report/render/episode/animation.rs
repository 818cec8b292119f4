use std::fmt::Write;

use super::narrative::BRAKING;
use super::view::{EDGE, EpisodeView, opening};
use crate::env::{Moment, Recording, Scenario};
use crate::judge::Verdict;

/// Width of the scene (px).
const WIDE: f64 = 760.0;
/// Height of the titles and of the speeds below (px).
const HEAD: f64 = 62.0;
const CHART: f64 = 90.0;
/// How long the last moment is seen before it begins again (s).
const PAUSE: f64 = 1.5;

/// Draws an episode as a picture that moves, in the time in which it happened. It plays in a browser, without any script.
///
/// `title` and `subtitle` say which it is.
pub fn animation(
    scenario: &Scenario,
    recording: &Recording,
    verdict: Option<&Verdict>,
    title: &str,
    subtitle: &str,
) -> String {
    let view = EpisodeView::new(scenario, recording, verdict);
    let (first, last) = view.span();
    let tall = WIDE * view.size().y / view.size().x;
    let (width, chart) = (WIDE + 2.0 * EDGE, HEAD + tall + 40.0);
    let height = chart + CHART + 40.0;
    let clock = Clock::new(&view);
    let mut page = opening(width, height, (title, subtitle));
    let _ = writeln!(
        page,
        "<svg x=\"{EDGE}\" y=\"{HEAD}\" width=\"{WIDE}\" height=\"{tall:.1}\" viewBox=\"{}\">",
        view.view_box()
    );
    view.ground(&mut page);
    view.ways(&mut page, last, 0.35);
    clock.sight(&mut page, &view);
    clock.car(&mut page, &view);
    clock.walker(&mut page, &view);
    view.scale(&mut page);
    let _ = writeln!(
        page,
        "</svg>\n<rect class=\"frame\" x=\"{EDGE}\" y=\"{HEAD}\" width=\"{WIDE}\" height=\"{tall:.1}\"/>\n\
         <text class=\"small faint\" x=\"{EDGE}\" y=\"{:.1}\">speed (m/s)</text>",
        chart - 12.0
    );
    EpisodeView::legend(&mut page, width - EDGE, chart - 12.0);
    let (left, wide) = (EDGE + 26.0, WIDE - 26.0);
    view.speeds(&mut page, left, chart, wide, CHART);
    for part in 0..=4 {
        let tick = first + (last - first) * part / 4;
        let x = left + wide * (tick - first) as f64 / (last - first).max(1) as f64;
        let _ = writeln!(
            page,
            "<text class=\"small faint\" x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{:.2} s</text>",
            chart + CHART + 25.0,
            view.time(tick)
        );
    }
    let _ = writeln!(
        page,
        "<path class=\"mark\" d=\"M{left:.1} {chart:.1}v{CHART}\"><animateTransform attributeName=\"transform\" type=\"translate\" \
         values=\"0 0;{wide:.1} 0;{wide:.1} 0\" keyTimes=\"0;{:.5};1\" {}/></path>\n</svg>",
        clock.moving,
        clock.rhythm()
    );
    page
}

/// When what is shown: the episode, and a pause at its end.
struct Clock {
    /// How long a round takes (s).
    round: f64,
    /// The share of it in which anything moves.
    moving: f64,
    /// The shares at which the moments are seen.
    key_times: String,
}

impl Clock {
    fn new(view: &EpisodeView<'_>) -> Self {
        let (first, last) = view.span();
        let length = view.time(last) - view.time(first);
        let round = length + PAUSE;
        let times = (first..=last).map(|tick| format!("{:.5}", (view.time(tick) - view.time(first)) / round));
        let key_times = times.chain(["1".to_string()]).collect::<Vec<_>>().join(";");
        Self { round, moving: length / round, key_times }
    }

    fn rhythm(&self) -> String {
        format!("dur=\"{:.2}s\" repeatCount=\"indefinite\"", self.round)
    }

    /// An animation of an attribute: a value for every moment that is shown, the last one for the pause.
    fn animate(
        &self,
        view: &EpisodeView<'_>,
        element: &str,
        attributes: &str,
        value: &mut dyn FnMut(&Moment) -> String,
    ) -> String {
        let mut values: Vec<String> = view.shown().map(|(_, moment)| value(moment)).collect();
        values.extend(values.last().cloned());
        format!(
            "<{element} {attributes} values=\"{}\" keyTimes=\"{}\" {}/>",
            values.join(";"),
            self.key_times,
            self.rhythm()
        )
    }

    fn car(&self, page: &mut String, view: &EpisodeView<'_>) {
        let moved = "attributeName=\"transform\" type=\"translate\"";
        let moved = self.animate(view, "animateTransform", moved, &mut |moment| {
            format!("{:.2} {:.2}", moment.ego.pose.x, -moment.ego.pose.y)
        });
        // An angle that jumps by a turn would spin the car.
        let mut last: Option<f64> = None;
        let turned = "attributeName=\"transform\" type=\"rotate\"";
        let turned = self.animate(view, "animateTransform", turned, &mut |moment| {
            let yaw = -moment.ego.pose.yaw.to_degrees();
            let yaw = last.map_or(yaw, |last| last + (yaw - last + 540.0).rem_euclid(360.0) - 180.0);
            last = Some(yaw);
            format!("{yaw:.1}")
        });
        let lit = "attributeName=\"opacity\" calcMode=\"discrete\"";
        let lit = self.animate(view, "animate", lit, &mut |moment| {
            if moment.control.brake > BRAKING { "1" } else { "0" }.to_string()
        });
        let car = view.car("").replacen("<g class=\"lamp\">", &format!("<g class=\"lamp\">{lit}"), 1);
        let _ = writeln!(page, "<g>{moved}<g>{turned}{car}</g></g>");
    }

    fn walker(&self, page: &mut String, view: &EpisodeView<'_>) {
        let moved = "attributeName=\"transform\" type=\"translate\"";
        let moved = self.animate(view, "animateTransform", moved, &mut |moment| {
            let place = moment.pedestrian.pose.position();
            format!("{:.2} {:.2}", place.x, -place.y)
        });
        let radius = view.walker_radius();
        let edge = radius * 0.25;
        let _ =
            writeln!(page, "<circle class=\"walker\" r=\"{radius:.2}\" stroke-width=\"{edge:.2}\">{moved}</circle>");
    }

    fn sight(&self, page: &mut String, view: &EpisodeView<'_>) {
        let scenario = view.scenario();
        let line = self.animate(view, "animate", "attributeName=\"d\"", &mut |moment| {
            let (eye, walker) = (moment.eye(scenario), moment.pedestrian.pose.position());
            format!("M{:.2} {:.2}L{:.2} {:.2}", eye.x, -eye.y, walker.x, -walker.y)
        });
        let seen = "attributeName=\"stroke-opacity\" calcMode=\"discrete\"";
        let seen = self.animate(view, "animate", seen, &mut |moment| {
            if moment.in_sight(scenario) { "1" } else { ".15" }.to_string()
        });
        let _ = writeln!(page, "<path class=\"sight\">{line}{seen}</path>");
    }
}

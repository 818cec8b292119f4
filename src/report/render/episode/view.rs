//! What pictures of an episode have in common: the part of it that is shown, the ground beneath, the actors.

use std::fmt::Write;
use std::ops::RangeInclusive;

use super::super::svg::escape;
use super::super::town::{Scenery, polygon};
use super::narrative::BRAKING;
use crate::env::{Moment, Recording, Scenario};
use crate::geometry::{Point, Vector};
use crate::judge::Verdict;

/// What is shown before the danger begins, and of an episode without a collision around its least gap (s).
const BEFORE: f64 = 1.5;
/// The shortest and the longest part of an episode that is shown (s).
const SHORTEST: f64 = 3.0;
const LONGEST: f64 = 8.0;
/// Ground around the actors (m), and the least that is shown of it.
const MARGIN: f64 = 5.0;
const LEAST: f64 = 24.0;

/// How everything looks.
pub const STYLE: &str = "\
.paper{fill:#fff}.ground{fill:#e9ece4}.walk{fill:#d5d7d9}.lane{fill:#a3a8ae}.zebra{fill:#f4f4f0;fill-opacity:.85}\
.house{fill:#c2b196;stroke:#96856b;stroke-width:.2}.car{fill:#1f5fc4;stroke:#fff;stroke-width:.16}.glass{fill:#bcd3f5}\
.lamp{fill:#ff2a1a}.walker{fill:#d4202c;stroke:#fff}.way{fill:none;stroke-linecap:round;stroke-linejoin:round}\
.ego-way{stroke:#1f5fc4}.walker-way{stroke:#d4202c}.sight{stroke:#222;stroke-dasharray:.7 .7;stroke-width:.12;fill:none}\
.hidden{stroke:#fff;stroke-opacity:.7}.frame{fill:none;stroke:#b9bdc2}\
text{font-family:Inter,'Helvetica Neue',Arial,sans-serif;fill:#22262b}.title{font-size:17px;font-weight:600}\
.small{font-size:12px}.faint{fill:#6a7078}.axis{stroke:#c8ccd0;stroke-width:1}.ego-line{fill:none;stroke:#1f5fc4;stroke-width:2}\
.walker-line{fill:none;stroke:#d4202c;stroke-width:2}.mark{stroke:#22262b;stroke-width:1;stroke-dasharray:2 3}\
.braking{fill:#ff2a1a;fill-opacity:.13}.unseen{fill:#22262b;fill-opacity:.18}";

/// The part of an episode that a picture shows.
pub struct EpisodeView<'a> {
    scenario: &'a Scenario,
    moments: &'a [Moment],
    ticks: RangeInclusive<usize>,
    /// South-west corner and size of what is seen (m).
    low: Point,
    size: Vector,
}

impl<'a> EpisodeView<'a> {
    /// Chooses what is shown: from a little before the danger began to the touch, or the time around the least gap.
    pub fn new(scenario: &'a Scenario, recording: &'a Recording, verdict: Option<&Verdict>) -> Self {
        let (moments, dt) = (recording.moments(), scenario.episode.tick);
        let (last, count) = (moments.len() - 1, |time: f64| (time / dt).round() as usize);
        let ticks = match verdict {
            Some(verdict) => {
                let shown = (verdict.warning + BEFORE).clamp(SHORTEST, LONGEST);
                last.saturating_sub(count(shown))..=last
            }
            None => {
                let gap = |tick: &usize| moments[*tick].gap(scenario);
                let nearest = (0..=last).min_by(|one, other| gap(one).total_cmp(&gap(other))).unwrap_or(0);
                nearest.saturating_sub(count(SHORTEST))..=(nearest + count(SHORTEST)).min(last)
            }
        };
        let shown = &moments[ticks.clone()];
        let places = shown.iter().flat_map(|moment| {
            let corners = moment.outline(scenario).corners();
            corners.into_iter().chain([moment.pedestrian.pose.position()])
        });
        let (mut low, mut high) = (Point::new(f64::MAX, f64::MAX), Point::new(f64::MIN, f64::MIN));
        for place in places {
            (low.x, low.y) = (low.x.min(place.x), low.y.min(place.y));
            (high.x, high.y) = (high.x.max(place.x), high.y.max(place.y));
        }
        let around = Vector::new(MARGIN, MARGIN);
        let wanted = high - low + around * 2.0;
        // Neither too flat nor too tall for a page.
        let size = Vector::new(wanted.x.max(LEAST).max(wanted.y * 0.85), wanted.y.max(LEAST * 0.6).max(wanted.x * 0.5));
        let middle = low + (high - low) / 2.0;
        Self { scenario, moments, ticks, low: middle - size / 2.0, size }
    }

    /// The moments that are shown, each with its tick.
    pub fn shown(&self) -> impl Iterator<Item = (usize, &'a Moment)> {
        self.ticks.clone().zip(&self.moments[self.ticks.clone()])
    }

    /// First and last tick.
    pub fn span(&self) -> (usize, usize) {
        (*self.ticks.start(), *self.ticks.end())
    }

    /// The time of a tick (s).
    pub fn time(&self, tick: usize) -> f64 {
        tick as f64 * self.scenario.episode.tick
    }

    /// The scenario.
    pub fn scenario(&self) -> &'a Scenario {
        self.scenario
    }

    /// Width and height of what is seen (m).
    pub fn size(&self) -> Vector {
        self.size
    }

    /// The `viewBox` of what is seen; y points down there.
    pub fn view_box(&self) -> String {
        let Self { low, size, .. } = self;
        format!("{:.2} {:.2} {:.2} {:.2}", low.x, -low.y - size.y, size.x, size.y)
    }

    /// Draws the ground: what of the town is in view.
    pub fn ground(&self, page: &mut String) {
        let (low, size, town) = (self.low, self.size, &self.scenario.town);
        let _ = writeln!(
            page,
            "<rect class=\"ground\" x=\"{:.2}\" y=\"{:.2}\" width=\"{:.2}\" height=\"{:.2}\"/>",
            low.x,
            -low.y - size.y,
            size.x,
            size.y
        );
        for (surface, corners) in &Scenery::new(town).within(low, low + size).polygons {
            polygon(page, surface.class(), corners);
        }
    }

    /// Draws a bar of five metres into the corner.
    pub fn scale(&self, page: &mut String) {
        let part = self.size.x * 0.01;
        let (x, y) = (self.low.x + 2.0 * part, -self.low.y - 2.0 * part);
        let _ = writeln!(
            page,
            "<path d=\"M{x:.2} {y:.2}h5\" stroke=\"#22262b\" stroke-width=\"{:.2}\"/>\
             <text x=\"{:.2}\" y=\"{:.2}\" style=\"font-size:{:.2}px\">5 m</text>",
            part * 0.5,
            x + 5.0 + part,
            y + part,
            part * 3.4
        );
    }

    /// How large the pedestrian is drawn (m): as it is, but never so small that it gets lost.
    pub fn walker_radius(&self) -> f64 {
        self.scenario.adversary.body.radius.max(self.size.x * 0.012)
    }

    /// Draws the ways of both from the first shown tick to this one.
    pub fn ways(&self, page: &mut String, end: usize, opacity: f64) {
        let shown = &self.moments[*self.ticks.start()..=end];
        let width = self.size.x * 0.006;
        let mut way = |class: &str, place: &dyn Fn(&Moment) -> Point| {
            let points = points(shown.iter().map(place));
            let _ = writeln!(
                page,
                "<polyline class=\"way {class}\" stroke-width=\"{width:.2}\" stroke-opacity=\"{opacity}\" points=\"{points}\"/>"
            );
        };
        way("ego-way", &|moment| moment.ego.pose.position());
        way("walker-way", &|moment| moment.pedestrian.pose.position());
    }

    /// Draws the line of sight: dashed, and pale where something stands in between.
    pub fn sight(&self, page: &mut String, moment: &Moment) {
        let (eye, walker) = (moment.eye(self.scenario), moment.pedestrian.pose.position());
        let class = if moment.in_sight(self.scenario) { "sight" } else { "sight hidden" };
        let _ = writeln!(
            page,
            "<path class=\"{class}\" d=\"M{:.2} {:.2}L{:.2} {:.2}\"/>",
            eye.x, -eye.y, walker.x, -walker.y
        );
    }

    /// Draws both where they are.
    pub fn actors(&self, page: &mut String, moment: &Moment) {
        let pose = &moment.ego.pose;
        let lit = if moment.control.brake > BRAKING { "" } else { " opacity=\"0\"" };
        let _ = writeln!(
            page,
            "<g transform=\"translate({:.3} {:.3}) rotate({:.2})\">{}</g>",
            pose.x,
            -pose.y,
            -pose.yaw.to_degrees(),
            self.car(lit)
        );
        let place = moment.pedestrian.pose.position();
        let radius = self.walker_radius();
        let _ = writeln!(
            page,
            "<circle class=\"walker\" cx=\"{:.3}\" cy=\"{:.3}\" r=\"{radius:.2}\" stroke-width=\"{:.2}\"/>",
            place.x,
            -place.y,
            radius * 0.25
        );
    }

    /// The car at the origin, looking along x; `lit` are the attributes of its brake lamps, or what they contain.
    pub fn car(&self, lit: &str) -> String {
        let vehicle = &self.scenario.vehicle;
        let (length, width) = (vehicle.half_length, vehicle.half_width);
        format!(
            "<rect class=\"car\" x=\"{:.2}\" y=\"{:.2}\" width=\"{:.2}\" height=\"{:.2}\" rx=\".45\"/>\
             <rect class=\"glass\" x=\"{:.2}\" y=\"{:.2}\" width=\".7\" height=\"{:.2}\" rx=\".2\"/>\
             <g class=\"lamp\"{lit}><rect x=\"{:.2}\" y=\"{:.2}\" width=\".35\" height=\".5\"/>\
             <rect x=\"{:.2}\" y=\"{:.2}\" width=\".35\" height=\".5\"/></g>",
            -length,
            -width,
            2.0 * length,
            2.0 * width,
            length * 0.25,
            -width * 0.8,
            width * 1.6,
            -length,
            -width + 0.12,
            -length,
            width - 0.62,
        )
    }

    /// Draws the speeds of both over time into a box of the page (px), with what the driver did and when it could not see.
    pub fn speeds(&self, page: &mut String, left: f64, top: f64, width: f64, height: f64) {
        let (first, last) = self.span();
        let across = |tick: usize| left + width * (tick - first) as f64 / (last - first).max(1) as f64;
        let fastest = self.shown().map(|(_, moment)| moment.ego.speed.max(moment.pedestrian.speed()));
        let most = (fastest.fold(1.0, f64::max) / 2.0).ceil() * 2.0;
        let up = |speed: f64| top + height * (1.0 - speed / most);
        for (class, holds) in [
            ("braking", &(|moment: &Moment| moment.control.brake > BRAKING) as &dyn Fn(&Moment) -> bool),
            ("unseen", &|moment| !moment.in_sight(self.scenario)),
        ] {
            let (y, tall) = if class == "braking" { (top, height) } else { (top + height + 4.0, 5.0) };
            let shown: Vec<(usize, bool)> = self.shown().map(|(tick, moment)| (tick, holds(moment))).collect();
            for same in shown.chunk_by(|one, next| one.1 == next.1).filter(|same| same[0].1) {
                let (from, to) = (across(same[0].0), across((same[same.len() - 1].0 + 1).min(last)));
                let _ = writeln!(
                    page,
                    "<rect class=\"{class}\" x=\"{from:.1}\" y=\"{y:.1}\" width=\"{:.1}\" height=\"{tall:.1}\"/>",
                    (to - from).max(1.0)
                );
            }
        }
        let steps = if most > 8.0 { 4 } else { 2 };
        for step in 0..=steps {
            let speed = most * f64::from(step) / f64::from(steps);
            let y = up(speed);
            let _ = writeln!(
                page,
                "<path class=\"axis\" d=\"M{left:.1} {y:.1}h{width:.1}\"/>\
                 <text class=\"small faint\" x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{speed}</text>",
                left - 6.0,
                y + 4.0
            );
        }
        let mut line = |class: &str, speed: &dyn Fn(&Moment) -> f64| {
            let each = self.shown().map(|(tick, moment)| format!("{:.1},{:.1}", across(tick), up(speed(moment))));
            let points = each.collect::<Vec<_>>().join(" ");
            let _ = writeln!(page, "<polyline class=\"{class}\" points=\"{points}\"/>");
        };
        line("walker-line", &|moment| moment.pedestrian.speed());
        line("ego-line", &|moment| moment.ego.speed);
    }

    /// Draws what the speeds' colours mean, ending at a place of the page (px).
    pub fn legend(page: &mut String, right: f64, top: f64) {
        let entries = [
            ("<path class=\"ego-line\" d=\"M0 -4h18\"/>", "car"),
            ("<path class=\"walker-line\" d=\"M0 -4h18\"/>", "pedestrian"),
            ("<rect class=\"braking\" y=\"-10\" width=\"18\" height=\"12\"/>", "car brakes"),
            ("<rect class=\"unseen\" y=\"-7\" width=\"18\" height=\"5\"/>", "out of sight"),
        ];
        let mut at = right - 350.0;
        for (sign, text) in entries {
            let _ = writeln!(
                page,
                "<g transform=\"translate({at:.1} {top:.1})\">{sign}<text class=\"small faint\" x=\"23\">{text}</text></g>"
            );
            at += 34.0 + 6.2 * text.len() as f64;
        }
    }
}

/// Points of a line, y down.
pub fn points(places: impl Iterator<Item = Point>) -> String {
    places.map(|place| format!("{:.2},{:.2}", place.x, -place.y)).collect::<Vec<_>>().join(" ")
}

/// Space at the edges of a picture (px).
pub const EDGE: f64 = 24.0;

/// How a picture of an episode begins: its size (px), its style, its title and subtitle.
pub fn opening(width: f64, height: f64, (title, subtitle): (&str, &str)) -> String {
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height:.0}\" width=\"{width}\" height=\"{height:.0}\">\n\
         <title>{0}</title>\n<style>{STYLE}</style>\n<rect class=\"paper\" width=\"{width}\" height=\"{height:.0}\"/>\n\
         <text class=\"title\" x=\"{EDGE}\" y=\"30\">{0}</text>\n<text class=\"small faint\" x=\"{EDGE}\" y=\"49\">{1}</text>\n",
        escape(title),
        escape(subtitle),
    )
}

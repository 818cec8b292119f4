//! A town from above, with where episodes began and how they ended.

use std::collections::BTreeMap;
use std::fmt::Write;

use super::super::svg::escape;
use super::scenery::Scenery;
use crate::env::{Ending, Outcome, Spawn};
use crate::geometry::{Point, Pose};
use crate::road::Town;

/// Ground shown around the town (m).
const MARGIN: f64 = 12.0;
/// Most beginnings that are drawn of a policy and a block.
const MOST_STARTS: u32 = 1000;
/// Height of the strip for the legend (m).
const LEGEND: f64 = 14.0;

/// Draws a town, and a dot for every place where pedestrians began: the redder, the more of them hit a moving car, the
/// bluer its ring, the more hit a standing one.
pub fn town_map(town: &Town, starts: &Starts) -> String {
    drawn(town, &|page, x, y| {
        for start in &starts.places {
            dot(page, start.place.x, -start.place.y, start.share(start.moving), start.share(start.standing));
        }
        if !starts.places.is_empty() {
            dots_legend(page, x, y);
        }
    })
}

/// Draws a town with beginnings of episodes: the egos in blue, the pedestrians in red, both with where they look.
pub fn spawn_map(town: &Town, spawns: &[Spawn]) -> String {
    drawn(town, &|page, x, y| {
        for spawn in spawns {
            arrow(page, &spawn.ego, "ego", 3.0);
        }
        for spawn in spawns {
            arrow(page, &spawn.pedestrian, "pedestrian", 1.6);
        }
        for (at, class, text) in [(75.0, "ego", "the ego begins here"), (130.0, "pedestrian", "the pedestrian")] {
            arrow(page, &Pose::new(x + at, -y, 0.0), class, 3.0);
            label(page, x + at + 5.0, y, text);
        }
    })
}

/// Draws a town with something on it; the place of the legend goes along.
fn drawn(town: &Town, content: &dyn Fn(&mut String, f64, f64)) -> String {
    let (low, high) = town.bounds();
    let (width, height) = (high.x - low.x + 2.0 * MARGIN, high.y - low.y + 2.0 * MARGIN + LEGEND);
    let (left, top) = (low.x - MARGIN, -high.y - MARGIN);
    let mut page = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"{left:.1} {top:.1} {width:.1} {height:.1}\" width=\"1000\" \
         font-family=\"sans-serif\">\n<title>{}</title>\n\
         <style>.ground{{fill:#e8ebe4}}.walk{{fill:#cfd1d4}}.lane{{fill:#8b9096}}.zebra{{fill:#f2f2ee;fill-opacity:.8}}\
         .house{{fill:#b9a68c;stroke:#8f7c63;stroke-width:.3}}.start{{stroke-width:.6}}\
         .ego,.pedestrian{{fill:none;stroke-width:.7;stroke-linecap:round}}.ego{{stroke:#1f5fc4}}\
         .pedestrian{{stroke:#b2182b}}</style>\n\
         <rect class=\"ground\" x=\"{left:.1}\" y=\"{top:.1}\" width=\"{width:.1}\" height=\"{height:.1}\"/>\n",
        escape(&town.name),
    );
    for (surface, corners) in &Scenery::new(town).polygons {
        polygon(&mut page, surface.class(), corners);
    }
    let (x, y) = (left + MARGIN, top + height - LEGEND / 2.0);
    scale_bar(&mut page, x, y);
    content(&mut page, x, y);
    page.push_str("</svg>\n");
    page
}

/// A stroke from a pose to where it looks, with a round foot.
fn arrow(page: &mut String, pose: &Pose, class: &str, length: f64) {
    let tip = pose.to_world(crate::geometry::Vector::new(length, 0.0));
    let _ = writeln!(
        page,
        "<path class=\"{class}\" d=\"M{:.1} {:.1}m-.4 0a.4 .4 0 1 0 .8 0a.4 .4 0 1 0 -.8 0M{:.1} {:.1}L{:.1} {:.1}\"/>",
        pose.x, -pose.y, pose.x, -pose.y, tip.x, -tip.y
    );
}

/// Places where pedestrians began: the same in all runs of a policy and a block.
#[derive(Debug, Clone, Default)]
pub struct Starts {
    places: Vec<Start>,
    index: BTreeMap<(String, u32, u32), usize>,
}

impl Starts {
    /// Adds an episode by its policy, block and number. Only the first ones are drawn: more dots would hide the town.
    pub fn add(&mut self, (policy, block, episode): (&str, u32, u32), outcome: &Outcome) {
        if episode >= MOST_STARTS {
            return;
        }
        let place = *self.index.entry((policy.to_string(), block, episode)).or_insert_with(|| {
            self.places.push(Start { place: outcome.spawn.pedestrian, moving: 0, standing: 0, all: 0 });
            self.places.len() - 1
        });
        let start = &mut self.places[place];
        start.all += 1;
        match outcome.ending {
            Ending::Collision { moving: true, .. } => start.moving += 1,
            Ending::Collision { .. } => start.standing += 1,
            _ => {}
        }
    }
}

/// How the episodes that began at a place ended.
#[derive(Debug, Clone)]
struct Start {
    place: Pose,
    moving: u32,
    standing: u32,
    all: u32,
}

impl Start {
    fn share(&self, count: u32) -> f64 {
        f64::from(count) / f64::from(self.all.max(1))
    }
}

fn dot(page: &mut String, x: f64, y: f64, moving: f64, standing: f64) {
    let mix = |from: f64, to: f64, share: f64| (from + (to - from) * share).round();
    let (r, g, b) = (mix(255.0, 178.0, moving), mix(255.0, 24.0, moving), mix(255.0, 43.0, moving));
    let (sr, sg, sb) = (mix(120.0, 33.0, standing), mix(120.0, 102.0, standing), mix(120.0, 220.0, standing));
    let _ = writeln!(
        page,
        "<circle class=\"start\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"1.2\" fill=\"rgb({r},{g},{b})\" stroke=\"rgb({sr},{sg},{sb})\"/>"
    );
}

fn label(page: &mut String, x: f64, y: f64, text: &str) {
    let _ = writeln!(page, "<text x=\"{x:.1}\" y=\"{:.1}\" font-size=\"4.5\">{text}</text>", y + 1.6);
}

/// A bar of fifty metres.
fn scale_bar(page: &mut String, x: f64, y: f64) {
    let _ = writeln!(page, "<rect x=\"{x:.1}\" y=\"{:.1}\" width=\"50\" height=\"1\" fill=\"#333\"/>", y - 0.5);
    label(page, x + 52.0, y, "50 m");
}

/// What the dots mean.
fn dots_legend(page: &mut String, x: f64, y: f64) {
    for (at, moving, standing, text) in [
        (75.0, 0.0, 0.0, "began here: none hit"),
        (130.0, 1.0, 0.0, "all hit, car moving"),
        (182.0, 0.0, 1.0, "all hit, car standing"),
    ] {
        dot(page, x + at, y, moving, standing);
        label(page, x + at + 3.0, y, text);
    }
}

/// Draws a polygon, y down.
pub fn polygon(page: &mut String, class: &str, corners: &[Point]) {
    let _ = write!(page, "<polygon class=\"{class}\" points=\"");
    for corner in corners {
        let _ = write!(page, "{:.2},{:.2} ", corner.x, -corner.y);
    }
    page.push_str("\"/>\n");
}

//! A town from above, with the starts of episodes and their ends.

use std::collections::BTreeMap;

use maud::{Markup, html};

use super::Scenery;
use crate::report::render::svg::{Document, outline, px};
use episode::Spawn;
use road::Town;
use road::geometry::{Point, Pose, Vector};

/// Ground shown around the town (m).
const MARGIN: f64 = 12.0;
/// Most starts in the picture for a policy and a block.
const MAX_STARTS: u32 = 1000;
/// Height of the strip for the legend (m).
const LEGEND: f64 = 14.0;
/// Rules of the map: its unit is a metre.
const STYLE: &str = ".panel text{font-size:4.5px;fill:var(--ink)}.start{stroke-width:.6}.ego,.pedestrian{fill:none;stroke-width:.7;\
stroke-linecap:round}.ego{stroke:var(--car)}.pedestrian{stroke:var(--person)}.paper{fill:var(--ground)}";

/// Draws a town, and a dot for every place where pedestrians started. The dot is redder the more of them collided; its ring is bluer the more of
/// them were bumps.
pub fn town_map(town: &Town, starts: &Starts) -> String {
    let legend =
        [(75.0, 0.0, 0.0, "start: no collision"), (130.0, 1.0, 0.0, "all collisions"), (182.0, 0.0, 1.0, "all bumps")];
    drawn(town, |x, y| {
        html! {
            @for start in &starts.places {
                (dot(start.place.x, -start.place.y, start.share(start.collisions), start.share(start.bumps)))
            }
            @if !starts.places.is_empty() {
                @for (at, collisions, bumps, text) in legend { (dot(x + at, y, collisions, bumps)) (label(x + at + 3.0, y, text)) }
            }
        }
    })
}

/// Draws a town with starts of episodes: the egos in blue, the pedestrians in red, both with their headings.
pub fn spawn_map(town: &Town, spawns: &[Spawn]) -> String {
    drawn(town, |x, y| {
        html! {
            @for spawn in spawns { (arrow(&spawn.ego, "ego", 3.0)) }
            @for spawn in spawns { (arrow(&spawn.pedestrian, "pedestrian", 1.6)) }
            @for (at, class, text) in [(75.0, "ego", "start of the ego"), (130.0, "pedestrian", "start of the pedestrian")] {
                (arrow(&Pose::new(x + at, -y, 0.0), class, 3.0))
                (label(x + at + 5.0, y, text))
            }
        }
    })
}

/// Draws a town with further shapes, which also get the place of the legend.
fn drawn(town: &Town, content: impl Fn(f64, f64) -> Markup) -> String {
    let (low, high) = town.bounds();
    let (width, height) = (high.x - low.x + 2.0 * MARGIN, high.y - low.y + 2.0 * MARGIN + LEGEND);
    let (left, top) = (low.x - MARGIN, -high.y - MARGIN);
    let (x, y) = (left + MARGIN, top + height - LEGEND / 2.0);
    let body = html! {
        (Scenery::new(town).drawn())
        rect.ink x=(px(x)) y=(px(y - 0.5)) width="50" height="1" {}
        (label(x + 52.0, y, "50 m"))
        (content(x, y))
    };
    Document { title: &town.name, view: [left, top, width, height], width: 1000.0, style: STYLE }.with(&body)
}

/// A stroke from a pose along its heading, with a round foot.
fn arrow(pose: &Pose, class: &str, length: f64) -> Markup {
    let tip = pose.to_world(Vector::new(length, 0.0));
    let (x, y) = (px(pose.x), px(-pose.y));
    html! {
        path class=(class) d={ "M" (x) " " (y) "m-.4 0a.4 .4 0 1 0 .8 0a.4 .4 0 1 0 -.8 0M" (x) " " (y) "L" (px(tip.x)) " " (px(-tip.y)) } {}
    }
}

fn label(x: f64, y: f64, text: &str) -> Markup {
    html! { text x=(px(x)) y=(px(y + 1.6)) { (text) } }
}

fn dot(x: f64, y: f64, collisions: f64, bumps: f64) -> Markup {
    let mix = |from: f64, to: f64, share: f64| (from + (to - from) * share).round();
    let colour = |from: [f64; 3], to: [f64; 3], share: f64| {
        let [r, g, b] = std::array::from_fn(|part| mix(from[part], to[part], share));
        format!("rgb({r},{g},{b})")
    };
    html! {
        circle.start cx=(px(x)) cy=(px(y)) r="1.2" fill=(colour([255.0; 3], [178.0, 24.0, 43.0], collisions))
            stroke=(colour([120.0; 3], [33.0, 102.0, 220.0], bumps)) {}
    }
}

/// Places where pedestrians started: the same in all runs of a policy and a block.
#[derive(Debug, Clone, Default)]
pub struct Starts {
    places: Vec<Start>,
    index: BTreeMap<(String, u32, u32), usize>,
}

impl Starts {
    /// Adds an episode by its policy, block and number: where the pedestrian started, and of a touch whether it is a collision. Only the
    /// first ones are drawn, since more dots would hide the town.
    pub fn add(&mut self, (policy, block, episode): (&str, u32, u32), pedestrian: Pose, touch: Option<bool>) {
        if episode >= MAX_STARTS {
            return;
        }
        let place = *self.index.entry((policy.to_string(), block, episode)).or_insert_with(|| {
            self.places.push(Start { place: pedestrian, collisions: 0, bumps: 0, all: 0 });
            self.places.len() - 1
        });
        let start = &mut self.places[place];
        start.all += 1;
        start.collisions += u32::from(touch == Some(true));
        start.bumps += u32::from(touch == Some(false));
    }
}

/// The ends of the episodes that started at a place.
#[derive(Debug, Clone)]
struct Start {
    place: Pose,
    collisions: u32,
    bumps: u32,
    all: u32,
}

impl Start {
    fn share(&self, count: u32) -> f64 {
        f64::from(count) / f64::from(self.all.max(1))
    }
}

impl Scenery {
    /// Its polygons, y down.
    pub fn drawn(&self) -> Markup {
        let corners = |corners: &[Point]| outline(corners.iter().map(|corner| (corner.x, -corner.y)), 2);
        html! { @for (surface, each) in &self.polygons { path class=(surface.name()) d=(corners(each)) {} } }
    }
}

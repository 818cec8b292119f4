use std::collections::BTreeMap;
use std::fmt::Write;

use maud::{Markup, html};

use super::identity::Named;
use super::tally::{Bin, Bins, NEAR, Tally};
use crate::report::render::svg::{Digits, Figure, Panel, px};

/// Width of a panel.
const WIDTH: f64 = 286.0;
/// Maximum number of panels; the pictures of the towns show the rest.
const MAX_PANELS: usize = 12;
/// Least number of episodes of a bin that is drawn at its full size.
const FULL: u32 = 5;

/// Trained pedestrians that share a map.
struct Group {
    title: String,
    around: Bins,
}

/// The starts of trained pedestrians as the car sees them, and how often they collide from there; `None` without a training. The towns with the starts are
/// files of their own.
pub fn spawns(tally: &Tally, cells: &[Named<'_>]) -> Option<Figure> {
    let mut groups: Vec<Group> = Vec::new();
    for named in cells.iter().filter(|named| named.cell.key.controller == "trained") {
        let Some(found) = tally.around.get(&named.cell.key) else { continue };
        let title = format!("{} · {}", named.place, named.cell.key.reward);
        let place = groups.iter().position(|group| group.title == title).unwrap_or_else(|| {
            groups.push(Group { title, around: Bins::new() });
            groups.len() - 1
        });
        let into = &mut groups[place].around;
        found.iter().for_each(|(place, bin)| into.entry(*place).or_default().merge(*bin));
    }
    let left_out = groups.len().saturating_sub(MAX_PANELS);
    groups.truncate(MAX_PANELS);
    if groups.is_empty() {
        return None;
    }
    let cut = if left_out > 0 { format!(" {left_out} more are not shown.") } else { String::new() };
    let legend: Vec<(String, String)> = ["never", "up to 20 %", "40 %", "60 %", "80 %", "above 80 %"]
        .iter()
        .enumerate()
        .map(|(level, text)| (format!("h{level}"), (*text).to_string()))
        .collect();
    let reach = Reach::new(&groups);
    let around = Figure {
        name: "spawns-around".into(),
        title: format!(
            "Where pedestrians started as the car sees it (it drives upwards), and how often a collision followed.{cut}"
        ),
        legend,
        panels: groups.iter().map(|group| around(&group.title, &group.around, reach)).collect(),
        ..Figure::default()
    };
    Some(around)
}

/// The class in the legend of a rate: the first class has only bins without a hit.
fn level(bin: Bin) -> usize {
    if bin.collisions == 0 {
        0
    } else {
        (f64::from(bin.collisions) / f64::from(bin.episodes.max(1)) * 5.0).ceil().clamp(1.0, 5.0) as usize
    }
}

/// Squares with an edge. Bins with fewer episodes are smaller; those with the highest rates are on top.
fn squares(bins: &Bins, edge: f64, place: impl Fn(f64, f64) -> (f64, f64)) -> Markup {
    let mut by_level: BTreeMap<usize, String> = BTreeMap::new();
    for ((column, row), bin) in bins {
        let (x, y) = place((f64::from(*column) + 0.5) * edge, (f64::from(*row) + 0.5) * edge);
        let side = edge * (0.45 + 0.55 * f64::from(bin.episodes.min(FULL)) / f64::from(FULL)) * 0.96;
        let path = by_level.entry(level(*bin)).or_default();
        let side = px(side);
        let _ = write!(path, "M{} {}h{side}v{side}h-{side}z", px(x - side.0 / 2.0), px(y - side.0 / 2.0));
    }
    html! { @for (level, path) in &by_level { path class={ "h" (level) } d=(path) {} } }
}

/// The text of a map, for readers who do not see it.
fn says(bins: &Bins) -> String {
    let mut all = Bin::default();
    bins.values().for_each(|bin| all.merge(*bin));
    format!("{} episodes from {} places; {} ended in a collision.", all.episodes, bins.len(), all.collisions)
}

/// The ground that all surroundings show ahead of the car, behind it and on either side (m).
#[derive(Debug, Clone, Copy)]
struct Reach {
    front: f64,
    back: f64,
    side: f64,
}

impl Reach {
    fn new(groups: &[Group]) -> Self {
        let mut reach = Self { front: 12.0, back: 5.0, side: 12.0 };
        for (ahead, left) in groups.iter().flat_map(|group| group.around.keys()) {
            let (ahead, left) = (f64::from(*ahead) * NEAR, f64::from(*left) * NEAR);
            reach.front = reach.front.max(ahead + 3.0 * NEAR);
            reach.back = reach.back.max(NEAR - ahead);
            reach.side = reach.side.max(left + 2.0 * NEAR).max(NEAR - left);
        }
        reach
    }
}

/// The surroundings of the car, which faces up.
fn around(title: &str, bins: &Bins, reach: Reach) -> Panel {
    let scale = WIDTH / (2.0 * reach.side);
    let height = (reach.front + reach.back) * scale;
    let (middle, bumper) = (WIDTH / 2.0, reach.front * scale);
    // No pedestrian starts beside the car, so the labels of the rings are there.
    let rings = || (1..).map(|ring| f64::from(ring) * 10.0).take_while(|ring| *ring < reach.front.max(reach.side));
    let body = html! {
        rect.ground width=(WIDTH) height=(px(height)) {}
        g transform={ "translate(" (px(middle)) " " (px(bumper)) ") scale(" (Digits(scale, 3)) ")" } {
            @for ring in rings() { circle.ring stroke-width=(Digits(1.0 / scale, 3)) r=(ring) {} }
            (squares(bins, NEAR, |x, y| (-y, -x)))
            rect.car x="-.95" y="-2.3" width="1.9" height="4.6" rx=".6" {}
        }
        @for ring in rings().filter(|ring| ring + 4.0 < reach.side) {
            text.muted.middle x=(px(middle + ring * scale)) y=(px(bumper + 12.0)) { (ring) " m" }
        }
    };
    Panel { title: title.into(), says: says(bins), size: (WIDTH, height), body }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_never_hit_is_pale() {
        let bin = |collisions| level(Bin { episodes: 10, collisions });
        assert_eq!([0, 1, 2, 3, 8, 9, 10].map(bin), [0, 1, 1, 2, 4, 5, 5]);
    }
}

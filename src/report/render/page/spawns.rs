use std::collections::BTreeMap;
use std::fmt::Write;

use super::super::town::Scenery;
use super::figure::{Figure, Panel};
use super::identity::Named;
use super::markup::{escape, slug};
use super::tally::{Bin, Bins, FAR, NEAR, Tally};
use crate::compile::NamedTown;
use crate::geometry::Point;

/// Width of a panel.
const WIDTH: f64 = 286.0;
/// As many panels at most; the rest is in the towns' own pictures.
const PANELS: usize = 12;
/// Ground shown around the outermost beginning (m).
const MARGIN: f64 = 8.0;
/// So many squares are across a town at most.
const ACROSS: f64 = 56.0;
/// A bin with so many episodes is drawn at its full size.
const FULL: u32 = 5;

/// Trained pedestrians that share a map.
struct Group<'a> {
    title: String,
    town: &'a NamedTown,
    starts: Bins,
    around: Bins,
}

/// Where trained pedestrians began and how often they hit a moving car from there: over the towns, and about the car.
pub fn spawns(tally: &Tally, cells: &[Named<'_>], towns: &[NamedTown]) -> Vec<Figure> {
    let mut groups: Vec<Group<'_>> = Vec::new();
    for named in cells.iter().filter(|named| named.cell.key.controller == "trained") {
        let Some(found) = tally.cells.iter().find(|cell| cell.key == named.cell.key) else { continue };
        let Some(town) = towns.iter().find(|town| town.name == named.cell.key.town) else { continue };
        let title = format!("{} · {}", named.place, named.cell.key.reward);
        let place = groups.iter().position(|group| group.title == title).unwrap_or_else(|| {
            groups.push(Group { title, town, starts: Bins::new(), around: Bins::new() });
            groups.len() - 1
        });
        let group = &mut groups[place];
        for (into, from) in [(&mut group.starts, &found.town), (&mut group.around, &found.around)] {
            from.iter().for_each(|(place, bin)| into.entry(*place).or_default().merge(*bin));
        }
    }
    let left_out = groups.len().saturating_sub(PANELS);
    groups.truncate(PANELS);
    if groups.is_empty() {
        return Vec::new();
    }
    let cut = if left_out > 0 { format!(" {left_out} more are not shown.") } else { String::new() };
    let legend: Vec<(String, String)> = ["never", "up to 20 %", "40 %", "60 %", "80 %", "above 80 %"]
        .iter()
        .enumerate()
        .map(|(level, text)| (format!("h{level}"), (*text).to_string()))
        .collect();
    let reach = Reach::new(&groups);
    let around = Figure {
        name: "figure-spawns-around".into(),
        title: format!(
            "Where pedestrians began as the car sees it (it drives upwards), and how often they hit it while it moved.{cut}"
        ),
        legend: legend.clone(),
        defs: String::new(),
        panels: groups.iter().map(|group| around(&group.title, &group.around, reach)).collect(),
    };
    let (defs, panels) = over_towns(&groups);
    let over = Figure {
        name: "figure-spawns-town".into(),
        title: format!("The same over the towns. Small squares: fewer than {FULL} episodes.{cut}"),
        legend,
        defs,
        panels,
    };
    vec![around, over]
}

/// The part of the legend that a rate belongs to: only what never hit is the first.
fn level(bin: Bin) -> usize {
    if bin.moving == 0 {
        0
    } else {
        (f64::from(bin.moving) / f64::from(bin.episodes.max(1)) * 5.0).ceil().clamp(1.0, 5.0) as usize
    }
}

/// Squares of an edge: the fewer episodes, the smaller; those with the highest rates on top.
fn squares(bins: &Bins, edge: f64, place: impl Fn(f64, f64) -> (f64, f64)) -> String {
    let mut by_level: BTreeMap<usize, String> = BTreeMap::new();
    for ((column, row), bin) in bins {
        let (x, y) = place((f64::from(*column) + 0.5) * edge, (f64::from(*row) + 0.5) * edge);
        let side = edge * (0.45 + 0.55 * f64::from(bin.episodes.min(FULL)) / f64::from(FULL)) * 0.96;
        let path = by_level.entry(level(*bin)).or_default();
        let _ = write!(path, "M{:.1} {:.1}h{side:.1}v{side:.1}h-{side:.1}z", x - side / 2.0, y - side / 2.0);
    }
    by_level
        .iter()
        .fold(String::new(), |text, (level, path)| text + &format!("<path class=\"h{level}\" d=\"{path}\"/>"))
}

/// What a map says to somebody who does not see it.
fn says(bins: &Bins) -> String {
    let mut all = Bin::default();
    bins.values().for_each(|bin| all.merge(*bin));
    format!("{} episodes from {} places; {} hit a moving car.", all.episodes, bins.len(), all.moving)
}

/// What all surroundings show of the ground ahead of the car, behind it and on either side (m).
#[derive(Debug, Clone, Copy)]
struct Reach {
    front: f64,
    back: f64,
    side: f64,
}

impl Reach {
    fn new(groups: &[Group<'_>]) -> Self {
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

/// The surroundings of the car, which drives upwards.
fn around(title: &str, bins: &Bins, reach: Reach) -> Panel {
    let scale = WIDTH / (2.0 * reach.side);
    let height = (reach.front + reach.back) * scale;
    let (middle, bumper) = (WIDTH / 2.0, reach.front * scale);
    let mut body = format!(
        "<rect class=\"ground\" width=\"{WIDTH:.0}\" height=\"{height:.0}\"/>\
         <g transform=\"translate({middle:.1} {bumper:.1}) scale({scale:.3})\">"
    );
    let mut rings = String::new();
    let mut ring = 10.0;
    while ring < reach.front.max(reach.side) {
        let radius = ring * scale;
        let _ = write!(body, "<circle class=\"ring\" stroke-width=\"{:.3}\" r=\"{ring:.0}\"/>", 1.0 / scale);
        // Nobody begins beside the car, so the labels stand there.
        if ring + 4.0 < reach.side {
            let (x, y) = (middle + radius, bumper + 12.0);
            let _ = write!(rings, "<text class=\"muted middle\" x=\"{x:.1}\" y=\"{y:.1}\">{ring:.0} m</text>");
        }
        ring += 10.0;
    }
    body.push_str(&squares(bins, NEAR, |x, y| (-y, -x)));
    body.push_str("<rect class=\"car\" x=\"-.95\" y=\"-2.3\" width=\"1.9\" height=\"4.6\" rx=\".6\"/></g>");
    body.push_str(&rings);
    Panel { title: title.into(), says: says(bins), size: (WIDTH, height), body }
}

/// The same bins, so many on an edge made one.
fn coarser(bins: &Bins, times: i32) -> Bins {
    let mut all = Bins::new();
    bins.iter()
        .for_each(|((x, y), bin)| all.entry((x.div_euclid(times), y.div_euclid(times))).or_default().merge(*bin));
    all
}

/// The towns with the beginnings on them. Every town is drawn once.
fn over_towns(groups: &[Group<'_>]) -> (String, Vec<Panel>) {
    let mut defs = String::new();
    let mut frames: BTreeMap<&str, (Point, Point)> = BTreeMap::new();
    for group in groups {
        let places = group.starts.keys().map(|(x, y)| Point::new(f64::from(*x) * FAR, f64::from(*y) * FAR));
        let (mut low, mut high) = places
            .fold((Point::new(f64::MAX, f64::MAX), Point::new(f64::MIN, f64::MIN)), |(low, high), place| {
                (low.inf(&place), high.sup(&place))
            });
        if let Some(known) = frames.get(group.town.name.as_str()) {
            (low, high) = (low.inf(&known.0), high.sup(&known.1));
        }
        frames.insert(&group.town.name, (low, high));
    }
    let margin = crate::geometry::Vector::new(MARGIN, MARGIN);
    for (name, (low, high)) in &mut frames {
        (*low, *high) = (*low - margin, *high + margin);
        let Some(group) = groups.iter().find(|group| group.town.name == *name) else { continue };
        let _ = write!(defs, "<g id=\"town-{}\">", slug(name));
        let mut last = "";
        for (surface, corners) in &Scenery::new(&group.town.town).within(*low, *high).polygons {
            if last != surface.class() {
                defs.push_str(if last.is_empty() { "" } else { "\"/>" });
                let _ = write!(defs, "<path class=\"{}\" d=\"", surface.class());
                last = surface.class();
            }
            for (place, corner) in corners.iter().enumerate() {
                let _ = write!(defs, "{}{:.1} {:.1}", if place == 0 { 'M' } else { 'L' }, corner.x, -corner.y);
            }
            defs.push('Z');
        }
        defs.push_str(if last.is_empty() { "</g>" } else { "\"/></g>" });
    }
    let panels = groups.iter().map(|group| {
        let (low, high) = frames[group.town.name.as_str()];
        let scale = WIDTH / (high.x - low.x);
        let height = (high.y - low.y) * scale;
        let times = ((high.x - low.x) / FAR / ACROSS).ceil().max(1.0);
        let body = format!(
            "<rect class=\"ground\" width=\"{WIDTH:.0}\" height=\"{height:.0}\"/>\
             <g transform=\"scale({scale:.4}) translate({:.1} {:.1})\"><use href=\"#town-{}\" opacity=\".55\"/>{}</g>",
            -low.x,
            high.y,
            escape(&slug(&group.town.name)),
            squares(&coarser(&group.starts, times as i32), times * FAR, |x, y| (x, -y)),
        );
        Panel { title: group.title.clone(), says: says(&group.starts), size: (WIDTH, height), body }
    });
    let panels = panels.collect();
    (defs, panels)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_never_hit_is_pale() {
        let bin = |moving| level(Bin { episodes: 10, moving });
        assert_eq!([0, 1, 2, 3, 8, 9, 10].map(bin), [0, 1, 1, 2, 4, 5, 5]);
    }
}

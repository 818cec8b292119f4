use std::collections::BTreeMap;
use std::fmt::Write;

use maud::{Markup, html};

use super::identity::Named;
use super::markup::slug;
use super::tally::{Bin, Bins, FAR, NEAR, Tally};
use crate::report::render::svg::{Digits, Figure, Panel, outline, px};
use crate::report::render::town::{Scenery, Surface};
use compile::NamedTown;
use world::geometry::Point;

/// Width of a panel.
const WIDTH: f64 = 286.0;
/// Most panels; the pictures of the towns show the rest.
const PANELS: usize = 12;
/// Ground shown around the outermost start (m).
const MARGIN: f64 = 8.0;
/// Most squares along an edge of a town.
const ACROSS: f64 = 56.0;
/// Least number of episodes of a bin that is drawn at its full size.
const FULL: u32 = 5;

/// Trained pedestrians that share a map.
struct Group<'a> {
    title: String,
    town: &'a NamedTown,
    starts: Bins,
    around: Bins,
}

/// The starts of trained pedestrians, and how often they collide from there: over the towns, and around the car.
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
            "Where pedestrians started as the car sees it (it drives upwards), and how often they hit it while it moved.{cut}"
        ),
        legend: legend.clone(),
        panels: groups.iter().map(|group| around(&group.title, &group.around, reach)).collect(),
        ..Figure::default()
    };
    let (defs, panels) = over_towns(&groups);
    let over = Figure {
        name: "figure-spawns-town".into(),
        title: format!("The same over the towns. Small squares: fewer than {FULL} episodes.{cut}"),
        legend,
        defs: Some(defs),
        panels,
        ..Figure::default()
    };
    vec![around, over]
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

/// The same bins with larger squares: `times` squares along an edge become one.
fn coarser(bins: &Bins, times: i32) -> Bins {
    let mut all = Bins::new();
    bins.iter()
        .for_each(|((x, y), bin)| all.entry((x.div_euclid(times), y.div_euclid(times))).or_default().merge(*bin));
    all
}

/// The towns with their starts. Every town is drawn once.
fn over_towns(groups: &[Group<'_>]) -> (Markup, Vec<Panel>) {
    let mut views: BTreeMap<&str, (Point, Point)> = BTreeMap::new();
    for group in groups {
        for (x, y) in group.starts.keys() {
            let place = Point::new(f64::from(*x) * FAR, f64::from(*y) * FAR);
            let view = views.entry(&group.town.name).or_insert((place, place));
            *view = (view.0.inf(&place), view.1.sup(&place));
        }
    }
    let margin = world::geometry::Vector::new(MARGIN, MARGIN);
    views.values_mut().for_each(|(low, high)| (*low, *high) = (*low - margin, *high + margin));
    let town = |name: &str| groups.iter().find(|group| group.town.name == name).map(|group| &group.town.town);
    let defs = html! {
        @for (name, (low, high)) in &views {
            @if let Some(town) = town(name) {
                g id={ "town-" (slug(name)) } {
                    @let scenery = Scenery::new(town).within(*low, *high);
                    @for same in scenery.polygons.chunk_by(|one, next| one.0 == next.0) {
                        path class=(same[0].0.name()) d=(surface(same)) {}
                    }
                }
            }
        }
    };
    let panel = |group: &Group<'_>| {
        let (low, high) = views.get(group.town.name.as_str())?;
        let scale = WIDTH / (high.x - low.x);
        let height = (high.y - low.y) * scale;
        let times = ((high.x - low.x) / FAR / ACROSS).ceil().max(1.0);
        let body = html! {
            rect.ground width=(WIDTH) height=(px(height)) {}
            g transform={ "scale(" (Digits(scale, 4)) ") translate(" (px(-low.x)) " " (px(high.y)) ")" } {
                use href={ "#town-" (slug(&group.town.name)) } opacity=".55" {}
                (squares(&coarser(&group.starts, times as i32), times * FAR, |x, y| (x, -y)))
            }
        };
        Some(Panel { title: group.title.clone(), says: says(&group.starts), size: (WIDTH, height), body })
    };
    (defs, groups.iter().filter_map(panel).collect())
}

/// Polygons of one surface as one path, y down.
fn surface(polygons: &[(Surface, Vec<Point>)]) -> String {
    polygons.iter().map(|(_, corners)| outline(corners.iter().map(|corner| (corner.x, -corner.y)), 1)).collect()
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

//! A page of towns: names on hover, axes, and places in the syntax of a scenario.

use maud::{Markup, PreEscaped, html};
use serde::Serialize;

use super::map_surfaces::{STYLE, all_lanes, lane_name, surfaces, view};
use super::scenery::{SectionLane, needed, step};
use crate::report::render::page::{OWN_SCRIPTS, head, json};
use crate::report::render::svg::{Digits, px};
use episode::{Spawn, Survey};
use road::geometry::{Point, Pose};
use road::{LaneKind, Town};

/// Maximum number of starts that a layer shows; more would hide each other.
const MAX_SHOWN: usize = 300;

/// A page of towns.
#[derive(Debug, Clone)]
pub struct MapPage<'a> {
    pub title: String,
    /// A line below the title.
    pub note: String,
    /// What is wrong with the scenario, drawn under its lines.
    pub problems: Vec<String>,
    pub towns: Vec<TownView<'a>>,
    /// For a page that follows a file: the script that holds the current version, and the version of this page.
    pub follows: Option<(String, String)>,
}

/// A town on a page.
#[derive(Debug, Clone)]
pub struct TownView<'a> {
    pub town: &'a Town,
    /// Starts that are drawn in it.
    pub starts: Vec<StartLayer<'a>>,
}

/// Starts of a spawn rule.
#[derive(Debug, Clone)]
pub struct StartLayer<'a> {
    /// Campaign and rule.
    pub name: String,
    /// The starts, and how often each constraint holds.
    pub survey: &'a Survey,
}

/// A lane as the script reads it.
#[derive(Serialize)]
struct LaneData {
    name: String,
    driving: bool,
    /// Places on its centre line: distance along the road (m), x and y (m), heading in driving direction (degrees).
    middle: Vec<[f64; 4]>,
}

/// The page. It needs no other file, except the script that tells it of a new version.
pub fn map_page(page: &MapPage<'_>) -> String {
    let policy = if page.follows.is_some() { "'unsafe-inline' 'self' file:" } else { OWN_SCRIPTS };
    let html = html! {
        (PreEscaped("<!doctype html>"))
        html lang="en" {
            (head(&page.title, None, policy, &[STYLE, include_str!("map_page.css")]))
            body {
                header.top {
                    p.kind { "falsify · preview" }
                    h1 { (page.title) }
                    p.meta { (page.note) }
                    button #theme type="button" hidden { "Dark" }
                }
                main #main {
                    @if !page.problems.is_empty() {
                        section #problems { @for problem in &page.problems { pre { (problem) } } }
                    }
                    @for (number, town) in page.towns.iter().enumerate() { (town_section(number, town, &page.title)) }
                    p.how {
                        "Move the pointer over a lane to read its road. Click a place to keep it; the buttons copy it as a scenario writes it. \
                         Drag to move the map, turn the wheel or press + and − to zoom."
                    }
                }
                @if let Some((script, version)) = &page.follows {
                    script type="application/json" id="follows" { (PreEscaped(json(&[script, version]))) }
                }
                script { (PreEscaped(include_str!("../page/page.js"))) (PreEscaped(include_str!("map_page.js"))) }
            }
        }
    };
    html.into_string() + "\n"
}

/// A town. The title of the page is not repeated.
fn town_section(number: usize, shown: &TownView<'_>, title: &str) -> Markup {
    let town = shown.town;
    let [left, top, width, height] = view(town).map(|number| Digits(number, 1));
    let step = step(town);
    let lanes: Vec<LaneData> = all_lanes(town).into_iter().map(|(_, lane)| lane_data(town, lane, step)).collect();
    html! {
        section.town id={ "town-" (number) } {
            @if town.name != title { h2 { (town.name) } }
            div.layers {
                @for (layer, starts) in shown.starts.iter().enumerate() {
                    label {
                        input type="checkbox" checked data-layer=(layer);
                        " " (starts.name) ": " (starts.survey.accepted) " of " (starts.survey.tried) " starts accepted"
                    }
                    @if !starts.survey.constraints.is_empty() {
                        details {
                            summary { "share of the starts that satisfies each constraint" }
                            ul {
                                @for (constraint, passed) in &starts.survey.constraints {
                                    li { (Digits(100.0 * f64::from(*passed) / f64::from(starts.survey.tried.max(1)), 1)) " %  " code { (constraint) } }
                                }
                            }
                        }
                    }
                }
                @if !shown.starts.is_empty() {
                    span.legend { span { (swatch("ego")) "start of the car" } span { (swatch("walker")) "start of the pedestrian" } }
                }
            }
            div.map {
                svg.panel viewBox={ (left) " " (top) " " (width) " " (height) } style={ "aspect-ratio:" (width) "/" (height) } role="img" aria-label={ "Map of " (town.name) } tabindex="0" {
                    rect.paper x=(left) y=(top) width=(width) height=(height) {}
                    (surfaces(town))
                    @for (layer, starts) in shown.starts.iter().enumerate() {
                        g.starts data-layer=(layer) { @for spawn in starts.survey.spawns.iter().take(MAX_SHOWN) { (start(spawn)) } }
                    }
                    g.axes {}
                    g.kept {}
                }
                div.zoom {
                    button type="button" data-zoom="in" aria-label="Zoom in" { "+" }
                    button type="button" data-zoom="out" aria-label="Zoom out" { "−" }
                    button type="button" data-zoom="all" { "All" }
                }
            }
            p.here aria-live="off" { "\u{a0}" }
            div.places {}
            script type="application/json" { (PreEscaped(json(&lanes))) }
        }
    }
}

fn lane_data(town: &Town, lane: SectionLane<'_>, step: f64) -> LaneData {
    let places: Vec<(f64, Pose)> = lane.places(step).map(|place| (place.s, town.pose(place))).collect();
    let line: Vec<Point> = places.iter().map(|(_, pose)| pose.position()).collect();
    let round = |number: f64, unit: f64| (number * unit).round() / unit;
    let place = |index: usize| {
        let (s, pose) = &places[index];
        [round(*s, 100.0), round(pose.x, 1000.0), round(pose.y, 1000.0), round(pose.yaw.to_degrees(), 100.0)]
    };
    LaneData {
        name: lane_name(town, lane),
        driving: lane.kind == LaneKind::Driving,
        middle: needed(&line).into_iter().map(place).collect(),
    }
}

/// The feet of a car and a pedestrian with their headings.
fn start(spawn: &Spawn) -> Markup {
    html! {
        @for (class, pose, length) in [("ego", &spawn.ego, 3.0), ("walker", &spawn.pedestrian, 1.6)] {
            @let tip = pose.position() + road::geometry::Vector::new(libm::cos(pose.yaw), libm::sin(pose.yaw)) * length;
            path class=(class) d={ "M" (px(pose.x)) " " (px(-pose.y)) "L" (px(tip.x)) " " (px(-tip.y)) } {}
            circle class=(class) cx=(px(pose.x)) cy=(px(-pose.y)) r="0.4" {}
        }
    }
}

fn swatch(class: &str) -> Markup {
    html! {
        svg viewBox="0 0 14 12" width="14" height="12" aria-hidden="true" {
            path class=(class) d="M3 6H13" {}
            circle class=(class) cx="3" cy="6" r="2" {}
        }
    }
}

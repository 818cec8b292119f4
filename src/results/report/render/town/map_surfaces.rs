//! A town from above, in which everything has its name.

use maud::{Markup, html};

use super::Surface;
use super::scenery::{SectionLane, lanes, outline, step};
use crate::report::render::svg::{Digits, outline as closed_path, px};
use road::Town;
use road::geometry::{OrientedBox, Point};

/// Ground shown around the town (m).
const MARGIN: f64 = 10.0;
/// Rules of the map.
pub const STYLE: &str = ".paper{fill:var(--ground)}.axes path{fill:none;stroke:var(--muted);vector-effect:non-scaling-stroke}\
.axes .rule{opacity:.28}.axes text{fill:var(--ink)}.light{fill:var(--seen)}.sign{fill:var(--paper);stroke:var(--brake);stroke-width:.3}\
.lane{stroke:var(--ground);stroke-width:.15}.lane:hover,.walk:hover{fill:var(--h1)}";

/// The part of the ground that shows a town: left, top, width and height (m), y down.
pub fn view(town: &Town) -> [f64; 4] {
    let (low, high) = town.bounds();
    [low.x - MARGIN, -high.y - MARGIN, high.x - low.x + 2.0 * MARGIN, high.y - low.y + 2.0 * MARGIN]
}

/// All that is visible from above, y down. A lane has the attribute `data-lane`: its place among [`all_lanes`].
pub fn surfaces(town: &Town) -> Markup {
    let step = step(town);
    let path = |corners: &[Point]| closed_path(corners.iter().map(|corner| (corner.x, -corner.y)), 2);
    html! {
        @for (number, (surface, lane)) in all_lanes(town).into_iter().enumerate() {
            path class=(surface.name()) data-lane=(number) d=(path(&outline(town, lane, step))) { title { (lane_name(town, lane)) } }
        }
        @for corners in &town.crosswalks {
            path class=(Surface::Zebra.name()) d=(path(corners)) { title { "crosswalk" } }
        }
        @for obstacle in &town.obstacles {
            path class=(Surface::House.name()) d=(path(&obstacle.corners())) { title { (box_name(obstacle)) } }
        }
        @for light in &town.traffic_lights {
            circle.light cx=(px(light.stop.x)) cy=(px(-light.stop.y)) r="0.9" {
                title { "traffic light of road " (town.roads[light.road.0 as usize].id) ", group " (light.group) ", turn " (light.turn + 1) " of " (light.turns) }
            }
        }
        @for sign in &town.speed_signs {
            circle.sign cx=(px(sign.trigger.pose.x)) cy=(px(-sign.trigger.pose.y)) r="0.7" {
                title { "speed limit " (Digits(sign.limit * 3.6, 1)) " km/h from here" }
            }
        }
        @for stop in &town.bus_stops {
            rect.sign x=(px(stop.x - 0.7)) y=(px(-stop.y - 0.7)) width="1.4" height="1.4" { title { "bus stop" } }
        }
        @for (sign, line) in town.give_way_signs.iter().map(|sign| (sign, town.pose(sign.line))) {
            circle.sign cx=(px(line.x)) cy=(px(-line.y)) r="0.7" { title { (sign.kind.name()) " sign of this lane" } }
        }
    }
}

/// The lanes that are drawn, from the ground up.
pub fn all_lanes(town: &Town) -> Vec<(Surface, SectionLane<'_>)> {
    [Surface::Walk, Surface::Lane]
        .into_iter()
        .flat_map(|kind| lanes(town, kind).map(move |lane| (kind, lane)))
        .collect()
}

/// What a lane is, in the numbers of its map.
pub fn lane_name(town: &Town, lane: SectionLane<'_>) -> String {
    let id = lane.start.lane.to_string().replace('-', "−");
    let sections = lane.road.sections.len();
    let section =
        if sections > 1 { format!(", section {} of {sections}", lane.start.section + 1) } else { String::new() };
    let junction = lane.road.junction.and_then(|index| town.junctions.get(index.0 as usize));
    let junction = junction.map_or(String::new(), |junction| format!(", junction {}", junction.id));
    let name = if lane.road.name.is_empty() { String::new() } else { format!(" “{}”", lane.road.name) };
    let width = Digits(town.lane_width(lane.start), 2);
    format!("road {}{name}, lane {id} ({}), {width} m wide{section}{junction}", lane.road.id, lane.kind.name())
}

fn box_name(obstacle: &OrientedBox) -> String {
    let (pose, half) = (obstacle.pose, obstacle.half);
    let [x, y, length, width] = [pose.x, pose.y, 2.0 * half.x, 2.0 * half.y].map(|number| Digits(number, 2));
    format!("obstacle at ({x} m, {y} m, {} deg), {length} m × {width} m", Digits(pose.yaw.to_degrees(), 1))
}

//! A town from above in which everything has its name, with axes.

use maud::{Markup, html};

use super::Surface;
use super::scenery::{SectionLane, lanes, outline, step};
use crate::report::render::svg::{Digits, Document, outline as closed_path, px};
use world::geometry::{OrientedBox, Point};
use world::road::Town;

/// Ground shown around the town (m).
const MARGIN: f64 = 10.0;
/// Displayed width (px).
const WIDTH: f64 = 1000.0;
/// Height of the numbers at the axes (px).
const LETTER: f64 = 12.0;
/// About this number of steps on the longer axis.
const STEPS: f64 = 10.0;
/// The most factors of a step: that many lead from a metre beyond every finite length.
const FACTORS: usize = 930;
/// Rules of the map.
pub const STYLE: &str = ".paper{fill:var(--ground)}.axes path{fill:none;stroke:var(--muted);vector-effect:non-scaling-stroke}\
.axes .rule{opacity:.28}.axes text{fill:var(--ink)}.light{fill:var(--seen)}.sign{fill:var(--paper);stroke:var(--brake);stroke-width:.3}\
.lane{stroke:var(--ground);stroke-width:.15}.lane:hover,.walk:hover{fill:var(--h1)}";

/// Draws a town with axes in metres. Lanes, crosswalks, obstacles, lights and signs show their names and measures when a pointer is over them.
pub fn labelled_map(town: &Town) -> String {
    let [left, top, width, height] = view(town);
    // Room for the numbers below and at the left.
    let letter = LETTER * width / WIDTH;
    let (wide, tall) = (width + 5.0 * letter, height + 2.0 * letter);
    let body = html! {
        (surfaces(town))
        (axes([left, top, width, height], letter))
    };
    Document { title: &town.name, view: [left - 5.0 * letter, top, wide, tall], width: WIDTH, style: STYLE }.with(&body)
}

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

/// Axes of a view, with lines across it and numbers of this height (m) below and at the left.
fn axes([left, top, width, height]: [f64; 4], letter: f64) -> Markup {
    let step = round_step(width.max(height) / STEPS);
    let (right, bottom) = (left + width, top + height);
    let ticks =
        |from: f64, to: f64| ((from / step).ceil() as i64..=(to / step).floor() as i64).map(move |i| i as f64 * step);
    let style = format!("font-size:{}px", Digits(letter, 2));
    html! {
        g.axes {
            @for x in ticks(left, right) {
                path.rule d={ "M" (px(x)) " " (px(top)) "V" (px(bottom)) } {}
                text.middle x=(px(x)) y=(px(bottom + 1.3 * letter)) style=(style) { (Digits(x, 1)) }
            }
            @for y in ticks(top, bottom) {
                path.rule d={ "M" (px(left)) " " (px(y)) "H" (px(right)) } {}
                text.end x=(px(left - 0.4 * letter)) y=(px(y + 0.35 * letter)) style=(style) { (Digits(-y, 1)) }
            }
            path d={ "M" (px(left)) " " (px(top)) "V" (px(bottom)) "H" (px(right)) } {}
            text.end x=(px(right)) y=(px(bottom - 0.4 * letter)) style=(style) { "x, m" }
            text x=(px(left + 0.4 * letter)) y=(px(top + letter)) style=(style) { "y, m" }
        }
    }
}

/// The nearest of 1, 2 and 5 times a power of ten that is not below a length.
fn round_step(length: f64) -> f64 {
    let mut step = 1.0;
    for factor in [2.0, 2.5, 2.0].into_iter().cycle().take(FACTORS) {
        if step >= length {
            break;
        }
        step *= factor;
    }
    step
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_of_axes_are_round() {
        assert_eq!(
            [0.3, 1.0, 1.2, 3.0, 11.0, 21.0, 60.0, 101.0].map(round_step),
            [1.0, 1.0, 2.0, 5.0, 20.0, 50.0, 100.0, 200.0]
        );
        assert_eq!(round_step(1e15), 1e15);
    }

    #[test]
    fn a_map_of_any_extent_is_drawn_with_few_lines() {
        let map = r#"<OpenDRIVE><road id="1" length="100" junction="-1"><planView><geometry s="0" x="0" y="0" hdg="0" length="100"><line/></geometry></planView><lanes><laneOffset s="0" d="1e9"/><laneSection s="0"><right><lane id="-1" type="driving"><width a="3.5"/></lane></right></laneSection></lanes></road></OpenDRIVE>"#;
        let town = Town::new(world::road::opendrive::read(map, "wide").unwrap());
        assert!(labelled_map(&town).matches("class=\"rule\"").count() < 40);
    }
}

//! CommonRoad XML: a lanelet for each driving lane, traffic lights with their cycles, the actors as dynamic obstacles, and the ego's start as
//! the planning problem.
//!
//! Both frames are right-handed, so no sign changes. A planning problem starts where the ego starts, so a file has the one or the other: the
//! problem without the car, or the recorded car without a problem. The second is for programs that measure a recording; the schema demands a
//! problem and is broken there.
//!
//! # Source
//! CommonRoad XML 2020a, `XML_commonRoad_XSD.xsd`.

use std::collections::BTreeMap;

use super::episode::{Actor, Motion, Shape};
use super::format::{AUTHOR, DATE, EgoDriver, ExportFile, Exporter, Variant, Walking};
use super::lane_bounds::lane_bounds;
use super::opendrive::lane_of;
use super::xml::{Short, Xml, attributes};
use super::{Episode, ExportError};
use road::geometry::{OrientedBox, Point, Pose, wrap_angle};
use road::{LaneKind, RoadIndex, Town, TrafficLight, Waypoint};
use world::sim::LightColour;

const NAME: &str = "commonroad";
/// The maximum distance between two points of a bound (m).
const STEP: f64 = 2.0;
/// The length of the goal, and the distance along the road from the last place of the ego to the middle of the goal (m). A car that has
/// reached it has passed the place of the touch.
const GOAL: [f64; 2] = [10.0, 12.0];
/// The time from the last tick in which the goal can be reached (s): enough to wait for the pedestrian and to set off again. Where lights
/// work, a cycle is added.
const AFTERWARDS: f64 = 10.0;

/// The lane of a road's section: road, section, lane.
type Key = (u32, u32, i32);

pub(super) const COMMONROAD: Exporter = Exporter {
    name: NAME,
    about: "CommonRoad 2020a XML: lanelets, lights, the others, and the ego's start as a planning problem",
    approximates: APPROXIMATES,
    usual_ego: EgoDriver::User,
    holds: |variant| variant.walking == Walking::Recorded,
    files,
};

const APPROXIMATES: &str = "lanes are polylines with a point every 2 m; sidewalks and signs are left out; lights change at ticks; with the recorded ego there is no planning problem";

fn files(episode: &Episode<'_>, variant: Variant) -> Result<Vec<ExportFile>, ExportError> {
    if variant.ego == EgoDriver::User {
        episode.without_friction(NAME)?;
        start_is_free(episode)?;
    }
    let text = document(episode, variant.ego);
    Ok(vec![ExportFile { name: format!("{}.commonroad.xml", episode.stem()), bytes: text.into_bytes() }])
}

/// Checks that the ego's start is free.
///
/// # Errors
/// An obstacle or an actor there.
fn start_is_free(episode: &Episode) -> Result<(), ExportError> {
    let outlines: Vec<OrientedBox> = episode.actors().iter().map(|actor| actor.outline(&actor.track[0])).collect();
    let others = episode.scenario.town.obstacles.iter().chain(&outlines[1..]);
    match others.filter(|other| other.overlaps(&outlines[0])).count() {
        0 => Ok(()),
        _ => {
            let what = "a planning problem that starts inside an obstacle".to_owned();
            Err(ExportError::NotRepresentable { format: NAME, what })
        }
    }
}

/// The name of a scenario of CommonRoad, by which solutions are named: `ZAM_FalsifyRUN-1_NUMBER_T-1`, where the number counts from one. A
/// recording ends with 2.
fn benchmark_id(name: &str, ego: EgoDriver) -> String {
    let (run, episode) = name.split_once(':').unwrap_or((name, ""));
    let run: String = run.chars().filter(char::is_ascii_alphanumeric).collect();
    let number = episode.parse::<u64>().map_or(1, |number| number.saturating_add(1));
    format!("ZAM_Falsify{run}-1_{number}_T-{}", if ego == EgoDriver::User { 1 } else { 2 })
}

fn document(episode: &Episode, ego: EgoDriver) -> String {
    let town = &episode.scenario.town;
    let lanes = lanes(town);
    let actors = episode.actors();
    let lights = lights(episode, lanes.len());
    let id = benchmark_id(episode.name, ego);
    let dt = Short(episode.dt());
    let source = format!("{}; approximated: {}", episode.summary(), APPROXIMATES);
    Xml::document(
        "commonRoad",
        attributes! {
            timeStepSize: dt, commonRoadVersion: "2020a", author: AUTHOR, affiliation: "falsify",
            source, benchmarkID: id, date: &DATE[..10],
        },
        |xml| {
            xml.within(&["location"], |xml| {
                xml.text("geoNameId", &-999);
                xml.text("gpsLatitude", &999);
                xml.text("gpsLongitude", &999);
            });
            xml.within(&["scenarioTags"], |xml| {
                xml.empty("urban", &[]);
                xml.empty("simulated", &[]);
            });
            for (key, number) in &lanes {
                write_lanelet(xml, town, &lanes, &lights, *key, *number);
            }
            for (number, _, light) in &lights {
                write_light(xml, episode, *number, light);
            }
            // Numbers are unique over lanelets, lights and obstacles.
            let mut number = lanes.len() + lights.len();
            let mut next = || {
                number += 1;
                number
            };
            for obstacle in &town.obstacles {
                write_static(xml, next(), obstacle);
            }
            for actor in &actors[usize::from(ego == EgoDriver::User)..] {
                // The format has no place for names.
                if actors.len() > 2 {
                    xml.comment(&actor.name);
                }
                write_dynamic(xml, next(), actor);
            }
            if ego == EgoDriver::User {
                let planning = next();
                xml.element("planningProblem", &[("id", &planning)], |xml| {
                    write_state(xml, "initialState", 0, &actors[0].track[0], true);
                    write_goal(xml, episode, &actors[0]);
                });
            }
        },
    )
}

/// All driving lanes with their numbers from 1.
fn lanes(town: &Town) -> BTreeMap<Key, usize> {
    let driving = town.lane_starts().filter(|(_, kind)| *kind == LaneKind::Driving);
    driving.map(|(start, _)| key(&start)).zip(1..).collect()
}

/// The traffic lights that work, with their numbers after those of the lanelets, and their lanes.
fn lights<'a>(episode: &Episode<'a>, lanelets: usize) -> Vec<(usize, Key, &'a TrafficLight)> {
    let placed = episode.lights().iter().filter_map(|light| {
        let lane = lane_of(&episode.scenario.town, &light.stop)?;
        Some((key(&lane), light))
    });
    placed.zip(lanelets + 1..).map(|((lane, light), number)| (number, lane, light)).collect()
}

fn key(waypoint: &Waypoint) -> Key {
    (waypoint.road.0, waypoint.section, waypoint.lane)
}

fn write_lanelet(
    xml: &mut Xml,
    town: &Town,
    lanes: &BTreeMap<Key, usize>,
    lights: &[(usize, Key, &TrafficLight)],
    (road, section, lane): Key,
    number: usize,
) {
    let own = &town.roads[road as usize];
    let range = &own.sections[section as usize];
    let at = |s: f64| Waypoint { road: RoadIndex(road), section, lane, s };
    let mut bounds = lane_bounds(town, at(range.start), STEP);
    // Bounds are left and right in driving direction, and run along it.
    if !own.is_forward(lane) {
        bounds.iter_mut().for_each(|bound| bound.reverse());
        bounds.swap(0, 1);
    }
    xml.element("lanelet", &[("id", &number)], |xml| {
        for (name, bound) in ["leftBound", "rightBound"].into_iter().zip(&bounds) {
            xml.within(&[name], |xml| bound.iter().for_each(|place| write_joint(xml, place)));
        }
        let middle = at((range.start + range.end) / 2.0);
        for before in town.predecessors(middle).filter_map(|lane| lanes.get(&key(&lane))) {
            xml.empty("predecessor", &[("ref", before)]);
        }
        for after in town.successors(middle).filter_map(|lane| lanes.get(&key(&lane))) {
            xml.empty("successor", &[("ref", after)]);
        }
        for (name, beside) in [("adjacentLeft", town.left_lane(middle)), ("adjacentRight", town.right_lane(middle))] {
            if let Some((beside, number)) = beside.and_then(|beside| Some((beside, lanes.get(&key(&beside))?))) {
                let same = own.is_forward(beside.lane) == own.is_forward(lane);
                xml.empty(name, &[("ref", number), ("drivingDir", &if same { "same" } else { "opposite" })]);
            }
        }
        xml.text("laneletType", &"urban");
        for (light, ..) in lights.iter().filter(|(_, of, _)| *of == (road, section, lane)) {
            xml.empty("trafficLightRef", &[("ref", light)]);
        }
    });
}

/// A light stands at the end of its lanelet, and holds its colours from the first tick on.
fn write_light(xml: &mut Xml, episode: &Episode, number: usize, light: &TrafficLight) {
    xml.element("trafficLight", &[("id", &number)], |xml| {
        xml.within(&["cycle"], |xml| {
            for (colour, ticks) in episode.phases(light) {
                xml.within(&["cycleElement"], |xml| {
                    xml.text("duration", &ticks);
                    let colour = match colour {
                        LightColour::Green => "green",
                        LightColour::Yellow => "yellow",
                        LightColour::Red => "red",
                    };
                    xml.text("color", &colour);
                });
            }
        });
        xml.within(&["position"], |xml| write_point(xml, &light.stop.position()));
        xml.text("active", &true);
    });
}

/// A point of a bound to 1e-6 m, so that lanelets that meet have the same points, and then moved by at most 5e-6 m, as its place decides, so that
/// no three points are on a line. CommonRoad's checker crashes at points a nanometre apart and at triangles that are nearly lines.
fn write_joint(xml: &mut Xml, place: &Point) {
    let [x, y] = [place.x, place.y].map(|number| (number * 1e6).round() as i64);
    let seed = (x as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ (y as u64).wrapping_mul(0xC2B2_AE3D_27D4_EB4F);
    let mixed = (seed ^ (seed >> 29)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let moved = |number: i64, bits: u64| (number * 1000 + (bits % 10_001) as i64 - 5000) as f64 / 1e9;
    write_point(xml, &Point::new(moved(x, mixed >> 40), moved(y, mixed >> 16 & 0xFF_FFFF)));
}

fn write_point(xml: &mut Xml, place: &Point) {
    xml.within(&["point"], |xml| {
        xml.text("x", &Short(place.x));
        xml.text("y", &Short(place.y));
    });
}

fn write_exact(xml: &mut Xml, name: &str, value: f64) {
    xml.within(&[name], |xml| xml.text("exact", &Short(value)));
}

fn write_static(xml: &mut Xml, number: usize, obstacle: &OrientedBox) {
    xml.element("staticObstacle", &[("id", &number)], |xml| {
        xml.text("type", &"unknown");
        write_rectangle(xml, 2.0 * obstacle.half.x, 2.0 * obstacle.half.y);
        xml.within(&["initialState"], |xml| {
            xml.within(&["position"], |xml| write_point(xml, &obstacle.pose.position()));
            write_exact(xml, "orientation", obstacle.pose.yaw);
            xml.within(&["time"], |xml| xml.text("exact", &0));
        });
    });
}

fn write_rectangle(xml: &mut Xml, length: f64, width: f64) {
    xml.within(&["shape", "rectangle"], |xml| {
        xml.text("length", &Short(length));
        xml.text("width", &Short(width));
    });
}

fn write_dynamic(xml: &mut Xml, number: usize, actor: &Actor) {
    xml.element("dynamicObstacle", &[("id", &number)], |xml| {
        let is_car = matches!(actor.shape, Shape::Vehicle(_));
        xml.text("type", if is_car { &"car" } else { &"pedestrian" });
        match actor.shape {
            Shape::Pedestrian(body) if body.target_box.is_none() => {
                xml.within(&["shape", "circle"], |xml| xml.text("radius", &Short(body.radius)));
            }
            _ => {
                let [length, width, _] = actor.size();
                write_rectangle(xml, length, width);
            }
        }
        write_state(xml, "initialState", 0, &actor.track[0], true);
        xml.within(&["trajectory"], |xml| {
            for (tick, motion) in actor.track.iter().enumerate().skip(1) {
                write_state(xml, "state", tick, motion, false);
            }
        });
    });
}

fn write_state(xml: &mut Xml, name: &str, tick: usize, motion: &Motion, first: bool) {
    xml.within(&[name], |xml| {
        xml.within(&["position"], |xml| write_point(xml, &motion.pose.position()));
        write_exact(xml, "orientation", motion.pose.yaw);
        xml.within(&["time"], |xml| xml.text("exact", &tick));
        write_exact(xml, "velocity", motion.velocity.norm());
        if first {
            ["acceleration", "yawRate", "slipAngle"].into_iter().for_each(|name| write_exact(xml, name, 0.0));
        }
    });
}

/// The middle of the goal: ahead of the last place of the ego along its lane, straight on at junctions. Where the road ends, it is that place.
fn goal(town: &Town, last: &Pose) -> (Pose, f64) {
    let Some(lane) = lane_of(town, last) else { return (*last, GOAL[0]) };
    let mut ahead = Vec::new();
    town.next(lane, GOAL[1], &mut ahead);
    let bend = |lane: &Waypoint| wrap_angle(town.pose(*lane).yaw - last.yaw).abs();
    let lane = ahead.into_iter().min_by(|a, b| bend(a).total_cmp(&bend(b))).unwrap_or(lane);
    (town.pose(lane), town.lane_width(lane))
}

fn write_goal(xml: &mut Xml, episode: &Episode, ego: &Actor) {
    let Some(last) = ego.track.last() else { return };
    let (place, width) = goal(&episode.scenario.town, &last.pose);
    let cycles = episode.lights().iter().filter_map(|light| Some(episode.trace.lights()?.period(light)));
    let patience = AFTERWARDS + cycles.fold(0.0, f64::max);
    xml.within(&["goalState"], |xml| {
        xml.within(&["position", "rectangle"], |xml| {
            xml.text("length", &Short(GOAL[0]));
            xml.text("width", &Short(width));
            xml.text("orientation", &Short(place.yaw));
            xml.within(&["center"], |xml| {
                xml.text("x", &Short(place.x));
                xml.text("y", &Short(place.y));
            });
        });
        xml.within(&["time"], |xml| {
            xml.text("intervalStart", &0);
            xml.text("intervalEnd", &(episode.ticks() + episode.ticks_in(patience)));
        });
    });
}

//! CommonRoad XML: a lanelet for each driving lane, the actors as dynamic obstacles, and the ego's start as the planning problem.
//!
//! Both frames are right-handed, so no sign changes.
//!
//! # Source
//! CommonRoad XML 2020a, `XML_commonRoad_XSD.xsd`.

use std::collections::BTreeMap;

use super::episode::{Actor, Motion, Shape};
use super::lane_bounds::lane_bounds;
use super::xml::{Short, Xml};
use super::{AUTHOR, DATE, Episode, ExportError, ExportFile, Exporter, Variant};
use world::geometry::{OrientedBox, Point};
use world::road::{LaneKind, RoadIndex, Town, Waypoint};

/// The exporter of CommonRoad scenarios.
#[derive(Debug, Clone, Copy)]
pub(super) struct CommonRoad;

const NAME: &str = "commonroad";
/// The greatest distance between two points of a bound (m).
const STEP: f64 = 2.0;
/// Length and width of the goal (m): the place of the ego at the end.
const GOAL: [f64; 2] = [5.0, 3.5];

/// The lane of a road's section: road, section, lane.
type Key = (u32, u32, i32);

impl Exporter for CommonRoad {
    fn name(&self) -> &'static str {
        NAME
    }

    fn about(&self) -> &'static str {
        "CommonRoad 2020a XML: lanelets, actors, and the ego's start as a planning problem"
    }

    fn approximates(&self) -> &'static str {
        "lanes are polylines with a point every 2 m; sidewalks, signs and lights are left out"
    }

    fn export(&self, episode: &Episode, _: Variant) -> Result<Vec<ExportFile>, ExportError> {
        episode.without_lights(NAME)?;
        let text = document(episode);
        Ok(vec![ExportFile { name: format!("{}.commonroad.xml", episode.stem()), bytes: text.into_bytes() }])
    }
}

fn document(episode: &Episode) -> String {
    let town = &episode.scenario.town;
    let lanes = lanes(town);
    let actors = episode.actors();
    let dt = Short(episode.dt());
    let source = episode.summary();
    Xml::document(
        "commonRoad",
        &[
            ("timeStepSize", &dt),
            ("commonRoadVersion", &"2020a"),
            ("author", &AUTHOR),
            ("affiliation", &"falsify"),
            ("source", &source),
            ("benchmarkID", &"ZAM_Falsify-1_1_T-1"),
            ("date", &&DATE[..10]),
        ],
        |xml| {
            xml.element("location", &[], |xml| {
                xml.text("geoNameId", &-999);
                xml.text("gpsLatitude", &999);
                xml.text("gpsLongitude", &999);
            });
            xml.element("scenarioTags", &[], |xml| {
                xml.empty("urban", &[]);
                xml.empty("simulated", &[]);
            });
            for (key, number) in &lanes {
                write_lanelet(xml, town, &lanes, *key, *number);
            }
            // Numbers are unique over lanelets and obstacles.
            let mut number = lanes.len();
            let mut next = || {
                number += 1;
                number
            };
            for obstacle in &town.obstacles {
                write_static(xml, next(), obstacle);
            }
            for actor in &actors {
                write_dynamic(xml, next(), actor);
            }
            let planning = next();
            xml.element("planningProblem", &[("id", &planning)], |xml| {
                write_state(xml, "initialState", 0, &actors[0].track[0], true);
                write_goal(xml, &actors[0]);
            });
        },
    )
}

/// All driving lanes with their numbers from 1.
fn lanes(town: &Town) -> BTreeMap<Key, usize> {
    let mut keys = Vec::new();
    for (road, index) in town.roads.iter().zip(0..) {
        for (section, number) in road.sections.iter().zip(0..) {
            let driving = section.lanes.iter().filter(|lane| lane.id != 0 && lane.kind == LaneKind::Driving);
            keys.extend(driving.map(|lane| (index, number, lane.id)));
        }
    }
    keys.into_iter().zip(1..).collect()
}

fn key(waypoint: &Waypoint) -> Key {
    (waypoint.road.0, waypoint.section, waypoint.lane)
}

fn write_lanelet(xml: &mut Xml, town: &Town, lanes: &BTreeMap<Key, usize>, (road, section, lane): Key, number: usize) {
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
            xml.element(name, &[], |xml| bound.iter().for_each(|place| write_point(xml, place)));
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
    });
}

fn write_point(xml: &mut Xml, place: &Point) {
    xml.element("point", &[], |xml| {
        xml.text("x", &Short(place.x));
        xml.text("y", &Short(place.y));
    });
}

fn write_exact(xml: &mut Xml, name: &str, value: f64) {
    xml.element(name, &[], |xml| xml.text("exact", &Short(value)));
}

fn write_static(xml: &mut Xml, number: usize, obstacle: &OrientedBox) {
    xml.element("staticObstacle", &[("id", &number)], |xml| {
        xml.text("type", &"unknown");
        write_rectangle(xml, 2.0 * obstacle.half.x, 2.0 * obstacle.half.y);
        xml.element("initialState", &[], |xml| {
            xml.element("position", &[], |xml| write_point(xml, &obstacle.pose.position()));
            write_exact(xml, "orientation", obstacle.pose.yaw);
            xml.element("time", &[], |xml| xml.text("exact", &0));
        });
    });
}

fn write_rectangle(xml: &mut Xml, length: f64, width: f64) {
    xml.element("shape", &[], |xml| {
        xml.element("rectangle", &[], |xml| {
            xml.text("length", &Short(length));
            xml.text("width", &Short(width));
        });
    });
}

fn write_dynamic(xml: &mut Xml, number: usize, actor: &Actor) {
    xml.element("dynamicObstacle", &[("id", &number)], |xml| {
        match actor.shape {
            Shape::Vehicle(_) => {
                let [length, width, _] = actor.size();
                xml.text("type", &"car");
                write_rectangle(xml, length, width);
            }
            Shape::Pedestrian(body) if body.target_box.is_some() => {
                let [length, width, _] = actor.size();
                xml.text("type", &"pedestrian");
                write_rectangle(xml, length, width);
            }
            Shape::Pedestrian(body) => {
                xml.text("type", &"pedestrian");
                xml.element("shape", &[], |xml| {
                    xml.element("circle", &[], |xml| xml.text("radius", &Short(body.radius)));
                });
            }
        }
        write_state(xml, "initialState", 0, &actor.track[0], true);
        xml.element("trajectory", &[], |xml| {
            for (tick, motion) in actor.track.iter().enumerate().skip(1) {
                write_state(xml, "state", tick, motion, false);
            }
        });
    });
}

fn write_state(xml: &mut Xml, name: &str, tick: usize, motion: &Motion, first: bool) {
    xml.element(name, &[], |xml| {
        xml.element("position", &[], |xml| write_point(xml, &motion.pose.position()));
        write_exact(xml, "orientation", motion.pose.yaw);
        xml.element("time", &[], |xml| xml.text("exact", &tick));
        write_exact(xml, "velocity", motion.velocity.norm());
        if first {
            ["acceleration", "yawRate", "slipAngle"].into_iter().for_each(|name| write_exact(xml, name, 0.0));
        }
    });
}

fn write_goal(xml: &mut Xml, ego: &Actor) {
    let Some(last) = ego.track.last() else { return };
    let [length, width] = GOAL;
    xml.element("goalState", &[], |xml| {
        xml.element("position", &[], |xml| {
            xml.element("rectangle", &[], |xml| {
                xml.text("length", &Short(length));
                xml.text("width", &Short(width));
                xml.text("orientation", &Short(last.pose.yaw));
                xml.element("center", &[], |xml| {
                    xml.text("x", &Short(last.pose.x));
                    xml.text("y", &Short(last.pose.y));
                });
            });
        });
        xml.element("time", &[], |xml| {
            xml.text("intervalStart", &0);
            xml.text("intervalEnd", &(ego.track.len() - 1));
        });
    });
}

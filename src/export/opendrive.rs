//! OpenDRIVE 1.7: the map of a town.
//!
//! A map that came from a file is the same file; obstacles and speed signs that the scenario adds to it are inserted. A town that was
//! designed is written: reading it back with [`opendrive::read`] gives the same town.
//!
//! # Source
//! ASAM OpenDRIVE 1.7.0.

use std::collections::BTreeMap;

use super::ExportError;
use super::episode::OBSTACLE_HEIGHT;
use super::format::{AUTHOR, DATE, ExportFile, Exporter};
use super::xml::{Attributes, Short, Xml, attributes};
use road::geometry::{OrientedBox, Point, Pose, wrap_angle};
use road::opendrive::{Addition, OBSTACLE, TRIGGER};
use road::{
    Cubic, Geometry, Junction, JunctionIndex, Lane, LaneFilter, LaneKind, LaneSection, Profile, Road, RoadEnd,
    RoadIndex, RoadLink, Shape, SpeedSign, Town, TownParts, TrafficLight, Waypoint, opendrive,
};

const NAME: &str = "xodr";
/// The height of signs and lights above the road (m).
const SIGN_HEIGHT: f64 = 2.0;
/// The width of a road mark (m).
const MARK: f64 = 0.12;
/// Straight pieces whose headings differ by less are one (rad): over a kilometre that is a micrometre.
const IN_LINE: f64 = 1e-9;
/// The signal types of a speed limit, a bus stop, and a traffic light with three lamps.
const SPEED_LIMIT: &str = "274";
const BUS_STOP: &str = "224";
const LIGHT: &str = "1000001";

pub(super) const XODR: Exporter = Exporter {
    name: NAME,
    about: "the OpenDRIVE map alone: the file of a town that has one, OpenDRIVE 1.7 for a designed town",
    approximates: "obstacles get a height of 3 m",
    files: |episode, _| Ok(vec![map_file(&episode.scenario.town)?]),
    ..Exporter::RECORDED
};

/// The map of a town as a file. Its name has a digest, so that failures of one town share it and towns of one name do not.
pub(super) fn map_file(of: &Town) -> Result<ExportFile, ExportError> {
    let map = town(of)?;
    let name = of.name.replace(|character: char| !character.is_ascii_alphanumeric(), "_");
    let digest = blake3::hash(map.as_bytes()).to_hex();
    Ok(ExportFile { name: format!("{name}-{}.xodr", &digest[..8]), bytes: map.into_bytes() })
}

/// The OpenDRIVE map of a town.
///
/// # Errors
/// The town adds obstacles or signs to a map that is not the one it was read from.
pub fn town(town: &Town) -> Result<String, ExportError> {
    match &town.map {
        Some(map) => with_additions(town, map),
        None => Ok(document(town)),
    }
}

fn not_representable(what: &str) -> ExportError {
    ExportError::NotRepresentable { format: NAME, what: what.to_owned() }
}

/// The map's file, with what the town has beside the map.
fn with_additions(town: &Town, map: &str) -> Result<String, ExportError> {
    let read = opendrive::read(map, &town.name).map_err(|error| not_representable(&format!("its map: {error}")))?;
    let TownParts { obstacles, speed_signs, bus_stops, .. } = read;
    let obstacles = town.obstacles.iter().filter(|own| !obstacles.contains(own));
    let signs = town.speed_signs.iter().filter(|own| !speed_signs.contains(own));
    let mut additions: BTreeMap<u32, Addition> = BTreeMap::new();
    for (number, obstacle) in obstacles.enumerate() {
        let Some(place) = place(town, obstacle.pose.position()) else { continue };
        let objects = &mut additions.entry(town.roads[place.road.0 as usize].id).or_default().objects;
        objects.push_str(&Xml::fragment(|xml| write_obstacle(xml, town, place, number, obstacle)));
    }
    for (number, sign) in signs.enumerate() {
        let Some(place) = lane_of(town, &sign.trigger.pose) else { continue };
        let signals = &mut additions.entry(town.roads[place.road.0 as usize].id).or_default().signals;
        signals.push_str(&Xml::fragment(|xml| write_sign(xml, town, place, number, sign)));
    }
    for (number, stop) in town.bus_stops.iter().filter(|own| !bus_stops.contains(own)).enumerate() {
        let Some(place) = place(town, *stop) else { continue };
        let road = &town.roads[place.road.0 as usize];
        let signals = &mut additions.entry(road.id).or_default().signals;
        signals.push_str(&Xml::fragment(|xml| write_bus_stop(xml, road, place.s, number, *stop)));
    }
    if additions.is_empty() {
        return Ok(map.to_owned());
    }
    opendrive::insert(map, &additions)
        .ok_or_else(|| not_representable("obstacles or signs beside a road that its map does not have"))
}

/// What stands beside a road, by the places of the lists of a town.
#[derive(Debug, Clone, Default)]
struct Beside {
    obstacles: Vec<(usize, Waypoint)>,
    crosswalks: Vec<usize>,
    signs: Vec<(usize, Waypoint)>,
    lights: Vec<(usize, Waypoint)>,
    stops: Vec<(usize, Waypoint)>,
}

fn document(town: &Town) -> String {
    let mut beside = vec![Beside::default(); town.roads.len()];
    let mut at = |place: Option<Waypoint>, add: &dyn Fn(&mut Beside, Waypoint)| {
        place.into_iter().for_each(|place| add(&mut beside[place.road.0 as usize], place));
    };
    for (number, obstacle) in town.obstacles.iter().enumerate() {
        at(place(town, obstacle.pose.position()), &|beside, place| beside.obstacles.push((number, place)));
    }
    for (number, sign) in town.speed_signs.iter().enumerate() {
        at(lane_of(town, &sign.trigger.pose), &|beside, place| beside.signs.push((number, place)));
    }
    for (number, light) in town.traffic_lights.iter().enumerate() {
        at(lane_of(town, &light.stop), &|beside, place| beside.lights.push((number, place)));
    }
    for (number, stop) in town.bus_stops.iter().enumerate() {
        at(place(town, *stop), &|beside, place| beside.stops.push((number, place)));
    }
    for (number, corners) in town.crosswalks.iter().enumerate() {
        at(place(town, corners[0]), &|beside, _| beside.crosswalks.push(number));
    }
    let (low, high) = town.bounds();
    Xml::document("OpenDRIVE", &[], |xml| {
        let [south, west, north, east] = [low.y, low.x, high.y, high.x].map(Short);
        xml.empty(
            "header",
            attributes! {
                revMajor: 1, revMinor: 7, name: town.name, version: "1.00", date: DATE, north,
                south, east, west, vendor: AUTHOR,
            },
        );
        for (index, (road, beside)) in town.roads.iter().zip(&beside).enumerate() {
            write_road(xml, town, RoadIndex(index as u32), road, beside);
        }
        write_controllers(xml, &town.traffic_lights);
        for (index, junction) in town.junctions.iter().enumerate() {
            write_junction(xml, town, JunctionIndex(index as u32), junction);
        }
    })
}

/// The number of a junction in the file. No road has it, since links by number alone would be ambiguous for some readers.
fn junction_number(town: &Town, junction: &Junction) -> u32 {
    let roads = || town.roads.iter().map(|road| road.id);
    let shared = town.junctions.iter().any(|junction| roads().any(|road| road == junction.id));
    let offset = if shared { roads().max().map_or(0, |last| last.saturating_add(1)) } else { 0 };
    junction.id.saturating_add(offset)
}

/// The nearest place on any lane; none in a town without lanes.
fn place(town: &Town, point: Point) -> Option<Waypoint> {
    town.nearest_lane(point, LaneFilter::Any)
}

/// The driving lane on which a pose lies: the nearest lane that leads in its direction, or else the nearest one.
pub(super) fn lane_of(town: &Town, pose: &Pose) -> Option<Waypoint> {
    let nearest = town.nearest_lane(pose.position(), LaneFilter::Driving)?;
    let same_way = |lane: &Waypoint| wrap_angle(town.pose(*lane).yaw - pose.yaw).abs() < std::f64::consts::FRAC_PI_2;
    let others = [town.left_lane(nearest), town.right_lane(nearest)].into_iter().flatten();
    Some(std::iter::once(nearest).chain(others).find(same_way).unwrap_or(nearest))
}

fn write_road(xml: &mut Xml, town: &Town, index: RoadIndex, road: &Road, beside: &Beside) {
    let junction =
        road.junction.map_or(-1, |junction| i64::from(junction_number(town, &town.junctions[junction.0 as usize])));
    let rule = if road.left_hand { "LHT" } else { "RHT" };
    xml.element("road", attributes! { name: road.name, length: road.length, id: road.id, junction, rule }, |xml| {
        xml.within(&["link"], |xml| {
            write_link(xml, town, "predecessor", road.predecessor);
            write_link(xml, town, "successor", road.successor);
        });
        xml.empty("type", &[("s", &0), ("type", &"town")]);
        xml.within(&["planView"], |xml| {
            pieces(road).iter().for_each(|piece| write_piece(xml, piece));
        });
        let heights = road.plan_view.elevation().cubics();
        if !heights.is_empty() {
            xml.within(&["elevationProfile"], |xml| {
                heights.iter().for_each(|cubic| write_cubic(xml, "elevation", "s", 0.0, cubic));
            });
        }
        xml.within(&["lanes"], |xml| {
            for cubic in road.lane_offset.cubics() {
                write_cubic(xml, "laneOffset", "s", 0.0, cubic);
            }
            for section in &road.sections {
                write_section(xml, road, section);
            }
        });
        if !beside.obstacles.is_empty() || !beside.crosswalks.is_empty() {
            xml.within(&["objects"], |xml| {
                for (number, place) in &beside.obstacles {
                    write_obstacle(xml, town, *place, *number, &town.obstacles[*number]);
                }
                for number in &beside.crosswalks {
                    write_crosswalk(xml, road, *number, &town.crosswalks[*number]);
                }
            });
        }
        if !beside.signs.is_empty() || !beside.lights.is_empty() || !beside.stops.is_empty() {
            xml.within(&["signals"], |xml| {
                for (number, place) in &beside.signs {
                    write_sign(xml, town, *place, *number, &town.speed_signs[*number]);
                }
                for (number, place) in &beside.lights {
                    write_light(xml, town, index, *place, *number);
                }
                for (number, place) in &beside.stops {
                    write_bus_stop(xml, road, place.s, *number, town.bus_stops[*number]);
                }
            });
        }
    });
}

fn end_name(end: RoadEnd) -> &'static str {
    match end {
        RoadEnd::Start => "start",
        RoadEnd::End => "end",
    }
}

fn write_link(xml: &mut Xml, town: &Town, name: &str, link: Option<RoadLink>) {
    match link {
        Some(RoadLink::Road(road, end)) => {
            let id = town.roads[road.0 as usize].id;
            xml.empty(name, attributes! { elementType: "road", elementId: id, contactPoint: end_name(end) });
        }
        Some(RoadLink::Junction(junction)) => {
            let id = junction_number(town, &town.junctions[junction.0 as usize]);
            xml.empty(name, &[("elementType", &"junction"), ("elementId", &id)]);
        }
        None => {}
    }
}

/// The pieces of a reference line, with straight ones that continue each other as one.
fn pieces(road: &Road) -> Vec<Geometry> {
    let mut pieces: Vec<Geometry> = Vec::new();
    for piece in road.plan_view.pieces() {
        let before = pieces.last_mut().filter(|before| {
            let both = (before.shape, piece.shape) == (Shape::Line, Shape::Line);
            both && wrap_angle(before.start.yaw - piece.start.yaw).abs() < IN_LINE
        });
        match before {
            Some(before) => *before = Geometry::line(before.s, before.start, piece.s + piece.length - before.s),
            None => pieces.push(*piece),
        }
    }
    pieces
}

fn write_piece(xml: &mut Xml, piece: &Geometry) {
    let Pose { x, y, yaw } = piece.start;
    xml.element("geometry", attributes! { s: piece.s, x, y, hdg: yaw, length: piece.length }, |xml| {
        match piece.shape {
            Shape::Line => xml.empty("line", &[]),
            Shape::Arc(curvature) => xml.empty("arc", &[("curvature", &curvature)]),
            Shape::Spiral(first, last) => xml.empty("spiral", &[("curvStart", &first), ("curvEnd", &last)]),
            Shape::Poly3([a, b, c, d]) => xml.empty("poly3", attributes! { a, b, c, d }),
            Shape::ParamPoly3 { u, v, normalized } => {
                let range = if normalized { "normalized" } else { "arcLength" };
                xml.empty(
                    "paramPoly3",
                    attributes! {
                        aU: u[0], bU: u[1], cU: u[2], dU: u[3], aV: v[0], bV: v[1], cV: v[2], dV: v[3], pRange: range,
                    },
                );
            }
        }
    });
}

/// A cubic, whose place is given relative to an origin (m).
fn write_cubic(xml: &mut Xml, name: &str, place: &str, origin: f64, cubic: &Cubic) {
    let Cubic { start, a, b, c, d } = *cubic;
    xml.empty(name, &[(place, &(start - origin)), ("a", &a), ("b", &b), ("c", &c), ("d", &d)]);
}

fn write_section(xml: &mut Xml, road: &Road, section: &LaneSection) {
    xml.element("laneSection", &[("s", &section.start)], |xml| {
        for (side, number) in [("left", 1), ("center", 0), ("right", -1)] {
            let lanes: Vec<&Lane> = section.lanes.iter().filter(|lane| lane.id.signum() == number).collect();
            if lanes.is_empty() && number == 0 {
                xml.within(&[side], |xml| xml.empty("lane", attributes! { id: 0, type: "none", level: false }));
            } else if !lanes.is_empty() {
                xml.element(side, &[], |xml| {
                    lanes.iter().for_each(|lane| write_lane(xml, road, section, lane));
                });
            }
        }
    });
}

fn write_lane(xml: &mut Xml, road: &Road, section: &LaneSection, lane: &Lane) {
    xml.element("lane", attributes! { id: lane.id, type: lane.kind.name(), level: false }, |xml| {
        if lane.predecessor.is_some() || lane.successor.is_some() {
            xml.within(&["link"], |xml| {
                lane.predecessor.iter().for_each(|id| xml.empty("predecessor", &[("id", id)]));
                lane.successor.iter().for_each(|id| xml.empty("successor", &[("id", id)]));
            });
        }
        if lane.id != 0 {
            for cubic in widths(&lane.width, section) {
                write_cubic(xml, "width", "sOffset", section.start, &cubic);
            }
        }
        // Junctions have no marks on their connecting roads.
        // The mark of a lane is at its outer edge, that of lane 0 between the directions.
        let driving = |id: i32| section.lanes.iter().any(|lane| lane.id == id && lane.kind == LaneKind::Driving);
        let kind = match lane.kind {
            _ if road.junction.is_some() => "none",
            // With one lane in each direction cars may pass each other; with more the directions are kept apart.
            _ if lane.id == 0 && driving(1) && driving(-1) => {
                if driving(2) || driving(-2) {
                    "solid"
                } else {
                    "broken"
                }
            }
            _ if lane.id == 0 && (driving(1) || driving(-1)) => "solid",
            LaneKind::Driving if driving(lane.id + lane.id.signum()) => "broken",
            LaneKind::Driving => "solid",
            _ => "none",
        };
        xml.empty(
            "roadMark",
            attributes! { sOffset: 0, type: kind, weight: "standard", color: "standard", width: MARK },
        );
    });
}

/// The cubics of a width, the first from the section's start on.
fn widths(width: &Profile, section: &LaneSection) -> Vec<Cubic> {
    Profile::sum(&[(width, 1.0)], section.start, section.end).cubics().to_vec()
}

/// A rectangle as an object, whose outline has its corners relative to a place beside the road.
fn write_obstacle(xml: &mut Xml, town: &Town, place: Waypoint, number: usize, obstacle: &OrientedBox) {
    let road = &town.roads[place.road.0 as usize];
    let line = road.plan_view.pose(place.s);
    let from_line = line.to_local(obstacle.pose.position());
    let pivot = line.to_world(road::geometry::Vector::new(0.0, from_line.y));
    let own = Pose::new(pivot.x, pivot.y, obstacle.pose.yaw);
    let heading = wrap_angle(obstacle.pose.yaw - line.yaw);
    let id = format!("obstacle_{number}");
    xml.element(
        "object",
        attributes! {
            id, name: "obstacle", type: "obstacle", s: place.s, t: from_line.y, zOffset: 0, hdg: heading,
            pitch: 0, roll: 0, orientation: "none", height: OBSTACLE_HEIGHT,
        },
        |xml| {
            write_outline(xml, &obstacle.corners(), own, OBSTACLE_HEIGHT);
            xml.empty("userData", &[("code", &OBSTACLE), ("value", &"1")]);
        },
    );
}

fn write_crosswalk(xml: &mut Xml, road: &Road, number: usize, corners: &[Point]) {
    let line = road.plan_view.pose(0.0);
    let id = format!("crosswalk_{number}");
    xml.element(
        "object",
        attributes! {
            id, name: "crosswalk", type: "crosswalk", s: 0, t: 0, zOffset: 0, hdg: 0, pitch: 0, roll: 0,
            orientation: "none",
        },
        |xml| write_outline(xml, corners, line, 0.0),
    );
}

/// The corners of an object in its own frame.
fn write_outline(xml: &mut Xml, corners: &[Point], frame: Pose, height: f64) {
    xml.within(&["outlines"], |xml| {
        xml.element("outline", &[("id", &0), ("closed", &true)], |xml| {
            for (id, corner) in corners.iter().enumerate() {
                let local = frame.to_local(*corner);
                xml.empty("cornerLocal", attributes! { id, u: local.x, v: local.y, z: 0, height });
            }
        });
    });
}

/// The lateral position of the outer edge of a side of a road (m).
fn edge(road: &Road, lane: &Waypoint) -> f64 {
    let lanes = &road.sections[lane.section as usize].lanes;
    let side = lanes.iter().filter(|other| other.id.signum() == lane.lane.signum());
    let width: f64 = side.map(|other| other.width.value(lane.s)).sum();
    road.lane_offset.value(lane.s) + f64::from(lane.lane.signum()) * width
}

/// A signal for one lane.
struct Signal<'a> {
    id: String,
    name: &'a str,
    kind: &'static str,
    subtype: String,
    dynamic: bool,
    /// The lane, and the place along it.
    lane: Waypoint,
}

impl Signal<'_> {
    fn write(&self, xml: &mut Xml, town: &Town, attributes: Attributes<'_>, data: impl FnOnce(&mut Xml)) {
        let lane = &self.lane;
        let road = &town.roads[lane.road.0 as usize];
        let (t, dynamic) = (Short(edge(road, lane)), if self.dynamic { "yes" } else { "no" });
        // The standard's direction, `+` for that of the reference line; CARLA's is that of the lanes' numbers, so the validity decides.
        let orientation = if road.is_forward(lane.lane) { "+" } else { "-" };
        let own: Attributes<'_> = attributes! {
            s: lane.s, t, id: self.id, name: self.name, dynamic, orientation, zOffset: SIGN_HEIGHT, country: "DE",
            type: self.kind, subtype: self.subtype,
        };
        xml.element("signal", &[own, attributes].concat(), |xml| {
            xml.empty("validity", &[("fromLane", &lane.lane), ("toLane", &lane.lane)]);
            data(xml);
        });
    }
}

fn write_sign(xml: &mut Xml, town: &Town, place: Waypoint, number: usize, sign: &SpeedSign) {
    let limit = Short(sign.limit * 3.6);
    let signal = Signal {
        id: format!("limit_{number}"),
        name: "speed limit",
        kind: SPEED_LIMIT,
        subtype: limit.to_string(),
        dynamic: false,
        lane: place,
    };
    signal.write(xml, town, &[("value", &limit), ("unit", &"km/h")], |xml| {
        let OrientedBox { pose: Pose { x, y, yaw }, half } = sign.trigger;
        let value = format!("{x} {y} {yaw} {} {}", half.x, half.y);
        xml.empty("userData", &[("code", &TRIGGER), ("value", &value)]);
    });
}

fn write_bus_stop(xml: &mut Xml, road: &Road, s: f64, number: usize, stop: Point) {
    let t = road.plan_view.pose(s).to_local(stop).y;
    xml.empty(
        "signal",
        attributes! {
            s, t, id: format!("stop_{number}"), name: "bus stop", dynamic: "no", orientation: "none",
            zOffset: SIGN_HEIGHT, country: "DE", type: BUS_STOP, subtype: "-1",
        },
    );
}

fn write_light(xml: &mut Xml, town: &Town, road: RoadIndex, place: Waypoint, number: usize) {
    // A light is at the end of its lane.
    let forward = town.roads[road.0 as usize].is_forward(place.lane);
    let section = &town.roads[road.0 as usize].sections[place.section as usize];
    let s = if forward { section.end } else { section.start };
    let signal = Signal {
        id: town.traffic_lights[number].signal.clone(),
        name: "traffic light",
        kind: LIGHT,
        subtype: "-1".to_owned(),
        dynamic: true,
        lane: Waypoint { s, ..place },
    };
    signal.write(xml, town, &[], |_| {});
}

/// The lights of one turn change together: they have one controller.
pub(super) fn controllers(lights: &[TrafficLight]) -> BTreeMap<(u32, u32), Vec<&TrafficLight>> {
    let mut all: BTreeMap<(u32, u32), Vec<&TrafficLight>> = BTreeMap::new();
    for light in lights {
        all.entry((light.group, light.turn)).or_default().push(light);
    }
    all
}

pub(super) fn controller_id((group, turn): (u32, u32)) -> String {
    format!("controller_{group}_{turn}")
}

fn write_controllers(xml: &mut Xml, lights: &[TrafficLight]) {
    for (turn, lights) in controllers(lights) {
        let id = controller_id(turn);
        xml.element("controller", &[("id", &id), ("sequence", &turn.1)], |xml| {
            for light in lights {
                xml.empty("control", &[("signalId", &light.signal), ("type", &"0")]);
            }
        });
    }
}

fn write_junction(xml: &mut Xml, town: &Town, index: JunctionIndex, junction: &Junction) {
    let id = junction_number(town, junction);
    xml.element("junction", attributes! { id, name: junction.name, type: "default" }, |xml| {
        for connection in &junction.connections {
            let road = |index: RoadIndex| town.roads[index.0 as usize].id;
            xml.element(
                "connection",
                attributes! {
                    id: connection.id, incomingRoad: road(connection.incoming),
                    connectingRoad: road(connection.connecting), contactPoint: end_name(connection.contact),
                },
                |xml| {
                    for (from, to) in &connection.lane_links {
                        xml.empty("laneLink", &[("from", from), ("to", to)]);
                    }
                },
            );
        }
        for turn in controllers(&town.traffic_lights).into_keys().filter(|turn| turn.0 == index.0) {
            let id = controller_id(turn);
            xml.empty("controller", attributes! { id, type: "0", sequence: turn.1 });
        }
    });
}

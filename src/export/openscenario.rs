//! OpenSCENARIO XML: timed polylines, one vertex a tick.
//!
//! The reference point of a vehicle is the middle of its rear axle, as the standard says. Programs differ for boxes that say otherwise: esmini moves
//! the rear axle into the origin. CARLA's ScenarioRunner reads version 1.0 only and places an actor by the middle of its box, so the files of
//! version 1.0 are written for it.
//!
//! # Source
//! ASAM OpenSCENARIO XML 1.0 and 1.3.0. ScenarioRunner: `srunner/tools/openscenario_parser.py`.

use std::collections::BTreeSet;

use super::episode::{Actor, Motion, Shape};
use super::format::{AUTHOR, DATE, EgoDriver, ExportFile, Exporter, Variant, Walking};
use super::xml::{Short, Xml, attributes};
use super::{Episode, ExportError, opendrive};
use world::sim::{ActorId, LightColour, VehicleBlueprint};

/// A version of the standard.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Version {
    /// For CARLA's ScenarioRunner.
    V1_0,
    V1_3,
}

/// How long a scenario goes on after the last tick without a collision (s): with the recorded ego, and with the user's.
const AFTERWARDS: [f64; 2] = [0.5, 30.0];
/// A time before the start (s), for the rule "greater than".
const BEFORE_START: f64 = -0.001;
/// Figures that the standard requires and the simulator does not have: mass of a pedestrian (kg), maximum speed of a vehicle (m/s),
/// diameter of a wheel (m).
const MASS: f64 = 75.0;
const MAX_SPEED: f64 = 69.4;
const WHEEL: f64 = 0.7;

pub(super) const XOSC_1_0: Exporter = Exporter {
    name: "xosc-1.0",
    about: "OpenSCENARIO XML 1.0 with its OpenDRIVE map, for CARLA's ScenarioRunner",
    approximates: "a pedestrian's disc is the square around it; the reference point is the middle of the box; the runner's controllers follow the tracks",
    holds: |_| true,
    files: |episode, variant| files(Version::V1_0, episode, variant),
    ..Exporter::RECORDED
};

pub(super) const XOSC_1_3: Exporter = Exporter {
    name: "xosc-1.3",
    about: "OpenSCENARIO XML 1.3 with its OpenDRIVE map",
    approximates: "a pedestrian's disc is the square around it, or a smaller one where a corner would graze the car earlier",
    files: |episode, variant| files(Version::V1_3, episode, variant),
    ..XOSC_1_0
};

fn files(version: Version, episode: &Episode<'_>, variant: Variant) -> Result<Vec<ExportFile>, ExportError> {
    let map = opendrive::map_file(&episode.scenario.town)?;
    let storyboard = Storyboard::new(version, episode, variant, &map.name)?;
    let ending = if version == Version::V1_0 { "-1.0" } else { "" };
    let name = format!("{}{ending}.xosc", episode.stem());
    Ok(vec![ExportFile { name, bytes: storyboard.text().into_bytes() }, map])
}

/// Traffic lights that change together.
struct Controller<'a> {
    name: String,
    signals: BTreeSet<&'a str>,
    /// Colours with their numbers of ticks, from the first tick on.
    phases: Vec<(LightColour, usize)>,
}

/// What a file holds.
struct Storyboard<'a> {
    version: Version,
    variant: Variant,
    map: &'a str,
    description: String,
    dt: f64,
    actors: Vec<Actor<'a>>,
    /// The place of the pedestrian of the verdict among the actors.
    pedestrian: usize,
    /// Length, width and height of the box of each actor (m).
    sizes: Vec<[f64; 3]>,
    /// The first tick of the pedestrians' trajectories, and the distance of the ego at which they start (m).
    release: Option<(usize, f64)>,
    /// The lights for an ego of the user.
    lights: Vec<Controller<'a>>,
}

impl<'a> Storyboard<'a> {
    fn new(version: Version, episode: &Episode<'a>, variant: Variant, map: &'a str) -> Result<Self, ExportError> {
        let format = if version == Version::V1_0 { XOSC_1_0.name } else { XOSC_1_3.name };
        if variant.ego == EgoDriver::User {
            if version == Version::V1_0 {
                // ScenarioRunner reads no phases.
                episode.without_lights(format)?;
            }
            episode.without_friction(format)?;
        }
        let actors = episode.actors();
        let sizes = (0..actors.len()).map(|place| episode.box_of(&actors, place)).collect();
        let mut storyboard = Self {
            version,
            variant,
            map,
            description: String::new(),
            dt: episode.dt(),
            actors,
            sizes,
            pedestrian: episode.main_pedestrian(),
            release: None,
            lights: Vec::new(),
        };
        if variant.ego == EgoDriver::User {
            let all = opendrive::controllers(episode.lights()).into_iter();
            storyboard.lights.extend(all.map(|(turn, lights)| {
                let signals = lights.iter().map(|light| light.signal.as_str()).collect();
                Controller { name: opendrive::controller_id(turn), signals, phases: episode.phases(lights[0]) }
            }));
        }
        if version == Version::V1_0 {
            // ScenarioRunner knows the ego by this name.
            "hero".clone_into(&mut storyboard.actors[0].name);
        }
        if variant.walking == Walking::Released {
            let axle = |motion: &Motion| storyboard.reference(&storyboard.actors[0], motion);
            let (tick, [x, y, z]) = episode.release(format, axle)?;
            storyboard.release = Some((tick, libm::hypot(libm::hypot(x, y), z)));
        }
        storyboard.description = storyboard.describe(episode);
        Ok(storyboard)
    }

    fn describe(&self, episode: &Episode) -> String {
        let ego = match self.variant.ego {
            EgoDriver::Recorded => "The ego and the pedestrians follow their recorded tracks.",
            EgoDriver::User => {
                "The ego starts as recorded and has no driver: assign yours. The replay of the pedestrians is open loop."
            }
        };
        let release = match self.release {
            Some((0, _)) => " The pedestrians walk from the start on: released is as recorded.".to_owned(),
            Some((_, distance)) => format!(" The pedestrians start when the ego is within {distance:.2} m."),
            None => String::new(),
        };
        let touch = |tick: usize| format!("{:.2} s", tick as f64 * self.dt);
        let disc = episode.outcome.is_collision().then(|| touch(episode.ticks()));
        let Actor { name, shape, .. } = &self.actors[self.pedestrian];
        let touches = match (Episode::touch_of_boxes(&self.actors, self.pedestrian, self.sizes[self.pedestrian]), disc)
        {
            (Some(boxes), Some(disc)) => {
                let boxes = touch(boxes);
                format!(" First overlap of ego and {name}: of the boxes at {boxes}, with the disc at {disc}.")
            }
            (Some(boxes), None) => format!(" The boxes overlap at {} although the disc is not touched.", touch(boxes)),
            _ => String::new(),
        };
        let smaller = self.actors.iter().zip(&self.sizes).any(|(actor, size)| size[0] < actor.size()[0]);
        let body = match shape {
            Shape::Pedestrian(body) if body.target_box.is_some() => "The pedestrian is a box",
            _ if smaller => {
                "Approximated: a pedestrian is a disc, and its box the square around it, or a smaller one if a corner of that would graze the car earlier"
            }
            _ => "Approximated: a pedestrian is a disc, and its box the square around it",
        };
        format!("{}. {ego}{release} {body}.{touches}", episode.summary().trim_end_matches('.'))
    }

    /// The reference point of an actor on the ground: the middle of the rear axle, or that of the box.
    fn reference(&self, actor: &Actor, motion: &Motion) -> [f64; 3] {
        let back = match actor.shape {
            Shape::Vehicle(blueprint) if self.version != Version::V1_0 => blueprint.wheelbase / 2.0,
            _ => 0.0,
        };
        let place = motion.pose.position() - motion.pose.forward() * back;
        [place.x, place.y, motion.ground + back * libm::tan(motion.pitch)]
    }

    fn text(&self) -> String {
        let minor = match self.version {
            Version::V1_0 => 0,
            Version::V1_3 => 3,
        };
        Xml::document("OpenSCENARIO", &[], |xml| {
            xml.empty(
                "FileHeader",
                attributes! {
                    revMajor: 1, revMinor: minor, date: DATE, author: AUTHOR, description: self.description,
                },
            );
            xml.empty("ParameterDeclarations", &[]);
            xml.empty("CatalogLocations", &[]);
            xml.within(&["RoadNetwork"], |xml| {
                xml.empty("LogicFile", &[("filepath", &self.map)]);
                if !self.lights.is_empty() {
                    xml.within(&["TrafficSignals"], |xml| self.signals(xml));
                }
            });
            xml.within(&["Entities"], |xml| {
                self.actors.iter().zip(&self.sizes).for_each(|(actor, size)| self.entity(xml, actor, *size));
            });
            xml.within(&["Storyboard"], |xml| {
                xml.within(&["Init", "Actions"], |xml| self.actors.iter().for_each(|actor| self.start(xml, actor)));
                xml.element("Story", &[("name", &"failure")], |xml| {
                    if self.version == Version::V1_0 {
                        xml.empty("ParameterDeclarations", &[]);
                    }
                    xml.element("Act", &[("name", &"act")], |xml| {
                        let driven =
                            |actor: &&Actor| actor.id != ActorId::EGO || self.variant.ego == EgoDriver::Recorded;
                        self.actors.iter().filter(driven).for_each(|actor| self.group(xml, actor));
                        trigger(xml, "StartTrigger", |xml| self.at_start(xml, "start_of_act"));
                    });
                });
                xml.within(&["StopTrigger"], |xml| self.stop(xml));
            });
        })
    }

    /// The controllers of the traffic lights, each of which starts with the colour of the first tick. A colour that is under way then
    /// is split: its start is the last phase.
    fn signals(&self, xml: &mut Xml) {
        for Controller { name, signals, phases } in &self.lights {
            xml.element("TrafficSignalController", &[("name", name)], |xml| {
                for ((colour, ticks), number) in phases.iter().zip(1..) {
                    // The lamps from the top down. A colour may come twice, and a phase has a name of its own.
                    let (colour, lamps) = match colour {
                        LightColour::Red => ("stop", "on;off;off"),
                        LightColour::Yellow => ("attention", "off;on;off"),
                        LightColour::Green => ("go", "off;off;on"),
                    };
                    let duration = Short(*ticks as f64 * self.dt);
                    xml.element("Phase", &[("name", &format!("{colour} {number}")), ("duration", &duration)], |xml| {
                        for signal in signals {
                            xml.empty("TrafficSignalState", &[("trafficSignalId", signal), ("state", &lamps)]);
                        }
                    });
                }
            });
        }
    }

    fn entity(&self, xml: &mut Xml, actor: &Actor, [length, width, height]: [f64; 3]) {
        let bounding_box = |xml: &mut Xml, ahead: f64| {
            xml.within(&["BoundingBox"], |xml| {
                xml.empty("Center", attributes! { x: Short(ahead), y: 0, z: Short(height / 2.0) });
                let [length, width, height] = [length, width, height].map(Short);
                xml.empty("Dimensions", attributes! { length, width, height });
            });
        };
        xml.element("ScenarioObject", &[("name", &actor.name)], |xml| match actor.shape {
            Shape::Vehicle(blueprint) => {
                let name = if self.version == Version::V1_0 { "vehicle.tesla.model3" } else { "car" };
                xml.element("Vehicle", &[("name", &name), ("vehicleCategory", &"car")], |xml| {
                    xml.empty("ParameterDeclarations", &[]);
                    let rear = if self.version == Version::V1_0 { -blueprint.wheelbase / 2.0 } else { 0.0 };
                    bounding_box(xml, rear + blueprint.wheelbase / 2.0);
                    performance(xml, blueprint);
                    xml.within(&["Axles"], |xml| {
                        axle(xml, "FrontAxle", blueprint.greatest_wheel_angle, rear + blueprint.wheelbase, width);
                        axle(xml, "RearAxle", 0.0, rear, width);
                    });
                    xml.within(&["Properties"], |xml| {
                        if self.version == Version::V1_0 {
                            property(xml, "type", if actor.id == ActorId::EGO { "ego_vehicle" } else { "simulation" });
                        }
                    });
                });
            }
            Shape::Pedestrian(_) => {
                let mass = Short(MASS);
                let (name, model) = ("adult", "walker.pedestrian.0001");
                let mut attributes: Vec<(&str, &dyn std::fmt::Display)> =
                    vec![("name", &name), ("mass", &mass), ("pedestrianCategory", &"pedestrian")];
                if self.version == Version::V1_0 {
                    attributes[0].1 = &model;
                    attributes.push(("model", &model));
                }
                xml.element("Pedestrian", &attributes, |xml| {
                    xml.empty("ParameterDeclarations", &[]);
                    bounding_box(xml, 0.0);
                    xml.within(&["Properties"], |xml| {
                        if self.version == Version::V1_0 {
                            property(xml, "type", "simulation");
                        }
                    });
                });
            }
        });
    }

    /// Places an actor; an ego without a track gets its speed, too.
    fn start(&self, xml: &mut Xml, actor: &Actor) {
        let ego_of_user = actor.id == ActorId::EGO && self.variant.ego == EgoDriver::User;
        let from = if actor.id == ActorId::EGO { 0 } else { self.first_tick() };
        xml.element("Private", &[("entityRef", &actor.name)], |xml| {
            xml.within(&["PrivateAction", "TeleportAction"], |xml| self.position(xml, actor, &actor.track[from]));
            if !ego_of_user {
                return;
            }
            if self.version == Version::V1_0 {
                xml.within(&["PrivateAction"], controller_of_scenario_runner);
            }
            xml.within(&["PrivateAction", "LongitudinalAction", "SpeedAction"], |xml| {
                let dynamics = attributes! { dynamicsShape: "step", value: 0, dynamicsDimension: "time" };
                xml.empty("SpeedActionDynamics", dynamics);
                let speed = Short(actor.track[0].velocity.norm());
                xml.within(&["SpeedActionTarget"], |xml| xml.empty("AbsoluteTargetSpeed", &[("value", &speed)]));
            });
        });
    }

    fn first_tick(&self) -> usize {
        self.release.map_or(0, |(tick, _)| tick)
    }

    fn position(&self, xml: &mut Xml, actor: &Actor, motion: &Motion) {
        let [x, y, z] = self.reference(actor, motion).map(Short);
        xml.within(&["Position"], |xml| {
            let (heading, pitch) = (Short(motion.heading), Short(motion.pitch));
            xml.empty("WorldPosition", attributes! { x, y, z, h: heading, p: pitch, r: 0 });
        });
    }

    /// The maneuver group in which an actor follows its track.
    fn group(&self, xml: &mut Xml, actor: &Actor) {
        let name = &actor.name;
        let released = self.release.filter(|_| matches!(actor.id, ActorId::Pedestrian(_)));
        let priority = if self.version == Version::V1_0 { "overwrite" } else { "override" };
        let named = |part: &str| format!("{part}_{name}");
        let (group, maneuver, event, action) = (named("group"), named("maneuver"), named("event"), named("action"));
        xml.element("ManeuverGroup", &[("name", &group), ("maximumExecutionCount", &1)], |xml| {
            xml.element("Actors", &[("selectTriggeringEntities", &false)], |xml| {
                xml.empty("EntityRef", &[("entityRef", name)]);
            });
            xml.element("Maneuver", &[("name", &maneuver)], |xml| {
                xml.element("Event", attributes! { name: event, priority, maximumExecutionCount: 1 }, |xml| {
                    xml.element("Action", &[("name", &action)], |xml| {
                        xml.within(&["PrivateAction", "RoutingAction", "FollowTrajectoryAction"], |xml| {
                            self.trajectory(xml, actor, released.is_some());
                        });
                    });
                    trigger(xml, "StartTrigger", |xml| match released {
                        None => self.at_start(xml, &named("start")),
                        Some((_, distance)) => self.at_distance(xml, &named("release"), distance),
                    });
                });
            });
        });
    }

    fn trajectory(&self, xml: &mut Xml, actor: &Actor, released: bool) {
        let first = if released { self.first_tick() } else { 0 };
        let name = format!("track_{}", actor.name);
        let polyline = |xml: &mut Xml| {
            xml.element("Trajectory", &[("name", &name), ("closed", &false)], |xml| {
                xml.within(&["Shape", "Polyline"], |xml| {
                    for (tick, motion) in actor.track[first..].iter().enumerate() {
                        let time = Short(tick as f64 * self.dt);
                        xml.element("Vertex", &[("time", &time)], |xml| self.position(xml, actor, motion));
                    }
                });
            });
        };
        if self.version == Version::V1_0 {
            polyline(xml);
        } else {
            xml.within(&["TrajectoryRef"], polyline);
        }
        xml.within(&["TimeReference"], |xml| {
            let domain = if released { "relative" } else { "absolute" };
            xml.empty("Timing", attributes! { domainAbsoluteRelative: domain, scale: 1, offset: 0 });
        });
        // ScenarioRunner knows no other mode than to follow.
        let mode = if self.version == Version::V1_0 { "follow" } else { "position" };
        xml.empty("TrajectoryFollowingMode", &[("followingMode", &mode)]);
    }

    /// The condition that is true from the first instant on.
    fn at_start(&self, xml: &mut Xml, name: &str) {
        condition(xml, name, "ByValueCondition", |xml| match self.version {
            Version::V1_0 => {
                xml.empty("SimulationTimeCondition", &[("value", &Short(BEFORE_START)), ("rule", &"greaterThan")]);
            }
            _ => xml.empty("SimulationTimeCondition", &[("value", &0), ("rule", &"greaterOrEqual")]),
        });
    }

    /// The condition that the ego is this near (m) to the pedestrian of the verdict.
    fn at_distance(&self, xml: &mut Xml, name: &str, distance: f64) {
        // The distance at the start is one at which the pedestrian walks, in spite of rounding.
        let distance = Short(distance + 1e-6);
        let (kind, rule) = match self.version {
            Version::V1_0 => ("cartesianDistance", "lessThan"),
            _ => ("euclidianDistance", "lessOrEqual"),
        };
        let pedestrian = &self.actors[self.pedestrian].name;
        self.by_entity(xml, name, &self.actors[0].name, |xml| {
            xml.empty(
                "RelativeDistanceCondition",
                attributes! {
                    entityRef: *pedestrian, relativeDistanceType: kind, value: distance, freespace: false,
                    rule,
                },
            );
        });
    }

    fn by_entity(&self, xml: &mut Xml, name: &str, entity: &str, content: impl FnOnce(&mut Xml)) {
        condition(xml, name, "ByEntityCondition", |xml| {
            xml.element("TriggeringEntities", &[("triggeringEntitiesRule", &"any")], |xml| {
                xml.empty("EntityRef", &[("entityRef", &entity)]);
            });
            xml.within(&["EntityCondition"], content);
        });
    }

    /// The ego touches a pedestrian, of the recorded ones none that it touched before, or time is over.
    fn stop(&self, xml: &mut Xml) {
        let is_recorded = self.variant == Variant::default();
        let is_pedestrian = |actor: &Actor| matches!(actor.id, ActorId::Pedestrian(_));
        let counts = |actor: &&Actor| is_pedestrian(actor) && !(is_recorded && actor.is_struck);
        for actor in self.actors.iter().filter(counts) {
            let name = format!("collision_{}", actor.name);
            xml.within(&["ConditionGroup"], |xml| {
                self.by_entity(xml, &name, &self.actors[0].name, |xml| {
                    xml.within(&["CollisionCondition"], |xml| xml.empty("EntityRef", &[("entityRef", &actor.name)]));
                });
            });
        }
        let afterwards = AFTERWARDS[usize::from(self.variant != Variant::default())];
        let end = Short((self.actors[0].track.len() - 1) as f64 * self.dt + afterwards);
        xml.within(&["ConditionGroup"], |xml| {
            condition(xml, "end", "ByValueCondition", |xml| {
                xml.empty("SimulationTimeCondition", &[("value", &end), ("rule", &"greaterThan")]);
            });
        });
    }
}

fn performance(xml: &mut Xml, blueprint: &VehicleBlueprint) {
    let forward = blueprint.throttle.iter().map(|line| line.at_rest).fold(0.0, f64::max);
    let numbers = [MAX_SPEED, forward, blueprint.full_brake];
    let [speed, acceleration, deceleration] = numbers.map(Short);
    xml.empty(
        "Performance",
        attributes! { maxSpeed: speed, maxAcceleration: acceleration, maxDeceleration: deceleration },
    );
}

fn axle(xml: &mut Xml, name: &str, steering: f64, ahead: f64, width: f64) {
    let [steering, diameter, track, ahead, height] = [steering, WHEEL, 0.8 * width, ahead, WHEEL / 2.0].map(Short);
    xml.empty(
        name,
        attributes! {
            maxSteering: steering, wheelDiameter: diameter, trackWidth: track, positionX: ahead,
            positionZ: height,
        },
    );
}

/// ScenarioRunner's controller that leaves a vehicle to another client.
fn controller_of_scenario_runner(xml: &mut Xml) {
    xml.within(&["ControllerAction"], |xml| {
        xml.within(&["AssignControllerAction"], |xml| {
            xml.element("Controller", &[("name", &"user")], |xml| {
                xml.within(&["Properties"], |xml| property(xml, "module", "external_control"));
            });
        });
        xml.within(&["OverrideControllerValueAction"], |xml| {
            for name in ["Throttle", "Brake", "Clutch", "ParkingBrake", "SteeringWheel"] {
                xml.empty(name, &[("value", &0), ("active", &false)]);
            }
            xml.empty("Gear", &[("number", &0), ("active", &false)]);
        });
    });
}

fn property(xml: &mut Xml, name: &str, value: &str) {
    xml.empty("Property", attributes! { name, value });
}

fn trigger(xml: &mut Xml, name: &str, content: impl FnOnce(&mut Xml)) {
    xml.within(&[name, "ConditionGroup"], content);
}

fn condition(xml: &mut Xml, name: &str, kind: &str, content: impl FnOnce(&mut Xml)) {
    xml.element("Condition", attributes! { name, delay: 0, conditionEdge: "none" }, |xml| {
        xml.within(&[kind], content);
    });
}

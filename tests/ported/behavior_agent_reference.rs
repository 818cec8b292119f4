//! The agent compared with recordings of CARLA's own agent, open loop.

use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::fs;
use std::path::{Path, PathBuf};

use crate::reference;
use base::seed::Seed;
use needs::needs;
use ported::behavior_agent::{AgentConfig, BehaviorAgent, Profile, Release};
use road::geometry::{Obstacles, Pose, Vector};
use road::{RoadIndex, RoadOption, RoutePoint, Town, Waypoint, opendrive};
use serde_json::Value;
use world::av::{Actor, DrivingPolicy, Light, Perception};
use world::sim::{ActorId, LightColour, VehicleBlueprint};

/// Half sizes of the recorded cars and walkers (m).
const CAR: [f64; 2] = [2.395_889_759_063_720_7, 1.081_725_001_335_144];
const WALKER: f64 = 0.187_678_888_440_132_14;
const WALKER_HEIGHT: f64 = 0.93;
const TOLERANCE: f64 = 1e-5;
/// Tolerance of recorded distances (m): the spacing of the recorded floats at the size of a town.
const DISTANCE_TOLERANCE: f64 = 1e-4;
/// An angle to the direction dead ahead (degrees); within it CARLA's agent may or may not see an obstacle.
const DEAD_AHEAD: f64 = 0.01;

/// A table with a header; its values are read by column name.
struct Table {
    columns: BTreeMap<String, usize>,
    rows: Vec<Vec<String>>,
}

impl Table {
    fn read(path: &Path) -> Self {
        let text = crate::gzip::read_text(path).unwrap_or_else(|| panic!("{} is not there", path.display()));
        let mut lines = text.lines().map(|line| line.split(',').map(str::to_owned).collect::<Vec<_>>());
        let header = lines.next().expect("a table has a header");
        Self { columns: header.into_iter().enumerate().map(|(i, name)| (name, i)).collect(), rows: lines.collect() }
    }

    fn text(&self, row: usize, column: &str) -> &str {
        &self.rows[row][self.columns[column]]
    }

    /// None where the cell is empty.
    fn number(&self, row: usize, column: &str) -> Option<f64> {
        let text = self.text(row, column);
        (!text.is_empty()).then(|| text.parse().unwrap_or_else(|_| panic!("{column} in row {row}: {text}")))
    }

    fn get(&self, row: usize, column: &str) -> f64 {
        self.number(row, column).unwrap_or_else(|| panic!("{column} in row {row} is empty"))
    }

    /// A pose from CARLA's axes; none where the cells are empty.
    fn pose(&self, row: usize, name: &str) -> Option<Pose> {
        let cell = |what: &str| self.number(row, &format!("{name}{what}"));
        Some(carla_pose(cell("x")?, cell("y")?, cell("yaw")?))
    }
}

fn carla_pose(x: f64, y: f64, yaw: f64) -> Pose {
    Pose::new(x, -y, -yaw.to_radians())
}

fn plan(town: &Town, table: &Table) -> Vec<RoutePoint> {
    let point = |row: usize| {
        let id = table.get(row, "road_id") as u32;
        let road = town.roads.iter().position(|road| road.id == id).expect("the plan's roads are in the town");
        RoutePoint {
            waypoint: Waypoint {
                road: RoadIndex(road as u32),
                section: table.get(row, "section_id") as u32,
                lane: table.get(row, "lane_id") as i32,
                s: table.get(row, "s"),
            },
            pose: table.pose(row, "").expect("a point of a plan has a pose"),
            lane_width: table.get(row, "lane_width"),
            is_junction: table.get(row, "is_junction") != 0.0,
            option: match table.text(row, "option") {
                "LEFT" => RoadOption::Left,
                "RIGHT" => RoadOption::Right,
                "STRAIGHT" => RoadOption::Straight,
                "LANEFOLLOW" => RoadOption::LaneFollow,
                other => panic!("unknown option {other}"),
            },
        }
    };
    (0..table.rows.len()).map(point).collect()
}

fn car(pose: Pose, speed: f64) -> Actor {
    let (velocity, half) = (pose.forward() * speed, Vector::new(CAR[0], CAR[1]));
    Actor { id: ActorId::Vehicle(1), pose, velocity, half, height: 0.0 }
}

fn walker(pose: Pose) -> Actor {
    let (velocity, half) = (Vector::zeros(), Vector::new(WALKER, WALKER));
    Actor { id: ActorId::Pedestrian(0), pose, velocity, half, height: WALKER_HEIGHT }
}

/// Agreement over the ticks of a release.
#[derive(Default)]
struct Agreement {
    ticks: usize,
    emergencies: usize,
    /// Ticks with a wrong flag and an obstacle dead ahead.
    dead_ahead: Vec<String>,
    wrong: Vec<String>,
    worst: BTreeMap<&'static str, (f64, String)>,
    off: Vec<String>,
}

impl Agreement {
    fn value(&mut self, what: &'static str, error: f64, tolerance: f64, place: &str) {
        let error = if error.is_nan() { f64::INFINITY } else { error };
        let worst = self.worst.entry(what).or_default();
        if error > worst.0 {
            *worst = (error, place.to_owned());
        }
        if error > tolerance {
            self.off.push(format!("{place}: {what} off by {error:.2e}"));
        }
    }
}

/// None where the map is not available.
fn read_town(name: &str) -> Option<Town> {
    let path = reference::folder().join("maps").join(format!("{name}.xodr"));
    let text = crate::gzip::read_text(&path)?;
    Some(Town::new(opendrive::read(&text, name).expect("the map of a case is readable")))
}

fn replay(
    case: &Value,
    folder: &Path,
    towns: &mut BTreeMap<String, Option<Town>>,
    release: Release,
    sum: &mut Agreement,
) {
    let name = case["name"].as_str().expect("a case has a name");
    let town_name = case["town"].as_str().expect("a case has a town");
    let Some(town) = towns.entry(town_name.to_owned()).or_insert_with(|| read_town(town_name)) else {
        loud!("SKIPPED: {name} of CARLA {}, for want of its map", release.name());
        return;
    };
    let profile = case["behavior"].as_str().and_then(Profile::named).expect("a case has a behaviour");
    let rows = Table::read(&folder.join(format!("{name}_trace.csv")));
    let blueprint = VehicleBlueprint::model3();
    let open = Obstacles::new(&[]);
    let trigger = case["light"]["at"]
        .as_array()
        .map(|at| carla_pose(at[0].as_f64().expect("a light's x"), at[1].as_f64().expect("a light's y"), 0.0));
    let mut agent = BehaviorAgent::new(AgentConfig { release, profile, ..AgentConfig::default() });
    for row in 0..rows.rows.len() {
        let place = format!("{} {name} tick {}", release.name(), rows.text(row, "tick"));
        let ego = car(rows.pose(row, "ego_").expect("the ego has a pose"), rows.get(row, "ego_v"));
        let pedestrians: Vec<Actor> = rows.pose(row, "ped_").map(walker).into_iter().collect();
        let vehicles: Vec<Actor> =
            rows.pose(row, "lead_").map(|pose| car(pose, rows.get(row, "lead_v"))).into_iter().collect();
        let lights: Vec<Light> = trigger
            .map(|trigger| {
                let red = rows.number(row, "light_red") == Some(1.0);
                Light { trigger, colour: if red { LightColour::Red } else { LightColour::Green } }
            })
            .into_iter()
            .collect();
        let affected = lights.iter().position(|light| (light.trigger.position() - ego.pose.position()).norm() <= 5.0);
        let perception = Perception {
            town,
            blueprint: &blueprint,
            tick: row as u32,
            dt: 0.05,
            ego,
            ground: 0.0,
            speed_limit: rows.get(row, "speed_limit") / 3.6,
            signed_limit: None,
            route: &[],
            pedestrians: &pedestrians,
            vehicles: &vehicles,
            obstacles: &open,
            lights: &lights,
            affecting_light: affected,
        };
        if row == 0 {
            agent.reset(&perception, Seed::root(0).stream());
            agent.set_plan(plan(town, &Table::read(&folder.join(format!("{name}_plan.csv")))));
        }
        let control = agent.drive(&perception);
        let decision = *agent.decision();
        sum.ticks += 1;
        sum.emergencies += usize::from(decision.emergency);
        let flags = [
            ("light_hazard", decision.red_light),
            ("walker_hazard", decision.walker.is_some()),
            ("vehicle_hazard", decision.vehicle.is_some()),
            ("hazard", decision.emergency),
        ];
        let wrong: Vec<&str> = flags
            .iter()
            .filter(|(flag, value)| (rows.get(row, flag) == 1.0) != *value)
            .map(|(flag, _)| *flag)
            .collect();
        if !wrong.is_empty() {
            let line = format!("{place}: {}", wrong.join(", "));
            let near = pedestrians.iter().chain(&vehicles);
            let dead_ahead = near.map(|actor| least_bearing(&ego, actor)).any(|bearing| bearing < DEAD_AHEAD);
            if dead_ahead {
                sum.dead_ahead.push(line);
            } else {
                sum.wrong.push(line);
            }
            continue;
        }
        for (what, flag, column, distance) in [
            ("walker distance", "walker_hazard", "walker_distance", decision.walker),
            ("vehicle distance", "vehicle_hazard", "vehicle_distance", decision.vehicle),
        ] {
            if rows.get(row, flag) == 1.0 {
                let error = rows.get(row, column) - distance.expect("the flags agree");
                sum.value(what, error.abs(), DISTANCE_TOLERANCE, &place);
            }
        }
        sum.value("target speed", (rows.get(row, "target_speed") - decision.target_speed * 3.6).abs(), 1e-4, &place);
        sum.value("throttle", (rows.get(row, "throttle") - control.throttle).abs(), TOLERANCE, &place);
        sum.value("brake", (rows.get(row, "brake") - control.brake).abs(), TOLERANCE, &place);
        sum.value("steer", (rows.get(row, "steer") + control.steer).abs(), TOLERANCE, &place);
        let queue = rows.get(row, "queue_len") - agent.plan().len() as f64;
        sum.value("queue length", queue.abs(), 0.0, &place);
    }
}

/// The smallest bearing at which the agents measure an obstacle (degrees): of its centre and its rear point, from the
/// ego's centre and from its bumper.
fn least_bearing(ego: &Actor, obstacle: &Actor) -> f64 {
    let tips = [0.0, ego.half.x].map(|ahead| ego.pose.to_world(Vector::new(ahead, 0.0)));
    let ends = [0.0, -obstacle.half.x].map(|ahead| obstacle.pose.to_world(Vector::new(ahead, 0.0)));
    let bearings = tips
        .iter()
        .flat_map(|tip| ends.map(|end| Pose::new(tip.x, tip.y, ego.pose.yaw).bearing_to(end).abs() * 180.0 / PI));
    bearings.fold(f64::INFINITY, f64::min)
}

#[needs(reference = "reference/behavior_agent_traces/v _trace.csv")]
#[test]
fn recorded_decisions_are_repeated_reference() {
    let root = reference::folder().join("reference").join("behavior_agent_traces");
    let folders = fs::read_dir(&root).unwrap();
    let mut folders: Vec<PathBuf> = folders.flatten().map(|entry| entry.path()).filter(|path| path.is_dir()).collect();
    folders.sort();
    let mut towns = BTreeMap::new();
    let mut failures = Vec::new();
    let mut replayed = 0;
    for folder in folders {
        let Some(version) = folder.file_name().and_then(|name| name.to_str()?.strip_prefix('v')) else { continue };
        let Some(release) = Release::named(version) else {
            loud!("SKIPPED: recordings of CARLA {version}, which no agent here claims to be");
            continue;
        };
        let Some(cases) = crate::gzip::read_text(&folder.join("cases.json")) else {
            loud!("SKIPPED: {} has no cases.json", folder.display());
            continue;
        };
        let cases: Value = serde_json::from_str(&cases).expect("cases.json is JSON");
        let mut sum = Agreement::default();
        for case in cases.as_array().expect("cases.json is a list") {
            let name = case["name"].as_str().expect("a case has a name");
            let is_there = |kind: &str| {
                ["csv", "csv.gz"].iter().any(|ending| folder.join(format!("{name}_{kind}.{ending}")).is_file())
            };
            if is_there("trace") && is_there("plan") {
                replay(case, &folder, &mut towns, release, &mut sum);
                replayed += 1;
            }
        }
        eprintln!(
            "CARLA {version}: {} ticks, {} emergency stops, {} wrong flags and {} with an obstacle dead ahead",
            sum.ticks,
            sum.emergencies,
            sum.wrong.len(),
            sum.dead_ahead.len()
        );
        for (what, (error, place)) in &sum.worst {
            eprintln!("  worst {what}: {error:.2e} ({place})");
        }
        for line in sum.wrong.iter().chain(&sum.dead_ahead).chain(&sum.off).take(40) {
            eprintln!("  {line}");
        }
        // In between, 32-bit headings decide whether an obstacle dead ahead is seen.
        let allowed = match release {
            Release::V0_9_12 => 8,
            Release::V0_9_13 => 2,
            Release::V0_9_11 | Release::V0_9_15 => 0,
        };
        if !sum.wrong.is_empty() || !sum.off.is_empty() || sum.dead_ahead.len() > allowed {
            failures.push(version.to_owned());
        }
    }
    assert!(replayed > 0, "no recordings of CARLA's agent are readable in {}", root.display());
    assert!(failures.is_empty(), "the agents of CARLA {} decide otherwise", failures.join(", "));
}

//! Maps against what CARLA's own map library makes of the same files.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use falsify::geometry::{Point, Pose, wrap_angle};
use falsify::road::{LaneFilter, LaneKind, RoadIndex, Town, Waypoint, opendrive};

/// Agreement asked for, in metres and in radians.
const TOLERANCE: f64 = 1e-3;

fn maps_folder() -> PathBuf {
    let folder = std::env::var_os("FALSIFY_REFERENCE_DIR").map(PathBuf::from);
    folder.unwrap_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared")).join("maps")
}

/// A map with one table of the oracle.
struct Case {
    town: Town,
    roads: BTreeMap<u32, RoadIndex>,
    table: Table,
}

/// A comma-separated table with a header.
struct Table {
    header: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Table {
    fn read(path: &Path) -> Self {
        let text = fs::read_to_string(path).unwrap();
        let mut lines = text.lines().map(|line| line.split(',').map(str::to_owned).collect::<Vec<_>>());
        Self { header: lines.next().unwrap(), rows: lines.collect() }
    }

    fn text<'a>(&self, row: &'a [String], column: &str) -> &'a str {
        let index = self.header.iter().position(|name| name == column).unwrap_or_else(|| panic!("no column {column}"));
        &row[index]
    }

    fn number(&self, row: &[String], column: &str) -> f64 {
        self.text(row, column).parse().unwrap_or_else(|_| panic!("{column} of {row:?}"))
    }
}

impl Case {
    fn waypoint(&self, row: &[String], prefix: &str) -> Waypoint {
        let number = |name: &str| self.table.number(row, &format!("{prefix}{name}"));
        Waypoint {
            road: self.roads[&(number("road_id") as u32)],
            section: number("section_id") as u32,
            lane: number("lane_id") as i32,
            s: number("s"),
        }
    }

    fn point(&self, row: &[String], prefix: &str) -> Point {
        Point::new(self.table.number(row, &format!("{prefix}x")), -self.table.number(row, &format!("{prefix}y")))
    }

    fn pose(&self, row: &[String], prefix: &str) -> Pose {
        let place = self.point(row, prefix);
        Pose::new(place.x, place.y, -self.table.number(row, &format!("{prefix}yaw")).to_radians())
    }

    fn kind(&self, row: &[String], column: &str) -> LaneKind {
        match self.table.text(row, column) {
            "Driving" => LaneKind::Driving,
            "Sidewalk" => LaneKind::Sidewalk,
            "Shoulder" => LaneKind::Shoulder,
            "Border" => LaneKind::Border,
            "Biking" => LaneKind::Biking,
            "Parking" => LaneKind::Parking,
            "Median" => LaneKind::Median,
            "Stop" => LaneKind::Stop,
            "Bidirectional" => LaneKind::Bidirectional,
            "None" | "NONE" => LaneKind::None,
            _ => LaneKind::Special,
        }
    }
}

/// What a comparison found.
#[derive(Default)]
struct Findings {
    compared: usize,
    worst_place: f64,
    worst_yaw: f64,
    mismatches: Vec<String>,
    ties: usize,
}

impl Findings {
    /// Compares poses and notes how far apart they are.
    fn pose(&mut self, ours: Pose, theirs: Pose, what: impl Fn() -> String) {
        let apart = (ours.position() - theirs.position()).norm();
        let turned = wrap_angle(ours.yaw - theirs.yaw).abs();
        self.worst_place = self.worst_place.max(apart);
        self.worst_yaw = self.worst_yaw.max(turned);
        self.check(apart <= TOLERANCE && turned <= TOLERANCE, || format!("{}: {ours:?} is not {theirs:?}", what()));
    }

    fn check(&mut self, holds: bool, what: impl FnOnce() -> String) {
        if !holds {
            self.mismatches.push(what());
        }
    }
}

/// Runs a comparison on every map that has such a table, prints what it finds, and fails on any mismatch.
fn with_tables(kind: &str, compare: impl Fn(&Case, &mut Findings)) {
    let folder = maps_folder();
    let Ok(entries) = fs::read_dir(folder.join("oracle")) else {
        eprintln!("SKIPPED: no reference maps in {}", folder.display());
        return;
    };
    let mut names: Vec<String> = entries.filter_map(|entry| entry.ok()?.file_name().into_string().ok()).collect();
    names.sort();
    let mut failures = Vec::new();
    for file in names {
        if file.ends_with(&format!("_{kind}.csv.gz")) {
            eprintln!("SKIPPED: {file} is compressed");
        }
        let Some(name) = file.strip_suffix(&format!("_{kind}.csv")) else { continue };
        let Ok(xml) = fs::read_to_string(folder.join(format!("{name}.xodr"))) else {
            eprintln!("SKIPPED: {file} has no map beside it");
            continue;
        };
        let town = Town::new(opendrive::read(&xml, name).unwrap());
        let roads = town.roads.iter().zip(0..).map(|(road, index)| (road.id, RoadIndex(index))).collect();
        let case = Case { town, roads, table: Table::read(&folder.join("oracle").join(&file)) };
        let mut findings = Findings::default();
        compare(&case, &mut findings);
        let Findings { compared, worst_place, worst_yaw, mismatches, ties } = findings;
        eprintln!(
            "{name} {kind}: {compared} compared, worst {worst_place:.1e} m and {worst_yaw:.1e} rad, {} mismatches, {ties} ties",
            mismatches.len()
        );
        mismatches.iter().take(5).for_each(|mismatch| eprintln!("  {mismatch}"));
        if !mismatches.is_empty() {
            failures.push(format!("{name}: {} of {compared}", mismatches.len()));
        }
    }
    assert!(failures.is_empty(), "{kind}: {failures:?}");
}

fn compare_lanes(case: &Case, found: &mut Findings) {
    for row in &case.table.rows {
        let at = case.waypoint(row, "");
        found.compared += 1;
        found.pose(case.town.pose(at), case.pose(row, ""), || format!("{at:?}"));
        let width = case.town.lane_width(at);
        found.check((width - case.table.number(row, "lane_width")).abs() <= TOLERANCE, || {
            format!("{at:?}: width {width}")
        });
        let kind = case.town.lane_kind(at);
        found.check(kind == case.kind(row, "lane_type"), || format!("{at:?}: kind {kind:?}"));
        let junction = case.town.junction(at).map_or(-1, |index| i64::from(case.town.junctions[index.0 as usize].id));
        found
            .check(junction == case.table.number(row, "junction_id") as i64, || format!("{at:?}: junction {junction}"));
    }
}

#[test]
fn lanes_agree_with_the_reference() {
    with_tables("lanes", compare_lanes);
}

#[test]
fn generated_waypoints_agree_with_the_reference() {
    with_tables("waypoints", |case, found| {
        compare_lanes(case, found);
        // A tenth of a micrometre separates a multiple of the step from where a section begins.
        let key = |w: &Waypoint| (w.road.0, w.section, w.lane, (w.s * 1e3).round() as i64);
        let mut ours: BTreeMap<_, i64> = BTreeMap::new();
        case.town.generate_waypoints(2.0).iter().for_each(|waypoint| *ours.entry(key(waypoint)).or_default() += 1);
        case.table.rows.iter().for_each(|row| *ours.entry(key(&case.waypoint(row, ""))).or_default() -= 1);
        for (key, count) in ours.iter().filter(|(_, count)| **count != 0) {
            found.check(false, || format!("{key:?} is there {count:+} times"));
        }
    });
}

#[test]
fn topology_agrees_with_the_reference() {
    with_tables("topology", |case, found| {
        let key = |w: Waypoint| (case.town.roads[w.road.0 as usize].id, w.section, w.lane, (w.s * 1e2).round() as i64);
        let mut pairs: BTreeMap<_, i64> = BTreeMap::new();
        for (entry, exit) in case.town.topology() {
            *pairs.entry((key(entry), key(exit))).or_default() += 1;
        }
        for row in &case.table.rows {
            found.compared += 1;
            let (entry, exit) = (case.waypoint(row, "entry_"), case.waypoint(row, "exit_"));
            found.pose(case.town.pose(entry), case.pose(row, "entry_"), || format!("{entry:?}"));
            found.pose(case.town.pose(exit), case.pose(row, "exit_"), || format!("{exit:?}"));
            *pairs.entry((key(entry), key(exit))).or_default() -= 1;
        }
        // CARLA loses a dead end where the lane's end rounds up to 32 bits beyond the road; we keep it.
        let dead_end =
            |(entry, exit): &(_, _)| matches!((entry, exit), ((a, b, c, _), (d, e, f, _)) if (a, b, c) == (d, e, f));
        for (pair, count) in pairs.iter().filter(|(pair, count)| **count != 0 && !(dead_end(pair) && **count == 1)) {
            found.check(false, || format!("{pair:?} is there {count:+} times"));
        }
    });
}

#[test]
fn junctions_agree_with_the_reference() {
    with_tables("junctions", |case, found| {
        let town = &case.town;
        for row in &case.table.rows {
            found.compared += 1;
            let id = case.table.number(row, "junction_id") as u32;
            let inside =
                town.roads.iter().filter(|road| road.junction.is_some_and(|j| town.junctions[j.0 as usize].id == id));
            let mut ours: Vec<String> = inside
                .flat_map(|road| {
                    let driving = road.sections[0].lanes.iter().filter(|lane| lane.kind == LaneKind::Driving);
                    driving.map(|lane| format!("{}:{}", road.id, lane.id))
                })
                .collect();
            let mut theirs: Vec<&str> = case.table.text(row, "road:lane list").split(';').collect();
            ours.sort_unstable();
            theirs.sort_unstable();
            found.check(ours == theirs, || format!("junction {id}: {ours:?} is not {theirs:?}"));
        }
    });
}

#[test]
fn next_and_previous_agree_with_the_reference() {
    with_tables("next", |case, found| {
        // The rows of each waypoint and direction.
        type Group<'a> = (Waypoint, Vec<&'a Vec<String>>);
        let mut groups: BTreeMap<(String, bool), Group> = BTreeMap::new();
        for row in &case.table.rows {
            let ahead = case.table.text(row, "direction") == "next";
            let from = case.waypoint(row, "");
            groups.entry((format!("{from:?}"), ahead)).or_insert_with(|| (from, Vec::new())).1.push(row);
        }
        for ((_, ahead), (from, rows)) in &groups {
            found.compared += 1;
            let mut ours = Vec::new();
            if *ahead {
                case.town.next(*from, 2.0, &mut ours);
            } else {
                case.town.previous(*from, 2.0, &mut ours);
            }
            // Waypoints without a branch have a row whose target is empty.
            let rows: Vec<_> = rows.iter().filter(|row| !case.table.text(row, "to_x").is_empty()).collect();
            found.check(ours.len() == rows.len(), || {
                format!("{from:?} ahead {ahead}: {} ways, not {}", ours.len(), rows.len())
            });
            for row in rows {
                // At the seam of two lanes the same place may be on either.
                let theirs = case.pose(row, "to_");
                let apart = |w: &Waypoint| (case.town.pose(*w).position() - theirs.position()).norm();
                let Some(same) = ours.iter().min_by(|a, b| apart(a).total_cmp(&apart(b))) else { continue };
                found.pose(case.town.pose(*same), theirs, || format!("{from:?} ahead {ahead} to {same:?}"));
            }
        }
    });
}

/// Whether two answers are equally good: lanes equally far, or two chords that meet at the corner nearest to the point. (In the
/// latter case the end of one chord and the beginning of the other differ, since chords are shorter than their part of the road.)
fn is_tie(point: Point, ours: Pose, theirs: Pose) -> bool {
    let apart = (ours.position() - theirs.position()).norm();
    let distance = |pose: Pose| (pose.position() - point).norm();
    let abeam = |pose: Pose| pose.to_local(point).normalize().x.abs() < 0.1;
    let equally_far = (distance(ours) - distance(theirs)).abs() <= TOLERANCE;
    apart > TOLERANCE && (equally_far || apart < 0.5 && (abeam(ours) || abeam(theirs)))
}

#[test]
fn nearest_lanes_agree_with_the_reference() {
    with_tables("queries", |case, found| {
        let hilly = case.table.rows.iter().any(|row| case.table.number(row, "z") != 0.0);
        let mut other_lanes = 0;
        for row in &case.table.rows {
            let point = case.point(row, "");
            for (filter, prefix) in [(LaneFilter::Driving, "driving_"), (LaneFilter::Any, "any_")] {
                found.compared += 1;
                let at = case.town.nearest_lane(point, filter).unwrap();
                let (ours, theirs) = (case.town.pose(at), case.pose(row, prefix));
                let wanted = case.waypoint(row, prefix);
                if hilly {
                    // Chords end elsewhere where pitch counts as a turn, and are up to 0.2 m off the bend they span.
                    other_lanes += usize::from((at.road, at.lane) != (wanted.road, wanted.lane));
                    found
                        .check((at.s - wanted.s).abs() < 1.0, || format!("{point} {filter:?}: {at:?}, not {wanted:?}"));
                } else if is_tie(point, ours, theirs) {
                    found.ties += 1;
                } else {
                    found.pose(ours, theirs, || format!("{point} {filter:?}: {at:?}, not {wanted:?}"));
                }
            }
        }
        if hilly {
            eprintln!("{}: hilly, {other_lanes} other lanes", case.town.name);
        }
        let (compared, ties) = (found.compared, found.ties);
        found.check(200 * ties <= compared, || format!("{ties} ties are too many"));
        found.check(100 * other_lanes <= compared, || format!("{other_lanes} other lanes are too many"));
    });
}

#[test]
fn speed_signs_and_traffic_lights_agree_with_the_reference() {
    with_tables("landmarks", |case, found| {
        let of_type =
            |kind: &'static str| case.table.rows.iter().filter(move |row| case.table.text(row, "type") == kind);
        let mut limits: Vec<i64> = of_type("274").map(|row| case.table.number(row, "value") as i64).collect();
        let mut ours: Vec<i64> = case.town.speed_signs.iter().map(|sign| (sign.limit * 3.6).round() as i64).collect();
        limits.sort_unstable();
        ours.sort_unstable();
        found.check(ours == limits, || format!("limits {ours:?} are not {limits:?}"));
        for row in of_type("274") {
            found.compared += 1;
            // The sign stands beside the road, abeam of a box that reaches one lane up to it.
            let sign = case.point(row, "");
            let limit = case.table.number(row, "value") / 3.6;
            let near = case.town.speed_signs.iter().filter(|ours| (ours.limit - limit).abs() < 1e-9);
            let distance = near.map(|ours| ours.trigger.distance_to(sign)).fold(f64::INFINITY, f64::min);
            found.check(distance < 10.0, || format!("no box within 10 m of the sign at {sign}, but at {distance}"));
        }
        let mut lights: Vec<&str> = of_type("1000001").map(|row| case.table.text(row, "id")).collect();
        lights.sort_unstable();
        lights.dedup();
        found.compared += lights.len();
        let ours = &case.town.traffic_lights;
        found.check(ours.len() == lights.len(), || format!("{} lights, not {}", ours.len(), lights.len()));
        for light in ours {
            let at = case.town.nearest_lane(light.stop.position(), LaneFilter::Driving).unwrap();
            let mut ahead = Vec::new();
            case.town.next(at, 3.5, &mut ahead);
            let enters = !case.town.is_junction(at) && ahead.iter().all(|w| case.town.is_junction(*w));
            found.check(enters && at.road == light.road && light.turn < light.turns, || format!("{light:?}"));
        }
    });
}

//! Maps compared with the results of CARLA's own map library for the same files.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::PathBuf;

use crate::reference;
use needs::needs;
use road::geometry::{Point, Pose, wrap_angle};
use road::{LaneFilter, LaneId, LaneKind, RoadIndex, Town, Waypoint, opendrive};

/// The required agreement, in metres and in radians.
const TOLERANCE: f64 = 1e-3;

fn maps_folder() -> PathBuf {
    reference::folder().join("maps")
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
    fn read(text: &str) -> Self {
        let mut lines = text.lines().map(|line| line.split(',').map(str::to_owned).collect::<Vec<_>>());
        Self { header: lines.next().unwrap_or_default(), rows: lines.collect() }
    }

    fn column(&self, column: &str) -> Option<usize> {
        self.header.iter().position(|name| name == column)
    }

    fn text<'a>(&self, row: &'a [String], column: &str) -> &'a str {
        &row[self.column(column).unwrap_or_else(|| panic!("no column {column}"))]
    }

    fn number(&self, row: &[String], column: &str) -> f64 {
        self.text(row, column).parse().unwrap_or_else(|_| panic!("{column} of {row:?}"))
    }

    /// A number of a column that not every table has.
    fn optional(&self, row: &[String], column: &str) -> Option<f64> {
        row[self.column(column)?].parse().ok()
    }
}

impl Case {
    fn waypoint(&self, row: &[String], prefix: &str) -> Waypoint {
        let number = |name: &str| self.table.number(row, &format!("{prefix}{name}"));
        Waypoint {
            // The comparisons of these places report roads that are missing here.
            road: self.roads.get(&(number("road_id") as u32)).copied().unwrap_or(RoadIndex(u32::MAX)),
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

/// The result of a comparison.
#[derive(Default)]
struct Findings {
    compared: usize,
    worst_place: f64,
    worst_yaw: f64,
    mismatches: Vec<String>,
    ties: usize,
}

impl Findings {
    /// Compares poses and records their distance.
    fn pose(&mut self, ours: Pose, theirs: Pose, what: impl Fn() -> String) {
        let apart = (ours.position() - theirs.position()).norm();
        let turned = wrap_angle(ours.yaw - theirs.yaw).abs();
        self.worst_place = self.worst_place.max(apart);
        self.worst_yaw = self.worst_yaw.max(turned);
        // CARLA computes in 32 bits, which resolve no millimetre beyond some kilometres from the origin.
        let reach = TOLERANCE.max(4.0 * f64::from(f32::EPSILON) * theirs.x.abs().max(theirs.y.abs()));
        self.check(apart <= reach && turned <= TOLERANCE, || format!("{}: {ours:?} is not {theirs:?}", what()));
    }

    fn check(&mut self, holds: bool, what: impl FnOnce() -> String) {
        if !holds {
            self.mismatches.push(what());
        }
    }
}

/// Runs a comparison on every map that has such a table, prints the result, and fails on any mismatch.
fn with_tables(kind: &str, compare: impl Fn(&Case, &mut Findings)) {
    let folder = maps_folder();
    let entries = fs::read_dir(folder.join("oracle")).unwrap();
    let files: Vec<String> = entries.filter_map(|entry| entry.ok()?.file_name().into_string().ok()).collect();
    let ending = format!("_{kind}.csv");
    let names: BTreeSet<&str> =
        files.iter().filter_map(|file| file.strip_suffix(".gz").unwrap_or(file).strip_suffix(&ending)).collect();
    let mut failures = Vec::new();
    let mut page = format!(
        "{:<24} {:>9} {:>9} {:>9} {:>10} {:>6}\n",
        format!("{kind} of"),
        "compared",
        "worst m",
        "worst rad",
        "mismatches",
        "ties"
    );
    for name in names {
        let Some(xml) = crate::gzip::read_text(&folder.join(format!("{name}.xodr"))) else {
            page += &format!("{name:<24} SKIPPED: there is no map beside its table\n");
            continue;
        };
        let text =
            crate::gzip::read_text(&folder.join("oracle").join(format!("{name}{ending}"))).expect("the table is there");
        let town = match opendrive::read(&xml, name) {
            Ok(parts) => Town::new(parts),
            Err(error) => {
                page += &format!("{name:<24} {error}\n");
                failures.push(format!("{name}: {error}"));
                continue;
            }
        };
        let roads = town.roads.iter().zip(0..).map(|(road, index)| (road.id, RoadIndex(index))).collect();
        let case = Case { town, roads, table: Table::read(&text) };
        let mut findings = Findings::default();
        compare(&case, &mut findings);
        let Findings { compared, worst_place, worst_yaw, mismatches, ties } = findings;
        page += &format!(
            "{name:<24} {compared:>9} {worst_place:>9.1e} {worst_yaw:>9.1e} {:>10} {ties:>6}\n",
            mismatches.len()
        );
        mismatches.iter().take(5).for_each(|mismatch| page += &format!("  {mismatch}\n"));
        if !mismatches.is_empty() {
            failures.push(format!("{name}: {} of {compared}", mismatches.len()));
        }
    }
    eprint!("\n{page}");
    assert!(failures.is_empty(), "{kind}: {failures:?}");
}

fn compare_lanes(case: &Case, found: &mut Findings) {
    for row in &case.table.rows {
        let at = case.waypoint(row, "");
        found.compared += 1;
        found.pose(case.town.pose(at), case.pose(row, ""), || format!("{at:?}"));
        if let Some(z) = case.table.optional(row, "z") {
            let elevation = case.town.elevation(at);
            found.check((elevation - z).abs() <= TOLERANCE, || format!("{at:?}: height {elevation}, not {z}"));
        }
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

#[needs(reference = "maps/oracle/ _lanes.csv")]
#[test]
fn lanes_agree_with_the_reference() {
    with_tables("lanes", compare_lanes);
}

#[needs(reference = "maps/oracle/ _waypoints.csv")]
#[test]
fn generated_waypoints_agree_with_the_reference() {
    with_tables("waypoints", |case, found| {
        compare_lanes(case, found);
        // A tenth of a micrometre separates a multiple of the step from the start of a section.
        let key = |w: &Waypoint| (w.road.0, w.section, w.lane, (w.s * 1e3).round() as i64);
        let mut ours: BTreeMap<_, i64> = BTreeMap::new();
        case.town.generate_waypoints(2.0).iter().for_each(|waypoint| *ours.entry(key(waypoint)).or_default() += 1);
        case.table.rows.iter().for_each(|row| *ours.entry(key(&case.waypoint(row, ""))).or_default() -= 1);
        for (key, count) in ours.iter().filter(|(_, count)| **count != 0) {
            found.check(false, || format!("{key:?} is there {count:+} times"));
        }
    });
}

#[needs(reference = "maps/oracle/ _topology.csv")]
#[test]
fn topology_agrees_with_the_reference() {
    with_tables("topology", |case, found| {
        let key = |w: Waypoint| (w.road.0, w.section, w.lane);
        let mut pairs: BTreeMap<_, Vec<(Waypoint, Waypoint)>> = BTreeMap::new();
        for (entry, exit) in case.town.topology() {
            pairs.entry((key(entry), key(exit))).or_default().push((entry, exit));
        }
        for row in &case.table.rows {
            found.compared += 1;
            let (entry, exit) = (case.waypoint(row, "entry_"), case.waypoint(row, "exit_"));
            found.pose(case.town.pose(entry), case.pose(row, "entry_"), || format!("{entry:?}"));
            found.pose(case.town.pose(exit), case.pose(row, "exit_"), || format!("{exit:?}"));
            let ours = pairs.get_mut(&(key(entry), key(exit))).and_then(Vec::pop);
            found.check(ours.is_some(), || format!("{entry:?} to {exit:?} is missing"));
            let Some((own_entry, own_exit)) = ours else { continue };
            let off = (own_entry.s - entry.s).abs().max((own_exit.s - exit.s).abs());
            found.check(off <= TOLERANCE, || format!("{entry:?} to {exit:?}: off by {off} m"));
        }
        // CARLA loses a dead end where the lane's end rounds up to 32 bits beyond the road; we keep it.
        let dead_end = |(entry, exit): &(Waypoint, Waypoint)| key(*entry) == key(*exit);
        for (entry, exit) in pairs.values().flatten().filter(|pair| !dead_end(pair)) {
            found.check(false, || format!("{entry:?} to {exit:?} is not there"));
        }
    });
}

#[needs(reference = "maps/oracle/ _junctions.csv")]
#[test]
fn junctions_agree_with_the_reference() {
    with_tables("junctions", |case, found| {
        let town = &case.town;
        for row in &case.table.rows {
            found.compared += 1;
            let id = case.table.number(row, "junction_id") as u32;
            let connections = town.junctions.iter().filter(|own| own.id == id).flat_map(|own| &own.connections);
            let roads: BTreeSet<RoadIndex> = connections.map(|connection| connection.connecting).collect();
            let ours: BTreeSet<String> = roads
                .iter()
                .map(|road| &town.roads[road.0 as usize])
                .flat_map(|road| {
                    let lanes = road.sections.iter().flat_map(|section| &section.lanes);
                    let driving = lanes.filter(|lane| lane.kind == LaneKind::Driving && lane.id != 0);
                    driving.map(|lane| format!("{}:{}", road.id, lane.id))
                })
                .collect();
            let list = case.table.text(row, "road:lane list").split(';').filter(|lane| !lane.is_empty());
            let theirs: BTreeSet<String> = list.map(str::to_owned).collect();
            found.check(ours == theirs, || format!("junction {id}: {ours:?} is not {theirs:?}"));
        }
    });
}

#[needs(reference = "maps/oracle/ _next.csv")]
#[test]
fn the_ways_ahead_agree_with_the_reference() {
    with_tables("next", |case, found| {
        // The rows of each waypoint.
        type Group<'a> = (Waypoint, Vec<&'a Vec<String>>);
        let mut groups: BTreeMap<String, Group> = BTreeMap::new();
        for row in case.table.rows.iter().filter(|row| case.table.text(row, "direction") == "next") {
            let from = case.waypoint(row, "");
            groups.entry(format!("{from:?}")).or_insert_with(|| (from, Vec::new())).1.push(row);
        }
        for (from, rows) in groups.values() {
            found.compared += 1;
            let mut ours = Vec::new();
            case.town.next(*from, 2.0, &mut ours);
            // Waypoints without a branch have a row whose target is empty.
            let rows: Vec<_> = rows.iter().filter(|row| !case.table.text(row, "to_x").is_empty()).collect();
            found.check(ours.len() == rows.len(), || format!("{from:?}: {} ways, not {}", ours.len(), rows.len()));
            for row in rows {
                // At the seam of two lanes the same position may be on either lane.
                let theirs = case.pose(row, "to_");
                let apart = |w: &Waypoint| (case.town.pose(*w).position() - theirs.position()).norm();
                let Some(same) = ours.iter().min_by(|a, b| apart(a).total_cmp(&apart(b))) else { continue };
                found.pose(case.town.pose(*same), theirs, || format!("{from:?} to {same:?}"));
            }
        }
    });
}

/// Whether two answers are equally good: the lanes are equally far, or two chords of one lane meet at the corner nearest to the
/// point. In the second case the end of one chord differs from the start of the other, since chords are shorter than their
/// part of the road. CARLA answers with the chord that its tree finds first.
fn is_tie(point: Point, [ours, theirs]: [Pose; 2], same_lane: bool) -> bool {
    let apart = (ours.position() - theirs.position()).norm();
    let distance = |pose: Pose| (pose.position() - point).norm();
    let abeam = |pose: Pose| pose.to_local(point).normalize().x.abs() < 0.1;
    let equally_far = (distance(ours) - distance(theirs)).abs() <= TOLERANCE;
    apart > TOLERANCE && (equally_far || same_lane && apart < 0.5 && (abeam(ours) || abeam(theirs)))
}

/// Whether CARLA answers with the start of a chord, and we with the end of the chord before it, which is the same corner. In a tight
/// bend the end of a chord lies decimetres before that corner along the lane. Chords end at whole metres from the lane's start.
fn is_later_chord(town: &Town, point: Point, ours: Waypoint, theirs: Waypoint) -> bool {
    let section = &town.roads[ours.road.0 as usize].sections[ours.section as usize];
    let along = |place: Waypoint| if place.lane < 0 { place.s - section.start } else { section.end - place.s };
    let distance = |place: Waypoint| (town.pose(place).position() - point).norm();
    let back = along(theirs) - along(ours);
    let whole = (along(theirs) - along(theirs).round()).abs() <= TOLERANCE;
    whole && back > 0.0 && back < 1.0 && distance(theirs) < distance(ours)
}

#[needs(reference = "maps/oracle/ _queries.csv")]
#[test]
fn nearest_lanes_agree_with_the_reference() {
    with_tables("queries", |case, found| {
        let town = &case.town;
        // CARLA looks in space, and we look from above.
        if town.roads.iter().any(|road| !road.plan_view.elevation().cubics().is_empty()) {
            return;
        }
        for row in &case.table.rows {
            let point = case.point(row, "");
            for (filter, prefix) in [(LaneFilter::Driving, "driving_"), (LaneFilter::Any, "any_")] {
                found.compared += 1;
                if case.table.text(row, &format!("{prefix}road_id")).is_empty() {
                    let at = town.nearest_lane(point, filter);
                    found.check(at.is_none(), || format!("{point} {filter:?}: {at:?}, not nothing"));
                    continue;
                }
                let wanted = case.waypoint(row, prefix);
                let Some(at) = town.nearest_lane(point, filter) else {
                    found.check(false, || format!("{point} {filter:?}: nothing, not {wanted:?}"));
                    continue;
                };
                let (ours, theirs) = (town.pose(at), case.pose(row, prefix));
                let lane = |place: Waypoint| (place.road, place.section, place.lane);
                let same_lane = lane(at) == lane(wanted);
                let at_corner = same_lane && is_later_chord(town, point, at, wanted);
                if at_corner || is_tie(point, [ours, theirs], same_lane) {
                    found.ties += 1;
                } else {
                    found.pose(ours, theirs, || format!("{point} {filter:?}: {at:?}, not {wanted:?}"));
                }
            }
        }
        let (compared, ties) = (found.compared, found.ties);
        found.check(200 * ties <= compared, || format!("{ties} ties are too many"));
    });
}

impl Case {
    /// Our driving lanes to which a sign or signal applies, by its range of lanes.
    fn lanes_of_landmark(&self, row: &[String]) -> Vec<Waypoint> {
        let at = |lane| Waypoint { lane, section: 0, ..self.landmark(row) };
        let Some(road) = self.town.roads.get(at(0).road.0 as usize) else { return Vec::new() };
        let ranges: Vec<(LaneId, LaneId)> = self
            .table
            .text(row, "lanes_from:to")
            .split([';', ' '])
            .filter_map(|range| range.split_once(':'))
            .filter_map(|(from, to)| Some((from.parse().ok()?, to.parse().ok()?)))
            .collect();
        let section = road.section_at(at(0).s);
        let lanes = road.sections[section].lanes.iter().filter(|lane| lane.kind == LaneKind::Driving && lane.id != 0);
        let held = lanes.filter(|lane| ranges.iter().any(|(a, b)| (*a.min(b)..=*a.max(b)).contains(&lane.id)));
        held.map(|lane| Waypoint { section: section as u32, ..at(lane.id) }).collect()
    }

    fn landmark(&self, row: &[String]) -> Waypoint {
        let number = |name: &str| self.table.number(row, name);
        let road = self.roads.get(&(number("road_id") as u32)).copied().unwrap_or(RoadIndex(u32::MAX));
        Waypoint { road, section: 0, lane: 0, s: number("s") }
    }

    /// The lanes before the junction that lead to a lane; outside junctions, the lane itself.
    fn approaches(&self, lane: Waypoint) -> Vec<(RoadIndex, u32, LaneId)> {
        let key = |w: &Waypoint| (w.road, w.section, w.lane);
        let (mut open, mut seen, mut outside) = (vec![lane], BTreeSet::new(), Vec::new());
        while let Some(lane) = open.pop() {
            if !seen.insert(key(&lane)) {
            } else if self.town.is_junction(lane) {
                open.extend(self.town.predecessors(lane));
            } else {
                outside.push(key(&lane));
            }
        }
        outside
    }
}

/// Whether the signals of a map are read as CARLA reads them: those of its own maps. Those of other tools mean what the standard says.
fn has_carla_signals(case: &Case) -> bool {
    case.town.map.as_deref().is_some_and(|map| map.contains("vendor=\"VectorZero\""))
}

#[needs(reference = "maps/oracle/ _landmarks.csv")]
#[test]
fn speed_signs_agree_with_the_reference() {
    with_tables("landmarks", |case, found| {
        if !has_carla_signals(case) {
            return;
        }
        let mut wanted: BTreeMap<i64, i64> = BTreeMap::new();
        for row in case.table.rows.iter().filter(|row| case.table.text(row, "type") == "274") {
            found.compared += 1;
            let limit =
                ["sub_type", "value"].iter().find_map(|column| case.table.optional(row, column).filter(|n| *n > 0.0));
            let Some(limit) = limit else { continue };
            let lanes = case.lanes_of_landmark(row).len();
            *wanted.entry(limit.round() as i64).or_default() += lanes as i64;
            // The sign is beside the road, abeam of a box on each lane to which it applies.
            let sign = case.point(row, "");
            let near = case.town.speed_signs.iter().filter(|ours| (ours.limit - limit / 3.6).abs() < 1e-9);
            let distance = near.map(|ours| ours.trigger.distance_to(sign)).fold(f64::INFINITY, f64::min);
            found.check(lanes == 0 || distance < 20.0, || {
                format!("no box within 20 m of the sign at {sign}, but at {distance}")
            });
        }
        for sign in &case.town.speed_signs {
            *wanted.entry((sign.limit * 3.6).round() as i64).or_default() -= 1;
        }
        wanted.retain(|_, count| *count != 0);
        found.check(wanted.is_empty(), || format!("missing boxes by limit: {wanted:?}"));
    });
}

#[needs(reference = "maps/oracle/ _landmarks.csv")]
#[test]
fn traffic_lights_agree_with_the_reference() {
    with_tables("landmarks", |case, found| {
        if !has_carla_signals(case) {
            return;
        }
        let town = &case.town;
        let mut wanted = BTreeSet::new();
        // Types for vehicles; CARLA has all of them as traffic lights.
        let is_light =
            |row: &[String]| ["1000001", "1000009", "1000010", "1000011"].contains(&case.table.text(row, "type"));
        for row in case.table.rows.iter().filter(|row| is_light(row)) {
            found.compared += 1;
            if case.table.optional(row, "is_dynamic") == Some(0.0) {
                continue;
            }
            let lanes = case.lanes_of_landmark(row);
            wanted.extend(
                lanes
                    .into_iter()
                    .flat_map(|lane| case.approaches(lane))
                    .map(|(road, section, lane)| (case.table.text(row, "id"), road, section, lane)),
            );
        }
        let count = |road| wanted.iter().filter(|light| light.1 == road).count();
        for road in (0..town.roads.len() as u32).map(RoadIndex) {
            let (ours, theirs) = (town.traffic_lights.iter().filter(|light| light.road == road).count(), count(road));
            let id = town.roads[road.0 as usize].id;
            found.check(ours == theirs, || format!("road {id}: {ours} lights on its lanes, not {theirs}"));
        }
        for light in &town.traffic_lights {
            found.check(light.turn < light.turns && !light.trigger.half.x.is_nan(), || format!("{light:?}"));
        }
    });
}

//! The lanes of a town in one flat table, with their centres as cubics and their links resolved.

use std::ops::Range;

use super::hash_order::hash_order;
use super::{Junction, Lane, LaneId, LaneKind, Profile, Road, RoadIndex, RoadLink, Waypoint};
use crate::geometry::{Point, Pose};

/// The index of a lane in the table.
pub(super) type LaneSlot = u32;

/// A lane of one section, ready for look-ups.
#[derive(Debug)]
pub(super) struct NetworkLane {
    pub road: RoadIndex,
    pub section: u32,
    pub id: LaneId,
    pub kind: LaneKind,
    /// Where its section starts and ends along the road (m).
    pub start: f64,
    pub end: f64,
    /// Whether the driving direction is that of growing `s`.
    forward: bool,
    /// Whether its road lies in a junction.
    pub in_junction: bool,
    /// Whether its centre line is one straight line.
    pub straight: bool,
    centre: Profile,
    pub width: Profile,
    next: Range<u32>,
    previous: Range<u32>,
}

impl NetworkLane {
    /// Whether the driving direction is that of growing `s`.
    pub fn forward(&self) -> bool {
        self.forward
    }

    /// Where driving along it starts and ends, along the road (m).
    pub fn driving_ends(&self) -> (f64, f64) {
        if self.forward() { (self.start, self.end) } else { (self.end, self.start) }
    }

    /// Whether this lane leads to another one of its road only since both have the same number: the file has no link.
    fn continues_unlinked(&self, roads: &[Road], next: &Self) -> bool {
        let own = roads[self.road.0 as usize].sections[self.section as usize].lane(self.id);
        let linked = own.and_then(|own| if self.forward { own.successor } else { own.predecessor });
        linked.is_none() && (self.road, self.id) == (next.road, next.id) && self.section != next.section
    }

    /// The waypoint at a distance along the road (m), clamped to the lane.
    pub fn waypoint(&self, s: f64) -> Waypoint {
        Waypoint {
            road: self.road,
            section: self.section,
            lane: self.id,
            s: s.max(self.start).min(self.end.max(self.start)),
        }
    }
}

/// All lanes of a town but those numbered 0.
#[derive(Debug)]
pub(super) struct LaneNetwork {
    lanes: Vec<NetworkLane>,
    /// The numbers of the lanes in an array of their own, for a quick search.
    ids: Vec<LaneId>,
    /// For each road the index of its first section in `sections`.
    roads: Vec<u32>,
    /// For each section the index of its first lane in `lanes`, and one more entry at the end.
    sections: Vec<u32>,
    links: Vec<LaneSlot>,
}

impl LaneNetwork {
    /// Lays out the lanes and resolves their links.
    ///
    /// # Source
    /// CARLA `road/MapBuilder.cpp`: the sign of the lane's number decides which end of the next road a car enters, not the file's
    /// contact points. A link applies to the nearest section that has a lane of that number; a right lane without a link to the next section
    /// continues under its own number, a left one ends. The lanes before a lane are those that lead to it.
    pub fn new(roads: &[Road], junctions: &[Junction]) -> Self {
        let mut network =
            Self { lanes: Vec::new(), ids: Vec::new(), roads: Vec::new(), sections: Vec::new(), links: Vec::new() };
        for (road, index) in roads.iter().zip(0..) {
            network.roads.push(network.sections.len() as u32);
            for (section, number) in road.sections.iter().zip(0..) {
                network.sections.push(network.lanes.len() as u32);
                for lane in section.lanes.iter().filter(|lane| lane.id != 0) {
                    network.lanes.push(NetworkLane {
                        road: RoadIndex(index),
                        section: number,
                        id: lane.id,
                        kind: lane.kind,
                        start: section.start,
                        end: section.end,
                        forward: road.is_forward(lane.id),
                        in_junction: road.junction.is_some(),
                        straight: is_straight(road, section.start, section.end),
                        centre: centre(road, &section.lanes, lane.id, section.start, section.end),
                        width: lane.width.clone(),
                        next: 0..0,
                        previous: 0..0,
                    });
                }
            }
        }
        network.roads.push(network.sections.len() as u32);
        network.sections.push(network.lanes.len() as u32);
        network.ids = network.lanes.iter().map(|lane| lane.id).collect();
        network.link(roads, junctions);
        network
    }

    fn link(&mut self, roads: &[Road], junctions: &[Junction]) {
        let orders: Vec<Vec<usize>> =
            junctions.iter().map(|junction| hash_order(junction.connections.iter().map(|each| each.id))).collect();
        let ways: Vec<Vec<LaneSlot>> =
            self.lanes.iter().map(|lane| self.ways_on(lane, roads, junctions, &orders)).collect();
        let mut back = vec![Vec::new(); ways.len()];
        for (from, to) in ways.iter().zip(0..).flat_map(|(ways, from)| ways.iter().map(move |to| (from, *to))) {
            // CARLA continues a lane without a link, and does not go back over it.
            if !self.lanes[from as usize].continues_unlinked(roads, &self.lanes[to as usize]) {
                back[to as usize].push(from);
            }
        }
        let mut links = Vec::new();
        let mut append = |slots: &[LaneSlot]| {
            let start = links.len() as u32;
            links.extend_from_slice(slots);
            start..links.len() as u32
        };
        for (lane, (next, previous)) in self.lanes.iter_mut().zip(ways.iter().zip(&back)) {
            lane.next = append(next);
            lane.previous = append(previous);
        }
        self.links = links;
    }

    /// The lanes that follow a lane. At a fork they are in CARLA's order, whose connections are in a hash table by their numbers;
    /// `orders` gives that order for each junction.
    fn ways_on(
        &self,
        lane: &NetworkLane,
        roads: &[Road],
        junctions: &[Junction],
        orders: &[Vec<usize>],
    ) -> Vec<LaneSlot> {
        let road = &roads[lane.road.0 as usize];
        let Some(own) = road.sections[lane.section as usize].lane(lane.id) else { return Vec::new() };
        let (linked, beyond) =
            if lane.forward() { (own.successor, road.successor) } else { (own.predecessor, road.predecessor) };
        // Sections may start at one place, one for each side of the road; those do not follow each other.
        let after = road.sections.partition_point(|section| section.start <= lane.start) as u32;
        let before = road.sections.partition_point(|section| section.start < lane.start) as u32;
        let inside = |id| {
            if lane.forward() {
                self.first_of(road, lane.road, after..road.sections.len() as u32, id)
            } else {
                self.first_of(road, lane.road, (0..before).rev(), id)
            }
        };
        let has_next = if lane.forward() { (after as usize) < road.sections.len() } else { before > 0 };
        if has_next {
            return linked.or((lane.id < 0).then_some(lane.id)).and_then(inside).into_iter().collect();
        }
        match beyond {
            Some(RoadLink::Road(next, _)) => linked.and_then(|id| self.edge(roads, next, id)).into_iter().collect(),
            Some(RoadLink::Junction(junction)) => {
                let connections = junctions.get(junction.0 as usize).map_or(&[][..], |found| &found.connections);
                let order = orders.get(junction.0 as usize).map_or(&[][..], Vec::as_slice);
                let mut ways: Vec<LaneSlot> = Vec::new();
                for connection in order.iter().filter_map(|place| connections.get(*place)) {
                    let Some(connecting) = roads.get(connection.connecting.0 as usize) else { continue };
                    if let Some(entries) = entries(connecting, lane) {
                        ways.extend(entries.into_iter().filter_map(|id| self.edge(roads, connection.connecting, id)));
                    } else if connection.incoming == lane.road {
                        for (_, to) in connection.lane_links.iter().filter(|(from, _)| *from == lane.id) {
                            let way = self.edge(roads, connection.connecting, *to);
                            ways.extend(way.filter(|slot| !ways.contains(slot)));
                        }
                    }
                }
                ways
            }
            None => Vec::new(),
        }
    }

    /// The lane at which a car enters a road: the first lane of a number from the start of the road if it is driven forward, else from its
    /// end.
    fn edge(&self, roads: &[Road], road: RoadIndex, id: LaneId) -> Option<LaneSlot> {
        let entered = roads.get(road.0 as usize)?;
        let sections = 0..entered.sections.len() as u32;
        match entered.is_forward(id) {
            true => self.first_of(entered, road, sections, id),
            false => self.first_of(entered, road, sections.rev(), id),
        }
    }

    /// The first lane of a number in some sections of a road; `None` beyond a section without lanes, where nothing leads on.
    fn first_of(
        &self,
        road: &Road,
        index: RoadIndex,
        sections: impl Iterator<Item = u32>,
        id: LaneId,
    ) -> Option<LaneSlot> {
        let mut has_lanes = sections.take_while(|section| !road.sections[*section as usize].lanes.is_empty());
        has_lanes.find_map(|section| self.slot_of(index, section, id))
    }

    pub fn lanes(&self) -> &[NetworkLane] {
        &self.lanes
    }

    pub fn lane(&self, slot: LaneSlot) -> &NetworkLane {
        &self.lanes[slot as usize]
    }

    /// Where a lane is in the table.
    pub fn slot_of(&self, road: RoadIndex, section: u32, id: LaneId) -> Option<LaneSlot> {
        let first = *self.roads.get(road.0 as usize)?;
        let last = *self.roads.get(road.0 as usize + 1)?;
        let place = first.checked_add(section).filter(|place| *place < last)? as usize;
        let range = self.sections[place]..self.sections[place + 1];
        let ids = &self.ids[range.start as usize..range.end as usize];
        ids.iter().zip(range).find(|(other, _)| **other == id).map(|(_, slot)| slot)
    }

    /// Where the lane of a waypoint is in the table.
    pub fn slot(&self, waypoint: Waypoint) -> Option<LaneSlot> {
        self.slot_of(waypoint.road, waypoint.section, waypoint.lane)
    }

    /// The lanes that follow the end of a lane, in driving direction.
    pub fn next(&self, lane: &NetworkLane) -> &[LaneSlot] {
        &self.links[lane.next.start as usize..lane.next.end as usize]
    }

    /// The lanes that lead to a lane.
    pub fn previous(&self, lane: &NetworkLane) -> &[LaneSlot] {
        &self.links[lane.previous.start as usize..lane.previous.end as usize]
    }

    /// The width of a lane (m).
    pub fn width(&self, lane: &NetworkLane, s: f64) -> f64 {
        lane.width.value(s)
    }

    /// The centre of a lane, heading along its driving direction.
    pub fn pose(&self, roads: &[Road], lane: &NetworkLane, s: f64) -> Pose {
        let line = roads[lane.road.0 as usize].plan_view.point(s);
        let (t, slope) = lane.centre.at(s).map_or((0.0, 0.0), |cubic| (cubic.value(s), cubic.slope(s)));
        let place = line.beside(t);
        Pose { x: place.x, y: place.y, yaw: line.lane_heading(lane.forward(), slope) }
    }

    /// How high a lane lies (m).
    pub fn elevation(&self, roads: &[Road], lane: &NetworkLane, s: f64) -> f64 {
        roads[lane.road.0 as usize].plan_view.elevation().value(s)
    }

    /// The centre of a lane, and its direction in CARLA's 32-bit numbers and CARLA's axes: some of its decisions depend on the last
    /// bit.
    ///
    /// # Source
    /// CARLA `road/Lane.cpp`, `ComputeTransform`, and `geom/Math.cpp`, `GetForwardVector`.
    pub fn carla_point(&self, roads: &[Road], lane: &NetworkLane, s: f64) -> (Point, [f32; 3]) {
        const DEGREES: f32 = 180.0 / std::f32::consts::PI;
        const RADIANS: f32 = std::f32::consts::PI / 180.0;
        let view = &roads[lane.road.0 as usize].plan_view;
        let line = view.point(s);
        let (t, slope) = lane.centre.at(s).map_or((0.0, 0.0), |cubic| (cubic.value(s), cubic.slope(s)));
        let mut yaw = -(line.yaw + f64::from(slope as f32)) as f32 * DEGREES;
        let mut pitch = view.elevation().slope(s) as f32 * DEGREES;
        if !lane.forward() {
            yaw += 180.0;
            pitch = 360.0 - pitch;
        }
        let ((up, flat), (sin, cos)) = (libm::sincosf(pitch * RADIANS), libm::sincosf(yaw * RADIANS));
        (line.beside(t), [cos * flat, sin * flat, up])
    }

    /// The edges of a lane: left and right of its centre along the reference line.
    pub fn edges(&self, roads: &[Road], lane: &NetworkLane, s: f64) -> [Point; 2] {
        let line = roads[lane.road.0 as usize].plan_view.point(s);
        let (t, half) = (lane.centre.value(s), lane.width.value(s) / 2.0);
        [line.beside(t + half), line.beside(t - half)]
    }
}

/// The lanes of a connecting road that a lane enters, by the links of the connecting road's lanes; `None` if those say nothing about the road
/// of the lane, as in a direct junction.
///
/// # Source
/// CARLA 0.9.16, as its client library behaves: it takes neither the incoming road of a connection nor its lane links. A way that two
/// connections name is there twice.
fn entries(connecting: &Road, lane: &NetworkLane) -> Option<Vec<LaneId>> {
    let leads = |link: Option<RoadLink>| matches!(link, Some(RoadLink::Road(road, _)) if road == lane.road);
    let first = connecting.sections.first().filter(|_| leads(connecting.predecessor));
    let last = connecting.sections.last().filter(|_| leads(connecting.successor));
    let driven = |each: &&Lane, forward| each.id != 0 && connecting.is_forward(each.id) == forward;
    let forth = first.into_iter().flat_map(|section| &section.lanes).filter(|each| driven(each, true));
    let back = last.into_iter().flat_map(|section| &section.lanes).filter(|each| driven(each, false));
    let links = forth.map(|each| (each.id, each.predecessor)).chain(back.map(|each| (each.id, each.successor)));
    let links: Vec<(LaneId, LaneId)> = links.filter_map(|(id, link)| Some((id, link?))).collect();
    if links.is_empty() {
        return None;
    }
    let mut entered: Vec<LaneId> = links.into_iter().filter(|(_, from)| *from == lane.id).map(|(id, _)| id).collect();
    entered.sort_unstable();
    Some(entered)
}

/// The lateral position of a lane's centre as one profile: the offset of lane 0, the lanes between, and half of its own width.
fn centre(road: &Road, lanes: &[Lane], id: LaneId, start: f64, end: f64) -> Profile {
    let side = f64::from(id.signum());
    let inner = |lane: &&Lane| lane.id.signum() == id.signum() && lane.id.abs() <= id.abs();
    let share = |lane: &Lane| if lane.id == id { 0.5 * side } else { side };
    let terms: Vec<(&Profile, f64)> = std::iter::once((&road.lane_offset, 1.0))
        .chain(lanes.iter().filter(inner).map(|lane| (&lane.width, share(lane))))
        .collect();
    Profile::sum(&terms, start, end)
}

/// Whether CARLA treats the lanes of a section as straight: one straight piece under it, and no vertical curve anywhere on
/// the road.
///
/// # Source
/// CARLA `road/Lane.cpp`, `IsStraight`. It ignores changing widths, and also offsets, which it looks up in the wrong place.
fn is_straight(road: &Road, start: f64, end: f64) -> bool {
    let on_line = road.plan_view.piece_at(start).is_some_and(|piece| {
        matches!(piece.shape, super::Shape::Line) && start >= piece.s && end <= piece.s + piece.length
    });
    on_line && road.plan_view.elevation().cubics().iter().all(|cubic| cubic.c == 0.0 && cubic.d == 0.0)
}

use std::collections::{BTreeMap, BTreeSet};

use roxmltree::Node;

use super::OpenDriveProblem;
use super::attributes::{Context, children};
use super::roads::{Roads, contact, id_of, number_of, numbers};
use crate::{Connection, Junction, JunctionIndex, LaneId, Road, RoadEnd};

pub(super) struct Junctions<'a> {
    pub junctions: Vec<Junction>,
    pub by_id: BTreeMap<&'a str, JunctionIndex>,
    /// For each junction the `id`s of its controllers, in turn.
    pub controllers: Vec<Vec<&'a str>>,
}

/// Reads the junctions, and creates those that only roads mention.
pub(super) fn read<'a, 'x: 'a>(context: &mut Context, root: Node<'a, 'x>, roads: &Roads<'a, 'x>) -> Junctions<'a> {
    let mut found = Junctions { junctions: Vec::new(), by_id: BTreeMap::new(), controllers: Vec::new() };
    let own = children(root, "junction").map(id_of);
    let numbers = numbers(own.chain(roads.nodes.iter().filter_map(|road| junction_of(*road))));
    for node in children(root, "junction") {
        let id = id_of(node);
        if found.by_id.contains_key(id) {
            context.warn(node, OpenDriveProblem::Duplicate { element: "junction", id: id.to_owned() });
            continue;
        }
        let mut connections: Vec<Connection> =
            children(node, "connection").filter_map(|node| connection(context, node, roads)).collect();
        number_anew(&mut connections);
        let mut controllers: Vec<(f64, &str)> = children(node, "controller")
            .filter_map(|node| Some((context.number_or_zero(node, "sequence"), node.attribute("id")?)))
            .collect();
        controllers.sort_by(|a, b| a.0.total_cmp(&b.0));
        let number = number_of(context, node, id, &numbers);
        found.add(id, number, node.attribute("name").unwrap_or_default(), connections);
        found.controllers.push(controllers.into_iter().map(|(_, id)| id).collect());
    }
    for node in &roads.nodes {
        let Some(id) = junction_of(*node) else { continue };
        if !found.by_id.contains_key(id) {
            context.warn(*node, OpenDriveProblem::UnknownReference { element: "road".to_owned(), id: id.to_owned() });
            let number = number_of(context, *node, id, &numbers);
            found.add(id, number, "", Vec::new());
            found.controllers.push(Vec::new());
        }
    }
    found
}

/// The `id` of the junction in which a road lies.
fn junction_of<'a>(road: Node<'a, '_>) -> Option<&'a str> {
    road.attribute("junction").filter(|id| !matches!(id.trim(), "-1" | ""))
}

impl<'a> Junctions<'a> {
    fn add(&mut self, id: &'a str, number: u32, name: &str, connections: Vec<Connection>) {
        self.by_id.insert(id, JunctionIndex(self.junctions.len() as u32));
        self.junctions.push(Junction { id: number, name: name.to_owned(), connections });
    }
}

fn connection(context: &mut Context, node: Node, roads: &Roads) -> Option<Connection> {
    let mut road = |names: [&'static str; 2]| {
        let id = names.iter().find_map(|name| node.attribute(*name)).unwrap_or_default();
        let found = roads.by_id.get(id).copied();
        if found.is_none() {
            context
                .warn(node, OpenDriveProblem::UnknownReference { element: "connection".to_owned(), id: id.to_owned() });
        }
        found
    };
    let (incoming, connecting) = (road(["incomingRoad", "incomingRoad"])?, road(["connectingRoad", "linkedRoad"])?);
    let contact = contact(node).unwrap_or(RoadEnd::Start);
    let mut lane_links: Vec<(LaneId, LaneId)> = children(node, "laneLink")
        .filter_map(|link| Some((context.whole(link, "from")?, context.whole(link, "to")?)))
        .collect();
    if lane_links.is_empty() {
        context.warn(node, OpenDriveProblem::GuessedLaneLinks);
        lane_links = links_of_lanes(&roads.roads[connecting.0 as usize], contact);
    }
    let id = node.attribute("id").and_then(|id| id.trim().parse().ok()).unwrap_or(0);
    Some(Connection { id, incoming, connecting, contact, lane_links })
}

/// Numbers connections by their places, if the file gives two of them the same number or none.
fn number_anew(connections: &mut [Connection]) {
    let distinct: BTreeSet<u32> = connections.iter().map(|connection| connection.id).collect();
    if distinct.len() < connections.len() {
        connections.iter_mut().zip(0..).for_each(|(connection, place)| connection.id = place);
    }
}

/// The links that the lanes of a connecting road have at one of its ends; a lane without one keeps its number.
fn links_of_lanes(road: &Road, contact: RoadEnd) -> Vec<(LaneId, LaneId)> {
    let section = match contact {
        RoadEnd::Start => road.sections.first(),
        RoadEnd::End => road.sections.last(),
    };
    let lanes = section.into_iter().flat_map(|section| &section.lanes).filter(|lane| lane.id != 0);
    let linked = lanes.map(|lane| match contact {
        RoadEnd::Start => (lane.predecessor.unwrap_or(lane.id), lane.id),
        RoadEnd::End => (lane.successor.unwrap_or(lane.id), lane.id),
    });
    linked.collect()
}

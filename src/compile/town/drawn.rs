use std::collections::BTreeMap;

use super::objects::SpeedSignKeys;
use super::site::{Drawn, Site};
use base::diagnostic::{Diagnostic, Span};
use base::signature::{Keys, short};
use base::{choice, keys};
use lang::diagnostics;
use lang::hir::{Block, Declaration};
use road::design::{BuildingRow, Carriageway, DesignError, FastBend, Node, Street, StreetProfile, TownDesign};
use road::geometry::Point;

/// Lateral accelerations that a bend, and a turn in a junction, may ask for at the speed limit before a check warns (m/s²): what passengers still
/// accept, and what asks too much of a driver that slows down a little for a turn.
const MAX_LATERAL: [f64; 2] = [4.0, 8.0];
/// Points of streets closer than this are one node (m).
const SAME_NODE: f64 = 0.01;

choice! {
    /// Which approaches of a junction have green at once.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum LightTurns {
        EachLeg = "each_leg",
        OppositeLegs = "opposite_legs",
    }
}

// The bounds are those of `road::design`.
keys! {
    /// Roads with lanes and sidewalks, junctions, and what stands beside them: written here, or read from a map.
    pub struct TownKeys = "town" {
        /// Width of a driving lane.
        lane_width: f64 as within(LENGTH, 2.0, 20.0) = "3.5 m",
        /// Width of the strip between lane and sidewalk.
        shoulder: f64 as within(LENGTH, 0.0, 20.0) = "0.3 m",
        /// Width of the sidewalks.
        sidewalk: f64 as within(LENGTH, 0.5, 20.0) = "3 m",
        /// Radius of the middle of a street where it bends: 0.5 m more than half the width of the street at least.
        bend_radius: f64 as within(LENGTH, 3.0, 1000.0) = "20 m",
        /// Radius of the sidewalk's outer edge at the corner of a junction.
        corner_radius: f64 as within(LENGTH, 0.5, 100.0) = "5 m",
        /// Whether all junctions have traffic lights.
        traffic_lights: bool = "false",
        /// Which approaches of a junction have green at once: one, or those opposite to each other. The `episode` has the
        /// durations.
        light_turns: LightTurns = "each_leg",
    }
    .holding(vec![StreetKeys::signature(), BuildingRow::signature().once()])
}

keys! {
    /// A street with sidewalks along straight lines. Traffic keeps to the right. Where streets share a point they meet: two
    /// bend, three make a T-junction, four a crossing. Streets with different lanes meet only in junctions. There cars turn
    /// right from the rightmost lane and left from the leftmost one.
    pub struct StreetKeys = "street" {
        /// The points it leads through, at least two, within 10 km of the origin.
        through: Vec<[f64; 2]>,
        /// Speed limit on the signs at its ends. Without it drivers keep the limit of the last sign, or 30 km/h before the
        /// first one.
        speed_limit: Option<f64> as positive(SPEED),
        /// Number of driving lanes in each direction in which it is driven. Drivers keep the lane in which they start.
        lanes: u32 as whole(1, 4) = "1",
        /// Whether all its lanes lead in the direction of its points. The points stay the middle of the street.
        one_way: bool = "false",
    }
}

/// The streets and houses that the block describes.
pub(super) fn build(declaration: &Declaration, site: &mut Site<'_>) -> Option<Drawn> {
    let design = design(declaration);
    let widths = design.streets.iter().map(|street| street.carriageway.street_half_width(&design.profile));
    let half_width = widths.fold(0.0, f64::max);
    match design.build() {
        Ok(parts) => {
            let streets: Vec<_> = declaration.block.nested(StreetKeys::KIND).collect();
            // Where signs stand, the limit of a street without one of its own depends on the way there.
            let has_signs = declaration.block.nested(SpeedSignKeys::KIND).next().is_some();
            let known = |bend: &FastBend| !has_signs || design.streets[bend.street].speed_limit.is_some();
            let fast = design.fast_bends(MAX_LATERAL).into_iter().filter(known).map(|bend| {
                let (place, at) = (streets[bend.street].place("speed_limit"), bend.in_junction);
                let asked = [bend.lateral, MAX_LATERAL[usize::from(at)]];
                diagnostics::fast_bend(place, at, bend.limit, bend.radius, asked)
            });
            site.said.extend(fast);
            Some(Drawn { parts, half_width })
        }
        Err(faults) => {
            let known = named_places(&declaration.block);
            site.said.extend(faults.iter().map(|fault| unbuildable(fault, &declaration.block, &known)));
            None
        }
    }
}

fn design(declaration: &Declaration) -> TownDesign {
    let block = &declaration.block;
    let keys: TownKeys = block.keys();
    let mut nodes: Vec<Node> = Vec::new();
    let mut node_at = |place: Point| {
        let known = nodes.iter().position(|node| (node.position - place).norm() < SAME_NODE);
        known.unwrap_or_else(|| {
            nodes.push(Node { name: node_name(place.x, place.y), position: place, lights: false });
            nodes.len() - 1
        })
    };
    let mut streets = Vec::new();
    for ((street, StreetKeys { through, speed_limit, lanes, one_way }), number) in block.inside().zip(1..) {
        streets.push(Street {
            name: street_name(street, number),
            nodes: through.into_iter().map(|point| node_at(point.into())).collect(),
            speed_limit,
            carriageway: Carriageway { forward: lanes, backward: if one_way { 0 } else { lanes } },
        });
    }
    if keys.traffic_lights {
        for (index, node) in nodes.iter_mut().enumerate() {
            node.lights = legs(&streets, index) > 2;
        }
    }
    TownDesign {
        name: declaration.name.clone(),
        nodes,
        streets,
        profile: StreetProfile { lane_width: keys.lane_width, shoulder: keys.shoulder, sidewalk: keys.sidewalk },
        bend_radius: keys.bend_radius,
        corner_radius: keys.corner_radius,
        block_buildings: block.inside().next().map(|(_, row)| row),
        opposite_lights: keys.light_turns == LightTurns::OppositeLegs,
        ..TownDesign::default()
    }
}

/// The number of pieces of street that meet at a node.
fn legs(streets: &[Street], node: usize) -> usize {
    let pieces = streets.iter().flat_map(|street| street.nodes.windows(2));
    pieces.map(|ends| ends.iter().filter(|end| **end == node).count()).sum()
}

/// Reports a fault of a design at its street, its corner or its measure.
fn unbuildable(fault: &DesignError, block: &Block, known: &BTreeMap<String, Span>) -> Diagnostic {
    if let DesignError::Measure { what, .. } = fault {
        // `setback of buildings` is the key `setback` of `row_houses`, `lane width` that of the town.
        let row = block.nested(BuildingRow::KIND).next();
        let (owner, key) = match (what.split_once(' '), row) {
            (Some((key, "of buildings" | "between buildings")), Some(row)) => (row, key.to_string()),
            _ => (block, what.replace(' ', "_")),
        };
        return diagnostics::unbuildable_town(owner.place(&key), &fault.to_string());
    }
    let mut places: Vec<Span> = Vec::new();
    for place in fault.names().into_iter().filter_map(|name| known.get(name).copied()) {
        if !places.contains(&place) {
            places.push(place);
        }
    }
    let mut diagnostic =
        diagnostics::unbuildable_town(places.first().copied().unwrap_or(block.head), &fault.to_string());
    let others = if places.len() > 2 { "this is one of them" } else { "the other is here" };
    for place in places.into_iter().skip(1) {
        diagnostic = diagnostic.label(place, others);
    }
    match fault {
        DesignError::Crossing { first, second, x, y } if first != second => {
            let round = |number: &f64| (number * 100.0).round() / 100.0;
            let point = node_name(round(x), round(y));
            diagnostic.help(format!("they meet where both go `through` the same point: give both `{point}`"))
        }
        _ => diagnostic,
    }
}

/// The places of streets and of their points, by their names in messages; that of a street comes first.
fn named_places(block: &Block) -> BTreeMap<String, Span> {
    let mut known = BTreeMap::new();
    for (street, number) in block.nested(StreetKeys::KIND).zip(1..) {
        known.entry(street_name(street, number)).or_insert(street.head);
    }
    for (street, StreetKeys { through, .. }) in block.inside() {
        for ([x, y], span) in through.into_iter().zip(street.members("through").iter().copied()) {
            known.entry(node_name(x, y)).or_insert(span);
        }
    }
    known
}

/// The name of a street in messages.
fn street_name(street: &Block, number: usize) -> String {
    street.name.clone().unwrap_or_else(|| format!("number {number}"))
}

/// The name of a node in messages.
fn node_name(x: f64, y: f64) -> String {
    format!("({} m, {} m)", short(x), short(y))
}

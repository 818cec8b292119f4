//! Towns of straight streets.

use road::Town;
use road::design::{Carriageway, Node, Street, TownDesign};
use road::geometry::Point;

/// A town of these nodes (m), with streets through these of them.
pub fn town(nodes: &[(f64, f64)], streets: &[&[usize]]) -> Town {
    let node = |&(x, y): &(f64, f64)| Node { name: String::new(), position: Point::new(x, y), lights: false };
    let street = |nodes: &&[usize]| Street {
        name: String::new(),
        nodes: nodes.to_vec(),
        speed_limit: None,
        carriageway: Carriageway::default(),
    };
    let (nodes, streets) = (nodes.iter().map(node).collect(), streets.iter().map(street).collect());
    Town::new(TownDesign { nodes, streets, ..TownDesign::default() }.build().unwrap())
}

use super::*;
use crate::road::design::{Node, Street, TownDesign};
use crate::road::RoadOption;

/// A block of four streets around a fifth, with junctions of three.
fn block() -> Town {
    let node = |x, y| Node { name: String::new(), position: Point::new(x, y), lights: false };
    let street = |nodes: Vec<usize>| Street { name: String::new(), nodes, speed_limit: None };
    let nodes = [(0.0, 0.0), (100.0, 0.0), (200.0, 0.0), (200.0, 80.0), (100.0, 80.0), (0.0, 80.0)];
    let design = TownDesign {
        nodes: nodes.into_iter().map(|(x, y)| node(x, y)).collect(),
        streets: vec![street(vec![0, 1, 2, 3, 4, 5, 0]), street(vec![1, 4])],
        ..TownDesign::default()
    };
    Town::new(design.build().unwrap())
}

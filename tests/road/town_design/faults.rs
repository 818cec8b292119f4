//! Designs that cannot be built.

use super::{faults, name, node, street, t_junction};
use road::design::{BuildingRow, DesignError, TownDesign};
use road::geometry::{OrientedBox, Pose};

#[test]
fn streets_without_two_nodes_or_with_odd_ones_are_faults() {
    let lone = faults(|town| town.streets.push(street("lone", &[2])));
    assert_eq!(lone, [DesignError::ShortStreet { street: name("lone"), nodes: 1 }]);
    let unknown = faults(|town| town.streets[0].nodes.push(9));
    assert_eq!(unknown, [DesignError::UnknownNode { street: name("High Street"), node: 9 }]);
    let repeated = faults(|town| town.streets[0].nodes.push(2));
    assert_eq!(repeated, [DesignError::RepeatedNode { street: name("High Street"), node: name("east") }]);
}

#[test]
fn nodes_on_one_place_and_unused_nodes_are_faults() {
    let same = faults(|town| {
        town.nodes.push(node("again", 80.0, 0.001));
        town.streets[0].nodes.push(4);
    });
    assert_eq!(same, [DesignError::SamePlace { first: name("east"), second: name("again") }]);
    let unused = faults(|town| town.nodes.push(node("lonely", 500.0, 0.0)));
    assert_eq!(unused, [DesignError::UnusedNode { node: name("lonely") }]);
}

#[test]
fn streets_that_cross_or_overlap_are_faults() {
    let cross = faults(|town| {
        town.nodes.extend([node("a", 40.0, -50.0), node("b", 40.0, 50.0)]);
        town.streets.push(street("cross", &[4, 5]));
    });
    let (first, second) = (name("High Street"), name("cross"));
    assert_eq!(cross, [DesignError::Crossing { first: first.clone(), second: second.clone(), x: 40.0, y: 0.0 }]);
    let beside = faults(|town| {
        town.nodes.extend([node("a", -70.0, -15.0), node("b", 70.0, -15.0)]);
        town.streets.push(street("beside", &[4, 5]));
    });
    assert!(
        matches!(&beside[0], DesignError::Overlap { first, second, .. } if first == "High Street" && second == "beside")
    );
    let apart = |y| {
        let mut town = t_junction();
        town.nodes.extend([node("a", -70.0, y), node("b", 70.0, y)]);
        town.streets.push(street("beside", &[4, 5]));
        town.build().is_ok()
    };
    assert!(apart(-16.61) && !apart(-16.59));
}

#[test]
fn sharp_angles_and_many_legs_are_faults() {
    let leg = |town: &mut TownDesign, degrees: f64| {
        let (sin, cos) = libm::sincos(degrees.to_radians());
        town.nodes.push(node("end", 100.0 * cos, 100.0 * sin));
        let end = town.nodes.len() - 1;
        town.streets.push(street("extra", &[1, end]));
    };
    let sharp = faults(|town| leg(town, 29.0));
    let expected = |fault: &DesignError| match fault {
        DesignError::SharpAngle { node, first, second, degrees, least } => {
            (node == "middle" && first == "High Street" && second == "extra")
                && (degrees - 29.0).abs() < 1e-9
                && *least > 29.9
        }
        _ => false,
    };
    assert!(sharp.iter().any(expected), "{sharp:?}");
    let many = faults(|town| {
        leg(town, 270.0);
        leg(town, 225.0);
    });
    assert_eq!(many, [DesignError::ManyLegs { node: name("middle"), legs: 5 }]);
    let twice = faults(|town| town.streets.push(street("double", &[0, 1])));
    assert!(twice.iter().any(|fault| matches!(fault, DesignError::SharpAngle { degrees, .. } if *degrees == 0.0)));
}

#[test]
fn a_leg_without_room_is_a_fault() {
    let short = faults(|town| town.nodes[2].position.x = 15.0);
    let [DesignError::ShortLeg { street: at, from, to, length, needed }] = &short[..] else { panic!("{short:?}") };
    assert_eq!((at.as_str(), from.as_str(), to.as_str(), *length), ("High Street", "middle", "east", 15.0));
    assert!((needed - 15.3).abs() < 1e-9);
    // Between two junctions there must be room for both.
    let between = |length: f64| {
        let mut town = t_junction();
        town.nodes[2].position.x = length;
        town.nodes.extend([node("beyond", length + 80.0, 0.0), node("south", length, -80.0)]);
        town.streets.extend([street("on", &[2, 4]), street("down", &[2, 5])]);
        town.build().is_ok()
    };
    assert!(between(2.0 * 10.3 + 5.01) && !between(2.0 * 10.3 + 4.99));
}

#[test]
fn lights_without_a_junction_are_a_fault() {
    assert_eq!(faults(|town| town.nodes[0].lights = true), [DesignError::LightsWithoutJunction { node: name("west") }]);
}

#[test]
fn a_building_on_a_lane_is_a_fault_even_in_the_middle_of_a_junction() {
    let house = |x, y| OrientedBox::new(Pose::new(x, y, 0.3), 2.0, 2.0);
    let found =
        faults(|town| town.buildings = vec![house(40.0, 20.0), house(0.0, 50.0), house(-50.0, 9.0), house(0.0, 0.0)]);
    let on = |building, road: &str| DesignError::BuildingOnLane { building, road: name(road) };
    assert_eq!(found, [on(1, "North Street"), on(2, "High Street"), on(3, "middle")]);
}

#[test]
fn bad_measures_are_faults() {
    let measures = faults(|town| {
        town.profile.lane_width = -4.0;
        town.corner_radius = f64::NAN;
        town.bend_radius = f64::INFINITY;
        town.block_buildings = Some(BuildingRow { setback: 1.0, depth: 10.0, length: 0.0, gap: 1.0 });
    });
    let what = measures.iter().filter_map(|fault| match fault {
        DesignError::Measure { what, .. } => Some(*what),
        _ => None,
    });
    assert_eq!(what.collect::<Vec<_>>(), ["lane width", "corner radius", "length of buildings", "bend radius"]);
    assert_eq!(
        faults(|town| town.nodes[3].position.y = f64::NAN),
        [DesignError::FarNode { node: name("north"), reach: 10_000.0 }]
    );
    let fast = faults(|town| town.streets[0].speed_limit = Some(0.0));
    assert_eq!(fast, [DesignError::SpeedLimit { street: name("High Street"), limit: 0.0 }]);
    let flat = faults(|town| town.buildings.push(OrientedBox::new(Pose::default(), 0.0, 3.0)));
    assert_eq!(flat, [DesignError::BuildingMeasure { building: 0 }]);
}

#[test]
fn all_faults_are_found_in_one_go() {
    let found = faults(|town| {
        town.nodes.push(node("lonely", 500.0, 0.0));
        town.nodes[2].position.x = 15.0;
        town.streets.push(street("lone", &[0]));
        town.nodes[0].lights = true;
        town.buildings.push(OrientedBox::new(Pose::new(-50.0, 0.0, 0.0), 3.0, 3.0));
    });
    assert_eq!(found.len(), 5, "{found:?}");
}

//! Roads above each other, and those that only seem to be.

use std::fmt::Write;

use proptest::prelude::*;
use road::geometry::{Point, Pose};
use road::opendrive::read;
use road::{LaneFilter, Place, Town};

/// Straight roads with the same lanes: start (m) and heading (rad), length (m), and the cubic of the height.
struct Street {
    start: Pose,
    length: f64,
    height: [f64; 4],
}

const CARS: &str = r#"<left><lane id="1" type="driving"><width a="3.5"/></lane></left><right><lane id="-1" type="driving"><width a="3.5"/></lane></right>"#;

fn town(streets: &[Street]) -> Town {
    let mut text = "<OpenDRIVE>".to_owned();
    for (number, Street { start: Pose { x, y, yaw }, length, height: [a, b, c, d] }) in streets.iter().enumerate() {
        write!(
            text,
            r#"<road id="{number}" length="{length}" junction="-1"><planView><geometry s="0" x="{x}" y="{y}" hdg="{yaw}" length="{length}"><line/></geometry></planView><elevationProfile><elevation s="0" a="{a}" b="{b}" c="{c}" d="{d}"/></elevationProfile><lanes><laneSection s="0">{CARS}</laneSection></lanes></road>"#
        )
        .unwrap();
    }
    Town::new(read(&(text + "</OpenDRIVE>"), "levels").unwrap())
}

/// A street to the east, and others.
fn above(streets: impl IntoIterator<Item = Street>) -> Town {
    let own = Street { start: Pose::new(0.0, 0.0, 0.0), length: 200.0, height: [0.0; 4] };
    town(&std::iter::once(own).chain(streets).collect::<Vec<_>>())
}

const NORTH: f64 = std::f64::consts::FRAC_PI_2;

#[test]
fn only_roads_near_each_other_at_other_heights_are_levels() {
    let bridge =
        |height| Street { start: Pose::new(100.0, -50.0, NORTH), length: 100.0, height: [height, 0.0, 0.0, 0.0] };
    assert!(!above([]).has_levels());
    assert!(!above([bridge(2.0)]).has_levels());
    assert!(above([bridge(6.0)]).has_levels());
    // A steep street is one level.
    assert!(!town(&[Street { start: Pose::default(), length: 300.0, height: [0.0, 0.12, 0.0, 0.0] }]).has_levels());
}

#[test]
fn roads_at_one_place_are_named() {
    let named = |town: &Town| {
        let each = town.crossings().into_iter();
        each.map(|found| (found.roads.map(|road| road.0), found.apart, found.is_same_way)).collect::<Vec<_>>()
    };
    let street =
        |y, yaw, height| Street { start: Pose::new(100.0, y, yaw), length: 80.0, height: [height, 0.0, 0.0, 0.0] };
    assert_eq!(named(&above([])), []);
    assert_eq!(named(&above([street(-40.0, NORTH, 0.0)])), [([0, 1], 0.0, false)]);
    assert_eq!(named(&above([street(-40.0, NORTH, 6.0)])), [([0, 1], 6.0, false)]);
    assert_eq!(named(&above([street(0.0, 0.0, 6.0)])), [([0, 1], 6.0, true)]);
    assert_eq!(named(&above([street(1.0, 0.0, 0.0)])), [([0, 1], 0.0, true)]);
    // Side by side, or end to end.
    assert_eq!(named(&above([street(7.0, 0.0, 0.0)])), []);
    assert_eq!(named(&above([Street { start: Pose::new(200.0, 0.0, 0.0), length: 50.0, height: [0.0; 4] }])), []);
}

#[test]
fn who_drives_up_a_ramp_stays_on_it() {
    // Along the street at its side, up to 8 m, and back above it.
    let ramp = Street { start: Pose::new(0.0, 3.5, 0.0), length: 200.0, height: [0.0, 0.04, 0.0, 0.0] };
    let bridge = Street { start: Pose::new(150.0, -50.0, NORTH), length: 100.0, height: [12.0, 0.0, 0.0, 0.0] };
    let town = above([ramp, bridge]);
    let along = |y: f64| (0..=190).fold(0.0, |height, x| town.ground(Point::new(f64::from(x), y), height));
    assert!((along(5.25) - 7.6).abs() < 1e-6, "{}", along(5.25));
    assert_eq!(along(-1.75), 0.0);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn nobody_meets_or_sees_who_is_more_than_three_metres_above(
        (x, turn, height) in (60.0..140.0f64, 0.6..2.5f64, 3.2..12.0f64),
        (along, ahead, aside) in (40.0..160.0f64, -30.0..30.0f64, -3.0..3.0f64),
    ) {
        let start = Pose::new(x, 0.0, turn).to_world(road::geometry::Vector::new(-60.0, 0.0));
        let bridge = Street { start: Pose::new(start.x, start.y, turn), length: 120.0, height: [height, 0.0, 0.0, 0.0] };
        let town = above([bridge]);
        let car = town.place_of_car(&Pose::new(along, -1.75, 0.0));
        prop_assert_eq!(car.ground, Some(0.0));
        let on_bridge = Pose::new(x, 0.0, turn).to_world(road::geometry::Vector::new(ahead, aside));
        prop_assert!(!town.is_on_level(car, Place::on(on_bridge, height)));
        prop_assert!(!town.is_on_level(Place::on(on_bridge, height), car));
        // Below it one walks on, and above it, too; both find their own lanes.
        let below = Place::on(on_bridge, town.ground(on_bridge, 0.0));
        prop_assert_eq!((below.ground, town.ground(on_bridge, height)), (Some(0.0), height));
        prop_assert!(town.is_on_level(car, below));
        let lane = |ground| town.nearest_lane(Place::on(on_bridge, ground), LaneFilter::Driving).unwrap().road.0;
        prop_assert_eq!((lane(0.0), lane(height)), (0, 1));
    }
}

//! Actors on roads above each other neither meet nor see each other, and ways end where roads do.

use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;

use base::seed::Seed;
use proptest::prelude::*;
use road::Town;
use road::geometry::{Obstacles, Point, Pose};
use world::av::{Path, PerfectSensors};
use world::sim::{
    ActorId, ActorStart, Control, LightCycle, PedestrianBody, Start, VehicleBlueprint, WalkCommand, World,
};

/// A street to the east over 200 m, and one along this pose, at a height of cubic coefficients.
fn town([x, y, yaw]: [f64; 3], length: f64, [a, b]: [f64; 2]) -> Town {
    let road = |id: u32, place: String, length: f64, height: String| {
        format!(
            r#"<road id="{id}" length="{length}" junction="-1"><planView><geometry s="0" {place} length="{length}"><line/></geometry></planView><elevationProfile><elevation s="0" {height} c="0" d="0"/></elevationProfile><lanes><laneSection s="0"><left><lane id="1" type="driving"><width a="3.5"/></lane></left><right><lane id="-1" type="driving"><width a="3.5"/></lane></right></laneSection></lanes></road>"#
        )
    };
    let street = road(1, r#"x="0" y="0" hdg="0""#.into(), 200.0, r#"a="0" b="0""#.into());
    let other = road(2, format!(r#"x="{x}" y="{y}" hdg="{yaw}""#), length, format!(r#"a="{a}" b="{b}""#));
    Town::new(road::opendrive::read(&format!("<OpenDRIVE>{street}{other}</OpenDRIVE>"), "t").unwrap())
}

/// What happens to a car of 10 m/s on the street from 60 m on, and to another car and a pedestrian who cross its way. Returns whether the ego saw
/// one of them, and whether one of them touched it.
fn drive(town: Town, other: Pose, walker: Pose) -> (bool, bool) {
    let (car, body) = (VehicleBlueprint::model3(), PedestrianBody::adult().nimble());
    let obstacles = Arc::new(Obstacles::new(&[]));
    let mut world = World::new(Arc::new(town), obstacles, vec![car.clone(), car], vec![body], None::<LightCycle>, 0.05);
    let vehicles = [Pose::new(60.0, -1.75, 0.0), other].map(|pose| ActorStart { pose, speed: 10.0 });
    world.begin(&Start { vehicles: &vehicles, pedestrians: &[ActorStart::standing(walker)], light_phase: 0.0 });
    let (mut sensors, mut seen, mut touched) = (PerfectSensors::default(), false, false);
    for _ in 0..120 {
        let perception = sensors.perceive(&world, 0);
        seen |= !perception.pedestrians.is_empty() || !perception.vehicles.is_empty();
        touched |= world.gap(0, 0) == 0.0;
        let command = WalkCommand { heading: walker.yaw, speed: 1.5 };
        let keeps = Control { throttle: 0.3, ..Control::default() };
        touched |= world.tick(&[keeps, keeps], &[command]).is_some_and(|contact| contact.pair.0 == ActorId::EGO);
    }
    (seen, touched)
}

#[test]
fn a_car_under_a_footbridge_hits_nobody_on_it() {
    let bridge = |height| town([100.0, -50.0, std::f64::consts::FRAC_PI_2], 100.0, [height, 0.0]);
    // Both are in the way of the ego when it comes.
    let (other, walker) = (Pose::new(101.75, -45.0, FRAC_PI_2), Pose::new(100.0, -8.0, FRAC_PI_2));
    assert_eq!(drive(bridge(0.0), other, walker), (true, true));
    assert_eq!(drive(bridge(6.0), other, walker), (false, false));
}

#[test]
fn a_car_behind_the_end_of_its_road_has_no_way_ahead() {
    let (town, car) = (town([0.0, 50.0, 0.0], 50.0, [0.0, 0.0]), VehicleBlueprint::model3());
    let mut world = World::new(Arc::new(town), Arc::new(Obstacles::new(&[])), vec![car], vec![], None, 0.05);
    let (mut sensors, mut path) = (PerfectSensors::default(), Path::default());
    for (x, is_over) in [(190.0, false), (199.0, false), (201.0, true), (260.0, true)] {
        let vehicles = [ActorStart::standing(Pose::new(x, -1.75, 0.0))];
        world.begin(&Start { vehicles: &vehicles, pedestrians: &[], light_phase: 0.0 });
        let perception = sensors.perceive(&world, 0);
        if x == 190.0 {
            path.reset(&perception, Seed::root(1).stream());
        }
        path.advance(&perception);
        assert_eq!(path.is_over(perception.ego.pose.position()), is_over, "{x}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn nobody_meets_who_is_more_than_three_metres_above(
        (at, turn, height) in (80.0..110.0f64, 0.5..2.6f64, 3.2..9.0f64),
        (slope, before, aside) in (-0.06..0.06f64, 0.0..20.0f64, -1.5..1.5f64),
    ) {
        // A bridge, or a ramp that is this high above the street.
        let point = |along: f64, aside: f64| Pose::new(at, 0.0, turn).to_world([along, aside].into());
        let begin = point(-50.0, 0.0);
        let slope = if height > 6.5 { slope } else { 0.0 };
        let town = town([begin.x, begin.y, turn], 100.0, [height - 50.0 * slope, slope]);
        let on = |Point { coords }: Point| Pose::new(coords.x, coords.y, turn);
        // Beside the street, since who starts above it is put on the street.
        let beside = (5.5 + before / 10.0) / libm::sin(turn);
        let (seen, touched) = drive(town, on(point(-before - 2.0 * beside, -1.75)), on(point(-beside, aside)));
        prop_assert!(!touched && !seen);
    }

    #[test]
    fn a_street_under_a_street_is_another_one(aside in -1.0..1.0f64, ahead in 8.0..40.0f64) {
        let world = town([0.0, 0.0, 0.0], 200.0, [5.0, 0.0]);
        let above = road::Place::on(Point::new(60.0 + ahead, aside), 5.0);
        let below = world.place_of_car(&Pose::new(60.0, -1.75, 0.0));
        prop_assert_eq!(below.ground, Some(0.0));
        prop_assert!(!world.is_on_level(below, above) && !world.is_on_level(above, below));
        prop_assert!(world.is_on_level(below, road::Place::on(above.point, 0.0)));
    }
}

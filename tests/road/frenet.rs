//! Places in the coordinates of the lane that a car is on.

use std::f64::consts::FRAC_PI_2;

use road::geometry::{Point, Pose, wrap_angle};
use road::opendrive::read;
use road::{Frenet, Place, Town, TownParts};

/// Where a town lies: mirrored at the x axis if so, then turned (rad), then moved (m).
#[derive(Clone, Copy)]
struct Put {
    mirrored: bool,
    turned: f64,
    moved: (f64, f64),
}

const AS_DRAWN: Put = Put { mirrored: false, turned: 0.0, moved: (0.0, 0.0) };
const TURNED: Put = Put { mirrored: false, turned: 2.1, moved: (-310.0, 45.0) };
const MIRRORED: Put = Put { mirrored: true, ..AS_DRAWN };

impl Put {
    fn side(self) -> f64 {
        if self.mirrored { -1.0 } else { 1.0 }
    }

    fn pose(self, x: f64, y: f64, yaw: f64) -> Pose {
        let at = Pose::new(self.moved.0, self.moved.1, self.turned).to_world([x, self.side() * y].into());
        Pose::new(at.x, at.y, self.turned + self.side() * yaw)
    }
}

/// A lane of 3.5 m to the right of a line from the origin 60 m to the east. There it forks into a left turn of 10 m and a right turn of 5 m, each with 50 m
/// behind it. Mirrored, traffic keeps to the left.
fn fork(put: Put) -> Town {
    let lane = if put.mirrored { 1 } else { -1 };
    let (side, rule) = if put.mirrored { ("left", "LHT") } else { ("right", "RHT") };
    let road = |id: u32, junction: i32, links: &str, (x, y, yaw): (f64, f64, f64), length: f64, curvature: f64| {
        let (at, shape) = (put.pose(x, y, yaw), if curvature == 0.0 { "line" } else { "arc" });
        let curvature = curvature * put.side();
        let curvature = if curvature == 0.0 { String::new() } else { format!(r#" curvature="{curvature}""#) };
        format!(
            r#"<road id="{id}" rule="{rule}" length="{length}" junction="{junction}"><link>{links}</link><planView><geometry s="0" x="{}" y="{}" hdg="{}" length="{length}"><{shape}{curvature}/></geometry></planView><lanes><laneSection s="0"><{side}><lane id="{lane}" type="driving"><link><predecessor id="{lane}"/><successor id="{lane}"/></link><width a="3.5"/></lane></{side}></laneSection></lanes></road>"#,
            at.x, at.y, at.yaw
        )
    };
    let leads = |to: u32| {
        format!(
            r#"<predecessor elementType="road" elementId="1" contactPoint="end"/><successor elementType="road" elementId="{to}" contactPoint="start"/>"#
        )
    };
    let behind = r#"<predecessor elementType="junction" elementId="9"/>"#;
    let roads = [
        road(1, -1, r#"<successor elementType="junction" elementId="9"/>"#, (0.0, 0.0, 0.0), 60.0, 0.0),
        road(2, 9, &leads(4), (60.0, 0.0, 0.0), 10.0 * FRAC_PI_2, 0.1),
        road(3, 9, &leads(5), (60.0, 0.0, 0.0), 5.0 * FRAC_PI_2, -0.2),
        road(4, -1, behind, (70.0, 10.0, FRAC_PI_2), 50.0, 0.0),
        road(5, -1, behind, (65.0, -5.0, -FRAC_PI_2), 50.0, 0.0),
    ];
    let connection = |id: u32| {
        format!(
            r#"<connection id="{id}" incomingRoad="1" connectingRoad="{id}" contactPoint="start"><laneLink from="{lane}" to="{lane}"/></connection>"#
        )
    };
    let junction = format!(r#"<junction id="9">{}{}</junction>"#, connection(2), connection(3));
    Town::new(read(&format!("<OpenDRIVE>{}{junction}</OpenDRIVE>", roads.concat()), "fork").unwrap())
}

/// The coordinates of a place for a car, both given as in the town as it is drawn; the direction without the turn of the town.
fn seen(town: &Town, put: Put, car: (f64, f64, f64), (x, y): (f64, f64)) -> [f64; 7] {
    let place = Place::on(put.pose(x, y, 0.0).position(), 0.0);
    let found = town.frenet(&put.pose(car.0, car.1, car.2), 0.0, place).unwrap();
    let Frenet { along, left, beyond_edge, inside, direction, car_left, car_turn } = found;
    [along, left, beyond_edge, inside, wrap_angle(direction - put.turned), car_left, car_turn]
}

fn near(found: [f64; 7], wanted: [f64; 7], most: f64) -> bool {
    found.iter().zip(wanted).all(|(found, wanted)| (found - wanted).abs() < most)
}

#[test]
fn places_beside_the_lane_of_a_car_have_the_coordinates_of_a_drawing() {
    let town = fork(AS_DRAWN);
    let found = |car, place| seen(&town, AS_DRAWN, car, place);
    let car = (40.0, -1.25, 0.1);
    assert!(near(found(car, (50.0, 2.0)), [10.0, 3.75, 2.0, -2.0, 0.0, 0.5, 0.1], 1e-9), "beside it");
    assert!(near(found(car, (30.0, -1.0)), [-10.0, 0.75, -1.0, 1.0, 0.0, 0.5, 0.1], 1e-9), "within it, behind the car");
    // Both turns have a right angle: the shorter one, whose centre has a radius of 3.25 m, is followed. The pieces of its arc are somewhat shorter.
    let bend = 3.25 * FRAC_PI_2;
    let wanted = [20.0 + bend + 10.0, 3.0, 1.25, -1.25, -FRAC_PI_2, 0.5, 0.1];
    assert!(near(found(car, (66.25, -15.0)), wanted, 0.02), "{:?}", found(car, (66.25, -15.0)));
    let far = [20.0 + bend + 35.0, -4.0, 2.25, -2.25, -FRAC_PI_2, 0.5, 0.1];
    assert!(near(found(car, (59.25, -40.0)), far, 0.02), "beyond 40 m the lane is extended");
    let before = [-45.0, 0.0, -1.75, -3.25, 0.0, 0.5, 0.1];
    assert!(near(found(car, (-5.0, -1.75)), before, 1e-9), "before its start it is extended, too");
    // A car that has begun to turn left is on that lane, not on the one that turns less.
    let turning = (60.0 + 11.75 * libm::sin(0.35), 10.0 - 11.75 * libm::cos(0.35), 0.35);
    let wanted = [11.75 * (FRAC_PI_2 - 0.35) + 10.0, 0.5, -1.25, 1.25, FRAC_PI_2, 0.0, 0.0];
    assert!(near(found(turning, (71.25, 20.0)), wanted, 0.04), "{:?}", found(turning, (71.25, 20.0)));
    let against = found((20.0, -1.75, 3.0), (10.0, -1.75));
    assert!(
        (against[6] - 3.0).abs() < 1e-9 && (against[0] + 10.0).abs() < 1e-9,
        "a car against the traffic: {against:?}"
    );
}

#[test]
fn a_turned_and_moved_town_has_the_same_coordinates_and_a_mirrored_one_those_with_the_signs_of_the_left_changed() {
    let (town, turned, mirrored) = (fork(AS_DRAWN), fork(TURNED), fork(MIRRORED));
    let both = Put { mirrored: true, ..TURNED };
    let turned_and_mirrored = fork(both);
    let (mut compared, mut places) = (0, Vec::new());
    for number in 0..400 {
        let share = |factor: f64| (f64::from(number) * factor).fract();
        places.push((90.0 * share(0.618_034) - 10.0, 80.0 * share(0.414_214) - 40.0));
        let car = (60.0 * share(0.732_051), -3.5 * share(0.236_068), 1.2 * (share(0.302_776) - 0.5));
        for place in &places {
            let wanted = seen(&town, AS_DRAWN, car, *place);
            assert!(near(seen(&turned, TURNED, car, *place), wanted, 1e-6), "{car:?} {place:?} {wanted:?}");
            let [along, left, beyond_edge, inside, direction, car_left, car_turn] = wanted;
            let wanted = [along, -left, beyond_edge, inside, -direction, -car_left, -car_turn];
            for (town, put) in [(&mirrored, MIRRORED), (&turned_and_mirrored, both)] {
                let found = seen(town, put, car, *place);
                assert!(near(found, wanted, 1e-6), "{car:?} {place:?} {found:?} {wanted:?}");
            }
            compared += 1;
        }
        places.drain(..places.len().saturating_sub(20));
    }
    assert!(compared > 5000, "{compared}");
}

#[test]
fn a_town_without_driving_lanes_and_a_place_that_is_nowhere_have_no_coordinates() {
    let nowhere = Place::on(Point::new(f64::NAN, 0.0), 0.0);
    assert_eq!(Town::new(TownParts::default()).frenet(&Pose::default(), 0.0, Place::on(Point::origin(), 0.0)), None);
    let town = fork(AS_DRAWN);
    assert_eq!(town.frenet(&Pose::default(), 0.0, nowhere), None);
    assert_eq!(town.frenet(&Pose::new(f64::NAN, 0.0, 0.0), 0.0, Place::on(Point::origin(), 0.0)), None);
}

//! InterFuser's behaviour that follows from its published code, in numbers.

use ported::interfuser::{
    Cell, Controller, Decision, EgoVector, Forecast, Inputs, ObjectMap, Reason, Settings, Sighting, Tracker, WAYPOINTS,
    find_detections,
};
use road::geometry::Point;

const ADULT: [f64; 2] = [0.187_68, 0.187_68];
const CAR: [f64; 2] = [2.45, 1.06];

/// A straight route in the network's form, the first point at 3.5 m.
fn straight() -> [EgoVector; WAYPOINTS] {
    std::array::from_fn(|index| EgoVector::new(0.0, -3.5 - index as f64))
}

fn inputs(speed: f64) -> Inputs {
    Inputs { speed, waypoints: straight(), p_not_junction: 0.9, p_red: 0.05, p_no_stop_sign: 0.95 }
}

/// A pedestrian at exactly this place, in its cell.
fn someone(forward: f64, right: f64, theta: f64, half: [f64; 2], speed: f64) -> Cell {
    let (row, col) = ((18.0 - forward).floor(), (right + 10.0).floor());
    Cell {
        row: row as usize,
        col: col as usize,
        existence: 1.0,
        dx: right - (col - 9.5),
        dy: forward - (17.5 - row),
        theta,
        half_length: half[0],
        half_width: half[1],
        speed,
    }
}

fn decide(speed: f64, cells: &[Cell]) -> Decision {
    let mut forecast = Forecast::new();
    forecast.draw(cells);
    Controller::new(&Settings::default()).step(&inputs(speed), &forecast)
}

/// The maximum multiple of 5 cm for which a condition is true; none is true beyond.
fn last(holds: impl Fn(f64) -> bool) -> f64 {
    (0..320).map(|step| f64::from(step) * 0.05).filter(|value| holds(*value)).fold(f64::NAN, f64::max)
}

#[test]
fn a_standing_person_is_braked_for_within_nine_metres_at_full_speed() {
    for (speed, nearest) in [(0.0, 7.10), (3.0, 7.10), (4.0, 8.15), (5.0, 9.15)] {
        let braked = last(|distance| decide(speed, &[someone(distance, 0.0, 1.0, ADULT, 0.0)]).brake);
        assert!((braked + 0.05 - nearest).abs() < 1e-9, "{speed} m/s: {}", braked + 0.05);
    }
}

#[test]
fn the_corridor_is_narrower_than_the_car() {
    for (theta, half, widest) in [(1.0, ADULT, 1.05), (0.75, ADULT, 1.30), (0.5, ADULT, 1.45), (1.5, CAR, 1.75)] {
        let blocked =
            last(|right| right < 9.0 && decide(5.0, &[someone(8.5, right, theta, half, 0.0)]).safe_distances[0] < 12.0);
        assert!((blocked - widest).abs() < 1e-9, "facing {theta}: {blocked}");
    }
}

#[test]
fn an_empty_road_is_free_up_to_the_last_point_with_a_direction() {
    let decision = decide(0.0, &[]);
    assert_eq!(decision.path_points, 73);
    assert!(decision.safe_distances.iter().all(|distance| (distance - 12.0 - 1.0 / 6.0).abs() < 1e-12));
    assert_eq!((decision.throttle, decision.brake, decision.reason), (0.75, false, Reason::None));
}

#[test]
fn a_person_on_a_cell_corner_is_none_and_one_on_a_border_is_two() {
    let count = |right, forward| {
        let mut map = ObjectMap::default();
        map.perceive(std::iter::once(Sighting { right, forward, theta: 1.0, half: ADULT, speed: 1.4 }));
        map.clamp();
        let mut found = Vec::new();
        find_detections(&map, &mut found);
        found.len()
    };
    assert_eq!((count(2.0, 8.0), count(0.03, 7.62), count(0.5, 7.5)), (0, 2, 1));
    assert_eq!((count(0.5, 18.6), count(10.6, 7.5), count(0.5, -2.6)), (0, 0, 0), "outside of the map");
}

/// The forecast speed of a pedestrian that walks at 2 m/s, after two seconds; the car stands.
fn forecast_speed(theta: f64, start: (f64, f64)) -> f64 {
    let (sin, cos) = libm::sincos(theta * std::f64::consts::PI);
    let mut tracker = Tracker::new();
    let (mut map, mut found) = (ObjectMap::default(), Vec::new());
    let mut speed = f64::NAN;
    for update in 0..20 {
        let walked = 0.2 * f64::from(update);
        let place = (start.0 + walked * cos, start.1 - walked * sin);
        map.perceive(std::iter::once(Sighting { right: place.0, forward: place.1, theta, half: ADULT, speed: 2.0 }));
        map.clamp();
        find_detections(&map, &mut found);
        tracker.update(&mut found, Point::origin(), 0.0, i64::from(update));
        // A second detection of the same person has a younger track; this test follows the best one.
        speed = found.iter().map(|cell| (cell.speed - 2.0).abs()).fold(f64::NAN, f64::max);
    }
    speed
}

#[test]
fn the_published_tracker_takes_the_heading_for_the_speed() {
    // From right to left the forecast is about 1 m/s, from left to right it is 0.
    for (theta, start, forecast) in [(1.0, (5.0, 8.5), 1.06), (0.0, (-5.0, 8.5), 0.015), (0.5, (0.6, 16.4), 0.51)] {
        let published = forecast_speed(theta, start);
        assert!((published - (2.0 - forecast)).abs() < 0.04, "{theta}: {published}");
    }
}

/// A car at 5 m/s and a pedestrian that comes from one side (+1 right, −1 left) and is 0.8 m from the middle line, on its side,
/// when the bumper would be there; the speed of the impact (m/s), `None` when they do not meet.
fn crossing(side: f64, walking: f64) -> Option<f64> {
    const DT: f64 = 0.05;
    const MEETING: f64 = 3.5;
    let theta = if side > 0.0 { 1.0 } else { 0.0 };
    let (mut driven, mut speed) = (0.0, 5.0);
    let mut tracker = Tracker::new();
    let mut controller = Controller::new(&Settings::default());
    let (mut map, mut found, mut forecast) = (ObjectMap::default(), Vec::new(), Forecast::new());
    let mut brake = false;
    for step in 0..160_u32 {
        let time = f64::from(step) * DT;
        let right = side * (0.8 + walking * (MEETING - time));
        let forward = 5.0 * MEETING + 2.45 - driven;
        if forward.abs() <= 2.45 + ADULT[0] && right.abs() <= 1.06 + ADULT[0] {
            return (speed > 0.1).then_some(speed);
        }
        if step.is_multiple_of(2) || step < 4 {
            map.perceive(std::iter::once(Sighting { right, forward, theta, half: ADULT, speed: walking }));
            map.clamp();
            find_detections(&map, &mut found);
            tracker.update(&mut found, Point::new(0.0, driven), 0.0, i64::from(step / 2));
            forecast.draw(&found);
        }
        let decision = controller.step(&inputs(speed), &forecast);
        if step.is_multiple_of(2) || step <= 4 {
            brake = decision.brake;
        }
        let before = speed;
        speed = if brake { (speed - 7.0 * DT).max(0.0) } else { speed };
        driven += 0.5 * (before + speed) * DT;
    }
    None
}

#[test]
fn a_person_from_the_left_is_hit_because_of_the_tracker() {
    for walking in [1.4, 2.0, 3.0, 3.5] {
        assert!(crossing(-1.0, walking).is_some_and(|impact| impact > 1.0));
        assert_eq!(crossing(1.0, walking), None);
    }
}

#[test]
fn a_minute_at_rest_ends_in_creeping_through_the_person_ahead() {
    let mut forecast = Forecast::new();
    forecast.draw(&[someone(4.0, 0.2, 1.0, ADULT, 0.0)]);
    let mut controller = Controller::new(&Settings::default());
    let creeping = (0..1300).filter(|_| !controller.step(&inputs(0.0), &forecast).brake).count();
    assert_eq!(creeping, 12);
}

#[test]
fn a_red_light_holds_it_for_fifty_seconds() {
    let mut controller = Controller::new(&Settings::default());
    let red = Inputs { p_red: 0.95, ..inputs(0.0) };
    let decisions: Vec<Decision> = (0..1100).map(|_| controller.step(&red, &Forecast::new())).collect();
    assert!(decisions[..1000].iter().all(|decision| decision.brake && decision.reason == Reason::RedLight));
    assert!(decisions[1000..1080].iter().all(|decision| !decision.brake));
    assert!(decisions[1080..].iter().all(|decision| decision.brake));
}

#[test]
fn a_plan_of_thousands_of_kilometres_has_a_path_of_some_points() {
    let mut waypoints = straight();
    waypoints[9] = EgoVector::new(4e9, 0.0);
    let inputs = Inputs { waypoints, ..inputs(0.0) };
    let points = Controller::new(&Settings::default()).step(&inputs, &Forecast::new()).path_points;
    assert!((10..100_000).contains(&points), "{points}");
}

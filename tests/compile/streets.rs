//! What stands and lies in designed towns, and what drivers and pedestrians make of it.

use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;

use base::seed::Seed;
use compile::{Campaign, Catalog, compile};
use episode::walker::Scripted;
use episode::{Draw, Outcome, Scenario, Trace, evaluate_observed};
use road::geometry::{OrientedBox, Point};
use verdict::{Reference, judge};
use world::sim::WalkCommand;

/// The campaign of a scenario whose imports are read from the folder of scenarios.
fn campaign(text: &str) -> Campaign {
    let root = crate::repository().join("scenarios/test_of_streets.scn");
    let read = |path: &Path| if path == root { Ok(text.to_string()) } else { std::fs::read_to_string(path) };
    let compiled = compile(std::slice::from_ref(&root), &Catalog::builtin(), &read, &mut Default::default()).unwrap();
    let plan = compiled.plan.unwrap_or_else(|| panic!("{:?}", compiled.diagnostics));
    plan.campaigns.into_iter().next().unwrap()
}

/// A campaign in a town with a street of 400 m along the x axis and these further parts.
fn in_street(parts: &str, rest: &str) -> Campaign {
    campaign(&format!(
        "edition 1\nimport \"std/paper.scn\"\nimport \"std/drivers.scn\"\n\
         town here {{ shoulder: 2.5 m  street main {{ through: [(-200 m, 0 m), (200 m, 0 m)] }}\n{parts} }}\n\
         spawn beside {{ ego_poses: [(-100 m, -1.75 m, 0 deg)] }}\n\
         campaign c {{ vehicle: model3  body: suicidal  episode: thirty_seconds  spawn: beside\n{rest} }}"
    ))
}

const STANDING: &str = "evaluate { towns: [here]  drivers: [blind]  pedestrians: [homing]  episodes: 1 }";

#[test]
fn a_row_holds_as_many_cars_as_there_is_room_for() {
    let row = "parked_row { from: (10 m, -4.75 m)  to: (10 m, -40.9 m)  gap: 1.5 m }";
    let off_lane = row.replace("(10 m, -4.75 m)", "(10 m, -6 m)");
    let town = in_street(&off_lane, STANDING).nth::<compile::Evaluation>(0).scenario.town.clone();
    // (34.9 m + 1.5 m) / 6 m: the sixth car ends 34.5 m from the start of the row.
    assert_eq!(town.obstacles.len(), 6);
    let ends = |car: &OrientedBox| {
        car.corners().iter().map(|corner| corner.y).fold((f64::MAX, f64::MIN), |(a, b), y| (a.min(y), b.max(y)))
    };
    for (number, car) in town.obstacles.iter().enumerate() {
        let (rear, front) = (-6.0 - 6.0 * number as f64, -10.5 - 6.0 * number as f64);
        let (low, high) = ends(car);
        assert!((low - front).abs() < 1e-9 && (high - rear).abs() < 1e-9, "{number}: {low} {high}");
        assert!((car.pose.yaw + std::f64::consts::FRAC_PI_2).abs() < 1e-12, "they look along the row");
        assert!((2.0 * car.half.y - 1.9).abs() < 1e-12);
    }
    let full = row.replace("-4.75", "-6").replace("-40.9", "-40.5");
    assert_eq!(
        in_street(&full, STANDING).nth::<compile::Evaluation>(0).scenario.town.obstacles.len(),
        6,
        "the last car just fits"
    );
}

#[test]
fn a_bus_is_an_obstacle_of_its_size() {
    let town =
        in_street("bus { at: (30 m, -5 m, 0 deg) }", STANDING).nth::<compile::Evaluation>(0).scenario.town.clone();
    let [bus] = town.obstacles.as_slice() else { panic!("{:?}", town.obstacles) };
    assert_eq!((bus.pose.x, bus.pose.y, bus.half.x, bus.half.y), (30.0, -5.0, 6.0, 1.275));
}

/// A campaign with the scripted pedestrian of a spawn rule in the same street.
fn walking(spawn: &str, policy: &str) -> Arc<Scenario> {
    let text = format!(
        "edition 1\nimport \"std/ncap.scn\"\nimport \"std/drivers.scn\"\nspawn path = given_path({spawn})\n\
         campaign c {{ vehicle: model3  body: adult_target  episode: protocol_test  spawn: path\n\
         evaluate {{ towns: [test_track]  drivers: [{policy}]  pedestrians: [scripted]  episodes: 4 }} }}"
    );
    campaign(&text).nth::<compile::Evaluation>(0).scenario.clone()
}

/// Outcomes and traces of the first episodes with the scripted pedestrian.
fn scripted(scenario: &Arc<Scenario>, episodes: u32) -> Vec<(Outcome, Trace)> {
    let seed = Seed::root(1);
    let mut note = |_, outcome: &Outcome, trace: &Trace| (*outcome, trace.clone());
    evaluate_observed(&mut Scripted, scenario, 0..episodes, &seed, &seed, &mut note, &mut |_| ControlFlow::Continue(()))
}

const PATH: &str = "through: [(60 m, -8 m), (60 m, -5 m), (60 m, -5 m), (66 m, 8 m)],  times: [0 s, 3 s, 5 s, 12 s]";

#[test]
fn a_scripted_pedestrian_is_on_its_path_at_every_tick() {
    let far = walking(&format!("ego_poses: [(-300 m, -1.75 m, 0 deg)],  ego_speed: 0 m/s,  {PATH}"), "blind");
    for (_, trace) in scripted(&far, 2) {
        let places: Vec<Point> = trace.pedestrian(0).iter().map(|state| state.pose.position()).collect();
        assert_eq!(places.len(), 301);
        for (tick, place) in places.iter().enumerate() {
            let time = tick as f64 * 0.05;
            let share = ((time - 5.0) / 7.0).clamp(0.0, 1.0);
            let wanted = Point::new(60.0 + 6.0 * share, -8.0 + (time.min(3.0)) + 13.0 * share);
            assert!((place - wanted).norm() < 1e-6, "{time} s: {place} instead of {wanted}");
        }
    }
}

#[test]
fn a_path_departs_after_its_delay_and_the_driver_holds_the_test_speed() {
    let spawn = format!("ego_poses: [(-100 m, -1.75 m, 0 deg)],  test_speed: 36 km/h,  {PATH},  delay: 1 s .. 4 s");
    for policy in ["blind", "idm", "rss"] {
        let mut departures = Vec::new();
        for (_, trace) in scripted(&walking(&spawn, policy), 4) {
            assert!((trace.vehicle(0)[0].state.speed - 10.0).abs() < 0.3, "{policy}: {:?}", trace.vehicle(0)[0]);
            let walking = trace.pedestrian(0).iter().position(|state| state.speed() > 0.1).expect("it departs");
            departures.push(walking);
        }
        assert!(departures.iter().all(|tick| (20..=81).contains(tick)), "{departures:?}");
        assert!(departures.windows(2).any(|pair| pair[0] != pair[1]), "the delay is drawn");
    }
}

#[test]
fn the_first_command_paces_and_turns_a_path_and_later_ones_do_not() {
    let scenario = walking(&format!("ego_poses: [(-300 m, -1.75 m, 0 deg)],  ego_speed: 0 m/s,  {PATH}"), "blind");
    let mut env = scenario.simulation();
    env.start(Draw::new(&Seed::root(3), 0));
    let stated = env.scene().scenario.spawn.scripted().expect("the rule has a path");
    assert!((stated.heading - std::f64::consts::FRAC_PI_2).abs() < 1e-12 && (stated.speed - 1.0).abs() < 1e-12);
    env.decide(&[WalkCommand { heading: 0.0, speed: 2.0 }]);
    for tick in 0..60 {
        env.tick();
        if tick == 10 {
            env.decide(&[WalkCommand { heading: 2.0, speed: 0.0 }]);
        }
    }
    // Twice the pace: after 3 s the path as it is given has been walked for 6 s, and it is turned to the right by 90 degrees.
    let given = Point::new(60.0 + 6.0 / 7.0, -5.0 + 13.0 / 7.0);
    let wanted = Point::new(60.0 + (given.y + 8.0), -8.0 - (given.x - 60.0));
    let place = env.scene().world.pedestrians[0].state.pose.position();
    assert!((place - wanted).norm() < 1e-6, "{place} instead of {wanted}");
}

/// The scenario of a test of Euro NCAP with an adversary and keys of the episode.
fn protocol(test: &str, adversary: &str, policy: &str, keys: &str) -> Arc<Scenario> {
    let town = if test.starts_with("cpnco") { "test_track_parked" } else { "test_track" };
    let text = format!(
        "edition 1\nimport \"std/ncap.scn\"\nimport \"std/drivers.scn\"\n\
         episode here {{ tick: 0.05 s  hold: 300  ticks: 300  {keys} }}\n\
         campaign c {{ vehicle: model3  body: {adversary}  episode: here  spawn: {test}\n\
         evaluate {{ towns: [{town}]  drivers: [{policy}]  pedestrians: [scripted]  episodes: 1 }} }}"
    );
    campaign(&text).nth::<compile::Evaluation>(0).scenario.clone()
}

/// The box of a target meets the front of a car that does not brake with its impact point at the stated share of the width.
#[test]
fn a_target_as_a_box_is_touched_at_its_impact_point() {
    for (test, adversary) in [("cpna", "adult_target_box"), ("cpfa", "adult_target_box"), ("cpnco", "child_target_box")]
    {
        let scenario = protocol(test, adversary, "blind", "");
        let (car, body) = (&scenario.cast.ego().blueprint, &scenario.cast.pedestrian().body);
        let walk = scenario.spawn.target_walk.as_ref().unwrap();
        let side = if test == "cpfa" { -1.0 } else { 1.0 };
        for (case, (outcome, trace)) in walk.cases.iter().zip(scripted(&scenario, walk.cases.len() as u32)) {
            let contact = trace.contact().unwrap_or_else(|| panic!("{test} {case:?}: {outcome:?}"));
            let front = contact.ahead - car.half_length - walk.target.half_width;
            assert!(front.abs() < 0.001, "{test} {case:?}: the front is {front:.4} m before the box");
            let impact_point = contact.aside * side - walk.target.impact_point;
            let apart = impact_point - (2.0 * case.overlap - 1.0) * car.half_width;
            assert!(apart.abs() < 0.05, "{test} {case:?}: {apart:.3} m beside the stated place");
            assert_eq!(body.half().y, walk.target.half_width);
            assert_eq!(outcome.least_gap, 0.0);
        }
    }
}

#[test]
fn friction_bounds_every_driver_and_the_reference_drivers() {
    for policy in ["behavior", "idm", "aeb", "rss", "predictive"] {
        let slippery = protocol("cpna", "adult_target", policy, "friction: 0.3");
        let mut hardest = 0.0_f64;
        for (_, trace) in scripted(&slippery, 18) {
            let speeds = trace.vehicle(0).windows(2).map(|pair| (pair[0].state.speed - pair[1].state.speed) / 0.05);
            hardest = speeds.fold(hardest, f64::max);
        }
        let bound = 0.3 * 9.81;
        assert!(hardest <= bound + 1e-9 && hardest > 0.99 * bound, "{policy} braked with {hardest:.2} m/s^2");
    }
    let avoided = |keys: &str| {
        let scenario = protocol("cpna", "adult_target", "blind", keys);
        let verdicts = scripted(&scenario, 18).into_iter().filter_map(|(_, trace)| judge(&trace.main_pair(&scenario)));
        verdicts.filter(|verdict| verdict.trial(Reference::Bound).is_avoided()).count()
    };
    let (dry, ice) = (avoided(""), avoided("friction: 0.05"));
    assert!(dry > ice + 5, "the best driver avoids {dry} of 18 collisions on a dry road and {ice} on ice");
}

#[test]
fn a_car_on_ice_slides_out_of_a_bend() {
    let bend = |keys: &str| {
        let text = format!(
            "edition 1\nimport \"std/drivers.scn\"\nimport \"std/ncap.scn\"\n\
             town bend {{ street s {{ through: [(-100 m, 0 m), (0 m, 0 m), (0 m, 100 m)] }} }}\n\
             episode here {{ ticks: 120  hold: 120  {keys} }}\n\
             spawn path = given_path(ego_poses: [(-40 m, -1.75 m, 0 deg)], ego_speed: 10 m/s,\n\
             through: [(-90 m, 30 m), (-90 m, 31 m)], speeds: [1 m/s])\n\
             campaign c {{ vehicle: model3  body: adult_target  episode: here  spawn: path\n\
             evaluate {{ towns: [bend]  drivers: [blind]  pedestrians: [scripted]  episodes: 1 }} }}"
        );
        let scenario = campaign(&text).nth::<compile::Evaluation>(0).scenario.clone();
        let (_, trace) = scripted(&scenario, 1).swap_remove(0);
        trace.vehicle(0).iter().map(|frame| frame.state.pose.x).fold(f64::MIN, f64::max)
    };
    let (dry, ice) = (bend(""), bend("friction: 0.05"));
    assert!(dry < 3.5 && ice > 5.0, "the outer edge of the lane is at 3.5 m: {dry:.1} m and {ice:.1} m");
}

/// A campaign with the scripted pedestrian of a path in a town.
fn in_town(town: &str, spawn: &str, episode: &str, policy: &str) -> Arc<Scenario> {
    let text = format!(
        "edition 1\nimport \"std/ncap.scn\"\nimport \"std/drivers.scn\"\n\
         driver yielding = idm(time_headway: 1.5 s, crosswalks: yield)\n\
         driver yielding_aeb = aeb(crosswalks: yield)\ndriver yielding_rss = rss_guarded(crosswalks: yield)\n\
         driver yielding_predictive = predictive(crosswalks: yield)\n\
         driver yielding_oracle = oracle_brake(crosswalks: yield)\n\
         town here {{ {town} }}\nspawn path = given_path({spawn})\n\
         episode here {{ {episode} }}\n\
         campaign c {{ vehicle: model3  body: adult_target  episode: here  spawn: path\n\
         evaluate {{ towns: [here]  drivers: [{policy}]  pedestrians: [scripted]  episodes: 1 }} }}"
    );
    campaign(&text).nth::<compile::Evaluation>(0).scenario.clone()
}

const LONG_STREET: &str =
    "street main { through: [(-250 m, 0 m), (150 m, 0 m)] }  crosswalk { at: (0 m, 0.5 m)  width: 3 m }";

#[test]
fn a_crosswalk_spans_the_carriageway() {
    let town = in_street("crosswalk { at: (10 m, 2 m) }", STANDING).nth::<compile::Evaluation>(0).scenario.town.clone();
    let [corners] = town.crosswalks.as_slice() else { panic!("{:?}", town.crosswalks) };
    let wanted = [(8.0, -6.0), (12.0, -6.0), (12.0, 6.0), (8.0, 6.0)];
    for (corner, (x, y)) in corners.iter().zip(wanted) {
        assert!((corner - Point::new(x, y)).norm() < 1e-9, "{corner}");
    }
    assert!(town.is_on_crosswalk(Point::new(9.0, -5.9)) && !town.is_on_crosswalk(Point::new(9.0, -6.1)));
}

#[test]
fn a_driver_that_heeds_crosswalks_stops_for_those_who_use_them() {
    // It waits at the kerb, and crosses at 1.4 m/s.
    let after = |delay: &str| {
        format!(
            "ego_poses: [(-60 m, -1.75 m, 0 deg)],  test_speed: 10 m/s,  delay: {delay},\n\
             through: [(0 m, -4.6 m), (0 m, 6 m)],  speeds: [1.4 m/s]"
        )
    };
    let drive = |spawn: &str, policy: &str| {
        scripted(&in_town(LONG_STREET, spawn, "hold: 300  ticks: 300", policy), 1).swap_remove(0)
    };
    let front = |trace: &Trace| {
        let crossing = trace.pedestrian(0).iter().take_while(|state| state.pose.y < 1.0).count();
        trace.vehicle(0)[crossing.min(trace.vehicle(0).len() - 1)].state.pose.x + 2.396
    };
    let slowest = |trace: &Trace| trace.vehicle(0).iter().map(|frame| frame.state.speed).fold(f64::MAX, f64::min);
    for policy in ["yielding", "yielding_aeb", "yielding_rss", "yielding_predictive", "yielding_oracle"] {
        let (outcome, trace) = drive(&after("9 s"), policy);
        assert!(!outcome.is_collision(), "{policy}: {outcome:?}");
        assert!((-8.0..-1.5).contains(&front(&trace)), "{policy} waits before the crosswalk: {}", front(&trace));
        assert!(slowest(&trace) < 0.3, "{policy} stops for a pedestrian at the kerb: {}", slowest(&trace));
        let last = trace.vehicle(0).last().unwrap().state;
        assert!(last.speed > 1.0 || last.pose.x > 5.0, "{policy} goes on afterwards: {last:?}");
    }
    for policy in ["idm", "aeb", "predictive"] {
        let (_, trace) = drive(&after("20 s"), policy);
        assert!(
            slowest(&trace) > 8.0,
            "{policy} drives past a pedestrian that stands at the kerb: {}",
            slowest(&trace)
        );
    }
    let (outcome, trace) = drive(&after("4.5 s"), "blind");
    assert!(outcome.is_collision() && outcome.on_crosswalk, "{outcome:?}");
    assert!(trace.contact().is_some());
    // A pedestrian at the kerb 18 m before the crosswalk has no claim to it.
    let (_, trace) = drive(&after("9 s").replace("(0 m, ", "(-20 m, "), "yielding");
    assert!(slowest(&trace) > 8.0, "{}", slowest(&trace));
}

const CROSSING: &str = "street east { through: [(-250 m, 0 m), (0 m, 0 m), (150 m, 0 m)] }\n\
                        street north { through: [(0 m, -150 m), (0 m, 0 m), (0 m, 150 m)] }";

#[test]
fn every_driver_takes_the_stated_turns() {
    let drivers = ["blind", "behavior", "idm", "aeb", "rss", "predictive", "oracle", "lav_ideal", "interfuser_ideal"];
    for policy in drivers {
        for (turn, start) in [("left", ""), ("straight", ""), ("right", ""), ("left", ",  ego_speed: 5 m/s")] {
            let spawn = format!(
                "ego_poses: [(-40 m, -1.75 m, 0 deg)],  ego_route: [{turn}],\n\
                 through: [(-140 m, 60 m), (-140 m, 61 m)],  speeds: [1 m/s]{start}"
            );
            let scenario = in_town(CROSSING, &spawn, "hold: 500  ticks: 500", policy);
            for (_, trace) in scripted(&scenario, 2) {
                let reached = |place: Point| match turn {
                    "left" => place.y > 15.0 && place.x.abs() < 8.0,
                    "right" => place.y < -15.0 && place.x.abs() < 8.0,
                    _ => place.x > 25.0 && place.y.abs() < 8.0,
                };
                let arrived = trace.vehicle(0).iter().any(|frame| reached(frame.state.pose.position()));
                let last = trace.vehicle(0).last().unwrap().state;
                assert!(arrived, "{policy} does not turn {turn}{start}: it ends at {last:?}");
            }
        }
    }
}

#[test]
fn every_driver_keeps_its_lane_through_a_crossing_of_wide_streets() {
    let east = |keys: &str| {
        format!(
            "street east {{ through: [(-250 m, 0 m), (0 m, 0 m), (150 m, 0 m)]  {keys} }}\n\
             street north {{ through: [(0 m, -150 m), (0 m, 0 m), (0 m, 150 m)]  one_way: true }}"
        )
    };
    let drivers = ["blind", "behavior", "idm", "aeb", "rss", "predictive", "oracle", "lav_ideal", "interfuser_ideal"];
    // Only the inner lane leads to the left, too; the one-way street cannot be entered to the right.
    let route = "ego_route: [straight],";
    let streets =
        [("lanes: 2", [(-1.75, route), (-5.25, "")]), ("lanes: 2  one_way: true", [(1.75, route), (-1.75, "")])];
    for (keys, lanes) in streets {
        for (policy, (lane, route)) in drivers.into_iter().flat_map(|policy| lanes.map(|lane| (policy, lane))) {
            let spawn = format!(
                "ego_poses: [(-40 m, {lane} m, 0 deg)],  {route}\n\
                 through: [(-140 m, 60 m), (-140 m, 61 m)],  speeds: [1 m/s]"
            );
            let scenario = in_town(&east(keys), &spawn, "hold: 400  ticks: 400", policy);
            let (_, trace) = scripted(&scenario, 1).swap_remove(0);
            let states = || trace.vehicle(0).iter().map(|frame| frame.state.pose);
            let aside = states().map(|pose| (pose.y - lane).abs()).fold(0.0, f64::max);
            assert!(aside < 0.6, "{policy} at {lane} m in a street with {keys}: {aside:.2} m beside its lane");
            assert!(states().any(|pose| pose.x > 25.0), "{policy} at {lane} m: {:?}", states().next_back());
        }
    }
}

#[test]
fn lights_keep_their_cycle_and_opposite_legs_share_a_turn() {
    use world::sim::LightColour::{self, Green, Red, Yellow};
    let town = format!("traffic_lights: true  light_turns: opposite_legs  {CROSSING}");
    let spawn = "ego_poses: [(-40 m, -1.75 m, 0 deg)],  ego_speed: 0 m/s,\n\
                 through: [(-140 m, 60 m), (-140 m, 61 m)],  speeds: [1 m/s]";
    let episode = "hold: 400  ticks: 400  light_green: 4 s  light_yellow: 2 s  light_red: 1 s  light_phase: 3.5 s";
    let scenario = in_town(&town, spawn, episode, "idm");
    let lights = &scenario.town.traffic_lights;
    assert_eq!(lights.len(), 4);
    for light in lights {
        assert_eq!(light.turns, 2);
        let opposite = lights.iter().find(|other| light.stop.forward().dot(&other.stop.forward()) < -0.9).unwrap();
        assert_eq!(light.turn, opposite.turn);
    }
    let mut env = scenario.simulation();
    env.start(Draw::new(&Seed::root(3), 0));
    env.decide(&[env.scene().scenario.spawn.scripted().unwrap()]);
    for tick in 0..400 {
        let time = 3.5 + f64::from(tick) * 0.05;
        let clock = env.scene().world.light_clock().expect("lights work");
        let wanted = |turn: u32| -> LightColour {
            match (time - 7.0 * f64::from(turn)).rem_euclid(14.0) {
                since if since < 4.0 => Green,
                since if since < 6.0 => Yellow,
                _ => Red,
            }
        };
        // At a change of colours both are right to within rounding.
        let near_change = [4.0, 6.0, 7.0, 0.0].iter().any(|change| ((time - change) % 7.0).abs() < 0.01);
        for light in lights.iter().filter(|_| !near_change) {
            assert_eq!(clock.colour(light), wanted(light.turn), "{time} s, turn {}", light.turn);
        }
        env.tick();
    }
}

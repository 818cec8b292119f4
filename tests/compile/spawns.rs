//! The starts of episodes have the distribution that the scenario declares, in every spelling of it.

use std::path::Path;
use std::sync::Arc;

use base::diagnostic::Sources;
use base::seed::Seed;
use compile::{Catalog, compile};
use episode::{FirstHeading, Scenario, Spawn};
use road::LaneFilter;
use road::geometry::wrap_angle;
use world::sim::PedestrianBody;

/// The scenario of a campaign in the outline of CARLA's Town01 with this spawn.
fn scenario(spawn: &str) -> Arc<Scenario> {
    scenario_in("town01_outline", "", spawn)
}

/// The scenario of a campaign in a town, which may be declared here, with this spawn.
fn scenario_in(town: &str, declared: &str, spawn: &str) -> Arc<Scenario> {
    let lib = crate::repository().join("scenarios/lib");
    let text = format!(
        "edition 1\nimport suicidal, thirty_seconds, ppo_paper, r1 from \"{0}/paper.scn\"\n\
         import \"{0}/drivers.scn\"\nimport \"{0}/carla_towns.scn\"\n{declared}\nspawn here {{ {spawn} }}\n\
         campaign c {{ vehicle: model3 body: suicidal spawn: here episode: thirty_seconds training: ppo_paper\n\
         train {{ towns: [{town}] drivers: [behavior] rewards: [r1] }} }}",
        lib.display()
    );
    let root = Path::new("test.scn").to_path_buf();
    let read = |path: &Path| if path == root { Ok(text.clone()) } else { std::fs::read_to_string(path) };
    let compiled =
        compile(std::slice::from_ref(&root), &Catalog::builtin(), &read, &mut Sources::default()).expect("readable");
    let plan = compiled.plan.unwrap_or_else(|| panic!("{:?}", compiled.diagnostics));
    plan.campaigns[0].nth::<compile::Training>(0).scenario.clone()
}

fn draw(scenario: &Scenario, count: u32) -> Vec<Spawn> {
    let mut stream = Seed::root(5).child("spawns").stream();
    let one = |_| scenario.spawn.sample(&scenario.town, &scenario.obstacles, FirstHeading::Random, &mut stream);
    (0..count).map(one).collect()
}

/// The largest distance of the sample's distribution function from a uniform one, times √n. It is above 1.95 in one sample of a
/// thousand (Kolmogorov).
fn kolmogorov(mut shares: Vec<f64>) -> f64 {
    shares.sort_by(f64::total_cmp);
    let n = shares.len() as f64;
    let apart = |(i, share): (usize, &f64)| (share - i as f64 / n).abs().max((share - (i as f64 + 1.0) / n).abs());
    shares.iter().enumerate().map(apart).fold(0.0, f64::max) * n.sqrt()
}

const CRITICAL: f64 = 1.95;

fn distance(spawn: &Spawn) -> f64 {
    (spawn.pedestrian.position() - spawn.ego.position()).norm()
}

fn bearing(spawn: &Spawn) -> f64 {
    let local = spawn.ego.to_local(spawn.pedestrian.position());
    libm::atan2(local.y, local.x)
}

const DIRECT: &str = "clearance: 0 m  bearing: -60 deg .. 60 deg  distance: 7 m .. 30 m";
const CONSTRAINTS: &str = "clearance: 0 m  bearing: -180 deg .. 180 deg  distance: 4 m .. 100 m
    require: [distance >= 7 m and distance <= 30 m, bearing > -60 deg, 60 deg > bearing]";

#[test]
fn both_spellings_of_the_papers_spawn_are_one_rule() {
    let (mut direct, constraints) = (scenario(DIRECT).spawn.clone(), scenario(CONSTRAINTS).spawn.clone());
    assert_ne!(direct, scenario("distance: 7 m .. 29 m").spawn, "the comparison sees differences");
    direct.name.clone_from(&constraints.name);
    assert_eq!(direct, constraints);
}

#[test]
fn bearing_and_distance_are_uniform_under_the_measure_of_range() {
    for spelling in [DIRECT, CONSTRAINTS] {
        let spawns = draw(&scenario(spelling), 20_000);
        let distances = spawns.iter().map(|spawn| (distance(spawn) - 7.0) / 23.0).collect();
        let third = std::f64::consts::FRAC_PI_3;
        let bearings = spawns.iter().map(|spawn| (bearing(spawn) + third) / (2.0 * third)).collect();
        assert!(kolmogorov(distances) < CRITICAL);
        assert!(kolmogorov(bearings) < CRITICAL);
    }
}

#[test]
fn the_ground_is_uniform_under_the_measure_of_area() {
    let spawns = draw(&scenario(&format!("{DIRECT}  measure: area")), 20_000);
    let square = |spawn: &Spawn| (distance(spawn).powi(2) - 49.0) / (900.0 - 49.0);
    assert!(kolmogorov(spawns.iter().map(square).collect()) < CRITICAL);
    let linear = spawns.iter().map(|spawn| (distance(spawn) - 7.0) / 23.0).collect();
    assert!(kolmogorov(linear) > 10.0, "the test tells the measures apart");
}

#[test]
fn the_ego_is_uniform_in_length_over_the_lanes() {
    let scenario = scenario(DIRECT);
    let spawns = draw(&scenario, 20_000);
    let (town, lanes) = (&scenario.town, scenario.town.driving_lanes());
    let total: f64 = lanes.iter().map(|lane| lane.length).sum();
    // The position of each ego along all lanes laid end to end.
    let share = |spawn: &Spawn| {
        let at = town.nearest_lane(spawn.ego.position(), LaneFilter::Driving).expect("an ego stands on a lane");
        let mut before = 0.0;
        for lane in lanes {
            let start = lane.start;
            if (start.road, start.section, start.lane) == (at.road, at.section, at.lane) {
                return (before + (at.s - start.s).abs()) / total;
            }
            before += lane.length;
        }
        panic!("the ego stands inside a junction");
    };
    assert!(kolmogorov(spawns.iter().map(share).collect()) < CRITICAL);
}

#[test]
fn a_piece_of_a_lane_is_used_evenly_and_a_distribution_is_followed() {
    let lane = scenario(DIRECT).town.driving_lanes().iter().copied().max_by(|a, b| a.length.total_cmp(&b.length));
    let lane = lane.expect("the town has lanes");
    let from = scenario(DIRECT).town.pose(lane.start);
    let scenario = scenario(&format!(
        "{DIRECT}  ego_lane {{ from: ({} m, {} m, {} rad) length: 40 m }}  ego_speed: choice(0 m/s, 4 m/s .. 8 m/s)
         heading: truncated(normal(90 deg, 30 deg), 45 deg .. 180 deg)",
        from.x, from.y, from.yaw
    ));
    let spawns = draw(&scenario, 20_000);
    let along = spawns.iter().map(|spawn| (spawn.ego.position() - from.position()).norm() / 40.0).collect();
    assert!(kolmogorov(along) < CRITICAL);
    let moving: Vec<f64> = spawns.iter().map(|spawn| spawn.ego_speed).filter(|speed| *speed > 0.0).collect();
    assert!((moving.len() as f64 / 20_000.0 - 0.5).abs() < 0.015);
    assert!(kolmogorov(moving.iter().map(|speed| (speed - 4.0) / 4.0).collect()) < CRITICAL);
    let headings: Vec<f64> = spawns.iter().map(|s| wrap_angle(s.pedestrian.yaw - s.ego.yaw).to_degrees()).collect();
    assert!(headings.iter().all(|heading| (45.0..=180.0).contains(heading)));
    let mean = headings.iter().sum::<f64>() / 20_000.0;
    // For the normal distribution truncated to -1.5 to 3 deviations: mean + deviation (φ(a) − φ(b)) / (Φ(b) − Φ(a)).
    let expected = 90.0 + 30.0 * (0.129_517_6 - 0.004_431_8) / (0.998_650_1 - 0.066_807_2);
    assert!((mean - expected).abs() < 0.7, "{mean} {expected}");
}

#[test]
fn rejected_constraints_are_true_of_every_start() {
    let scenario = scenario(
        "ground: [sidewalk]  sight: visible  ego_road: straight  require: [aside > 0 m or distance < 10 m, facing < 90 deg]",
    );
    for spawn in draw(&scenario, 300) {
        let town = &scenario.town;
        let place = spawn.pedestrian.position();
        let lane = town.nearest_lane(place, LaneFilter::Sidewalk).expect("the town has sidewalks");
        assert!((town.pose(lane).position() - place).norm() <= town.lane_width(lane) / 2.0 + 1e-9);
        assert!(scenario.obstacles.shows(
            spawn.ego.position(),
            (place, PedestrianBody::adult().radius),
            std::iter::empty()
        ));
        assert!(spawn.ego.to_local(place).y > 0.0 || distance(&spawn) < 10.0);
        let seen = spawn.pedestrian.to_local(spawn.ego.position());
        assert!(libm::atan2(seen.y, seen.x).to_degrees() < 90.0);
    }
}

/// Stretches of road that are half a percent of a town's lanes, and ground that is near few poses of the ego.
#[test]
fn no_start_fails_where_few_poses_of_the_ego_will_do() {
    let long = "town long { street { through: [(-1200 m, 0 m), (1200 m, 0 m), (1200 m, 200 m)] } }";
    let bends = scenario_in("long", long, "ego_road: bend");
    let drawn = draw(&bends, 2000);
    assert!(drawn.iter().all(|spawn| spawn.ego.x > 1150.0), "the only bend is at the end");
    let two = "town two {
        bend_radius: 12 m
        street { through: [(0 m, 0 m), (86 m, 0 m), (86 m, 56 m), (0 m, 56 m), (0 m, 0 m)] }
        street far { through: [(0 m, 400 m), (900 m, 400 m)] }
    }";
    let barren = scenario_in("two", two, "bearing: -63 deg  distance: 18 m .. 36 m  ground: driving");
    assert!(draw(&barren, 20).iter().all(|spawn| spawn.ego.y < 100.0), "there is no ground beside the long street");
}

#[test]
fn every_draw_is_accepted_when_nothing_is_left_to_rejection() {
    for (spawn, all) in [
        (DIRECT, true),
        (CONSTRAINTS, true),
        ("distance: 7 m .. 30 m  sight: visible", false),
        ("distance: 7 m .. 30 m  ego_road: straight", false),
        ("distance: 7 m .. 30 m  require: facing < 90 deg", false),
    ] {
        let scenario = scenario(spawn);
        let mut stream = Seed::root(6).stream();
        let (town, obstacles) = (&scenario.town, &scenario.obstacles);
        let survey = scenario.spawn.survey(town, obstacles, FirstHeading::Random, 2_000, &mut stream);
        assert_eq!(survey.accepted == survey.tried, all, "{spawn}");
    }
}

//! PufferDrive's policy in closed loop, without anybody else.

use std::sync::Arc;

use crate::pufferdrive_reference::{examples, files, small_car};
use crate::reference;
use base::seed::Seed;
use needs::needs;
use ported::pufferdrive::{Network, Pedestrians, PufferDrive, PufferDriveKeys, RoadMap, polylines};
use road::geometry::Obstacles;
use road::{Town, opendrive};
use world::av::{DrivingPolicy, PerfectSensors};
use world::sim::{ActorStart, Start, VehicleBlueprint, World};

/// What happened in some drives of 30 s.
#[derive(Debug, Default, PartialEq)]
struct Drives {
    drives: usize,
    /// Reached the first goal within 9 s, before any edge of the road was touched.
    reached: usize,
    /// Touched an edge, and left all driving lanes with the middle.
    brushed: usize,
    off_road: usize,
    goals: usize,
    /// Way (m).
    way: f64,
}

fn drives(town: &Arc<Town>, network: &Arc<Network>, car: &VehicleBlueprint, greedy: bool, starts: u64) -> Drives {
    let map = RoadMap::new(&polylines(town));
    let keys = PufferDriveKeys { weights: String::new(), greedy, pedestrians: Pedestrians::Shown };
    let mut drives = Drives::default();
    let lanes = town.driving_lanes();
    for start in 0..starts {
        let lane = &lanes[(start as usize * 7) % lanes.len()];
        let share = (0.5 + 0.618 * start as f64).fract();
        let pose = town.pose(town.along(lane, lane.length * share));
        let mut world = World::new(town.clone(), Arc::new(Obstacles::new(&[])), vec![car.clone()], vec![], None, 0.05);
        world.begin(&Start { vehicles: &[ActorStart::standing(pose)], pedestrians: &[], light_phase: 0.0 });
        let (mut sensors, mut driver) = (PerfectSensors::default(), PufferDrive::new(network.clone(), keys.clone()));
        driver.reset(&sensors.perceive(&world, 0), Seed::root(start).stream());
        let mut goal = map.next_goal(&pose);
        let (mut goals, mut reached, mut brushed, mut off_road) = (0, false, false, false);
        for tick in 0..600 {
            let state = world.ego().state;
            if tick % 2 == 0 && (goal - state.pose.position()).norm() < 2.0 && state.speed <= 10.0 {
                goal = map.next_goal(&state.pose);
                reached |= goals == 0 && tick <= 180 && !brushed;
                goals += 1;
            }
            let control = driver.drive(&sensors.perceive(&world, 0));
            world.tick(&[control], &[]);
            let state = world.ego().state;
            drives.way += state.speed * 0.05;
            brushed |= map.touches_edge(&state.outline(car));
            off_road |= town.lane_around(state.pose.position()).is_none_or(|lane| lane.inside < 0.0);
        }
        drives.drives += 1;
        drives.reached += usize::from(reached);
        drives.brushed += usize::from(brushed);
        drives.off_road += usize::from(off_road);
        drives.goals += goals;
    }
    drives
}

/// In its own simulator all of 32 cars reach their first goal in 9 s without contact, and up to one leaves the road in 30 s. Here it leaves none.
#[needs(reference = "pufferdrive weights.bin")]
#[needs(reference = "maps town02.xodr")]
#[test]
fn it_drives_in_its_towns() {
    let network = Arc::new(examples().remove(0).1);
    let starts = crate::samples::samples(24, 100) as u64;
    for path in files(&reference::folder(), ".xodr") {
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        if !["Town01", "Town02"].contains(&name.as_str()) {
            continue;
        }
        let town = Arc::new(Town::new(opendrive::read(&std::fs::read_to_string(&path).unwrap(), &name).unwrap()));
        let small = VehicleBlueprint { half_length: 1.575, half_width: 0.7, ..small_car() };
        let large = VehicleBlueprint { half_length: 2.25, half_width: 1.0, ..small_car() };
        for (size, car, greedy) in [("small", &small, false), ("small", &small, true), ("full-size", &large, false)] {
            let drives = drives(&town, &network, car, greedy, starts);
            let speed = drives.way / 30.0 / drives.drives as f64;
            loud!("PufferDrive in {name}, {size}, greedy {greedy}: {drives:?}, {speed:.1} m/s");
            assert_eq!(drives.off_road, 0);
            assert!((10.5..12.0).contains(&speed));
            match size {
                "small" => {
                    assert!(
                        8 * drives.reached >= 7 * drives.drives && 2 * drives.brushed < drives.drives,
                        "{drives:?}"
                    );
                }
                // It is wider than the policy knows.
                _ => assert!(3 * drives.brushed >= drives.drives, "{drives:?}"),
            }
        }
    }
}

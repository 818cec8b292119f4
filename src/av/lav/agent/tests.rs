use std::sync::Arc;

use super::*;
use crate::av::Sensors;
use crate::geometry::Point;
use crate::geometry::{Obstacles, Pose, Vector};
use crate::road::LaneFilter;
use crate::road::Town;
use crate::road::design::{Node, Street, TownDesign};
use crate::seed::Seed;
use crate::sim::{PedestrianBody, Scene, VehicleBlueprint, WalkCommand, World};

fn town(nodes: &[(f64, f64)], streets: &[&[usize]]) -> Arc<Town> {
    let node = |&(x, y): &(f64, f64)| Node { name: String::new(), position: Point::new(x, y), lights: false };
    let street = |nodes: &&[usize]| Street { name: String::new(), nodes: nodes.to_vec(), speed_limit: None };
    let design = TownDesign {
        nodes: nodes.iter().map(node).collect(),
        streets: streets.iter().map(street).collect(),
        ..TownDesign::default()
    };
    Arc::new(Town::new(design.build().unwrap()))
}

fn ring() -> Arc<Town> {
    town(
        &[
            (0.0, 0.0),
            (80.0, 0.0),
            (170.0, 0.0),
            (260.0, 0.0),
            (260.0, 150.0),
            (170.0, 150.0),
            (80.0, 150.0),
            (0.0, 150.0),
            (80.0, 75.0),
            (170.0, 75.0),
        ],
        &[&[0, 1, 2, 3, 4, 5, 6, 7, 0], &[1, 8, 6], &[2, 9, 5], &[8, 9]],
    )
}

/// A car on a lane of a town, and somebody standing far away.
struct Drive {
    world: World,
    sensors: Sensors,
    lav: Lav,
}

impl Drive {
    fn new(town: &Arc<Town>, version: Version, start: Pose, seed: u64) -> Self {
        let mut world = World::new(
            Arc::clone(town),
            Arc::new(Obstacles::new(&[])),
            VehicleBlueprint { start_up_pause: 0.0, ..VehicleBlueprint::mkz_2017() },
            PedestrianBody::adult().nimble(),
            None,
            0.05,
        );
        world.begin(&Scene { ego: start, ego_speed: 0.0, pedestrian: Pose::new(-1e4, 0.0, 0.0), light_phase: 0.0 });
        let (mut sensors, mut lav) = (Sensors::default(), Lav::new(version, 0.1, 1.0));
        lav.reset(&sensors.perceive(&world), Seed::root(seed).stream());
        Self { world, sensors, lav }
    }

    fn tick(&mut self, command: WalkCommand) -> Control {
        let control = self.lav.drive(&self.sensors.perceive(&self.world));
        self.world.tick(control, command);
        control
    }

    fn off_route(&self) -> f64 {
        let mut points = self.lav.path.points();
        let (first, _) = (points.next().unwrap(), points.next());
        first.pose.to_local(self.world.ego.pose.position()).y
    }
}

#[test]
fn explore() {
    let town = ring();
    for version in [Version::V1, Version::V2] {
        for seed in 0..4 {
            let start = town.pose(town.nearest_lane(Point::new(40.0, 3.0), LaneFilter::Driving).unwrap());
            let mut drive = Drive::new(&town, version, start, seed);
            let (mut worst, mut sum, mut speeds) = (0.0_f64, 0.0, 0.0);
            let mut hist = std::collections::BTreeMap::<String, (f64, f64, usize)>::new();
            for tick in 0..6000 {
                let c = drive.tick(WalkCommand::default());
                let off = drive.off_route();
                worst = worst.max(off.abs());
                sum += off * off;
                speeds += drive.world.ego.speed;
                let e = hist.entry(format!("{:?}", drive.lav.command)).or_default();
                e.0 = e.0.max(off.abs());
                e.1 += drive.world.ego.speed;
                e.2 += 1;
                if seed == 0 && tick % 50 == 0 && tick < 1000 {
                    println!(
                        "{tick} {:?} v {:.2} off {off:.2} steer {:.2} thr {:.2} {:?}",
                        drive.world.ego.pose, drive.world.ego.speed, c.steer, c.throttle, drive.lav.command
                    );
                }
            }
            println!(
                "{version:?} {seed}: worst {worst:.2} rms {:.3} mean speed {:.2}",
                (sum / 6000.0_f64).sqrt(),
                speeds / 6000.0
            );
            for (k, (w, v, n)) in hist {
                println!("   {k}: worst {w:.2} mean v {:.2} n {n}", v / n as f64);
            }
        }
    }
}

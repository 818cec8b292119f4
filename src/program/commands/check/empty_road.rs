//! An empty road with a bend and a turn, on which a driver shows that it follows its route.

use base::seed::Seed;
use episode::Scenario;
use road::geometry::Point;
use road::{LaneFilter, RoadOption, Waypoint, lane_route};
use world::av::{DrivingPolicy, Fault, Perception, PerfectSensors};
use world::sim::{ActorStart, Control, Start, World};

/// The town: a street with a bend that ends at another one.
pub const TOWN: &str = "\
town empty_road {
  bend_radius: 30 m
  street first { through: [(0 m, 0 m), (80 m, 0 m), (120 m, 40 m), (120 m, 120 m)] }
  street second { through: [(20 m, 120 m), (120 m, 120 m), (220 m, 120 m)] }
}
";
/// Where the car starts, at rest.
const START: (f64, f64) = (20.0, -1.75);
/// How far beyond its lane the centre of the car may be (m): more than a driver cuts a corner.
const ASIDE: f64 = 1.0;
/// How far behind the turn the road ends (m), and the time for it (s).
const BEHIND: f64 = 20.0;
const TIME_LIMIT: f64 = 120.0;
/// Steering that differs by less is constant.
const SAME: f64 = 0.01;

/// What a driver did up to now.
struct Drive {
    /// Time since the start (s), way (m) and speed (m/s).
    time: f64,
    way: f64,
    speed: f64,
    /// The least steering and the greatest, and the last.
    steer: (f64, f64, f64),
}

/// What went wrong on the way, as parts of sentences.
#[derive(Default)]
pub struct Mishaps {
    /// How a part of the car's body left the road.
    pub off_road: Option<String>,
    /// How its centre left its lane, or why it did not get to the end.
    pub off_lane: Option<String>,
}

/// Lets a driver follow the road in the town of a scenario, a left turn at its end.
pub fn follow(scenario: &Scenario, driver: &mut dyn DrivingPolicy, seed: &Seed) -> Mishaps {
    let mut found = Mishaps::default();
    let town = &scenario.town;
    let start = town.nearest_lane(Point::new(START.0, START.1), LaneFilter::Driving).expect("the town has lanes");
    let route = lane_route(town, start, &[RoadOption::Left]).expect("the road ends at a junction");
    let end = *route.last().expect("a route has its start");
    let blueprint = scenario.cast.ego().blueprint.clone();
    let mut world =
        World::new(town.clone(), scenario.obstacles.clone(), vec![blueprint], vec![], None, scenario.episode.tick);
    let vehicles = [ActorStart::standing(town.pose(start))];
    world.begin(&Start { vehicles: &vehicles, pedestrians: &[], light_phase: 0.0 });
    let mut sensors = PerfectSensors::default();
    driver.reset(&perceive(&mut sensors, &world, &route), seed.stream());
    let mut drive = Drive { time: 0.0, way: 0.0, speed: 0.0, steer: (f64::INFINITY, f64::NEG_INFINITY, 0.0) };
    while drive.time < TIME_LIMIT {
        let perception = perceive(&mut sensors, &world, &route);
        driver.prepare(&perception);
        let control = driver.drive(&perception);
        if let Some(fault) = driver.fault() {
            return Mishaps { off_lane: Some(told(fault)), ..found };
        }
        world.tick(&[control], &[]);
        let ego = world.ego().state;
        drive.note(world.elapsed(), ego.speed, ego.speed * world.dt, &control);
        let here = ego.pose.position();
        let inside = route.iter().map(|lane| town.inside_lane(*lane, here)).fold(f64::NEG_INFINITY, f64::max);
        if town.inside_road(&world.ego().outline(), ego.ground) < 0.0 {
            found.off_road.get_or_insert_with(|| drive.left("the road with a part of its body"));
        }
        if inside < -ASIDE {
            found.off_lane.get_or_insert_with(|| drive.left("its lane"));
        }
        if found.off_road.is_some() && found.off_lane.is_some() {
            return found;
        }
        let around = town.lane_around(here).filter(|lane| lane.place.is_on_lane_of(&end));
        if around.is_some_and(|lane| (lane.place.s - end.s).abs() >= BEHIND) {
            return found;
        }
    }
    found.off_lane.get_or_insert_with(|| drive.stopped());
    found
}

/// What the driver of the car perceives, with its route.
fn perceive<'a>(sensors: &'a mut PerfectSensors, world: &'a World, route: &'a [Waypoint]) -> Perception<'a> {
    Perception { route, ..sensors.perceive(world, 0) }
}

impl Drive {
    fn note(&mut self, time: f64, speed: f64, way: f64, control: &Control) {
        let (least, greatest, _) = self.steer;
        (self.time, self.speed, self.way) = (time, speed, self.way + way);
        self.steer = (least.min(control.steer), greatest.max(control.steer), control.steer);
    }

    fn left(&self, what: &str) -> String {
        let Self { time, way, speed, steer: (least, greatest, last) } = self;
        let side = if *last > 0.0 { "left" } else { "right" };
        let steer = match (greatest - least < SAME, last.abs() < SAME) {
            (true, true) => "the driver does not steer".into(),
            (true, false) => format!("the driver steers constantly {:.2} to the {side}", last.abs()),
            (false, true) => "the driver did not steer then".into(),
            (false, false) => format!("the driver steered {:.2} to the {side} then", last.abs()),
        };
        format!("the car left {what} {time:.1} s after the start, after {way:.0} m, at {speed:.1} m/s: {steer}")
    }

    fn stopped(&self) -> String {
        match self.way < 1.0 {
            true => format!("the car stood for {TIME_LIMIT:.0} s"),
            false => format!("the car did not get through the turn in {TIME_LIMIT:.0} s: it drove {:.0} m", self.way),
        }
    }
}

/// What a driver did wrong, and what helps.
pub(super) fn told(fault: Fault) -> String {
    let help = match fault {
        Fault::Late { .. } => "; `--timeout` here, and `timeout` in a scenario, give it more time",
        Fault::LateStart { .. } => "; `--start-timeout` here gives it more time",
        _ => "",
    };
    format!("it {fault}{help}")
}

//! The behaviour agent, tick by tick, in its four releases.

use base::seed::Seed;
use ported::behavior_agent::{AgentConfig, BehaviorAgent, Decision, Profile, Release};
use road::geometry::{Obstacles, Pose, Vector};
use road::{
    Geometry, Junction, JunctionIndex, Lane, LaneId, LaneKind, LaneSection, PlanView, Profile as Width, Road, Town,
    TownParts,
};
use world::av::{Actor, DrivingMode, DrivingPolicy, Light, Perception};
use world::sim::{ActorId, Control, LightColour, VehicleBlueprint};

/// A road of 200 m along +x as in CARLA's towns: lanes of 4 m, a shoulder of 0.3 m and a sidewalk of 4 m on each side.
/// The right driving lane's centre is at y = −2.
fn town(in_junction: bool) -> Town {
    let lane = |id: LaneId| {
        let (kind, width) = match id.abs() {
            0 => (LaneKind::None, 0.0),
            1 => (LaneKind::Driving, 4.0),
            2 => (LaneKind::Shoulder, 0.3),
            _ => (LaneKind::Sidewalk, 4.0),
        };
        Lane { id, kind, width: Width::constant(width), limits: Vec::new(), predecessor: None, successor: None }
    };
    let road = Road {
        id: 7,
        name: String::new(),
        length: 200.0,
        left_hand: false,
        junction: in_junction.then_some(JunctionIndex(0)),
        plan_view: PlanView::new(vec![Geometry::line(0.0, Pose::default(), 200.0)]),
        lane_offset: Width::constant(0.0),
        sections: vec![LaneSection { start: 0.0, end: 200.0, lanes: (-3..=3).rev().map(lane).collect() }],
        predecessor: None,
        successor: None,
    };
    let junction = Junction { id: 1, name: String::new(), connections: Vec::new() };
    Town::new(TownParts { roads: vec![road], junctions: vec![junction], ..TownParts::default() })
}

/// The ego stands 50 m down the road with its bumper at x = 52.4; the other fields set everything else.
struct Scene {
    town: Town,
    blueprint: VehicleBlueprint,
    ego: Actor,
    walkers: Vec<Actor>,
    obstacles: Obstacles,
    vehicles: Vec<Actor>,
    lights: Vec<Light>,
    affecting: Option<usize>,
}

impl Scene {
    fn new() -> Self {
        Self {
            town: town(false),
            blueprint: VehicleBlueprint::model3(),
            ego: vehicle(50.0, -2.0, 7.5),
            walkers: Vec::new(),
            obstacles: Obstacles::new(&[]),
            vehicles: Vec::new(),
            lights: Vec::new(),
            affecting: None,
        }
    }

    fn with_walker(x: f64, y: f64) -> Self {
        Self { walkers: vec![walker(x, y, 1.0)], ..Self::new() }
    }

    fn perception(&self) -> Perception<'_> {
        Perception {
            town: &self.town,
            blueprint: &self.blueprint,
            tick: 0,
            dt: 0.05,
            ego: self.ego,
            ground: 0.0,
            speed_limit: 30.0 / 3.6,
            signed_limit: None,
            route: &[],
            pedestrians: &self.walkers,
            vehicles: &self.vehicles,
            obstacles: &self.obstacles,
            lights: &self.lights,
            affecting_light: self.affecting,
        }
    }

    fn agent(&self, release: Release) -> BehaviorAgent {
        let mut agent = BehaviorAgent::new(AgentConfig { release, ..AgentConfig::default() });
        agent.reset(&self.perception(), Seed::root(1).stream());
        agent
    }

    /// The second tick of a fresh agent, so that its planner has run.
    fn decide(&self, release: Release) -> (Control, Decision) {
        let mut agent = self.agent(release);
        let (pedestrians, vehicles, lights, affecting_light) = (&[][..], &[][..], &[][..], None);
        agent.drive(&Perception { pedestrians, vehicles, lights, affecting_light, ..self.perception() });
        let control = agent.drive(&self.perception());
        (control, *agent.decision())
    }

    fn stops(&self, release: Release) -> bool {
        self.decide(release).1.emergency
    }
}

fn vehicle(x: f64, y: f64, speed: f64) -> Actor {
    let pose = Pose::new(x, y, 0.0);
    let (velocity, half) = (Vector::new(speed, 0.0), Vector::new(2.4, 1.08));
    Actor { id: ActorId::Vehicle(1), pose, velocity, half, height: 0.0 }
}

fn walker(x: f64, y: f64, yaw: f64) -> Actor {
    let (pose, velocity, half) = (Pose::new(x, y, yaw), Vector::zeros(), Vector::new(0.188, 0.188));
    Actor { id: ActorId::Pedestrian(0), pose, velocity, half, height: 0.93 }
}

const NEWEST: Release = Release::V0_9_15;

#[test]
fn each_release_has_its_emergency_brake() {
    let scene = Scene::with_walker(56.0, -1.5);
    for (release, brake) in Release::ALL.into_iter().zip([1.0, 0.5, 0.5, 0.5]) {
        let (control, decision) = scene.decide(release);
        assert!(decision.emergency, "{release:?}");
        assert_eq!(control, Control { throttle: 0.0, brake, steer: 0.0 }, "{release:?}");
    }
}

#[test]
fn a_walker_on_the_sidewalk_stops_only_the_old_releases() {
    let scene = Scene::with_walker(56.0, -6.0);
    let stops = Release::ALL.map(|release| scene.stops(release));
    assert_eq!(stops, [true, true, false, false]);
}

#[test]
fn the_old_releases_see_less_far() {
    let scene = Scene::with_walker(58.5, -1.5);
    let stops = Release::ALL.map(|release| scene.stops(release));
    assert_eq!(stops, [false, false, true, true]);
}

#[test]
fn a_walker_exactly_dead_ahead_is_run_over() {
    let scene = Scene { walkers: vec![walker(56.0, -2.0, 0.0)], ..Scene::new() };
    for release in Release::ALL {
        assert!(!scene.stops(release), "{release:?}");
    }
}

#[test]
fn distances_are_to_the_walkers_back() {
    let distance = |yaw: f64| {
        let scene = Scene { walkers: vec![walker(56.0, -1.8, yaw)], ..Scene::new() };
        scene.decide(NEWEST).1.walker.unwrap()
    };
    let (away, towards) = (distance(0.0), distance(std::f64::consts::PI));
    assert!((towards - away - 0.36).abs() < 0.02, "{away} and {towards}");
}

#[test]
fn in_junctions_walkers_hide_in_the_zigzag() {
    let spots = (0..60).map(|i| 53.0 + f64::from(i) / 10.0);
    let scene = |x| Scene { town: town(true), ..Scene::with_walker(x, -1.3) };
    let seen = spots.filter(|x| scene(*x).stops(NEWEST)).count();
    assert!((15..50).contains(&seen), "{seen} of 60");
}

#[test]
fn without_walkers_the_wide_cone_looks_at_vehicles() {
    // Its back is 39 degrees to the side, though its centre is in the lane.
    let aside = Actor { pose: Pose::new(57.0, -1.0, -0.4), ..vehicle(0.0, 0.0, 0.0) };
    let scene = Scene { vehicles: vec![aside], ..Scene::new() };
    let found = Release::ALL.map(|release| scene.decide(release).1.walker.is_some());
    assert_eq!(found, [false, false, true, true]);
}

#[test]
fn the_first_vehicle_in_the_list_counts() {
    let scene = Scene { vehicles: vec![vehicle(64.7, -1.9, 0.0), vehicle(58.0, -1.9, 0.0)], ..Scene::new() };
    let (_, decision) = scene.decide(Release::V0_9_13);
    assert!(!decision.emergency && decision.vehicle.is_some_and(|distance| distance > 9.0), "{decision:?}");
}

#[test]
fn a_slow_vehicle_ahead_is_followed() {
    let scene = Scene { vehicles: vec![vehicle(64.7, -1.9, 5.0)], ..Scene::new() };
    let (_, decision) = scene.decide(Release::V0_9_13);
    assert!((decision.target_speed * 3.6 - 8.0).abs() < 1e-9, "10 km/h slower than 18: {decision:?}");
    // If the back of a car is far enough away, its centre is out of the newest release's reach.
    assert!(!scene.stops(NEWEST));
    assert_eq!(scene.decide(NEWEST).1.vehicle, None);
}

#[test]
fn an_emergency_stop_straightens_the_wheels() {
    let mut scene = Scene::with_walker(56.0, -1.5);
    scene.ego.pose = Pose::new(50.0, -2.0, 0.05);
    assert_eq!(scene.decide(NEWEST).0.steer, 0.0);
}

#[test]
fn a_red_light_is_kept_until_it_changes() {
    let light = |colour| vec![Light { trigger: Pose::new(54.0, -2.1, 0.0), colour }];
    let mut scene = Scene { lights: light(LightColour::Red), ..Scene::new() };
    scene.ego.pose.y = -2.05;
    let mut agent = scene.agent(NEWEST);
    assert_eq!(agent.drive(&scene.perception()).brake, 0.5);
    assert_eq!(agent.mode(), DrivingMode::RedLight);
    scene.ego.pose.x = 80.0;
    agent.drive(&scene.perception());
    assert!(agent.decision().red_light, "though it is far behind");
    scene.lights = light(LightColour::Green);
    agent.drive(&scene.perception());
    assert!(!agent.decision().red_light);
    scene.lights = light(LightColour::Red);
    agent.drive(&scene.perception());
    assert!(!agent.decision().red_light, "a light behind does not count anew");
}

#[test]
fn lights_behind_and_for_others_do_not_stop() {
    let stops = |x: f64, y: f64| {
        let light = Light { trigger: Pose::new(x, y, 0.0), colour: LightColour::Red };
        let mut scene = Scene { lights: vec![light], ..Scene::new() };
        scene.ego.pose.y = -2.05;
        scene.decide(NEWEST).1.red_light
    };
    assert!(stops(54.9, -2.0) && !stops(55.1, -2.0), "within 5 m of the centre");
    assert!(!stops(48.0, -2.0), "behind");
    assert!(!stops(52.0, 2.0), "the oncoming lane");
}

#[test]
fn the_oldest_release_obeys_the_light_it_stands_at() {
    let light = Light { trigger: Pose::new(54.0, -2.0, 0.0), colour: LightColour::Red };
    let scene = Scene { lights: vec![light], ..Scene::new() };
    assert!(!scene.stops(Release::V0_9_11), "it does not look for lights itself");
    let at_light = Scene { affecting: Some(0), ..scene };
    assert!(at_light.stops(Release::V0_9_11));
    let passed = Scene { town: town(true), ..at_light };
    assert!(!passed.stops(Release::V0_9_11), "in the junction it goes on");
}

#[test]
fn at_the_end_of_its_plan_it_brakes_and_stays() {
    let scene = Scene::new();
    for release in Release::ALL {
        let mut agent = scene.agent(release);
        agent.set_plan(Vec::new());
        assert_eq!(agent.drive(&scene.perception()), Control::FULL_BRAKE);
        assert_eq!(agent.mode(), DrivingMode::Arrived);
    }
}

#[test]
fn profiles_keep_below_the_limit() {
    let scene = Scene::new();
    let targets = Profile::ALL.map(|profile| {
        let mut agent = BehaviorAgent::new(AgentConfig { profile, ..AgentConfig::default() });
        agent.reset(&scene.perception(), Seed::root(1).stream());
        agent.drive(&scene.perception());
        (agent.decision().target_speed * 3.6).round()
    });
    assert_eq!(targets, [24.0, 27.0, 29.0]);
}

#[test]
fn names_lead_back_to_releases() {
    for release in Release::ALL {
        assert_eq!(Release::named(release.name()), Some(release));
    }
    assert_eq!(Release::named("0.9.14"), Some(Release::V0_9_15));
    assert_eq!(Release::named("0.9.16"), None);
}

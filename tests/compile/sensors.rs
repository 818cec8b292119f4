//! Sensors in front of a driver: what the driver receives and when. Nothing else changes.

use std::path::Path;
use std::sync::{Arc, LazyLock, Mutex};

use base::seed::{Seed, Stream};
use compile::{Catalog, Plan, compile};
use episode::{Draw, Scenario};
use rand::Rng;
use road::geometry::{Obstacles, OrientedBox, Pose, Vector};
use world::av::sensors::{ConfusedAs, Prediction, Seam, Sector, SensorKeys, SensorModel, SensorWrapper};
use world::av::{Actor, ActuationDelay, DrivingMode, DrivingPolicy, Perception};
use world::sim::{ActorId, Control};

fn plan(text: &str) -> Plan {
    let root = crate::repository().join("scenarios/sensors.scn");
    let read = |path: &Path| if path == root { Ok(text.to_string()) } else { std::fs::read_to_string(path) };
    let compiled = compile(std::slice::from_ref(&root), &Catalog::builtin(), &read, &mut Default::default()).unwrap();
    compiled.plan.unwrap_or_else(|| panic!("{:?}", compiled.diagnostics))
}

/// A campaign that evaluates policies against the intercepting controller.
fn campaign(declarations: &str, policies: &str) -> Plan {
    plan(&format!(
        r#"
        edition 1
        import "lib/paper.scn"
        import "lib/drivers.scn"
        import "lib/sensors.scn"
        import "lib/towns.scn"
        {declarations}
        campaign tried {{
          vehicle: model3  body: suicidal  spawn: ahead  episode: thirty_seconds  training: ppo_paper
          train {{ towns: [harbour] drivers: [blind] rewards: [r2] runs: 1 }}
          evaluate {{ towns: [harbour] drivers: [{policies}] pedestrians: [intercept] }}
        }}"#
    ))
}

/// What a driver received: pedestrians and vehicles of every tick, and the first number of its random stream.
#[derive(Default)]
struct Seen {
    pedestrians: Vec<Vec<Actor>>,
    vehicles: Vec<Vec<Actor>>,
    draw: u64,
}

struct Probe(Arc<Mutex<Seen>>);

impl DrivingPolicy for Probe {
    fn reset(&mut self, _: &Perception<'_>, mut stream: Stream) {
        *self.0.lock().unwrap() = Seen { draw: stream.next_u64(), ..Seen::default() };
    }

    fn drive(&mut self, perception: &Perception<'_>) -> Control {
        let mut seen = self.0.lock().unwrap();
        seen.pedestrians.push(perception.pedestrians.to_vec());
        seen.vehicles.push(perception.vehicles.to_vec());
        Control::default()
    }

    fn mode(&self) -> DrivingMode {
        DrivingMode::Cruise
    }
}

fn person(x: f64, y: f64, velocity: Vector) -> Actor {
    let (pose, half) = (Pose::new(x, y, 0.3), Vector::new(0.19, 0.19));
    Actor { id: ActorId::Pedestrian(0), pose, velocity, half, height: 0.93 }
}

fn car(x: f64, y: f64, yaw: f64) -> Actor {
    let (pose, velocity) = (Pose::new(x, y, yaw), Vector::zeros());
    Actor { id: ActorId::Vehicle(0), pose, velocity, half: Vector::new(2.3, 0.9), height: 0.0 }
}

fn exact() -> SensorKeys {
    let plan = campaign("sensors plain { }  driver sensing = aeb(sensors: plain)", "sensing");
    let driver = plan.campaigns[0].drivers.iter().find(|driver| driver.name == "sensing").unwrap();
    driver.sensor_model.as_ref().unwrap().keys.clone()
}

fn model(keys: SensorKeys) -> SensorModel {
    SensorModel { keys, sectors: Vec::new(), seams: Vec::new() }
}

/// What a driver at the origin that faces east receives, over this number of ticks of 0.05 s, from actors that keep their velocity.
fn look(model: &SensorModel, walls: &[OrientedBox], people: &[Actor], cars: &[Actor], ticks: u32, seed: u64) -> Seen {
    static SCENARIO: LazyLock<Arc<Scenario>> =
        LazyLock::new(|| campaign("", "blind").campaigns[0].nth::<compile::Evaluation>(0).scenario.clone());
    let scenario = &*SCENARIO;
    let obstacles = Obstacles::new(walls);
    let seen = Arc::new(Mutex::new(Seen::default()));
    let mut driver = SensorWrapper::new(Box::new(Probe(seen.clone())), Arc::new(model.clone()));
    let dt = 0.05;
    for tick in 0..ticks {
        let moved = |(id, actor): (ActorId, &Actor)| {
            let place = actor.pose.position() + actor.velocity * (f64::from(tick) * dt);
            Actor { id, pose: Pose { x: place.x, y: place.y, ..actor.pose }, ..*actor }
        };
        let people: Vec<Actor> = (0..).map(ActorId::Pedestrian).zip(people).map(moved).collect();
        let cars: Vec<Actor> = (0..).map(ActorId::Vehicle).zip(cars).map(moved).collect();
        let perception = Perception {
            town: &scenario.town,
            blueprint: &scenario.cast.ego().blueprint,
            tick,
            dt,
            ego: car(0.0, 0.0, 0.0),
            ground: 0.0,
            speed_limit: 8.0,
            signed_limit: None,
            route: &[],
            pedestrians: &people,
            vehicles: &cars,
            obstacles: &obstacles,
            lights: &[],
            affecting_light: None,
        };
        if tick == 0 {
            driver.reset(&perception, Seed::root(seed).stream());
        }
        driver.drive(&perception);
    }
    drop(driver);
    Arc::into_inner(seen).unwrap().into_inner().unwrap()
}

fn found(model: &SensorModel, walls: &[OrientedBox], people: &[Actor], cars: &[Actor]) -> (usize, usize) {
    let seen = look(model, walls, people, cars, 1, 1);
    (seen.pedestrians[0].len(), seen.vehicles[0].len())
}

#[test]
fn exact_sensors_change_no_bit_of_an_episode() {
    let names = ["behavior", "idm", "aeb", "predictive"];
    let declarations = r#"
        driver a = behavior_agent(release: "0.9.15", sensors: perfect)
        driver b = idm(time_headway: 1.5 s, sensors: perfect)
        driver c = aeb(sensors: perfect)
        driver d = predictive(sensors: perfect)
        driver e = behavior_agent(release: "0.9.15", sensors: carla_list)
    "#;
    let others = "driver f = aeb(sensors: poor)";
    // The library declares its drivers in a file without sensors named `perfect`, so they have no sensors in front of them.
    let plan = campaign(&format!("{declarations} {others}"), &format!("{}, a, b, c, d, e, f", names.join(", ")));
    let digests = |scenario: &Arc<Scenario>| -> Vec<u64> {
        let mut env = scenario.simulation();
        (0..15)
            .map(|episode| {
                env.start(Draw::new(&Seed::root(5), episode));
                while env.outcome().is_none() {
                    env.carry_out(&[env.scene().intercept(0)]);
                }
                env.outcome().unwrap().digest
            })
            .collect()
    };
    let of = |name: &str| {
        let found = plan.campaigns[0].all::<compile::Evaluation>().find(|each| *each.policy == *name).unwrap();
        digests(&found.scenario)
    };
    for (bare, sensed) in names.iter().zip(["a", "b", "c", "d"]) {
        assert_eq!(of(bare), of(sensed), "{bare}");
    }
    assert_eq!(of("behavior"), of("e"), "the list of actors is all that CARLA's driver has");
    assert_ne!(of("aeb"), of("f"), "poor sensors make another driver");
}

#[test]
fn latency_and_rate_are_exact_in_ticks() {
    let walker = person(10.0, 0.0, Vector::new(0.0, 2.0));
    let late = model(SensorKeys { latency: 0.2, update_rate: Some(10.0), ..exact() });
    let seen = look(&late, &[], &[walker], &[], 20, 1);
    for (tick, pedestrians) in seen.pedestrians.iter().enumerate() {
        if tick < 4 {
            assert!(pedestrians.is_empty(), "nothing has arrived at tick {tick}");
            continue;
        }
        let measured = (tick - 4) / 2 * 2;
        assert!((pedestrians[0].pose.y - 2.0 * 0.05 * measured as f64).abs() < 1e-12, "tick {tick}");
    }
    let ahead = model(SensorKeys { prediction: Prediction::ConstantVelocity, ..late.keys });
    let seen = look(&ahead, &[], &[walker], &[], 20, 1);
    for (tick, pedestrians) in seen.pedestrians.iter().enumerate().skip(4) {
        assert!((pedestrians[0].pose.y - 2.0 * 0.05 * tick as f64).abs() < 1e-12, "predicted at tick {tick}");
    }
}

#[test]
fn walls_and_others_hide() {
    let looking = model(SensorKeys { least_visible: 0.3, ..exact() });
    let far = person(20.0, 0.0, Vector::zeros());
    let wall = |y: f64| OrientedBox::new(Pose::new(10.0, y, 0.0), 0.1, 5.0);
    assert_eq!(found(&looking, &[], &[far], &[]), (1, 0));
    assert_eq!(found(&looking, &[wall(0.0)], &[far], &[]), (0, 0), "behind a wall");
    assert_eq!(found(&model(exact()), &[wall(0.0)], &[far], &[]), (1, 0), "exact sensors see through it");
    // The wall's edge is at y = −0.05 on the way: the person's right half and its middle ray's neighbour stay hidden.
    let edge = wall(-5.0 - 0.02);
    assert_eq!(found(&looking, &[edge], &[far], &[]), (1, 0), "three of five rays pass");
    let strict = model(SensorKeys { least_visible: 0.7, ..exact() });
    assert_eq!(found(&strict, &[edge], &[far], &[]), (0, 0), "which is too few here");
    assert_eq!(found(&looking, &[], &[far], &[car(12.0, 0.0, 1.57)]), (0, 1), "behind a car");
    assert_eq!(found(&looking, &[], &[far], &[car(25.0, 0.0, 1.57)]), (1, 1), "in front of one");
    assert_eq!(found(&looking, &[wall(0.0)], &[], &[car(25.0, 0.0, 1.57)]), (0, 0), "cars hide as well");
    assert_eq!(found(&looking, &[], &[far, person(10.0, 0.0, Vector::zeros())], &[]), (1, 0), "in single file");
}

#[test]
fn only_the_field_is_seen() {
    let (ahead, behind, aside) = (Some(18.0), Some(2.0), Some(10.0));
    let window = model(SensorKeys { ahead, behind, aside, eye: 1.3, ..exact() });
    let sector = Sector { facing: 0.0, width: 100.0_f64.to_radians(), range: Some(12.0) };
    let at = |x, y| person(x, y, Vector::zeros());
    let count = |model: &SensorModel, x, y| found(model, &[], &[at(x, y)], &[]).0;
    for (x, y, wanted) in [(17.9, 9.9, 1), (18.1, 0.0, 0), (-1.9, 0.0, 1), (-2.1, 0.0, 0), (5.0, -10.1, 0)] {
        assert_eq!(count(&window, x, y), wanted, "({x}, {y}) in the window");
    }
    let narrow = SensorModel { sectors: vec![sector], ..window.clone() };
    // 50 degrees from the eye at x = 1.3.
    for (x, y, wanted) in [(6.3, 5.9, 1), (6.3, 6.0, 0), (13.2, 0.0, 1), (13.4, 0.0, 0), (-1.0, 0.0, 0)] {
        assert_eq!(count(&narrow, x, y), wanted, "({x}, {y}) in the sector");
    }
    let seam = Seam { facing: 0.5, width: 0.1, miss: 1.0 };
    let sewn = SensorModel { seams: vec![seam], ..window };
    assert_eq!(count(&sewn, 1.3 + 8.0 * 0.8776, 8.0 * 0.4794), 0, "in the seam");
    assert_eq!(count(&sewn, 1.3 + 8.0 * 0.8776, -8.0 * 0.4794), 1);
}

#[test]
fn misses_happen_at_the_stated_rate() {
    let missing = model(SensorKeys { near: 10.0, far: 20.0, miss_near: 0.1, miss_far: 0.5, ..exact() });
    for (x, wanted) in [(5.0, 0.1), (15.0, 0.3), (30.0, 0.5)] {
        let n = 20_000;
        let seen = look(&missing, &[], &[person(x, 0.0, Vector::zeros())], &[], n, 3);
        let missed = seen.pedestrians.iter().filter(|list| list.is_empty()).count() as f64 / f64::from(n);
        let deviation = (wanted * (1.0 - wanted) / f64::from(n)).sqrt();
        assert!((missed - wanted).abs() < 3.3 * deviation, "{missed} of {wanted} ± {deviation} at {x} m");
    }
    let remembering = model(SensorKeys { memory: 1.0, ..missing.keys });
    let seen = look(&remembering, &[], &[person(5.0, 0.0, Vector::new(0.0, 1.0))], &[], 200, 3);
    let first = seen.pedestrians.iter().position(|list| !list.is_empty()).unwrap();
    for (tick, list) in seen.pedestrians.iter().enumerate().skip(first) {
        assert!((list[0].pose.y - 0.05 * tick as f64).abs() < 1e-9, "it is remembered as walking on");
    }
}

/// The name, mean and standard deviation of a quantity, and a function that reads it from an actor.
type Case<'a> = (&'a str, f64, f64, &'a dyn Fn(&Actor) -> f64);

#[test]
fn noise_has_the_stated_moments() {
    let noisy = model(SensorKeys {
        position_noise: 0.3,
        velocity_noise: 0.5,
        heading_noise: 0.2,
        size_noise: 0.1,
        speed_pull: 0.5,
        walking_speed: 1.2,
        ..exact()
    });
    let n = 20_000;
    let seen = look(&noisy, &[], &[person(8.0, 2.0, Vector::zeros())], &[], n, 4);
    let moments = |value: &dyn Fn(&Actor) -> f64| {
        let values: Vec<f64> = seen.pedestrians.iter().map(|list| value(&list[0])).collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        (mean, (values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / values.len() as f64).sqrt())
    };
    // While it stands, the driver assumes that it walks at half of 1.2 m/s along its heading of 0.3 rad.
    let cases: [Case<'_>; 6] = [
        ("x", 8.0, 0.3, &|actor| actor.pose.x),
        ("y", 2.0, 0.3, &|actor| actor.pose.y),
        ("heading", 0.3, 0.2, &|actor| actor.pose.yaw),
        ("east", 0.6 * 0.955_336, 0.5, &|actor| actor.velocity.x),
        ("north", 0.6 * 0.295_520, 0.5, &|actor| actor.velocity.y),
        ("size", 0.0, 0.1, &|actor| libm::log(actor.half.x / 0.19)),
    ];
    for (name, mean, deviation, value) in cases {
        let (got_mean, got_deviation) = moments(value);
        assert!((got_mean - mean).abs() < 4.0 * deviation / f64::from(n).sqrt(), "{name}: mean {got_mean}");
        assert!((got_deviation / deviation - 1.0).abs() < 0.03, "{name}: deviation {got_deviation}");
    }
}

#[test]
fn a_pedestrian_may_be_taken_for_a_vehicle() {
    let confusing = model(SensorKeys { confusion: 0.25, ..exact() });
    let walker = [person(8.0, 0.0, Vector::zeros())];
    let seen = look(&confusing, &[], &walker, &[], 20_000, 6);
    let confused = seen.vehicles.iter().filter(|list| list.len() == 1).count();
    assert!((confused as f64 / 20_000.0 - 0.25).abs() < 0.01, "{confused}");
    for (people, cars) in seen.pedestrians.iter().zip(&seen.vehicles) {
        assert_eq!(people.len() + cars.len(), 1);
        assert!(cars.iter().all(|car| car.half == confusing.confused_half()));
    }
    let both = model(SensorKeys { confused_as: ConfusedAs::Both, ..confusing.keys });
    let seen = look(&both, &[], &walker, &[], 1000, 6);
    assert!(seen.pedestrians.iter().all(|list| list.len() == 1));
    assert!(seen.vehicles.iter().any(|list| list.len() == 1));
}

#[test]
fn false_alarms_come_and_go_as_stated() {
    let alarming = model(SensorKeys { false_alarms: 0.5, false_alarm_length: 0.5, ..exact() });
    let seen = look(&alarming, &[], &[], &[], 40_000, 7);
    let there: Vec<bool> = seen.pedestrians.iter().map(|list| !list.is_empty()).collect();
    let births = there.windows(2).filter(|pair| !pair[0] && pair[1]).count() as f64;
    let absent = there.iter().filter(|there| !**there).count() as f64 * 0.05;
    assert!((births / absent / 0.5 - 1.0).abs() < 0.12, "{births} in {absent} s");
    let length = (40_000.0 * 0.05 - absent) / births;
    assert!((length / 0.5 - 1.0).abs() < 0.12, "{length} s each");
}

#[test]
fn no_setting_moves_a_draw_of_another() {
    let walker = [person(8.0, 0.0, Vector::zeros())];
    let noisy = model(SensorKeys { position_noise: 0.3, ..exact() });
    let missing = model(SensorKeys {
        miss_near: 0.4,
        miss_far: 0.4,
        confusion: 0.2,
        confused_as: ConfusedAs::Both,
        false_alarms: 1.0,
        velocity_noise: 1.0,
        ..noisy.keys.clone()
    });
    let (a, b) = (look(&noisy, &[], &walker, &[], 500, 8), look(&missing, &[], &walker, &[], 500, 8));
    assert_eq!(a.draw, b.draw, "the driver's own stream");
    assert_eq!(a.draw, Seed::root(8).stream().next_u64(), "which is the one it would have without sensors");
    let mut compared = 0;
    for (one, other) in a.pedestrians.iter().zip(&b.pedestrians) {
        // The pedestrian is first; a false alarm is far from it.
        if let Some(found) = other.iter().find(|actor| (actor.pose.x - one[0].pose.x).abs() < 1e-12) {
            assert_eq!((found.pose.x, found.pose.y), (one[0].pose.x, one[0].pose.y));
            compared += 1;
        }
    }
    assert!((200..400).contains(&compared), "{compared} of 500 were not missed");
    let again = look(&missing, &[], &walker, &[], 500, 8);
    assert_eq!((again.pedestrians, again.vehicles), (b.pedestrians, b.vehicles));
}

#[test]
fn what_a_user_calls_perfect_is_nobodys_default() {
    let tried = |name: &str| {
        let plan = plan(&format!(
            r#"
            edition 1
            import "std/paper.scn"
            import "std/towns.scn"
            sensors {name} {{ range: 1 m  latency: 1 s }}
            vehicle car = model3()
            driver p = idm()
            campaign c {{
              vehicle: car  body: suicidal  spawn: ahead  episode: thirty_seconds  training: ppo_paper
              train {{ towns: harbour  drivers: p  rewards: r1  runs: 1 }}
            }}
            "#
        ));
        plan.campaigns[0].nth::<compile::Training>(0).origin.fingerprint
    };
    assert_eq!(tried("perfect"), tried("nice"));
}

/// Commands a throttle that grows by 0.01 a tick.
struct Growing(u32);

impl DrivingPolicy for Growing {
    fn reset(&mut self, _: &Perception<'_>, _: Stream) {
        self.0 = 0;
    }

    fn drive(&mut self, _: &Perception<'_>) -> Control {
        self.0 += 1;
        Control { throttle: f64::from(self.0) / 100.0, ..Control::default() }
    }

    fn mode(&self) -> DrivingMode {
        DrivingMode::Cruise
    }

    fn snapshot(&self) -> Option<Box<dyn DrivingPolicy>> {
        Some(Box::new(Self(self.0)))
    }
}

#[test]
fn commands_take_effect_after_the_actuation_delay() {
    let scenario = campaign("", "blind").campaigns[0].nth::<compile::Evaluation>(0).scenario.clone();
    let obstacles = Obstacles::new(&[]);
    let perception = Perception {
        town: &scenario.town,
        blueprint: &scenario.cast.ego().blueprint,
        tick: 0,
        dt: 0.05,
        ego: car(0.0, 0.0, 0.0),
        ground: 0.0,
        speed_limit: 8.0,
        signed_limit: None,
        route: &[],
        pedestrians: &[],
        vehicles: &[],
        obstacles: &obstacles,
        lights: &[],
        affecting_light: None,
    };
    let throttles = |driver: &mut dyn DrivingPolicy| -> Vec<u32> {
        (0..5).map(|_| (driver.drive(&perception).throttle * 100.0).round() as u32).collect()
    };
    for (delay, wanted) in [(0.0, [1, 2, 3, 4, 5]), (0.1, [0, 0, 1, 2, 3]), (0.14, [0, 0, 0, 1, 2])] {
        let mut driver = ActuationDelay::new(Box::new(Growing(0)), delay);
        driver.reset(&perception, Seed::root(1).stream());
        assert_eq!(throttles(&mut driver), wanted, "{delay} s");
        // A copy goes on from the same state, and a new episode forgets what waits.
        let mut copy = driver.snapshot().unwrap();
        assert_eq!(throttles(copy.as_mut()), throttles(&mut driver), "{delay} s");
        driver.reset(&perception, Seed::root(1).stream());
        assert_eq!(throttles(&mut driver), wanted, "{delay} s");
    }
}

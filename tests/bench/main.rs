//! `cargo bench`: the time of the parts of a campaign. Compare ratios within one run; machines are noisy.

use std::io::{BufRead, Read, Write};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::sync::Arc;

use base::seed::Seed;
use compile::Plan;
use divan::Bencher;
use divan::counter::ItemsCount;
use episode::walker::{Random, WalkPolicy};
use episode::{Draw, Outcome, PolicyMaker, Scenario, Simulation, Trace, evaluate};
use falsify::session::{Input, Session};
use learn::{ActorCritic, PpoConfig, RecordedRollout, Trainer, update_on_recorded};
use rand::RngExt;
use results::jobs::watch;
use road::LaneFilter;
use search::{PedestrianEnv, TrainingRun};
use verdict::{NearMiss, judge};
use world::sim::WalkCommand;

fn main() {
    // The benchmark of external drivers starts this binary again as a driver.
    match std::env::args().nth(1).as_deref() {
        Some("drive-json") => driver(false),
        Some("drive-binary") => driver(true),
        _ => divan::main(),
    }
}

/// One evaluation for each driving policy, in the harbour.
const SCENARIO: &str = r#"
edition 1
import "lib/paper.scn"
import "lib/drivers.scn"
import "lib/sensors.scn"
import "lib/towns.scn"
driver lav_eyed = idm(sensors: lav_eyes)
campaign bench {
  vehicle: model3  body: suicidal  spawn: ahead  episode: thirty_seconds  training: ppo_paper
  train { towns: [harbour] drivers: [behavior] rewards: [r2] runs: 1 }
  evaluate {
    towns: [harbour]  pedestrians: [random]
    drivers: [
      behavior, behavior_0_9_11, behavior_0_9_13, interfuser, lav, lav_v1, idm, blind,
      aeb, rss, predictive, oracle, late_oracle, lav_eyed
    ]
  }
}
"#;

const DRIVERS: [&str; 14] = [
    "behavior",
    "behavior_0_9_11",
    "behavior_0_9_13",
    "interfuser",
    "lav",
    "lav_v1",
    "idm",
    "blind",
    "aeb",
    "rss",
    "predictive",
    "oracle",
    "late_oracle",
    "lav_eyed",
];

fn plan() -> Plan {
    plan_of(SCENARIO)
}

fn plan_of(text: &str) -> Plan {
    let root: PathBuf = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/bench.scn");
    let (file, text) = (root.clone(), text.to_string());
    let read = move |path: &Path| if path == file { Ok(text.clone()) } else { std::fs::read_to_string(path) };
    let planned = Session::default().with_reader(read).plan(&Input::file(root));
    planned.expect("the scenario is sound").plan
}

fn scenario(policy: &str) -> Arc<Scenario> {
    let plan = plan();
    let found = plan.campaigns[0].all::<compile::Evaluation>().find(|evaluation| *evaluation.policy == *policy);
    found.expect("the policy is in the scenario").scenario.clone()
}

/// Simulator ticks: perception, driver, car, walker, contact.
#[divan::bench(args = DRIVERS, sample_count = 20)]
fn ticks(bencher: Bencher<'_, '_>, policy: &str) {
    let scenario = scenario(policy);
    let run =
        || {
            let seed = Seed::root(1);
            evaluate(&mut Random::default(), &scenario, 20, &seed, &seed.child("walker"), &mut |_| {
                ControlFlow::Continue(())
            })
        };
    let ticks: u32 = run().iter().map(|outcome| outcome.ticks).sum();
    bencher.counter(ItemsCount::new(ticks)).bench_local(run);
}

/// Ticks of one car and one pedestrian, and of four cars and twelve pedestrians, from tick 0 on: their run-ups differ.
#[divan::bench(args = ["pair", "crowd"], sample_count = 20)]
fn casts(bencher: Bencher<'_, '_>, campaign: &str) {
    let plan = plan_of(CASTS);
    let found = plan.campaigns.iter().find(|each| each.name == campaign).expect("it is one of the two");
    let scenario = &found.nth::<compile::Evaluation>(0).scenario;
    let started = |number| {
        let mut simulation = scenario.simulation();
        simulation.start(Draw::new(&Seed::root(1), number));
        simulation
    };
    let starts: Vec<_> = (0..20).map(started).collect();
    let run = || -> u32 {
        let walk = |start: &dyn Simulation| {
            let mut copy = start.snapshot().expect("its drivers can be copied");
            let (mut walker, mut commands) =
                (Random::default(), vec![WalkCommand::default(); scenario.cast.pedestrians.len()]);
            walker.begin(Seed::root(2).stream());
            while copy.outcome().is_none() {
                walker.choose(&copy.scene(), &mut commands);
                copy.carry_out(&commands);
            }
            copy.outcome().map_or(0, |outcome| outcome.ticks)
        };
        starts.iter().map(|start| walk(&**start)).sum()
    };
    bencher.counter(ItemsCount::new(run())).bench_local(run);
}

/// Two campaigns in one street.
const CASTS: &str = r#"
edition 1
import "lib/paper.scn"
import "lib/drivers.scn"
town street {
  traffic_lights: false
  street main { through: [(0 m, 0 m), (200 m, 0 m), (400 m, 0 m)]  speed_limit: 50 km/h }
}
spawn near { bearing: -60 deg .. 60 deg  distance: 7 m .. 40 m }
campaign pair {
  vehicle: model3  body: suicidal  spawn: near  episode: thirty_seconds
  evaluate { towns: [street]  drivers: [idm]  pedestrians: [random] }
}
campaign crowd {
  vehicle: model3  body: suicidal  spawn: near  episode: thirty_seconds
  cast {
    first: pedestrian()
    crowd: pedestrian(count: 11)
    behind: vehicle(driver: idm, behind: ego, gap: 1 s .. 2 s)
    front: vehicle(driver: idm, distance: 30 m .. 40 m)
    van: vehicle(distance: 12 m .. 20 m, aside: -3.2 m)
  }
  evaluate { towns: [street]  drivers: [idm]  pedestrians: [random] }
}
"#;

/// An evaluation against CARLA's agent: without analysis of its episodes, with their verdicts, and with near misses as in a
/// campaign; counted in simulator ticks.
#[divan::bench(args = ["nothing", "verdicts", "near_misses", "both"], sample_count = 20)]
fn judging(bencher: Bencher<'_, '_>, noted: &str) {
    let plan = plan();
    let evaluation = &plan.campaigns[0].nth::<compile::Evaluation>(0);
    let (judged, measured) = (noted == "verdicts" || noted == "both", noted == "near_misses" || noted == "both");
    let run = || {
        let mut note = |outcome: &Outcome, trace: &Trace| {
            let verdict = judged.then(|| judge(&trace.main_pair(&evaluation.scenario)));
            let near = measured.then(|| NearMiss::new(&trace.main_pair(&evaluation.scenario)));
            divan::black_box((verdict, near));
            outcome.ticks
        };
        watch(evaluation, None, 0..20, &Seed::root(1), &mut note, &mut |_| ControlFlow::Continue(()))
    };
    let ticks: u32 = run().iter().sum();
    bencher.counter(ItemsCount::new(ticks)).bench_local(run);
}

/// A training of twenty updates, simulator included; counted in decisions.
#[divan::bench(sample_count = 10)]
fn training(bencher: Bencher<'_, '_>) {
    let plan = plan();
    let training = &plan.campaigns[0].nth::<compile::Training>(0);
    let mut config = training.config.clone();
    config.steps = 3_000;
    bencher.counter(ItemsCount::new(3_000_u32)).bench_local(|| {
        TrainingRun::begin(&training.scenarios(), 1, &config, &Seed::root(1))
            .and_then(|run| run.carry_on(&mut |_| ControlFlow::Continue(())))
            .expect("numbers stay finite")
    });
}

/// The first half of an update: 150 decisions of a stochastic controller, with simulator, values and advantages.
#[divan::bench(sample_count = 50)]
fn rollout(bencher: Bencher<'_, '_>) {
    let plan = plan();
    let training = &plan.campaigns[0].nth::<compile::Training>(0);
    let mut envs = [PedestrianEnv::new(training.scenario.simulation(), Seed::root(1))];
    let mut trainer = Trainer::new(&mut envs, &training.config, &Seed::root(1)).expect("states are finite");
    bencher.counter(ItemsCount::new(training.config.steps_per_update)).bench_local(|| {
        trainer.collect(&mut envs, &|| false).map(drop).expect("rewards are finite");
    });
}

/// The second half: ten epochs over 150 decisions; counted in gradient steps.
#[divan::bench(sample_count = 50)]
fn update(bencher: Bencher<'_, '_>) {
    let config = PpoConfig::paper();
    let decisions = config.steps_per_update;
    let mut stream = Seed::root(1).stream();
    let mut draw = |count: usize| (0..count).map(|_| stream.random_range(-1.0..1.0)).collect::<Vec<f64>>();
    let policy = ActorCritic::new(4, 2, &config.hidden, 0.0, &mut Seed::root(2).stream());
    let rollout = RecordedRollout {
        obs: draw(4 * decisions).into_iter().map(|x| x as f32).collect(),
        actions: draw(2 * decisions),
        rewards: draw(decisions),
        episode_starts: (0..decisions).map(|step| step % 30 == 0).collect(),
        last_obs: draw(4),
        last_done: false,
    };
    let order: Vec<Vec<usize>> = vec![(0..decisions).collect(); config.epochs];
    let steps = config.epochs * decisions.div_ceil(config.batch_size);
    bencher
        .counter(ItemsCount::new(steps))
        .bench_local(|| update_on_recorded(policy.clone(), &rollout, &order, &config).expect("losses are finite"));
}

/// From the text of a scenario and its library to a plan, towns built.
#[divan::bench]
fn compilation() -> Plan {
    plan()
}

/// `falsify check` of two hundred lines as a process of its own: it loads the program, reads, checks, and builds two towns and four spawns.
///
/// The program is copied first, as an installation does. The kernel keeps a file that a linker has just written in small pieces, which
/// take longer to map.
#[divan::bench(sample_count = 200)]
fn startup(bencher: Bencher<'_, '_>) {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/bench/two_hundred_lines.scn");
    let folder = tempfile::tempdir().expect("there is room for a copy");
    let program = folder.path().join("falsify");
    std::fs::copy(env!("CARGO_BIN_EXE_falsify"), &program).expect("there is room for a copy");
    bencher.bench_local(|| {
        // Without pipes: their work belongs to the reader.
        let status = std::process::Command::new(&program).arg("check").arg(&file).stdout(Stdio::null()).status();
        assert!(status.expect("the program starts").success());
    });
}

/// The start of an episode: spawn, driver's first route.
#[divan::bench]
fn spawn(bencher: Bencher<'_, '_>) {
    let mut env = scenario("behavior").simulation();
    let mut episode = 0;
    bencher.bench_local(|| {
        env.start(Draw::new(&Seed::root(1), episode));
        episode += 1;
    });
}

/// The paper's spawn rule, written directly and as constraints, in the outline of CARLA's Town01; counted in scenes.
const SPAWNS: &str = r#"
edition 1
import "lib/paper.scn"
import "lib/drivers.scn"
import "lib/carla_towns.scn"
spawn constraints {
  bearing: -180 deg .. 180 deg
  distance: 4 m .. 1000 m
  require: [distance >= 7 m and distance <= 30 m, bearing >= -60 deg and bearing <= 60 deg]
}
campaign bench {
  vehicle: model3  body: suicidal  spawn: ahead  episode: thirty_seconds  training: ppo_paper
  train { towns: [town01_outline] drivers: [behavior] rewards: [r1] runs: 1 }
  evaluate { towns: [town01_outline] drivers: [behavior] spawn: constraints }
}
"#;

#[divan::bench(args = ["direct", "constraints"])]
fn scenes(bencher: Bencher<'_, '_>, spelling: &str) {
    let plan = plan_of(SPAWNS);
    let campaign = &plan.campaigns[0];
    let scenario = if spelling == "direct" {
        &campaign.nth::<compile::Training>(0).scenario
    } else {
        &campaign.nth::<compile::Evaluation>(0).scenario
    };
    let mut stream = Seed::root(1).stream();
    bencher.counter(ItemsCount::new(1000_u32)).bench_local(|| {
        for _ in 0..1000 {
            let first = scenario.cast.pedestrian().first_heading;
            divan::black_box(scenario.spawn.sample(&scenario.town, &scenario.obstacles, first, &mut stream));
        }
    });
}

/// The look-up that CARLA's driver needs for its decisions.
#[divan::bench]
fn nearest_lane(bencher: Bencher<'_, '_>) {
    let scenario = scenario("behavior");
    let place = scenario.town.pose(scenario.town.driving_lanes()[0].start).position();
    bencher.bench_local(|| scenario.town.nearest_lane(divan::black_box(place), LaneFilter::Any));
}

/// One world a message and many worlds, as lines of JSON and as floats. The driver is this binary itself, which answers without
/// computation (`driver` below), so this is the cost of the messages. Counted in ticks of a world.
#[divan::bench(args = ["json", "binary"], consts = [1, 8, 32, 128], sample_count = 5)]
fn external<const WORLDS: usize>(bencher: Bencher<'_, '_>, encoding: &str) {
    use world::av::external::{External, Program, Settings};
    let own = std::env::current_exe().expect("a bench has a file").display().to_string();
    let program = Program { words: vec![own, format!("drive-{encoding}")], ..Program::default() };
    let opener = Arc::new(process::ProcessOpener::default());
    let settings = Settings { worlds: WORLDS, timeout: 60.0, ..Settings::default() };
    let maker = move || -> Box<dyn world::av::DrivingPolicy> {
        Box::new(External::new(program.clone(), settings, opener.clone()))
    };
    let outside = driven_by(Arc::new(maker));
    episodes_of(bencher, &outside, 128);
}

/// A small network from an ONNX file, counted in ticks of a world.
#[divan::bench(consts = [1, 32], sample_count = 5)]
fn onnx<const WORLDS: usize>(bencher: Bencher<'_, '_>) {
    use world::av::onnx::{Model, Onnx};
    let bytes = include_bytes!("../reference/onnx/follow.onnx").to_vec();
    let model = Arc::new(Model::read(bytes, None).expect("the network drives"));
    let maker = move || -> Box<dyn world::av::DrivingPolicy> { Box::new(Onnx::new(WORLDS, model.clone())) };
    let outside = driven_by(Arc::new(maker));
    episodes_of(bencher, &outside, 32);
}

/// A scenario with another driver of the ego.
fn driven_by(policy: PolicyMaker) -> Arc<Scenario> {
    let mut scenario = Scenario::clone(&scenario("blind"));
    scenario.cast.vehicles[0].policy = policy;
    Arc::new(scenario)
}

fn episodes_of(bencher: Bencher<'_, '_>, scenario: &Arc<Scenario>, episodes: u32) {
    let run = || {
        let seed = Seed::root(1);
        evaluate(&mut Random::default(), scenario, episodes, &seed, &seed.child("walker"), &mut |_| {
            ControlFlow::Continue(())
        })
    };
    let ticks: u32 = run().iter().map(|outcome| outcome.ticks).sum();
    bencher.counter(ItemsCount::new(ticks)).bench_local(run);
}

/// Drives straight on in every world of a message.
fn driver(binary: bool) {
    let (mut input, mut output) = (std::io::stdin().lock(), std::io::stdout().lock());
    let mut line = String::new();
    input.read_line(&mut line).expect("a greeting");
    let encoding = if binary { "binary" } else { "json" };
    writeln!(output, "{{\"protocol\":\"falsify-av/1\",\"encoding\":\"{encoding}\"}}").expect("somebody listens");
    let world = 8 * (12 + 8 * 8 + 3 * 20);
    let mut length = [0; 4];
    let mut answer = Vec::new();
    loop {
        answer.clear();
        if binary {
            if input.read_exact(&mut length).is_err() {
                return;
            }
            let mut worlds = vec![0; u32::from_le_bytes(length) as usize];
            input.read_exact(&mut worlds).expect("a whole message");
            answer.extend_from_slice(&(worlds.len() as u32 / world * 32).to_le_bytes());
            for numbers in worlds.chunks(world as usize) {
                answer.extend_from_slice(&numbers[..8]);
                [0.5_f64, 0.0, 0.0].iter().for_each(|number| answer.extend_from_slice(&number.to_le_bytes()));
            }
        } else {
            line.clear();
            if input.read_line(&mut line).is_ok_and(|read| read == 0) {
                return;
            }
            let message: serde_json::Value = serde_json::from_str(&line).expect("a message");
            answer.extend_from_slice(b"{\"actions\":[");
            for (place, world) in message["worlds"].as_array().expect("worlds").iter().enumerate() {
                let comma = if place > 0 { "," } else { "" };
                write!(answer, "{comma}{{\"id\":{},\"throttle\":0.5}}", world["id"]).expect("memory");
            }
            answer.extend_from_slice(b"]}\n");
        }
        output.write_all(&answer).and_then(|()| output.flush()).expect("somebody listens");
    }
}

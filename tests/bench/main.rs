//! `cargo bench`: what a campaign spends its time on. Compare ratios within one run; machines are noisy.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use divan::Bencher;
use divan::counter::ItemsCount;
use falsify::compile::{Catalog, Plan, compile};
use falsify::diagnostic::Sources;
use falsify::env::{PedestrianEnv, Scenario};
use falsify::falsifier::{Random, train, try_walker};
use falsify::rl::{ActorCritic, PpoConfig, RecordedRollout, Trainer, update_on_recorded};
use falsify::road::LaneFilter;
use falsify::seed::Seed;
use rand::RngExt;

fn main() {
    divan::main();
}

/// One evaluation for each driving policy, in the harbour.
const SCENARIO: &str = r#"
edition 1
import "lib/paper.scn"
import "lib/drivers.scn"
import "lib/sensors.scn"
import "lib/towns.scn"
policy lav_eyed = idm(sensors: lav_eyes)
campaign bench {
  vehicle: model3  adversary: suicidal  spawn: ahead  episode: thirty_seconds  training: ppo_paper
  train { towns: [harbour] policies: [behavior] rewards: [r2] runs: 1 }
  evaluate {
    towns: [harbour]  pedestrians: [random]
    policies: [
      behavior, behavior_0_9_11, behavior_0_9_13, interfuser, lav, lav_v1, careful, blind,
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
    "careful",
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
    let read = |path: &Path| if path == root { Ok(text.to_string()) } else { std::fs::read_to_string(path) };
    let compiled = compile(std::slice::from_ref(&root), &Catalog::builtin(), &read, &mut Sources::default());
    compiled.expect("the library can be read").plan.expect("the scenario is sound")
}

fn scenario(policy: &str) -> Arc<Scenario> {
    let plan = plan();
    let found = plan.campaigns[0].evaluations.iter().find(|evaluation| evaluation.policy == policy);
    found.expect("the policy is in the scenario").scenario.clone()
}

/// Simulator ticks: perception, driver, car, walker, contact.
#[divan::bench(args = DRIVERS, sample_count = 20)]
fn ticks(bencher: Bencher<'_, '_>, policy: &str) {
    let scenario = scenario(policy);
    let run = || {
        let seed = Seed::root(1);
        try_walker(&mut Random::default(), &scenario, 20, &seed, &seed.child("walker"), &mut |_| {
            ControlFlow::Continue(())
        })
    };
    let ticks: u32 = run().iter().map(|outcome| outcome.ticks).sum();
    bencher.counter(ItemsCount::new(ticks)).bench_local(run);
}

/// A training of twenty updates, simulator included; counted in decisions.
#[divan::bench(sample_count = 10)]
fn training(bencher: Bencher<'_, '_>) {
    let plan = plan();
    let training = &plan.campaigns[0].trainings[0];
    let mut config = training.config.clone();
    config.total_steps = 3_000;
    bencher.counter(ItemsCount::new(3_000_u32)).bench_local(|| {
        train(&training.scenario, 1, &config, &Seed::root(1), &mut |_| ControlFlow::Continue(()))
            .expect("numbers stay finite")
    });
}

/// The first half of an update: 150 decisions of a sampling pedestrian, simulator, values and advantages included.
#[divan::bench(sample_count = 50)]
fn rollout(bencher: Bencher<'_, '_>) {
    let plan = plan();
    let training = &plan.campaigns[0].trainings[0];
    let mut envs = [PedestrianEnv::new(training.scenario.clone(), Seed::root(1))];
    let mut trainer = Trainer::new(&mut envs, &training.config, &Seed::root(1)).expect("states are finite");
    bencher.counter(ItemsCount::new(training.config.rollout_steps)).bench_local(|| {
        trainer.collect(&mut envs).map(drop).expect("rewards are finite");
    });
}

/// The second half: ten epochs over 150 decisions; counted in gradient steps.
#[divan::bench(sample_count = 50)]
fn update(bencher: Bencher<'_, '_>) {
    let config = PpoConfig::paper();
    let decisions = config.rollout_steps;
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

/// The beginning of an episode: spawn, driver's first route.
#[divan::bench]
fn spawn(bencher: Bencher<'_, '_>) {
    let mut env = PedestrianEnv::new(scenario("behavior"), Seed::root(1));
    let mut episode = 0;
    bencher.bench_local(|| {
        env.begin(episode);
        episode += 1;
    });
}

/// The paper's spawn rule, spelt directly and as constraints, in the outline of CARLA's Town01; counted in scenes.
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
  vehicle: model3  adversary: suicidal  spawn: ahead  episode: thirty_seconds  training: ppo_paper
  train { towns: [town01_outline] policies: [behavior] rewards: [r1] runs: 1 }
  evaluate { towns: [town01_outline] policies: [behavior] spawn: constraints }
}
"#;

#[divan::bench(args = ["direct", "constraints"])]
fn scenes(bencher: Bencher<'_, '_>, spelling: &str) {
    let plan = plan_of(SPAWNS);
    let campaign = &plan.campaigns[0];
    let scenario =
        if spelling == "direct" { &campaign.trainings[0].scenario } else { &campaign.evaluations[0].scenario };
    let mut stream = Seed::root(1).stream();
    bencher.counter(ItemsCount::new(1000_u32)).bench_local(|| {
        for _ in 0..1000 {
            let first = scenario.adversary.first_heading;
            divan::black_box(scenario.spawn.sample(&scenario.town, &scenario.obstacles, first, &mut stream));
        }
    });
}

/// The look-up on which CARLA's driver's decisions hang.
#[divan::bench]
fn nearest_lane(bencher: Bencher<'_, '_>) {
    let scenario = scenario("behavior");
    let place = scenario.town.pose(scenario.town.driving_lanes()[0].start).position();
    bencher.bench_local(|| scenario.town.nearest_lane(divan::black_box(place), LaneFilter::Any));
}

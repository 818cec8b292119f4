//! A car that learns to drive: what it sees, what its network does elsewhere, and that its training is repeatable and of use.

use std::path::Path;
use std::sync::Arc;

use base::diagnostic::Sources;
use base::seed::Seed;
use compile::{Catalog, Plan, Training, compile};
use episode::{Draw, Phase, Scenario, Simulation};
use learn::{ActorCritic, Env, Trained};
use search::TrainingRun;
use search::driving::{ACTION_BOUNDS, ACTION_SCALES, DriveEnv, inputs};
use world::av::onnx::{Model, Onnx};

use crate::program::{error, falsify};

const SCENARIO: &str = r#"
edition 1
import "lib/pedestrians.scn"
import "lib/drivers.scn"
import "lib/towns.scn"
spawn near { distance: 10 m .. 30 m }
episode short { ticks: 60  hold: 10 }
training quick = ppo(steps: 900, steps_per_update: 150, epochs: 2, batch_size: 128, environments: 3, initial_log_std: -3, hidden: [24])
campaign driving {
  vehicle: model3  body: plausible  spawn: near  episode: short  training: quick
  drive { towns: [harbour, village]  imitates: idm  KEYS }
}
"#;

fn plan(keys: &str) -> Plan {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/driving.scn");
    let text = SCENARIO.replace("KEYS", keys);
    let read = |path: &Path| if path == root { Ok(text.clone()) } else { std::fs::read_to_string(path) };
    let compiled = compile(std::slice::from_ref(&root), &Catalog::builtin(), &read, &mut Sources::default()).unwrap();
    compiled.plan.unwrap_or_else(|| panic!("{:?}", compiled.diagnostics))
}

/// A folder with the scenario as `it.scn`.
fn written(keys: &str) -> tempfile::TempDir {
    let place = tempfile::tempdir().unwrap();
    let library = format!("\"{}/scenarios/lib/", env!("CARGO_MANIFEST_DIR"));
    std::fs::write(place.path().join("it.scn"), SCENARIO.replace("KEYS", keys).replace("\"lib/", &library)).unwrap();
    place
}

fn begin(training: &Training) -> TrainingRun {
    let rule = training.drive.as_ref().unwrap();
    let (environments, config) = (training.config.environments, &training.config);
    TrainingRun::begin_driving(&training.scenarios(), rule, environments, config, &Seed::root(4), &|_| false).unwrap()
}

fn trained(training: &Training, threads: usize) -> Trained {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    pool.install(|| begin(training).carry_on(&mut |_| std::ops::ControlFlow::Continue(()))).unwrap()
}

/// The scenario with a network from its file as the driver.
fn driven_by(networks: &ActorCritic, scenario: &Scenario) -> Arc<Scenario> {
    let bytes = networks.to_onnx_with(&inputs(), &ACTION_SCALES, &ACTION_BOUNDS, &Default::default());
    let model = Arc::new(Model::read(bytes, None).unwrap());
    let mut scenario = scenario.clone();
    scenario.cast.vehicles[0].policy = Arc::new(move || Box::new(Onnx::new(1, model.clone())));
    Arc::new(scenario)
}

/// Lets a network drive as a learner and as a driver from its file along the same run-up; returns both ways, tick by tick.
fn ways(networks: &ActorCritic, training: &Training, ticks: usize) -> [Vec<[f64; 2]>; 2] {
    let seed = Seed::root(9);
    let scenario = &training.scenarios()[1];
    let mut learner = DriveEnv::new(scenario, training.drive.as_ref().unwrap(), &seed);
    let mut driver = driven_by(networks, scenario).simulation();
    driver.place(Draw::new(&seed, 0));
    let mut obs = vec![0.0; learner.obs_dim()];
    learner.reset(&mut obs);
    let (mut action, mut scratch) = ([0.0; 2], networks.scratch(1));
    let mut ways = [Vec::new(), Vec::new()];
    let bounds = learner.action_bounds();
    for _ in 0..ticks {
        networks.act(&obs, &mut action, &mut scratch);
        for (number, (low, high)) in action.iter_mut().zip(&bounds) {
            *number = number.clamp(*low, *high);
        }
        assert!(!learner.step(&action, &mut obs).done());
        driver.tick();
        assert_eq!(learner.simulation().phase(), driver.phase());
        if driver.phase() != Phase::RunUp {
            break;
        }
        for (way, simulation) in ways.iter_mut().zip([learner.simulation(), &*driver]) {
            let ego = &simulation.scene().world.ego().state;
            way.push([ego.pose.x, ego.pose.y]);
        }
    }
    ways
}

#[test]
fn a_network_sees_and_does_in_its_file_what_it_saw_and_did_in_its_training() {
    let plan = plan("hold: 1  cars: 0  demonstrations: 15_000");
    let training = &plan.campaigns[0].nth::<Training>(0);
    let networks = trained(training, 1).policies.remove(0);
    let [learner, driver] = ways(&networks, training, 120);
    let far = learner[0].iter().zip(learner[learner.len() - 1]).map(|(a, b)| (a - b).abs()).sum::<f64>();
    assert!(learner.len() > 40 && far > 10.0, "it drives: {far} m in {} ticks", learner.len());
    // Both differ by the rounding of a hyperbolic tangent, which the road does not amplify.
    for (tick, (a, b)) in learner.iter().zip(&driver).enumerate() {
        assert!((a[0] - b[0]).abs() + (a[1] - b[1]).abs() < 1e-3, "tick {tick}: {a:?} and {b:?}");
    }
}

#[test]
fn copies_of_one_start_that_take_turns_do_not_get_each_others_answers() {
    let plan = plan("hold: 1  cars: 0  demonstrations: 0");
    let training = &plan.campaigns[0].nth::<Training>(0);
    let learner = DriveEnv::new(&training.scenarios()[1], training.drive.as_ref().unwrap(), &Seed::root(9));
    let networks = learn::first_networks(&learner.agents(), &training.config, &Seed::root(1));
    let mut start = driven_by(&networks[0], &training.scenarios()[1]).simulation();
    start.place(Draw::new(&Seed::root(9), 0));
    let copies = || [start.snapshot().unwrap(), start.snapshot().unwrap()];
    let [mut alone, _] = copies();
    let [mut one, mut other] = copies();
    one.prepare();
    for _ in 0..40 {
        other.prepare();
        one.tick();
        one.prepare();
        other.tick();
        alone.tick();
        let place = |simulation: &dyn Simulation| simulation.scene().world.ego().state;
        assert_eq!(place(&*other), place(&*alone));
    }
}

#[test]
fn threads_and_interruptions_change_no_bit() {
    let plan = plan("hold: 2  cars: 2  demonstrations: 2_000");
    let training = &plan.campaigns[0].nth::<Training>(0);
    let one = trained(training, 1);
    assert_eq!(trained(training, 2).to_safetensors(), one.to_safetensors());
    let mut run = begin(training);
    run.update().unwrap();
    let state = run.state(&Default::default());
    let rule = training.drive.as_ref().unwrap();
    let (environments, config) = (training.config.environments, &training.config);
    let resume = |seed| TrainingRun::resume(&state, &training.scenarios(), Some(rule), environments, config, &seed);
    let resumed = resume(Seed::root(4)).unwrap().carry_on(&mut |_| std::ops::ControlFlow::Continue(())).unwrap();
    assert_eq!(resumed.to_safetensors(), one.to_safetensors());
}

#[test]
fn imitating_drivers_drive_better() {
    let first = |keys: &str| {
        let curve = trained(plan(keys).campaigns[0].nth::<Training>(0), 1).learning_curve;
        curve.last().unwrap().mean_reward.unwrap()
    };
    let (without, with) = (first("demonstrations: 0"), first("demonstrations: 15_000"));
    assert!(with > without + 0.5, "{with} against {without}");
}

#[test]
fn a_report_has_a_driver_that_drives() {
    let place = written("runs: 2");
    let output = falsify(&["run", "--smoke", "it.scn", "--out", "."], place.path());
    assert!(output.status.success(), "{}", error(&output));
    let file = place.path().join("driving-smoke/drivers/harbour+village-idm-0.onnx");
    Model::read(std::fs::read(file).unwrap(), None).unwrap();
}

#[test]
fn a_drivers_training_sees_one_state_at_a_time() {
    let said = error(&falsify(&["check", "it.scn", "--set", "quick.frame_stack=2"], written("").path()));
    assert!(said.contains("frame_stack: 1"), "{said}");
}

#[test]
fn demonstrations_count_as_decisions_and_ticks() {
    let place = written("demonstrations: 4_000");
    let listed = falsify(&["run", "--list", "it.scn"], place.path());
    assert!(String::from_utf8_lossy(&listed.stdout).contains("4900 decisions"), "{listed:?}");
    let said = error(&falsify(&["run", "--max-ticks", "3000", "it.scn"], place.path()));
    assert!(said.contains("not finished within the 3000 ticks"), "{said}");
}

#[test]
fn an_imitation_can_be_stopped() {
    let plan = plan("demonstrations: 4_000");
    let training = plan.campaigns[0].nth::<Training>(0);
    let (rule, environments) = (training.drive.as_ref().unwrap(), training.config.environments);
    let begin = |watch: &(dyn Fn(f64) -> bool + Sync)| {
        TrainingRun::begin_driving(&training.scenarios(), rule, environments, &training.config, &Seed::root(4), watch)
    };
    let heard = std::sync::Mutex::new(Vec::new());
    let hear = |share| heard.lock().unwrap().push(share);
    let begun = begin(&|share| {
        hear(share);
        share > 0.5
    });
    assert!(begun.err().is_some_and(|error| error.is_stopped()));
    assert!(heard.lock().unwrap().iter().any(|share| *share < 0.1));
    heard.lock().unwrap().clear();
    let begun = begin(&|share| {
        hear(share);
        false
    });
    assert!(begun.is_ok());
    assert_eq!(heard.lock().unwrap().last(), Some(&1.0));
}

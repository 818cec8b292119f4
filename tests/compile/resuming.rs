//! A real training: interrupted, continued on other threads, and used in an evaluation.

use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::path::Path;
use std::slice::from_ref;

use base::diagnostic::Sources;
use base::seed::Seed;
use compile::{Catalog, Plan, compile};
use episode::ObservationSpec;
use episode::walker::{ActionMode, Intercept, TrainedWalker, WalkPolicy};
use learn::{ActorCritic, CheckpointError, Env, FrameStack, Trained};
use search::{PedestrianEnv, TrainingRun};
use world::sim::WalkCommand;

/// Short episodes with drivers that have memory and drivers that draw random numbers; settings of both kinds.
const SCENARIO: &str = r#"
edition 1
import "lib/paper.scn"
import "lib/drivers.scn"
import "lib/towns.scn"
training plain = ppo(steps: 360, steps_per_update: 30, epochs: 2, environments: 3)
training rich = ppo(steps: 360, steps_per_update: 30, epochs: 2, environments: 3, frame_stack: 3, normalize_observations: true,
                    normalize_rewards: true, learning_rate_schedule: linear, target_kl: 0.05)
campaign plain {
  vehicle: model3  body: suicidal  spawn: ahead  episode: thirty_seconds  training: plain
  train { towns: [harbour] drivers: [behavior, idm] rewards: [r2] runs: 1 }
}
reward led {
  potential: -distance / 30 m
  on touch(front) => max(3, 1.5 * v_c in m/s)
}
campaign rich {
  vehicle: model3  body: suicidal  spawn: ahead  episode: thirty_seconds  training: rich
  train { towns: [harbour] drivers: [behavior, idm] rewards: [led] runs: 1 }
}
training copied = ppo(steps: 360, steps_per_update: 30, epochs: 2, environments: 3, starts: 5, hard_starts: 0.5,
                      normalize_observations: true)
spawn ahead_of_a_moving_car { bearing: -60 deg .. 60 deg  distance: 7 m .. 40 m }
campaign copied {
  vehicle: model3  body: suicidal  spawn: ahead_of_a_moving_car  episode: thirty_seconds  training: copied
  train { towns: [harbour] drivers: [behavior, idm] rewards: [r2] runs: 1 }
}
"#;

fn plan() -> Plan {
    let root = crate::repository().join("scenarios/resuming.scn");
    let read = |path: &Path| if path == root { Ok(SCENARIO.to_string()) } else { std::fs::read_to_string(path) };
    let compiled = compile(from_ref(&root), &Catalog::builtin(), &read, &mut Sources::default()).unwrap();
    compiled.plan.unwrap_or_else(|| panic!("{:?}", compiled.diagnostics))
}

#[test]
fn a_real_training_continues_bit_for_bit_after_any_update() {
    let (seed, none) = (Seed::root(3), BTreeMap::new());
    for training in plan().campaigns.iter().flat_map(|campaign| campaign.all::<compile::Training>()) {
        let (scenario, envs, config) = (&training.scenario, training.config.environments, &training.config);
        // The state before the first update and after each update.
        let run = TrainingRun::begin(from_ref(scenario), envs, config, &seed).unwrap();
        let mut states = vec![run.state(&none)];
        let whole = run.carry_on(&mut |run| {
            states.push(run.state(&none));
            ControlFlow::Continue(())
        });
        let whole = whole.unwrap();
        assert_eq!(whole.learning_curve.len(), 4);
        assert_eq!(Trained::from_safetensors(&whole.to_safetensors()).unwrap(), whole);
        assert_eq!(states.len(), 5);
        assert_eq!(
            TrainingRun::begin(from_ref(scenario), envs, config, &seed)
                .and_then(|run| run.carry_on(&mut |_| ControlFlow::Continue(())))
                .unwrap(),
            whole
        );
        for (updates, state) in states.iter().enumerate() {
            let resumed = TrainingRun::resume(state, from_ref(scenario), None, envs, config, &seed).unwrap();
            assert_eq!(&resumed.state(&none), state, "a state survives being read");
            let mut later = Vec::new();
            let end = resumed.carry_on(&mut |run| {
                later.push(run.state(&none));
                ControlFlow::Continue(())
            });
            assert_eq!(end.unwrap(), whole, "{} after {updates} updates", training.key.policy);
            assert_eq!(later, states[updates + 1..], "{} after {updates} updates", training.key.policy);
        }
    }
}

#[test]
fn a_state_is_refused_where_its_episodes_lead_elsewhere() {
    let plan = plan();
    let behavior = &plan.campaigns[0].nth::<compile::Training>(0);
    let mut run = TrainingRun::begin(from_ref(&behavior.scenario), 3, &behavior.config, &Seed::root(3)).unwrap();
    run.update().unwrap();
    let state = run.state(&BTreeMap::new());
    let other_seed =
        TrainingRun::resume(&state, from_ref(&behavior.scenario), None, 3, &behavior.config, &Seed::root(4));
    assert!(matches!(other_seed, Err(CheckpointError::Env { env: 0 })), "{other_seed:?}");
    let rich = &plan.campaigns[1].nth::<compile::Training>(0).config;
    let other_settings = TrainingRun::resume(&state, from_ref(&behavior.scenario), None, 3, rich, &Seed::root(3));
    assert!(matches!(&other_settings, Err(CheckpointError::Settings { .. })), "{other_settings:?}");
}

/// The state of the only pedestrian.
fn state(env: &PedestrianEnv) -> [f64; ObservationSpec::DIM] {
    let mut state = [0.0; ObservationSpec::DIM];
    env.simulation().scene().write_state(&mut state);
    state
}

#[test]
fn an_environment_goes_back_to_any_decision_of_an_episode() {
    let plan = plan();
    let trainings: Vec<&compile::Training> = plan.campaigns[0].all().collect();
    for (training, other_driver) in [(&trainings[0], &trainings[1]), (&trainings[1], &trainings[0])] {
        let make = || PedestrianEnv::new(training.scenario.simulation(), Seed::root(9));
        let mut elsewhere = PedestrianEnv::new(other_driver.scenario.simulation(), Seed::root(9));
        let (mut env, mut walker, mut refused) = (make(), Intercept, 0);
        assert!(make().load(&env.save().unwrap()), "an environment before its first episode");
        for episode in 0..4 {
            env.begin(episode);
            walker.begin(Seed::root(1).index(episode).stream());
            while env.simulation().outcome().is_none() {
                let saved = env.save().unwrap();
                let mut other = make();
                assert!(other.load(&saved));
                assert_eq!(other.save().unwrap(), saved);
                assert!(!make().load(&saved[..saved.len() - 1]), "a damaged state");
                assert_eq!(state(&other).map(f64::to_bits), state(&env).map(f64::to_bits));
                for env in [&mut env, &mut other] {
                    let mut commands = [WalkCommand::default()];
                    walker.choose(&env.simulation().scene(), &mut commands);
                    env.carry_out(&commands);
                }
                assert_eq!(other.save(), env.save());
                assert_eq!(other.simulation().outcome(), env.simulation().outcome());
                refused += u32::from(!elsewhere.load(&saved));
            }
        }
        assert!(refused > 0, "another driver drives alike");
    }
}

#[test]
fn threads_within_a_training_change_nothing() {
    let plan = plan();
    for campaign in &plan.campaigns {
        let training = &campaign.nth::<compile::Training>(0);
        let at = |workers: usize, threads: Option<usize>| -> Trained {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(workers).build().unwrap();
            let config = learn::PpoConfig { threads, ..training.config.clone() };
            let begin = || TrainingRun::begin(from_ref(&training.scenario), 5, &config, &Seed::root(2));
            pool.install(|| begin().and_then(|run| run.carry_on(&mut |_| ControlFlow::Continue(()))).unwrap())
        };
        let one = at(1, Some(1));
        for (workers, threads) in [(1, None), (4, Some(1)), (4, Some(2)), (4, Some(3)), (4, None), (2, Some(64))] {
            assert_eq!(at(workers, threads), one, "{workers} workers, {threads:?}");
        }
    }
}

#[test]
fn a_trained_walker_sees_stacked_and_normalised_states() {
    let plan = plan();
    let training = &plan.campaigns[1].nth::<compile::Training>(0);
    let begun = TrainingRun::begin(from_ref(&training.scenario), 3, &training.config, &Seed::root(2)).unwrap();
    let trained = begun.carry_on(&mut |_| ControlFlow::Continue(())).unwrap();
    assert_eq!(trained.policies[0].obs_dim(), 3 * ObservationSpec::DIM);
    assert!(trained.policies[0].observation_moments().is_some());
    // The value after it is read back from a file.
    let bytes = trained.policies[0].to_safetensors(&BTreeMap::new());
    let (policy, _) = ActorCritic::from_safetensors(&bytes).unwrap();
    let mut walker = TrainedWalker::new(vec![policy], &training.scenario.cast, ActionMode::Deterministic);
    let mut env = PedestrianEnv::new(training.scenario.simulation(), Seed::root(5));
    let (mut stack, mut scratch) = (FrameStack::new(4, 3), trained.policies[0].scratch(1));
    for episode in 0..3 {
        env.begin(episode);
        walker.begin(Seed::root(1).stream());
        stack.begin(&state(&env));
        while env.simulation().outcome().is_none() {
            let mut action = [0.0; 2];
            trained.policies[0].act(stack.as_slice(), &mut action, &mut scratch);
            let bounds = env.simulation().scene().bounds();
            let clamped = [0, 1].map(|i| action[i].clamp(bounds[i].0, bounds[i].1));
            let mut commands = [WalkCommand::default(); 2];
            let (chosen, wanted) = commands.split_at_mut(1);
            walker.choose(&env.simulation().scene(), chosen);
            env.simulation().scene().write_commands(&clamped, wanted);
            assert_eq!(chosen, wanted);
            env.carry_out(chosen);
            stack.push(&state(&env));
        }
    }
}

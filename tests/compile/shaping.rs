//! Shaping in the pedestrian's world: it guides the learner and changes nothing else.

use std::ops::ControlFlow;
use std::path::Path;

use base::diagnostic::Sources;
use base::seed::Seed;
use compile::{Catalog, Training, compile};
use learn::{Env, shaping};
use rand::RngExt;
use search::{PedestrianEnv, TrainingRun};

/// Rewards with and without a potential.
const SCENARIO: &str = r#"
edition 1
import "lib/paper.scn"
import "lib/drivers.scn"
import "lib/towns.scn"
reward plain { on touch => 1  on step => -0.01 }
reward zero { potential: 0 * distance / 1 m  on touch => 1  on step => -0.01 }
reward shaped {
  potential: -distance / 30 m - miss_distance / 10 m + 0.1 * elapsed in s
  on touch => 1
  on step => -0.01
}
training short = ppo(steps: 300, steps_per_update: 100, epochs: 2, environments: 2)
episode ten_seconds { ticks: 200 }
campaign c {
  vehicle: model3  body: suicidal  spawn: ahead  episode: ten_seconds  training: short
  train { towns: [harbour] drivers: [behavior] rewards: [plain, zero, shaped] runs: 1 }
}
"#;

fn trainings() -> Vec<Training> {
    let root = crate::repository().join("scenarios/shaping.scn");
    let read = |path: &Path| if path == root { Ok(SCENARIO.to_string()) } else { std::fs::read_to_string(path) };
    let compiled = compile(std::slice::from_ref(&root), &Catalog::builtin(), &read, &mut Sources::default()).unwrap();
    let plan = compiled.plan.unwrap_or_else(|| panic!("{:?}", compiled.diagnostics));
    plan.campaigns[0].all::<compile::Training>().cloned().collect()
}

#[test]
fn whatever_the_pedestrian_does_a_terminated_episode_earns_the_potential_of_its_start() {
    let all = trainings();
    let (plain, shaped) = (&all[0].scenario, &all[2].scenario);
    let seed = Seed::root(5);
    let mut envs = [plain, shaped].map(|scenario| PedestrianEnv::new(scenario.simulation(), seed));
    let (mut terminated, mut cut) = (0, 0);
    for episode in 0..60 {
        let mut stream = seed.child("acts").index(episode).stream();
        let mut state = [0.0; 4];
        envs.iter_mut().for_each(|env| env.reset(&mut state));
        let [plain, shaped] = &mut envs;
        assert_eq!(plain.potential(), 0.0);
        let (begin, gamma) = (shaped.potential(), 0.98);
        let (mut before, mut discount, mut sum) = (begin, 1.0, 0.0);
        assert!(begin < -7.0 / 30.0);
        loop {
            // One in two walks at the car, so that many reach it.
            let action = match episode % 2 {
                0 => [0.0, 3.5],
                _ => [stream.random_range(-3.0..3.0), stream.random_range(0.0..3.5)],
            };
            let step = shaped.step(&action, &mut state);
            assert_eq!(plain.step(&action, &mut state), step, "the reward itself is not shaped");
            let after = shaped.potential();
            sum += discount * shaping(before, after, step, gamma);
            (before, discount) = (after, discount * gamma);
            if step.terminated {
                terminated += 1;
                assert!((sum + begin).abs() < 1e-12, "{sum} {begin}");
            } else if step.truncated {
                cut += 1;
                assert!((sum + begin - discount * after).abs() < 1e-12);
            }
            if step.done() {
                assert_eq!(plain.simulation().outcome(), shaped.simulation().outcome());
                break;
            }
        }
    }
    assert!(terminated > 10 && cut > 5, "{terminated} {cut}");
}

#[test]
fn a_potential_changes_what_is_learnt_and_not_what_is_reported() {
    let trained: Vec<_> = trainings()[..3]
        .iter()
        .map(|it| {
            let begun =
                TrainingRun::begin(&it.scenarios(), it.config.environments, &it.config, &Seed::root(3)).unwrap();
            begun.carry_on(&mut |_| ControlFlow::Continue(())).unwrap()
        })
        .collect();
    assert_eq!(trained[0], trained[1], "a potential of 0 is none");
    assert_ne!(trained[0].policies[0], trained[2].policies[0]);
    // Ten decisions at most, each worth −0.01, and 1 for a hit; the potential alone would be worth more.
    let rewards = trained[2].learning_curve.iter().flat_map(|log| &log.finished).map(|episode| episode.reward);
    assert!(rewards.clone().count() > 10 && rewards.clone().all(|reward| (-0.1 - 1e-9..=1.0).contains(&reward)));
    // The first rollout is of the same policy, with the same episodes.
    assert_eq!(trained[0].learning_curve[0].finished, trained[2].learning_curve[0].finished);
}

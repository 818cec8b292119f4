//! The whole chain learns: text → scenario → training → evaluation.

use std::ops::ControlFlow;
use std::path::Path;

use base::diagnostic::Sources;
use base::seed::Seed;
use compile::{Catalog, ControllerKind, compile};
use episode::walker::{ActionMode, Random, TrainedWalker, WalkPolicy};
use episode::{Outcome, evaluate};
use search::{TrainingRun, first_networks};

const SCENARIO: &str = r#"
edition 1
import "lib/paper.scn"
import "lib/drivers.scn"
import "lib/towns.scn"
training half = ppo(steps: 30_000)
campaign learning {
  vehicle: plain_car  body: suicidal  spawn: ahead  episode: thirty_seconds  training: half
  train { towns: [harbour] drivers: [idm] rewards: [r1] runs: 1 }
  evaluate { towns: [harbour] drivers: [idm] pedestrians: [trained, untrained] }
}
"#;

#[test]
fn a_trained_pedestrian_hits_a_careful_car_far_more_often_than_a_random_one() {
    let root = crate::repository().join("scenarios/learning.scn");
    let read = |path: &Path| if path == root { Ok(SCENARIO.to_string()) } else { std::fs::read_to_string(path) };
    let compiled = compile(std::slice::from_ref(&root), &Catalog::builtin(), &read, &mut Sources::default()).unwrap();
    let plan = compiled.plan.unwrap();
    let (training, evaluation) =
        (&plan.campaigns[0].nth::<compile::Training>(0), &plan.campaigns[0].nth::<compile::Evaluation>(0));
    assert_eq!((&evaluation.controller, evaluation.origin.needs), (&ControllerKind::Trained, Some(0)));
    let begun = TrainingRun::begin(&training.scenarios(), 1, &training.config, &Seed::root(3)).unwrap();
    let trained = begun.carry_on(&mut |_| ControlFlow::Continue(())).unwrap();
    let rate = |walker: &mut dyn WalkPolicy| {
        let (episodes, own) = (Seed::root(4), Seed::root(5));
        let outcomes = evaluate(walker, &evaluation.scenario, 200, &episodes, &own, &mut |_| ControlFlow::Continue(()));
        outcomes.iter().filter(|outcome: &&Outcome| outcome.is_touch()).count()
    };
    let cast = &evaluation.scenario.cast;
    let learnt = rate(&mut TrainedWalker::new(trained.policies, cast, ActionMode::Deterministic));
    let random = rate(&mut Random::default());
    assert!(learnt > 120 && random < 40, "{learnt} and {random} of 200");
    let first = plan.campaigns[0].nth::<compile::Evaluation>(1).first.as_deref().unwrap();
    let networks = first_networks(&evaluation.scenario.cast, &first.config, &Seed::root(3));
    let begun = TrainingRun::begin(&training.scenarios(), 1, &training.config, &Seed::root(3)).unwrap();
    assert_eq!(networks, begun.finish().policies, "the untrained network is the one with which the training begins");
    let untrained = rate(&mut TrainedWalker::new(networks, cast, ActionMode::Deterministic));
    assert!(untrained < 60, "{untrained} of 200");
}

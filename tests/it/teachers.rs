//! Trainings that begin with the finds of a falsifier.

use std::collections::BTreeMap;
use std::path::Path;
use std::slice::from_ref;

use base::diagnostic::Sources;
use base::seed::Seed;
use compile::{Catalog, Plan, Training, compile};
use learn::ActorCritic;
use world::falsifier::{Lesson, TrainError, TrainingRun, first_networks};

/// A campaign with one training, which has these keys in addition, and a search with a falsifier that trains by it.
fn compiled(keys: &str) -> Result<Plan, Vec<String>> {
    let text = format!(
        "edition 1\nimport \"lib/paper.scn\"\nimport \"lib/pedestrians.scn\"\nimport \"lib/rewards.scn\"\nimport \"lib/drivers.scn\"\nimport \"lib/towns.scn\"\n\
         spawn near {{ bearing: -60 deg .. 60 deg  distance: 7 m .. 20 m  ego_speed: 6 m/s }}\n\
         reward nothing {{ on hit => 0 }}\n\
         falsifier hits = archive(reward: r1)\n\
         falsifier none = archive(reward: nothing)\n\
         falsifier learner = ppo(reward: r1, training: taught)\n\
         training taught = ppo(steps: 60, steps_per_update: 20, epochs: 1, normalize_observations: true, {keys})\n\
         campaign c {{ vehicle: model3 adversary: pursuer spawn: near episode: brief training: taught\n\
         train {{ towns: [harbour, village] policies: [blind] rewards: [r1] runs: 1 together: all }}\n\
         search {{ towns: [harbour] policies: [blind] falsifiers: [learner] budget: 1_000 runs: 1 }} }}\n\
         episode brief {{ ticks: 160  hold: 10  end_when: ahead < -6 m }}\n"
    );
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/taught.scn");
    let read = |path: &Path| if path == root { Ok(text.clone()) } else { std::fs::read_to_string(path) };
    let compiled = compile(from_ref(&root), &Catalog::builtin(), &read, &mut Sources::default()).expect("readable");
    compiled.plan.ok_or(compiled.diagnostics.into_iter().map(|each| each.message).collect())
}

fn training(keys: &str) -> Training {
    compiled(keys).unwrap_or_else(|said| panic!("{said:?}")).campaigns.remove(0).trainings.remove(0)
}

fn seed() -> Seed {
    Seed::root(4)
}

fn begun(training: &Training, stop: bool) -> Result<(TrainingRun, Lesson), TrainError> {
    let teacher = training.teacher.as_ref().expect("it has a teacher");
    let (places, config) = (training.scenarios(), &training.config);
    TrainingRun::begin_taught(teacher, &places, training.environments, config, &seed(), &|| stop)
}

/// The networks at the end.
fn ended(mut run: TrainingRun) -> ActorCritic {
    while !run.is_done() {
        run.update().expect("it learns");
    }
    run.finish().actor_critic
}

#[test]
fn a_training_begins_where_the_teacher_left_it_and_goes_on() {
    let first = training("teacher: hits, teacher_ticks: 6_000");
    let cloned = first.clone();
    let (run, lesson) = begun(&first, false).expect("it is taught");
    assert!(lesson.imitated > 5 && lesson.imitated <= lesson.failures && lesson.ticks <= 12_000, "{lesson:?}");
    let networks = ended(run);
    // Again, and with an interruption; the saved state needs no teacher.
    let (mut run, again) = begun(&cloned, false).expect("it is taught");
    assert_eq!(again, lesson);
    run.update().expect("it learns");
    let state = run.state(&BTreeMap::new());
    let (places, environments) = (cloned.scenarios(), cloned.environments);
    let run = TrainingRun::resume(&state, &places, environments, &cloned.config, &seed()).expect("it continues");
    assert_eq!(ended(run), networks);
    let (run, _) = begun(&cloned, false).expect("it is taught");
    let drawn = first_networks(&cloned.scenario.cast, &cloned.config, &seed());
    assert_ne!(run.finish().actor_critic, drawn);
}

#[test]
fn a_teacher_that_finds_nothing_leaves_a_plain_training() {
    let plain = training("");
    assert!(plain.teacher.is_none());
    let run = TrainingRun::begin(&plain.scenarios(), plain.environments, &plain.config, &seed()).expect("it begins");
    let (taught, lesson) = begun(&training("teacher: none, teacher_ticks: 3_000"), false).expect("it begins");
    assert!(lesson.imitated == 0 && lesson.ticks > 0, "{lesson:?}");
    assert_eq!(ended(taught), ended(run));
}

#[test]
fn a_teacher_can_be_stopped() {
    let stopped = begun(&training("teacher: hits"), true).map(|_| ()).expect_err("it was stopped");
    assert!(stopped.is_stopped());
}

#[test]
fn a_falsifier_that_trains_cannot_teach() {
    let said = compiled("teacher: learner").map(|_| ()).expect_err("a circle");
    assert!(said.iter().any(|message| message.contains("`learner` cannot teach")), "{said:?}");
}

#[test]
fn keys_of_a_teacher_change_the_digest_and_their_absence_does_not() {
    let digests = ["", "teacher: hits", "teacher: hits, teacher_ticks: 200_001"].map(|keys| training(keys).fingerprint);
    assert!(digests[0] != digests[1] && digests[1] != digests[2]);
}

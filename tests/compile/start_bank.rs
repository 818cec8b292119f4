//! A training may begin its episodes with copies of kept starts: the same world, without the time of the run-ups.

use std::path::Path;
use std::slice::from_ref;
use std::sync::Arc;

use base::diagnostic::Sources;
use base::seed::Seed;
use compile::{Catalog, Training, compile};
use episode::{Ending, Outcome, Scenario};
use search::{HardStarts, PedestrianEnv, StartBank, TrainingRun};

fn scenario(spawn: &str, driver: &str) -> Arc<Scenario> {
    training(spawn, driver, "").scenario.clone()
}

/// A training in the harbour, with further keys of `ppo`; its pedestrian is paid for faults.
fn training(spawn: &str, driver: &str, keys: &str) -> Training {
    let text = format!(
        "edition 1\nimport \"lib/paper.scn\"\nimport \"lib/drivers.scn\"\nimport \"lib/sensors.scn\"\nimport \"lib/towns.scn\"\n\
         import \"lib/pedestrians.scn\"\nimport \"lib/rewards.scn\"\n\
         training first = ppo(steps: 4_000, environments: 4, steps_per_update: 1000, epochs: 1, learning_rate: 0.000001, initial_log_std: -1{keys})\n\
         driver sharp = idm(sensors: perfect)\n\
         driver squinting = idm(time_headway: 1.5 s, sensors: poor)\n\
         spawn here {{ bearing: -60 deg .. 60 deg  distance: 7 m .. 40 m  {spawn} }}\n\
         episode brief {{ ticks: 160  hold: 10  end_when: ahead < -6 m }}\n\
         campaign c {{ vehicle: model3 body: pursuer spawn: here episode: brief training: first\n\
         train {{ towns: [harbour] drivers: [{driver}] rewards: [fault] runs: 1 }} }}"
    );
    let root = crate::repository().join("scenarios/bank.scn");
    let read = |path: &Path| if path == root { Ok(text.clone()) } else { std::fs::read_to_string(path) };
    let compiled = compile(from_ref(&root), &Catalog::builtin(), &read, &mut Sources::default()).expect("readable");
    let plan = compiled.plan.unwrap_or_else(|| panic!("{:?}", compiled.diagnostics));
    plan.campaigns[0].nth::<Training>(0).clone()
}

fn bank(scenario: &Arc<Scenario>, size: usize) -> Option<Arc<StartBank>> {
    StartBank::new(scenario, size, None, Seed::root(8)).map(Arc::new)
}

/// The outcomes of episodes in which the pedestrian walks to where it would meet the car.
fn outcomes(env: &mut PedestrianEnv, episodes: u64) -> Vec<Outcome> {
    let outcome = |episode| {
        env.begin(episode);
        while env.simulation().outcome().is_none() {
            let commands = [env.simulation().scene().intercept(0)];
            env.carry_out(&commands);
        }
        *env.simulation().outcome().expect("it is over")
    };
    (0..episodes).map(outcome).collect()
}

/// The share of episodes of a kind.
fn share(outcomes: &[Outcome], kind: impl Fn(&Outcome) -> bool) -> f64 {
    outcomes.iter().filter(|outcome| kind(outcome)).count() as f64 / outcomes.len() as f64
}

#[test]
fn rates_from_the_bank_and_from_fresh_starts_agree() {
    const EPISODES: u64 = 1200;
    type Kind = (&'static str, fn(&Outcome) -> bool);
    let kinds: [Kind; 4] = [
        ("a touch", |outcome| matches!(outcome.ending, Ending::Touch { .. })),
        ("a collision", |outcome| matches!(outcome.ending, Ending::Touch { moving: true, .. })),
        ("a fast collision", |outcome| matches!(outcome.ending, Ending::Touch { impact_speed: 3.0.., .. })),
        ("a missed car", |outcome| matches!(outcome.ending, Ending::Lost)),
    ];
    for driver in ["behavior", "squinting"] {
        let scenario = scenario("", driver);
        let fresh = outcomes(&mut PedestrianEnv::new(scenario.simulation(), Seed::root(6)), EPISODES);
        let kept = bank(&scenario, EPISODES as usize);
        let copied = outcomes(&mut PedestrianEnv::new(scenario.simulation(), Seed::root(7)).with_bank(kept), EPISODES);
        for (name, kind) in kinds {
            let (fresh, copied) = (share(&fresh, kind), share(&copied, kind));
            let rate = 0.5 * (fresh + copied);
            assert!(rate > 0.02 && rate < 0.98, "{driver}: {name} in {rate} of the episodes tells nothing");
            // Copies of one start may all end alike, so the starts of the bank and the draws from it count once more each.
            let spread = (rate * (1.0 - rate) * 3.0 / EPISODES as f64).sqrt();
            let z = (fresh - copied) / spread;
            assert!(
                z.abs() < 3.0,
                "{driver}: {name} in {fresh} of fresh starts and {copied} of copies, {z} deviations"
            );
        }
        let speed = |outcomes: &[Outcome]| {
            let speeds: Vec<f64> = outcomes.iter().map(|outcome| outcome.spawn.ego_speed).collect();
            let mean = speeds.iter().sum::<f64>() / speeds.len() as f64;
            (mean, speeds.iter().map(|speed| (speed - mean).powi(2)).sum::<f64>() / speeds.len() as f64)
        };
        let ((fresh, variance), (copied, _)) = (speed(&fresh), speed(&copied));
        let z = (fresh - copied) / (variance * 3.0 / EPISODES as f64).sqrt();
        assert!(z.abs() < 3.0, "{driver}: at {fresh} m/s afresh and {copied} m/s from the bank, {z} deviations");
    }
}

#[test]
fn copies_share_their_start_and_only_what_is_random_differs_after_it() {
    for (driver, random) in [("sharp", false), ("squinting", true)] {
        let scenario = scenario("", driver);
        let mut differ = false;
        // From most starts the driver does the same whatever its sensors miss.
        for seed in (15..45).map(Seed::root) {
            let mut env = PedestrianEnv::new(scenario.simulation(), Seed::root(7))
                .with_bank(StartBank::new(&scenario, 1, None, seed).map(Arc::new));
            let copies = outcomes(&mut env, 12);
            let first = copies[0];
            assert!(copies.iter().all(|copy| (copy.start, copy.spawn) == (first.start, first.spawn)), "{driver}");
            differ |= copies.iter().any(|copy| copy.digest != first.digest);
            // The copy is what the driven start is, up to the last bit.
            let original = outcomes(&mut PedestrianEnv::new(scenario.simulation(), seed), 1)[0];
            assert_eq!((original.start, original.spawn, original.run_up), (first.start, first.spawn, first.run_up));
            assert!(random || original == first, "{driver}");
        }
        assert_eq!(differ, random, "{driver}");
    }
}

#[test]
fn an_episode_depends_on_its_number_and_not_on_what_was_drawn_before() {
    let scenario = scenario("", "squinting");
    let kept = bank(&scenario, 4);
    let mut env = PedestrianEnv::new(scenario.simulation(), Seed::root(7)).with_bank(kept.clone());
    let all = outcomes(&mut env, 10);
    let starts: std::collections::BTreeSet<u64> = all.iter().map(|outcome| outcome.start).collect();
    assert!(starts.len() > 1 && starts.len() <= 4, "{starts:?}");
    for bank in [kept, bank(&scenario, 4)] {
        let mut env = PedestrianEnv::new(scenario.simulation(), Seed::root(7)).with_bank(bank);
        for number in [7, 2, 9] {
            env.begin(number);
            while env.simulation().outcome().is_none() {
                let commands = [env.simulation().scene().intercept(0)];
                env.carry_out(&commands);
            }
            assert_eq!(env.simulation().outcome(), Some(&all[number as usize]));
        }
    }
}

#[test]
fn there_is_no_bank_where_it_would_save_nothing() {
    assert!(bank(&scenario("ego_speed: 8 m/s", "behavior"), 4).is_none(), "there is no run-up");
    assert!(bank(&scenario("", "behavior"), 0).is_none());
    assert!(bank(&scenario("", "behavior"), 4).is_some());
}

#[test]
fn the_stated_share_of_copies_is_of_hard_starts_whatever_was_drawn_before() {
    const SHARE: f64 = 0.6;
    // Every seventh start is hard.
    let hard = HardStarts { share: SHARE, is_hard: |_, number| number.is_multiple_of(7) };
    let scenario = scenario("", "squinting");
    let kept = || StartBank::new(&scenario, 20, Some(hard), Seed::root(8)).map(Arc::new);
    let begin = |env: &mut PedestrianEnv, episode| {
        env.begin(episode);
        env.simulation().scene().world.ego().state
    };
    let mut env = PedestrianEnv::new(scenario.simulation(), Seed::root(7)).with_bank(kept());
    let drawn: Vec<_> = (0..400).map(|episode| begin(&mut env, episode)).collect();
    let mut driven = PedestrianEnv::new(scenario.simulation(), Seed::root(8));
    let hard_ones: Vec<_> = (0..200).step_by(7).map(|number| begin(&mut driven, number)).collect();
    let share = drawn.iter().filter(|start| hard_ones.contains(start)).count() as f64 / 400.0;
    // Of the others a seventh is hard by chance.
    let expected = SHARE + (1.0 - SHARE) * 3.0 / 20.0;
    assert!((share - expected).abs() < 0.08, "{share} beside {expected}");
    let mut later = PedestrianEnv::new(scenario.simulation(), Seed::root(7)).with_bank(kept());
    for episode in [301, 4, 77] {
        assert_eq!(begin(&mut later, episode), drawn[episode as usize]);
    }
    // Where no start is hard, starts are those of a bank without the difference.
    let none = HardStarts { share: SHARE, is_hard: |_, _| false };
    let of = |hard| StartBank::new(&scenario, 20, hard, Seed::root(8)).map(Arc::new);
    let mut plain = PedestrianEnv::new(scenario.simulation(), Seed::root(7)).with_bank(of(None));
    let mut without = PedestrianEnv::new(scenario.simulation(), Seed::root(7)).with_bank(of(Some(none)));
    for episode in 0..20 {
        assert_eq!(begin(&mut plain, episode), begin(&mut without, episode));
    }
}

/// The share of episodes with a fault while nothing is learnt yet.
#[test]
fn at_hard_starts_a_first_attempt_causes_faults_more_often() {
    let faults = |keys| {
        let training = training("", "behavior", keys);
        let (environments, config) = (training.config.environments, &training.config);
        let mut run = TrainingRun::begin(&training.scenarios(), environments, config, &Seed::root(5)).unwrap();
        let log = run.update().unwrap();
        let judged: Vec<bool> = log.finished.iter().filter_map(|episode| episode.fault).collect();
        assert!(judged.len() > 300, "{} episodes tell nothing", judged.len());
        judged.iter().filter(|fault| **fault).count() as f64 / judged.len() as f64
    };
    let (usual, hard) = (faults(", starts: 40"), faults(", starts: 40, hard_starts: 100 percent"));
    assert!(hard > 1.5 * usual && usual > 0.0, "{hard} of the episodes, {usual} without");
}

//! `cargo bench --bench reference_world`: the paper's training on the reference world, rollouts and updates timed separately.
//!
//! Prints one JSON object for each training. `tests/reference/sb3_speed` compares it with stable-baselines3.

#![expect(clippy::print_stdout, reason = "its output is its result")]

use std::time::Instant;

use base::seed::Seed;
use learn::{PpoConfig, Trainer};

use ped_world::{End, PedWorld, Reward, Road, Rules, Units};

#[path = "../learn/ped_world.rs"]
#[expect(dead_code, reason = "the tests look at more of the world than a training does")]
mod ped_world;

const TRAININGS: u64 = 3;

/// The CPU seconds of this thread, or wall seconds where the system has no such count. A training of one environment
/// stays on its thread.
struct Clock(Instant);

impl Clock {
    fn seconds(&self) -> f64 {
        let counted = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
        let nanoseconds: Option<f64> = counted.and_then(|text| text.split_whitespace().next()?.parse().ok());
        nanoseconds.map_or_else(|| self.0.elapsed().as_secs_f64(), |nanoseconds| nanoseconds * 1e-9)
    }
}

fn main() {
    let config = PpoConfig::paper();
    let rules = Rules { road: Road::Straight, obs: Units::Raw, act: Units::Raw, reward: Reward::R2, end: End::Lost };
    for number in 0..TRAININGS {
        let (seed, clock) = (Seed::root(number), Clock(Instant::now()));
        let mut worlds = [PedWorld::new(rules, seed.child("world").stream())];
        let mut trainer = Trainer::new(&mut worlds, &config, &seed.child("train")).expect("states are finite");
        let (mut rollout, mut update) = (0.0, 0.0);
        while !trainer.is_done() {
            let before = clock.seconds();
            let experience = trainer.collect(&mut worlds, &|| false).expect("rewards are finite");
            let between = clock.seconds();
            experience.learn().expect("losses are finite");
            rollout += between - before;
            update += clock.seconds() - between;
        }
        let steps = trainer.steps();
        println!(
            "{{\"learner\": \"falsify\", \"seed\": {number}, \"steps\": {steps}, \"rollout_cpu_s\": {rollout:.4}, \"update_cpu_s\": {update:.4}}}"
        );
    }
}

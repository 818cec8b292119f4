use std::sync::{Arc, Mutex, PoisonError};

use rand::RngExt;

use super::{EgoSpeed, PedestrianEnv, Scenario};
use base::seed::Seed;

/// Starts of a scenario whose run-up has been driven, to be copied: a run-up takes more ticks than most encounters.
///
/// Start *k* depends only on the seed and on *k*; it is driven when it is first drawn, by whichever environment draws it. What is random in a copy from tick 0
/// on is drawn from streams of its own ([`DrivingPolicy::reseed`](crate::av::DrivingPolicy::reseed)), so copies share their past and not their future.
/// A bank is for trainings: an evaluation whose episodes share starts would have a narrower interval than it claims.
pub struct StartBank {
    scenario: Arc<Scenario>,
    seed: Seed,
    starts: Vec<Mutex<Option<Box<PedestrianEnv>>>>,
}

impl StartBank {
    /// A bank of `size` starts; none where it would save nothing or change what episodes are: starts without a run-up, tests whose case depends on the
    /// number of the episode, and drivers that cannot be copied.
    pub fn new(scenario: &Arc<Scenario>, size: usize, seed: Seed) -> Option<Self> {
        let spawn = &scenario.spawn;
        let suits = matches!(spawn.ego_speed, EgoSpeed::Steady) && spawn.target_walk.is_none() && size > 0;
        suits.then(|| PedestrianEnv::new(scenario.clone(), seed).snapshot())??;
        Some(Self { scenario: scenario.clone(), seed, starts: (0..size).map(|_| Mutex::default()).collect() })
    }

    /// A copy of the start that this seed draws; none if its driver failed before tick 0.
    pub(super) fn copy(&self, seed: &Seed) -> Option<PedestrianEnv> {
        let number = seed.child("start").stream().random_range(0..self.starts.len());
        let mut start = self.starts[number].lock().unwrap_or_else(PoisonError::into_inner);
        let start = start.get_or_insert_with(|| {
            let mut env = Box::new(PedestrianEnv::new(self.scenario.clone(), self.seed));
            env.begin(number as u64);
            env
        });
        start.failed_run_up().is_none().then(|| start.snapshot()).flatten()
    }
}

impl std::fmt::Debug for StartBank {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("StartBank").field("starts", &self.starts.len()).finish_non_exhaustive()
    }
}

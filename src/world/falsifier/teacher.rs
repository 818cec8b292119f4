use std::collections::BTreeMap;
use std::sync::Arc;

use rayon::prelude::*;

use super::{Failure, Falsifier, Simulator, TrainError};
use crate::env::{FailureCell, PedestrianEnv, Scenario};
use base::seed::Seed;
use learn::{ActorCritic, Demonstrations, FrameStack, PpoConfig, imitate};

/// A falsifier whose failures a training begins with: the actor is fitted to the commands that led to them.
///
/// It searches every place of the training with a budget of its own. The failures that earned at least half of the best are repeated, and each decision
/// is a demonstration. A failure counts its reward, divided by the square root of what all failures of its [`FailureCell`] in its place
/// have earned, so rare kinds of failures stay.
#[derive(Debug, Clone)]
pub struct Teacher {
    pub falsifier: Arc<dyn Falsifier>,
    /// The places of the training, with the reward of the falsifier.
    pub scenarios: Vec<Arc<Scenario>>,
    /// Ticks of the search in each place.
    pub budget: u64,
}

/// What a teacher found.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Lesson {
    /// All failures.
    pub failures: usize,
    /// Those whose commands were imitated.
    pub imitated: usize,
    /// Ticks of all searches.
    pub ticks: u64,
}

/// The share of the best reward that a failure must have earned to be imitated.
const LEAST_SHARE: f64 = 0.5;

/// The failures of a place, and the seed of their starts.
struct Found {
    failures: Vec<Failure>,
    starts: Seed,
    ticks: u64,
    stopped: bool,
}

impl Teacher {
    /// Searches, and fits the actor to what was found; without a failure that earned anything the networks stay. All random numbers come from `seed`.
    ///
    /// # Errors
    /// As [`Falsifier::search`]; [`learn::TrainError::Stopped`] when `stop` was true.
    pub fn teach(
        &self,
        policy: &mut ActorCritic,
        config: &PpoConfig,
        seed: &Seed,
        stop: &(dyn Fn() -> bool + Sync),
    ) -> Result<Lesson, TrainError> {
        let places: Vec<(u64, &Arc<Scenario>)> = (0..).zip(&self.scenarios).collect();
        let found = places.par_iter().map(|(place, scenario)| self.search(scenario, &seed.index(*place), stop));
        let found = found.collect::<Vec<_>>().into_iter().collect::<Result<Vec<Found>, TrainError>>()?;
        if found.iter().any(|found| found.stopped) {
            return Err(learn::TrainError::Stopped { update: 0 }.into());
        }
        let rewards = found.iter().flat_map(|found| &found.failures).map(|failure| failure.outcome.reward);
        let best = rewards.fold(0.0, f64::max);
        let wins = |failure: &&Failure| best > 0.0 && failure.outcome.reward >= LEAST_SHARE * best;
        let lessons = self.scenarios.par_iter().zip(&found).map(|(scenario, found)| {
            let chosen: Vec<&Failure> = found.failures.iter().filter(wins).collect();
            demonstrations(scenario, &found.starts, &chosen, config.frame_stack)
        });
        let mut all = Demonstrations::default();
        for lesson in lessons.collect::<Vec<_>>() {
            all.observations.extend(lesson.observations);
            all.actions.extend(lesson.actions);
            all.weights.extend(lesson.weights);
        }
        imitate(policy, &all, config, &seed.child("imitation"));
        Ok(Lesson {
            failures: found.iter().map(|found| found.failures.len()).sum(),
            imitated: found.iter().flat_map(|found| &found.failures).filter(wins).count(),
            ticks: found.iter().map(|found| found.ticks).sum(),
        })
    }

    fn search(
        &self,
        scenario: &Arc<Scenario>,
        seed: &Seed,
        stop: &(dyn Fn() -> bool + Sync),
    ) -> Result<Found, TrainError> {
        let starts = seed.child("starts");
        let mut simulator = Simulator::new(scenario.clone(), starts, self.budget, stop);
        self.falsifier.search(&mut simulator, &seed.child("search"))?;
        let outcome = simulator.into_spent();
        Ok(Found { failures: outcome.failures, starts, ticks: outcome.ticks, stopped: outcome.stopped })
    }
}

/// Repeats failures and notes what the pedestrian saw and what it did.
fn demonstrations(scenario: &Arc<Scenario>, starts: &Seed, failures: &[&Failure], frames: usize) -> Demonstrations {
    let mut earned: BTreeMap<FailureCell, f64> = BTreeMap::new();
    for failure in failures {
        *earned.entry(failure.cell).or_default() += failure.outcome.reward;
    }
    let mut env = PedestrianEnv::new(scenario.clone(), *starts);
    let mut state = vec![0.0; scenario.cast.obs_dim()];
    let mut action = vec![0.0; env.bounds().len()];
    let mut stack = FrameStack::new(state.len(), frames);
    let mut noted = Demonstrations::default();
    for failure in failures {
        let weight = failure.outcome.reward / earned[&failure.cell].sqrt();
        env.begin(failure.start);
        for (number, commands) in failure.commands.chunks_exact(scenario.cast.pedestrian_count()).enumerate() {
            env.write_state(&mut state);
            if number == 0 {
                stack.begin(&state);
            } else {
                stack.push(&state);
            }
            env.write_action(commands, &mut action);
            for (component, (low, high)) in action.iter_mut().zip(env.bounds()) {
                *component = component.clamp(*low, *high);
            }
            noted.observations.extend_from_slice(stack.as_slice());
            noted.actions.extend_from_slice(&action);
            noted.weights.push(weight);
            env.carry_out(commands);
        }
    }
    noted
}

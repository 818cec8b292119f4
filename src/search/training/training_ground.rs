use std::sync::Arc;

use super::{PedestrianEnv, StartBank};
use crate::driving::{DriveEnv, DriveRule, Pupil};
use base::seed::Seed;
use episode::Scenario;
use episode::walker::FaultStreak;
use learn::{Agent, Env, PpoConfig, Step};
use world::av::Fault;

/// An environment whose episodes take place in several scenarios in turn: other towns, other drivers.
///
/// Episode k of environment i takes place in scenario (i + k) mod n, so all scenarios have equal shares of the episodes, whatever the number
/// of environments. With one scenario it is a [`PedestrianEnv`], or a [`DriveEnv`].
pub(super) struct TrainingGround {
    envs: Vec<Box<dyn Place>>,
    /// The place of the running episode's scenario.
    current: usize,
}

/// An environment of one scenario.
trait Place: Env + Send {
    /// The episodes in a row in which a driver failed.
    fn faults(&self) -> &FaultStreak;

    /// The driver that learns; `None` if a pedestrian does.
    fn driver(&mut self) -> Option<&mut DriveEnv> {
        None
    }
}

impl Place for PedestrianEnv {
    fn faults(&self) -> &FaultStreak {
        self.faults()
    }
}

impl Place for DriveEnv {
    fn faults(&self) -> &FaultStreak {
        self.faults()
    }

    fn driver(&mut self) -> Option<&mut DriveEnv> {
        Some(self)
    }
}

impl TrainingGround {
    /// The environment with this number, of scenarios with equal states and actions; `episodes` is its own seed. With a rule the car learns to
    /// drive, else a pedestrian learns. Each scenario has the bank of starts that all environments share, if it has one.
    ///
    /// # Panics
    /// When there is no scenario.
    pub fn new(
        scenarios: &[Arc<Scenario>],
        rule: Option<&Arc<DriveRule>>,
        banks: &[Option<Arc<StartBank>>],
        config: &PpoConfig,
        number: usize,
        episodes: &Seed,
    ) -> Self {
        assert!(!scenarios.is_empty(), "training needs a scenario");
        let seed = |place: u64| if place == 0 { *episodes } else { episodes.child("place").index(place) };
        let envs = (0..).zip(scenarios).zip(banks).map(|((place, scenario), bank)| match rule {
            Some(rule) => Box::new(DriveEnv::new(scenario, rule, &seed(place))) as Box<dyn Place>,
            None => {
                let env = PedestrianEnv::new(scenario.simulation(), seed(place));
                Box::new(env.with_bank(bank.clone()).with_agents(config))
            }
        });
        // The first reset moves on to the scenario of the number.
        Self { current: (number + scenarios.len() - 1) % scenarios.len(), envs: envs.collect() }
    }

    /// Why a driver failed in ten episodes in a row, if one did.
    pub fn hopeless(&self) -> Option<Fault> {
        self.envs.iter().find_map(|env| env.faults().hopeless())
    }

    /// Whether the user asked to stop while a driver was waited for.
    pub fn is_stopped(&self) -> bool {
        self.envs.iter().any(|env| env.faults().is_stopped())
    }

    fn env(&self) -> &dyn Place {
        &*self.envs[self.current]
    }
}

impl Pupil for TrainingGround {
    fn teach(&mut self, teaches: bool) {
        self.envs.iter_mut().filter_map(|env| env.driver()).for_each(|driver| driver.teach(teaches));
    }

    fn shown(&mut self) -> [f64; 2] {
        self.envs[self.current].driver().map_or([0.0; 2], |driver| driver.shown())
    }
}

impl Env for TrainingGround {
    fn agents(&self) -> Vec<Agent> {
        self.env().agents()
    }

    fn credit(&self, agent: usize, reward: f64) -> f64 {
        self.env().credit(agent, reward)
    }

    fn obs_dim(&self) -> usize {
        self.env().obs_dim()
    }

    fn action_bounds(&self) -> Vec<(f64, f64)> {
        self.env().action_bounds()
    }

    fn reset(&mut self, obs: &mut [f64]) {
        self.current = (self.current + 1) % self.envs.len();
        self.envs[self.current].reset(obs);
    }

    fn step(&mut self, action: &[f64], obs: &mut [f64]) -> Step {
        self.envs[self.current].step(action, obs)
    }

    fn is_success(&self) -> bool {
        self.env().is_success()
    }

    fn is_fault(&self) -> Option<bool> {
        self.env().is_fault()
    }

    fn potential(&self) -> f64 {
        self.env().potential()
    }

    /// The place of the running scenario, and the state of each.
    fn save(&self) -> Option<Vec<u8>> {
        let states = self.envs.iter().map(|env| String::from_utf8(env.save()?).ok()).collect::<Option<Vec<_>>>()?;
        serde_json::to_vec(&(self.current, states)).ok()
    }

    fn load(&mut self, state: &[u8]) -> bool {
        let Ok((current, states)) = serde_json::from_slice::<(usize, Vec<String>)>(state) else { return false };
        self.current = current;
        current < self.envs.len()
            && states.len() == self.envs.len()
            && self.envs.iter_mut().zip(&states).all(|(env, state)| env.load(state.as_bytes()))
    }
}

use std::sync::Arc;

use super::{Agents, StartBank};
use base::seed::Seed;
use episode::walker::FaultStreak;
use episode::{Controller, Draw, Simulation};
use learn::{Agent, Env, PpoConfig, Step};
use world::sim::WalkCommand;

/// An environment whose agent controls the pedestrians, or whose agents control one each: the episodes of a simulation, one after another.
///
/// Episode *k* depends only on the seed and on *k*. A decision is one command for each pedestrian of the cast, in the order of their numbers. An
/// action is joint: the numbers of all controlled pedestrians, one after another. So is a state.
pub struct PedestrianEnv {
    simulation: Box<dyn Simulation>,
    seed: Seed,
    next_episode: u64,
    /// The starts that episodes begin with copies of; `None` for fresh starts.
    bank: Option<Arc<StartBank>>,
    /// The commands of the running episode. Its state depends only on them and on its number.
    decisions: Vec<WalkCommand>,
    /// Memory for the commands of a decision.
    commands: Vec<WalkCommand>,
    faults: FaultStreak,
    /// The agents; `None` if one chooses for all pedestrians.
    agents: Option<Agents>,
}

/// A running episode up to now, with all data to repeat it.
#[derive(serde::Serialize, serde::Deserialize)]
struct RunningEpisode {
    /// The number of the next episode; 0 if none has started.
    next_episode: u64,
    /// The commands up to now.
    decisions: Vec<WalkCommand>,
    /// The hash of its start and of its states, which a repetition must reach.
    digest: u64,
}

/// Commands for which memory is reserved; longer episodes reserve more once.
const MAX_RESERVED: usize = 4096;

impl PedestrianEnv {
    /// Makes an environment whose first episode is number 0 under the seed.
    pub fn new(simulation: Box<dyn Simulation>, seed: Seed) -> Self {
        let scenario = simulation.scenario();
        let pedestrians = scenario.cast.pedestrians.len();
        let decisions = scenario.episode.ticks.div_ceil(scenario.episode.hold) as usize * pedestrians;
        Self {
            simulation,
            seed,
            next_episode: 0,
            bank: None,
            decisions: Vec::with_capacity(decisions.min(MAX_RESERVED)),
            commands: vec![WalkCommand::default(); pedestrians],
            faults: FaultStreak::default(),
            agents: None,
        }
    }

    /// The same environment with the agents of a training with these settings.
    pub fn with_agents(mut self, config: &PpoConfig) -> Self {
        self.agents = Agents::new(&self.simulation.scenario().cast, config);
        self
    }

    /// The same environment, whose episodes begin with copies of the bank's starts.
    pub fn with_bank(mut self, bank: Option<Arc<StartBank>>) -> Self {
        self.bank = bank;
        self
    }

    /// The simulation of the running episode.
    pub fn simulation(&self) -> &dyn Simulation {
        &*self.simulation
    }

    /// The episodes in a row in which the driver failed.
    pub fn faults(&self) -> &FaultStreak {
        &self.faults
    }

    /// Starts the episode with this number, and drives its run-up.
    pub fn begin(&mut self, number: u64) {
        let draw = Draw::new(&self.seed, number);
        match self.bank.as_ref().and_then(|bank| bank.copy(&draw.drivers)) {
            Some(copy) => {
                self.simulation = copy;
                self.simulation.reseed(&draw.drivers);
            }
            None => self.simulation.start(draw),
        }
        self.next_episode = number + 1;
        self.decisions.clear();
        if let Some(agents) = &mut self.agents {
            agents.begin(&*self.simulation);
        }
    }

    /// Carries out a decision: one command for each pedestrian.
    pub fn carry_out(&mut self, commands: &[WalkCommand]) -> Step {
        self.decisions.extend_from_slice(commands);
        let step = self.simulation.carry_out(commands);
        if let Some(outcome) = self.simulation.outcome() {
            self.faults.count(outcome.fault());
        }
        if let Some(agents) = &mut self.agents {
            agents.step(step.reward, &*self.simulation, &self.decisions);
        }
        step
    }

    /// Repeats an episode up to the recorded point, and returns whether it led to the same state.
    ///
    /// Neither the world nor a driver can be copied to a file. But the episode's number and the commands determine it, and ticks are cheap.
    fn replay(&mut self, running: &RunningEpisode) -> bool {
        let Some(number) = running.next_episode.checked_sub(1) else {
            return self.next_episode == 0 && running.decisions.is_empty();
        };
        if !running.decisions.len().is_multiple_of(self.commands.len()) {
            return false;
        }
        self.begin(number);
        for commands in running.decisions.chunks(self.commands.len()) {
            let roles = self.simulation.scenario().cast.pedestrians.iter().zip(commands);
            let possible = roles.into_iter().all(|(role, command)| match &role.controller {
                Controller::External => (role.action.speed.0..=role.action.speed.1).contains(&command.speed),
                Controller::Fixed(_) | Controller::Own(_) => true,
            });
            if self.simulation.outcome().is_some() || !possible {
                return false;
            }
            self.carry_out(commands);
        }
        self.simulation.state_hash() == running.digest
    }
}

impl Env for PedestrianEnv {
    fn agents(&self) -> Vec<Agent> {
        self.agents
            .as_ref()
            .map_or_else(|| self.simulation.scenario().cast.agents(None), |agents| agents.all().to_vec())
    }

    fn obs_dim(&self) -> usize {
        self.simulation.scenario().cast.obs_dim()
    }

    fn action_bounds(&self) -> Vec<(f64, f64)> {
        self.simulation.scenario().cast.action_bounds()
    }

    fn credit(&self, agent: usize, reward: f64) -> f64 {
        self.agents.as_ref().map_or(reward, |agents| agents.earned(agent))
    }

    fn reset(&mut self, state: &mut [f64]) {
        self.begin(self.next_episode);
        self.simulation.scene().write_state(state);
    }

    fn step(&mut self, action: &[f64], state: &mut [f64]) -> Step {
        // A driver that failed too often is not asked any more; the training ends with the current update.
        let step = match self.faults.hopeless() {
            Some(_) => Step { reward: 0.0, terminated: false, truncated: true },
            None => {
                let mut commands = std::mem::take(&mut self.commands);
                self.simulation.scene().write_commands(action, &mut commands);
                let step = self.carry_out(&commands);
                self.commands = commands;
                step
            }
        };
        self.simulation.scene().write_state(state);
        step
    }

    /// Whether the episode ended in a failure of the driver.
    fn is_success(&self) -> bool {
        self.simulation.is_failure()
    }

    fn is_fault(&self) -> Option<bool> {
        self.simulation.judged_fault()
    }

    fn potential(&self) -> f64 {
        self.simulation.shaping()
    }

    fn save(&self) -> Option<Vec<u8>> {
        let running = RunningEpisode {
            next_episode: self.next_episode,
            decisions: self.decisions.clone(),
            digest: self.simulation.state_hash(),
        };
        serde_json::to_vec(&running).ok()
    }

    fn load(&mut self, state: &[u8]) -> bool {
        serde_json::from_slice(state).is_ok_and(|running| self.replay(&running))
    }
}

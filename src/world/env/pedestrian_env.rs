mod settle;
mod start;

use std::sync::Arc;

use super::drivers::Drivers;
use super::observers::{MAX_RESERVED, Observers};
use super::run_up::{self, RunUp, Stage};
use super::running::RunningEpisode;
use super::script::Script;
use super::tally::hashed;
use super::{
    Actions, Controller, Draw, Ending, FailureCell, Outcome, Phase, RewardRule, Scenario, Scene, Simulation, Spawn,
    SpawnRule, StartBank,
};
use crate::av::Fault;
use crate::geometry::Pose;
use crate::requirement::Degree;
use crate::sim::{ActorStart, PedestrianState, WalkCommand, World};
use base::seed::Seed;
use learn::{Env, Step};

/// A runnable logical scenario: it draws concrete episodes, one after another.
///
/// Episode *k* depends only on the seed and on *k*. So two controllers that are evaluated with one seed have the same starts and the same
/// drivers.
///
/// Where the ego starts in its steady state ([`EgoSpeed::Steady`](super::EgoSpeed::Steady)), the driver first drives alone along a *run-up* that ends at the drawn
/// pose. Tick 0 of the episode is the tick in which it gets there: with its own speed, pose within the lane, and memory. Until then there are
/// no pedestrians; vehicles and traffic lights run. A driver that does not get there within 60 s (120 s where traffic lights work; at most 20,000 ticks) or touches
/// another vehicle starts at the drawn pose, at rest and without memory.
///
/// A decision is one command for each pedestrian of the cast, in the order of their numbers. As an [`Env`] its action is joint: the
/// numbers of all controlled pedestrians, one after another. So is its state.
pub struct PedestrianEnv {
    scenario: Arc<Scenario>,
    seed: Seed,
    next_episode: u64,
    source: StartSource,
    world: World,
    /// The start of each vehicle of the running episode.
    vehicles: Vec<ActorStart>,
    /// Time within the cycles of the traffic lights at the start (s).
    light_phase: f64,
    run_up: RunUp,
    drivers: Drivers,
    actions: Actions,
    script: Script,
    episode: Episode,
    /// The commands of the running episode. Its state depends only on them, its number and its width.
    decisions: Vec<WalkCommand>,
    observers: Observers,
    faults_in_a_row: u32,
    last_fault: Option<Fault>,
    /// Memory for the commands of a tick.
    scratch: Vec<WalkCommand>,
}

/// Number of episodes in a row that a driver may fail; then it is not asked again.
const MAX_FAULTS: u32 = 10;

/// Where the starts of episodes come from.
#[derive(Debug, Clone)]
struct StartSource {
    /// The part of the spawn's distances from which the next episodes are drawn; 1 for all.
    width: f64,
    /// The spawn rule with that part of the distances, if that is not all.
    near: Option<SpawnRule>,
    /// The starts that episodes from all distances begin with copies of; `None` for fresh starts.
    bank: Option<Arc<StartBank>>,
}

/// The record of the running episode.
#[derive(Debug, Clone, Copy)]
struct Episode {
    spawn: Spawn,
    /// The hash of the spawn as it was drawn.
    start: u64,
    /// The environment's width when it started.
    width: f64,
    /// Whether the pedestrians need a decision.
    is_due: bool,
    /// Ticks for which the present commands have been carried out.
    held: u32,
    reward: f64,
    /// Whether the hit that ended it is a fault of the driver.
    is_fault: bool,
    outcome: Option<Outcome>,
}

impl Episode {
    /// The record of an episode that has just started.
    fn new(spawn: Spawn, width: f64) -> Self {
        let start = hashed(0, &spawn);
        Self { spawn, start, width, is_due: true, held: 0, reward: 0.0, is_fault: false, outcome: None }
    }
}

impl PedestrianEnv {
    /// Makes an environment whose first episode is number 0 under the seed. The scenario's spawn rule must have been probed.
    pub fn new(scenario: Arc<Scenario>, seed: Seed) -> Self {
        let drivers = Drivers::of(&scenario.cast);
        Self::with_drivers(scenario, seed, drivers)
    }

    fn with_drivers(scenario: Arc<Scenario>, seed: Seed, drivers: Drivers) -> Self {
        let (cast, rule) = (&scenario.cast, &scenario.episode);
        // Prepared here, so that no tick waits for it.
        scenario.town.prepare();
        let world = World::new(
            scenario.town.clone(),
            scenario.obstacles.clone(),
            cast.vehicles.iter().map(|role| role.blueprint.clone()).collect(),
            cast.pedestrians.iter().map(|role| role.body).collect(),
            rule.traffic_lights.then_some(rule.light_cycle()),
            rule.tick,
        );
        let actions = Actions::new(cast);
        let nowhere = Spawn { ego: Pose::default(), ego_speed: 0.0, pedestrian: Pose::default() };
        let decisions = rule.ticks.div_ceil(rule.hold).min(MAX_RESERVED) as usize * actions.commands.len();
        Self {
            vehicles: cast.vehicles.iter().map(|role| role.start.unwrap_or_default()).collect(),
            observers: Observers::new(&scenario, &world),
            scratch: actions.commands.clone(),
            actions,
            scenario,
            seed,
            next_episode: 0,
            source: StartSource { width: 1.0, near: None, bank: None },
            world,
            light_phase: 0.0,
            run_up: RunUp::new(run_up::LENGTH),
            drivers,
            script: Script::default(),
            episode: Episode::new(nowhere, 1.0),
            decisions: Vec::with_capacity(decisions),
            faults_in_a_row: 0,
            last_fault: None,
        }
    }

    /// The same environment, whose episodes begin with copies of the bank's starts while they are drawn from all distances.
    pub fn with_bank(mut self, bank: Option<Arc<StartBank>>) -> Self {
        self.source.bank = bank;
        self
    }

    /// The world as it is now.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// A copy in its present state, if all drivers can be copied.
    pub fn copy(&self) -> Option<Self> {
        Some(Self {
            drivers: self.drivers.snapshot()?,
            scenario: self.scenario.clone(),
            source: self.source.clone(),
            world: self.world.clone(),
            vehicles: self.vehicles.clone(),
            run_up: self.run_up.clone(),
            actions: self.actions.clone(),
            script: self.script.clone(),
            decisions: self.decisions.clone(),
            observers: self.observers.clone(),
            scratch: self.scratch.clone(),
            ..*self
        })
    }

    /// The running episode: its number and the decisions.
    fn running(&self) -> RunningEpisode {
        let digest = self.state_hash();
        let (next_episode, width) = (self.next_episode, self.episode.width);
        RunningEpisode { next_episode, width, decisions: self.decisions.clone(), digest }
    }

    /// Repeats an episode up to the recorded point, and returns whether it led to the same state.
    ///
    /// Neither the world nor a driver can be copied to a file. But the episode's number and the commands determine it, and ticks are cheap.
    fn replay(&mut self, running: &RunningEpisode) -> bool {
        let Some(number) = running.next_episode.checked_sub(1) else {
            return self.next_episode == 0 && running.decisions.is_empty();
        };
        let pedestrians = self.world.pedestrians.len();
        if !running.decisions.len().is_multiple_of(pedestrians) {
            return false;
        }
        self.set_curriculum(running.width);
        self.begin(number);
        for commands in running.decisions.chunks(pedestrians) {
            let roles = || self.scenario.cast.pedestrians.iter().zip(commands);
            let possible = roles().all(|(role, command)| match role.controller {
                Controller::External => (role.action.speed.0..=role.action.speed.1).contains(&command.speed),
                Controller::Fixed(fixed) => fixed == *command,
            });
            if self.episode.outcome.is_some() || !possible {
                return false;
            }
            self.carry_out(commands);
        }
        self.state_hash() == running.digest
    }

    /// Hashes the start of the running episode and all its states since.
    fn state_hash(&self) -> u64 {
        hashed(self.observers.tally.digest, &self.episode.spawn)
    }

    /// Whether the user asked to stop while a driver or a controller was waited for. Nothing is concluded from the episodes since then.
    pub fn is_stopped(&self) -> bool {
        let ended = self.outcome().and_then(Outcome::fault);
        self.last_fault == Some(Fault::Stopped) || ended == Some(Fault::Stopped)
    }

    /// The driver's last fault, if it failed in ten episodes in a row.
    pub fn hopeless(&self) -> Option<Fault> {
        self.last_fault.filter(|_| self.faults_in_a_row >= MAX_FAULTS)
    }

    /// Draws the next episodes by another spawn rule. It is not probed: it must be a part of the present one around whose poses of the car a
    /// pedestrian can be placed.
    pub fn respawn(&mut self, rule: SpawnRule) {
        Arc::make_mut(&mut self.scenario).spawn = rule;
    }

    #[inline]
    pub(super) fn failed_run_up(&self) -> Option<Fault> {
        match self.run_up.stage {
            Stage::Failed(fault) => Some(fault),
            Stage::RunUp | Stage::Encounter => None,
        }
    }

    /// Simulates a tick of the encounter.
    #[inline]
    fn tick_encounter(&mut self) -> Option<Step> {
        let Self { scenario, world, actions, script, observers, episode, .. } = self;
        episode.held += 1;
        let commands = match script.command(scenario, world) {
            None => &actions.commands,
            Some(stated) => {
                self.scratch.copy_from_slice(&actions.commands);
                self.scratch[0] = stated;
                &self.scratch
            }
        };
        actions.contact = world.tick(&actions.controls, commands);
        observers.tick(&Scene { scenario, world, actions });
        let rule = &scenario.episode;
        let (ticks, held) = (world.ticks, episode.held);
        let over = actions.contact.is_some() || ticks >= rule.ticks || held >= rule.hold || self.is_test_over();
        over.then(|| self.settle())
    }
}

impl Simulation for PedestrianEnv {
    fn scenario(&self) -> &Arc<Scenario> {
        &self.scenario
    }

    fn place(&mut self, draw: Draw) {
        if !self.place_copy(&draw) {
            self.place_drawn(draw);
        }
    }

    fn phase(&self) -> Phase {
        match self.run_up.stage {
            _ if self.episode.outcome.is_some() => Phase::Over,
            Stage::RunUp => Phase::RunUp,
            _ if self.episode.is_due => Phase::Decision,
            _ => Phase::Tick,
        }
    }

    fn decide(&mut self, commands: &[WalkCommand]) {
        assert_eq!(commands.len(), self.actions.commands.len(), "each pedestrian has a command");
        let Self { scenario, world, actions, script, .. } = self;
        let number = self.next_episode.saturating_sub(1);
        if world.ticks == 0
            && let Some(start) = script.begin(scenario, number, world, commands[0])
        {
            actions.starts[0].pose = start;
            world.pedestrians[0].state = PedestrianState::standing(start);
        }
        actions.decide(&scenario.cast, commands);
        self.decisions.extend_from_slice(&actions.commands);
        (self.episode.is_due, self.episode.held) = (false, 0);
        self.observers.decide(&Scene { scenario, world, actions });
    }

    fn tick(&mut self) -> Option<Step> {
        if self.run_up.is_running() {
            self.tick_run_up();
            return None;
        }
        match self.failed_run_up().or_else(|| self.drivers.drive(&self.world, &self.run_up, &mut self.actions)) {
            Some(fault) => Some(self.give_up(fault)),
            None => self.tick_encounter(),
        }
    }

    #[inline]
    fn scene(&self) -> Scene<'_> {
        Scene { scenario: &self.scenario, world: &self.world, actions: &self.actions }
    }

    fn outcome(&self) -> Option<&Outcome> {
        self.episode.outcome.as_ref()
    }

    fn abandon(&mut self, fault: Fault) {
        self.finish(Ending::ControllerError(fault));
    }

    fn run_up_ticks(&self) -> u32 {
        self.run_up.ticks
    }

    fn degrees(&self) -> &[Degree] {
        self.observers.requirements.degrees()
    }

    fn cell(&self) -> Option<FailureCell> {
        FailureCell::new(&self.scene(), self.outcome()?, self.observers.requirements.goal_moment())
    }

    fn judged_fault(&self) -> Option<bool> {
        self.scenario.oracle.is_some().then_some(self.episode.is_fault)
    }

    fn shaping(&self) -> f64 {
        self.scenario.reward.potential.as_ref().map_or(0.0, |formula| {
            RewardRule::worth(
                Some(formula),
                &self.observers.situation(&self.scene()),
                &self.observers.requirements.robustness,
            )
        })
    }

    fn snapshot(&self) -> Option<Box<dyn Simulation>> {
        Some(Box::new(self.copy()?))
    }

    fn batch_size(&self) -> usize {
        self.drivers.policies[0].batch_size()
    }

    fn clone_for_batch(&self) -> Option<Box<dyn Simulation>> {
        let drivers = self.drivers.clone_for_batch(&self.scenario.cast)?;
        Some(Box::new(Self::with_drivers(self.scenario.clone(), self.seed, drivers)))
    }

    fn prepare(&mut self) {
        if self.failed_run_up().is_none() {
            self.drivers.prepare(&self.world, &self.run_up);
        }
    }
}

impl Env for PedestrianEnv {
    fn obs_dim(&self) -> usize {
        self.scenario.cast.obs_dim()
    }

    fn action_bounds(&self) -> Vec<(f64, f64)> {
        self.actions.bounds.clone()
    }

    fn reset(&mut self, state: &mut [f64]) {
        self.begin(self.next_episode);
        self.scene().write_state(state);
    }

    fn step(&mut self, action: &[f64], state: &mut [f64]) -> Step {
        // A driver that failed too often is not asked any more; the training ends with the current update.
        let step = match self.hopeless() {
            Some(_) => Step { reward: 0.0, terminated: false, truncated: true },
            None => {
                let mut commands = std::mem::take(&mut self.scratch);
                self.scene().write_commands(action, &mut commands);
                self.decide(&commands);
                self.scratch = commands;
                loop {
                    if let Some(step) = self.tick() {
                        break step;
                    }
                }
            }
        };
        self.scene().write_state(state);
        step
    }

    /// Whether the episode ended in a failure of the driver.
    fn is_success(&self) -> bool {
        self.is_failure()
    }

    fn is_fault(&self) -> Option<bool> {
        self.judged_fault()
    }

    fn potential(&self) -> f64 {
        self.shaping()
    }

    fn set_curriculum(&mut self, share: f64) {
        if self.source.width.to_bits() != share.to_bits() {
            self.source.width = share;
            self.source.near = self.scenario.spawn.nearest(share);
        }
    }

    fn save(&self) -> Option<Vec<u8>> {
        Some(self.running().to_bytes())
    }

    fn load(&mut self, state: &[u8]) -> bool {
        RunningEpisode::from_bytes(state).is_some_and(|running| self.replay(&running))
    }
}

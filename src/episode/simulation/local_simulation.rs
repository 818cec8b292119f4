mod settle;
mod start;
mod touched;
mod touches;

use std::sync::Arc;

use self::touched::Touches;
use super::drivers::Drivers;
use super::external_world::Bridge;
use super::observers::Observers;
use super::own_walkers::OwnWalkers;
use super::run_up;
use super::run_up::{RunUp, Stage};
use super::script::Script;
use super::tally::{hashed, hashed_start};
use crate::requirement::Degree;
use crate::scenario::spawn::Placing;
use crate::{
    Actions, Draw, Ending, FailureCell, Outcome, Phase, RewardRule, Scenario, Scene, Simulation, Spawn, SpawnRule,
    WrapDriver,
};
use base::seed::Seed;
use learn::Step;
use road::geometry::Pose;
use world::av::Fault;
use world::sim::{PedestrianState, WalkCommand, World};

/// Our simulator: it runs concrete episodes of a scenario, one after another.
///
/// An episode depends only on its [`Draw`]. So two controllers that are evaluated with one seed have the same starts and the same drivers.
///
/// Where the ego starts in its steady state ([`EgoSpeed::Steady`](crate::EgoSpeed::Steady)), the driver first drives alone along a *run-up* that ends at the drawn
/// pose. Tick 0 of the episode is the tick in which it gets there: with its own speed, pose within the lane, and memory. Until then there are
/// no pedestrians; vehicles and traffic lights run. A driver that does not get there within 60 s (120 s where traffic lights work; at most 20,000 ticks) or touches
/// another vehicle starts at the drawn pose, at rest and without memory.
///
/// A decision is one command for each pedestrian of the cast, in the order of their numbers. Those with a controller of their own do not carry
/// it out.
///
/// Where the scenario names an [`ExternalWorld`](crate::ExternalWorld), the car drives there from tick 0 on, and only its run-up is ours. Such an episode
/// has no snapshot.
pub struct LocalSimulation {
    scenario: Arc<Scenario>,
    world: World,
    bridge: Option<Bridge>,
    /// Where the actors of the running episode start.
    placing: Placing,
    /// Time within the cycles of the traffic lights at the start (s).
    light_phase: f64,
    run_up: RunUp,
    drivers: Drivers,
    actions: Actions,
    walkers: OwnWalkers,
    /// Why a pedestrian's own controller failed, which the next tick reports.
    failed_walker: Option<Fault>,
    script: Script,
    episode: Episode,
    /// The touches up to now, while it is open whether there is another.
    touches: Option<Touches>,
    /// Ticks that were simulated after the last one of the episode.
    ticks_beyond: u32,
    observers: Observers,
    /// Memory for the commands of a tick.
    scratch: Vec<WalkCommand>,
}

impl Scenario {
    /// What runs its episodes.
    pub fn simulation(self: &Arc<Self>) -> Box<dyn Simulation> {
        Box::new(LocalSimulation::new(self.clone()))
    }
}

/// The record of the running episode.
#[derive(Debug, Clone, Copy)]
struct Episode {
    /// The number of its start.
    number: u64,
    spawn: Spawn,
    /// The hash of the spawn as it was drawn.
    start: u64,
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
    fn new(number: u64, spawn: Spawn, others: &Placing) -> Self {
        let start = others.drawn().fold(hashed(0, &spawn), hashed_start);
        Self { number, spawn, start, is_due: true, held: 0, reward: 0.0, is_fault: false, outcome: None }
    }
}

impl LocalSimulation {
    /// The scenario's spawn rule must have been probed.
    pub fn new(scenario: Arc<Scenario>) -> Self {
        let drivers = Drivers::of(&scenario.cast);
        Self::with_drivers(scenario, drivers)
    }

    fn with_drivers(scenario: Arc<Scenario>, drivers: Drivers) -> Self {
        let (cast, rule) = (&scenario.cast, &scenario.episode);
        // Prepared here, so that no tick waits for it.
        scenario.town.prepare();
        let mut world = World::new(
            scenario.town.clone(),
            scenario.obstacles.clone(),
            cast.vehicles.iter().map(|role| role.blueprint.clone()).collect(),
            cast.pedestrians.iter().map(|role| role.body).collect(),
            rule.traffic_lights.then_some(rule.light_cycle()),
            rule.tick,
        );
        for (vehicle, role) in world.vehicles.iter_mut().zip(&cast.vehicles) {
            vehicle.is_parked = role.is_parked;
        }
        let (actions, placing) = (Actions::new(cast), Placing::new(&scenario));
        let nowhere = Spawn { ego: Pose::default(), ego_speed: 0.0, pedestrian: Pose::default() };
        Self {
            walkers: OwnWalkers::new(cast),
            failed_walker: None,
            observers: Observers::new(&scenario, &world),
            scratch: actions.commands.clone(),
            actions,
            bridge: scenario.external_world.clone().map(Bridge::new),
            scenario,
            world,
            light_phase: 0.0,
            run_up: RunUp::new(run_up::LENGTH),
            drivers,
            script: Script::default(),
            touches: None,
            ticks_beyond: 0,
            episode: Episode::new(0, nowhere, &placing),
            placing,
        }
    }

    /// A copy in its present state, if all drivers can be copied and the car drives here.
    fn copy(&self) -> Option<Self> {
        if self.bridge.is_some() {
            return None;
        }
        Some(Self {
            bridge: None,
            drivers: self.drivers.snapshot()?,
            walkers: self.walkers.snapshot()?,
            scenario: self.scenario.clone(),
            world: self.world.clone(),
            placing: self.placing.clone(),
            run_up: self.run_up.clone(),
            actions: self.actions.clone(),
            script: self.script.clone(),
            observers: self.observers.clone(),
            touches: self.touches.clone(),
            scratch: self.scratch.clone(),
            ..*self
        })
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
        let contact = match &mut self.bridge {
            None => Ok(world.tick(&actions.controls, commands)),
            Some(bridge) => {
                let own = self.drivers.policies[0].world_driver().map(|name| (name, self.run_up.route()));
                let begun = match world.ticks {
                    0 => bridge.begin(scenario, world, self.drivers.world_seed(), own),
                    _ => Ok(()),
                };
                world.walk(commands);
                begun.and_then(|()| bridge.tick(world, actions.controls[0])).map(|ego| {
                    if own.is_some() {
                        actions.observe(world.ego(), &ego, world.dt);
                    }
                    world.follow(ego)
                })
            }
        };
        actions.contact = match contact {
            Ok(contact) => contact,
            Err(fault) => return Some(self.give_up(Ending::WorldError(fault))),
        };
        observers.tick(&Scene::new(scenario, world, actions));
        if self.goes_on() {
            return None;
        }
        let rule = &self.scenario.episode;
        let (ticks, held) = (self.world.ticks, self.episode.held);
        let over = self.actions.contact.is_some() || ticks >= rule.ticks || held >= rule.hold || self.is_test_over();
        over.then(|| self.settle())
    }
}

impl Simulation for LocalSimulation {
    fn scenario(&self) -> &Arc<Scenario> {
        &self.scenario
    }

    fn respawn(&mut self, rule: SpawnRule) {
        Arc::make_mut(&mut self.scenario).spawn = rule;
    }

    fn place(&mut self, draw: Draw) {
        self.place_drawn(draw);
    }

    fn reseed(&mut self, drivers: &Seed) {
        self.drivers.seed = *drivers;
        self.drivers.reseed(drivers);
        self.walkers.reseed(drivers);
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
        if world.ticks == 0
            && let Some(start) = script.begin(scenario, self.episode.number, world, commands[0])
        {
            actions.starts[0].pose = start;
            world.pedestrians[0].state = PedestrianState::standing(start);
            world.put_on_ground();
        }
        (self.episode.is_due, self.episode.held) = (false, 0);
        match self.walkers.decide(scenario, world, actions, commands) {
            Ok(commands) => actions.decide(&scenario.cast, commands),
            Err(fault) => self.failed_walker = Some(fault),
        }
        self.observers.decide(&Scene::new(scenario, world, actions));
    }

    fn tick(&mut self) -> Option<Step> {
        if self.run_up.is_running() {
            self.tick_run_up();
            return None;
        }
        if let Some(fault) = self.failed_walker {
            return Some(self.give_up(Ending::ControllerError(fault)));
        }
        match self.failed_run_up().or_else(|| self.drivers.drive(&self.world, &self.run_up, &mut self.actions)) {
            // What it did before is known.
            Some(_) if self.go_back() => Some(self.settle()),
            Some(fault) => Some(self.give_up(Ending::Error(fault))),
            None => self.tick_encounter(),
        }
    }

    #[inline]
    fn scene(&self) -> Scene<'_> {
        Scene::new(&self.scenario, &self.world, &self.actions)
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

    fn ticks_beyond(&self) -> u32 {
        self.ticks_beyond
    }

    #[inline]
    fn failed_run_up(&self) -> Option<Fault> {
        match self.run_up.stage {
            Stage::Failed(fault) => Some(fault),
            Stage::RunUp | Stage::Encounter => None,
        }
    }

    fn state_hash(&self) -> u64 {
        hashed(self.observers.tally.digest, &self.episode.spawn)
    }

    fn degrees(&self) -> &[Degree] {
        self.observers.requirements.degrees()
    }

    fn cell(&self) -> Option<FailureCell> {
        FailureCell::new(&self.scene(), self.outcome()?, self.observers.requirements.goal_moment())
    }

    fn judged_fault(&self) -> Option<bool> {
        self.scenario.reward.needs_judgement().then_some(self.episode.is_fault)
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

    fn snapshot_with(&self, wrap: &WrapDriver<'_>) -> Option<Box<dyn Simulation>> {
        let mut copy = self.copy()?;
        let ego = copy.drivers.policies.remove(0);
        copy.drivers.policies.insert(0, wrap(ego));
        Some(Box::new(copy))
    }

    fn snapshot_without(&self, pedestrian: usize) -> Option<Box<dyn Simulation>> {
        let mut copy = self.copy()?;
        copy.world.pedestrians[pedestrian].is_present = false;
        Some(Box::new(copy))
    }

    fn snapshot(&self) -> Option<Box<dyn Simulation>> {
        Some(Box::new(self.copy()?))
    }

    fn batch_size(&self) -> usize {
        self.drivers.policies[0].batch_size()
    }

    fn clone_for_batch(&self) -> Option<Box<dyn Simulation>> {
        if self.bridge.is_some() {
            return None;
        }
        let drivers = self.drivers.clone_for_batch(&self.scenario.cast)?;
        Some(Box::new(Self::with_drivers(self.scenario.clone(), drivers)))
    }

    fn prepare(&mut self) {
        if self.failed_run_up().is_none() {
            self.drivers.prepare(&self.world, &self.run_up);
        }
    }
}

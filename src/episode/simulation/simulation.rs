use std::sync::Arc;

use crate::requirement::Degree;
use crate::{FailureCell, Outcome, Scenario, Scene, SpawnRule};
use base::seed::{Seed, Stream};
use learn::Step;
use world::av::{DrivingPolicy, Fault};
use world::sim::WalkCommand;

/// Makes another driver of a driver.
pub type WrapDriver<'a> = dyn Fn(Box<dyn DrivingPolicy>) -> Box<dyn DrivingPolicy> + 'a;

/// Runs episodes of a scenario, tick by tick: our simulator ([`LocalSimulation`](crate::LocalSimulation)), or a bridge to another one.
///
/// Searches, trainings, evaluations and estimates need no more of a simulator than this. A method with a body is something that a simulator
/// need not be able to do.
pub trait Simulation: Send {
    fn scenario(&self) -> &Arc<Scenario>;

    /// Draws the next episodes by another spawn rule. It is not probed: it must be a part of the present one around whose poses of the car a
    /// pedestrian can be placed.
    fn respawn(&mut self, rule: SpawnRule);

    /// Places the actors. Its run-up follows, if the episode has one.
    fn place(&mut self, draw: Draw);

    /// What the episode waits for.
    fn phase(&self) -> Phase;

    /// Takes one command for each pedestrian, which the next ticks carry out.
    ///
    /// # Panics
    /// When the number of commands is not that of the pedestrians.
    fn decide(&mut self, commands: &[WalkCommand]);

    /// Simulates a tick. Returns the step of the decision with the last of its ticks.
    fn tick(&mut self) -> Option<Step>;

    /// What pedestrians see now.
    fn scene(&self) -> Scene<'_>;

    /// The outcome of the episode; `None` while it runs.
    fn outcome(&self) -> Option<&Outcome>;

    /// Ends an episode whose pedestrians have no further commands, since their controller failed as a program.
    fn abandon(&mut self, fault: Fault);

    /// The ticks of the episode's run-up up to now.
    fn run_up_ticks(&self) -> u32 {
        0
    }

    /// The ticks that were simulated after the last one of an episode, to see whether the car touches another pedestrian.
    fn ticks_beyond(&self) -> u32 {
        0
    }

    /// Why the driver failed in the run-up, which the next tick reports; `None` if it did not.
    fn failed_run_up(&self) -> Option<Fault> {
        None
    }

    /// Draws from another seed what drivers draw from now on, so that copies of one start go on differently.
    fn reseed(&mut self, drivers: &Seed);

    /// The hash of the start of the running episode and of all its states since.
    fn state_hash(&self) -> u64;

    /// The degree of each requirement of the scenario in the episode that has ended; empty without requirements, while it runs, and after a
    /// driver or a controller failed.
    fn degrees(&self) -> &[Degree] {
        &[]
    }

    /// Whether the episode that has ended is a failure by the criterion of the scenario.
    fn is_failure(&self) -> bool {
        self.outcome().is_some_and(|outcome| self.scenario().criterion.is_met(outcome, self.degrees()))
    }

    /// The cell of the failure that ended the episode; `None` if there is none, and if the episode does not count.
    fn cell(&self) -> Option<FailureCell> {
        FailureCell::new(&self.scene(), self.outcome()?, None)
    }

    /// Whether the driver is to blame for the touch that ended the episode; `None` if the reward asks for no judgement.
    fn judged_fault(&self) -> Option<bool> {
        None
    }

    /// The potential of the present state, which shapes the reward of a learner.
    fn shaping(&self) -> f64 {
        0.0
    }

    /// A copy in the present state; `None` if that cannot be copied. Then a caller repeats the episode from its start.
    fn snapshot(&self) -> Option<Box<dyn Simulation>> {
        None
    }

    /// A copy in the present state whose driver under test is what `wrap` makes of it; `None` if that cannot be copied.
    fn snapshot_with(&self, wrap: &WrapDriver<'_>) -> Option<Box<dyn Simulation>> {
        let _ = wrap;
        None
    }

    /// A copy in the present state without a pedestrian; `None` if that cannot be copied.
    fn snapshot_without(&self, pedestrian: usize) -> Option<Box<dyn Simulation>> {
        let _ = pedestrian;
        None
    }

    /// The number of simulations whose drivers are best asked together.
    fn batch_size(&self) -> usize {
        1
    }

    /// Another simulation of the same scenario for a batch; `None` if a batch is no faster.
    fn clone_for_batch(&self) -> Option<Box<dyn Simulation>> {
        None
    }

    /// Lets the drivers prepare for the next tick, so that those of a batch can be asked at once.
    fn prepare(&mut self) {}

    /// Starts an episode and drives its run-up.
    fn start(&mut self, draw: Draw) {
        self.place(draw);
        while self.phase() == Phase::RunUp {
            self.tick();
        }
    }

    /// Carries out a decision: one command for each pedestrian.
    fn carry_out(&mut self, commands: &[WalkCommand]) -> Step {
        self.decide(commands);
        loop {
            if let Some(step) = self.tick() {
                return step;
            }
        }
    }
}

/// Watches an episode.
pub trait Observer {
    /// Whether it watches nothing.
    fn is_idle(&self) -> bool {
        false
    }

    /// Tick 0: the pedestrians have appeared.
    fn begin(&mut self, scene: &Scene<'_>) {
        let _ = scene;
    }

    /// The pedestrians have taken a decision.
    fn decide(&mut self, scene: &Scene<'_>) {
        let _ = scene;
    }

    /// A tick has been simulated.
    fn tick(&mut self, scene: &Scene<'_>) {
        let _ = scene;
    }

    /// The episode is over.
    fn end(&mut self, degrees: &[Degree]) {
        let _ = degrees;
    }
}

/// Nobody watches.
impl Observer for () {
    fn is_idle(&self) -> bool {
        true
    }
}

/// What an episode waits for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Phase {
    /// A tick of its run-up, in which the driver drives alone.
    RunUp,
    /// The next decision of the pedestrians.
    Decision,
    /// A tick that carries out their decision.
    Tick,
    /// Nothing: it is over.
    Over,
}

/// The random numbers of an episode. Equal ones give equal episodes.
#[derive(Debug, Clone)]
pub struct Draw {
    /// The number of the start: it chooses the case if a spawn rule goes through cases in turn.
    pub number: u64,
    /// What the spawn rule draws.
    pub start: Stream,
    /// The seed of all that drivers draw, the way to the start included.
    pub drivers: Seed,
}

impl Draw {
    /// Episode *k* of a seed: it depends only on the seed and on *k*.
    pub fn new(seed: &Seed, number: u64) -> Self {
        let drivers = seed.index(number);
        Self { number, start: drivers.child("spawn").stream(), drivers }
    }
}

/// Carries out a decision, one command for each pedestrian, and lets an observer watch.
pub fn carry_out(simulation: &mut dyn Simulation, commands: &[WalkCommand], observer: &mut dyn Observer) -> Step {
    if observer.is_idle() {
        return simulation.carry_out(commands);
    }
    simulation.decide(commands);
    observer.decide(&simulation.scene());
    loop {
        if let Some(step) = tick(simulation, observer) {
            return step;
        }
    }
}

/// Simulates a tick, and lets an observer watch.
pub(crate) fn tick(simulation: &mut dyn Simulation, observer: &mut dyn Observer) -> Option<Step> {
    let step = simulation.tick();
    observer.tick(&simulation.scene());
    if step.is_some() && simulation.outcome().is_some() {
        observer.end(simulation.degrees());
    }
    step
}

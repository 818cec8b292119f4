use std::collections::BTreeSet;
use std::sync::Arc;

use super::{Failure, StartSet};
use base::seed::Seed;
use episode::requirement::Degree;
use episode::{Draw, FailureCell, Outcome, Phase, Scenario, Scene, Simulation, SpawnRule};
use learn::Step;
use world::av::Fault;
use world::sim::WalkCommand;

/// The simulation of a falsifier: it counts ticks against a budget and stores every failure.
///
/// A decision is carried out only when the budget has all the ticks that it may take, and an episode starts only when it has those of the
/// longest run-up. So the budget is never exceeded. Ticks of a run-up count, since they cost as much as others. A start that is tried
/// again at once continues from a copy of its first tick where the drivers can be copied, so its run-up is driven and counted once. An
/// episode that is given up, or that the budget cuts off, only costs its ticks.
pub struct BudgetedSimulation<'a> {
    scenario: Arc<Scenario>,
    seed: Seed,
    simulation: Box<dyn Simulation>,
    budget: u64,
    used: u64,
    start: u64,
    /// The first tick of the last start that had a run-up, and its number.
    ready: Option<(u64, Box<dyn Simulation>)>,
    commands: Vec<WalkCommand>,
    /// Ticks of the episode before the running decision.
    before: u32,
    /// Memory for the commands of a decision.
    chosen: Vec<WalkCommand>,
    episodes: u64,
    left_out: u64,
    starts: BTreeSet<u64>,
    /// The lowest number of a start, and the hash of that start.
    first_start: Option<(u64, u64)>,
    failures: Vec<Failure>,
    spent: bool,
    stop: &'a (dyn Fn() -> bool + Sync),
    stopped: bool,
    /// Called with the number of ticks used since the last episode began.
    progress: &'a (dyn Fn(u64) + Sync),
    reported_ticks: u64,
    /// Ticks after every decision; only shares record them.
    clock: Option<Vec<u64>>,
    /// The decisions of a share that ended an episode, by their places in its clock.
    ends: Vec<usize>,
}

/// The result of a search.
#[derive(Debug, Clone, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct SearchOutcome {
    /// Ticks that were simulated.
    pub ticks: u64,
    /// Number of finished episodes that count.
    pub episodes: u64,
    /// Number of finished episodes that are left out ([`LeftOut`](episode::LeftOut)): neither they nor their starts are in other numbers.
    pub left_out: u64,
    /// The starts of these episodes.
    pub starts: StartSet,
    /// The lowest number of the starts of all episodes and [`Outcome::start`] of it: searches with equal ones have equal starts.
    pub first_start: Option<(u64, u64)>,
    /// The failures, in the order in which they were found.
    pub failures: Vec<Failure>,
    /// Whether it was stopped from outside.
    pub stopped: bool,
}

impl<'a> BudgetedSimulation<'a> {
    /// Makes one with a budget in ticks. Start *k* depends only on the seed and on *k*. `stop` is queried before every episode.
    pub fn new(scenario: Arc<Scenario>, seed: Seed, budget: u64, stop: &'a (dyn Fn() -> bool + Sync)) -> Self {
        let chosen = vec![WalkCommand::default(); scenario.cast.pedestrians.len()];
        Self {
            simulation: scenario.simulation(),
            scenario,
            seed,
            budget,
            used: 0,
            start: 0,
            ready: None,
            commands: Vec::new(),
            before: 0,
            chosen,
            episodes: 0,
            left_out: 0,
            starts: BTreeSet::new(),
            first_start: None,
            failures: Vec::new(),
            spent: false,
            stop,
            stopped: false,
            progress: &|_| {},
            reported_ticks: 0,
            clock: None,
            ends: Vec::new(),
        }
    }

    /// Reports the ticks that were used since the last report, before every episode. Shares of the budget report their own.
    pub fn with_progress(self, progress: &'a (dyn Fn(u64) + Sync)) -> Self {
        Self { progress, ..self }
    }

    /// Whether the budget is used up.
    pub fn is_spent(&self) -> bool {
        self.spent
    }

    /// Ticks that remain.
    pub fn left(&self) -> u64 {
        self.budget - self.used
    }

    /// Starts an episode from the start with this number; false when the budget is used up.
    pub fn begin(&mut self, start: u64) -> bool {
        self.place(Draw::new(&self.seed, start));
        !self.spent
    }

    /// Carries out the decision for a joint action; `None` if the budget is used up.
    pub fn act(&mut self, action: &[f64]) -> Option<Step> {
        let mut commands = std::mem::take(&mut self.chosen);
        self.scene().write_commands(action, &mut commands);
        let step = self.carry_out(&commands);
        self.chosen = commands;
        (!self.spent).then_some(step)
    }

    fn note(&mut self, outcome: Outcome) {
        self.first_start = earlier(self.first_start, Some((self.start, outcome.start)));
        self.ends.extend(self.clock.as_ref().map(|clock| clock.len() - 1));
        if outcome.left_out.is_some() {
            self.left_out += 1;
            return;
        }
        self.episodes += 1;
        self.starts.insert(self.start);
        if let Some(cell) = self.cell().filter(|_| self.is_failure()) {
            let commands = self.commands.clone();
            let violation = self.scenario.criterion.requirement().and_then(|place| self.degrees().get(place).copied());
            let (start, ticks, simulations) = (self.start, self.used, self.episodes + self.left_out);
            self.failures.push(Failure { start, ticks, simulations, commands, outcome, violation, cell });
        }
    }

    /// Splits the rest of the budget into equal shares that may be used in parallel, one decision at a time.
    pub(super) fn shares(&self, count: u64) -> Vec<Self> {
        let share = |_| {
            let mut share = Self::new(self.scenario.clone(), self.seed, self.left() / count, self.stop)
                .with_progress(self.progress);
            share.clock = Some(Vec::new());
            share
        };
        (0..count).map(share).collect()
    }

    /// Adds the failures of the shares. The shares ran in step, so the ticks of a failure are those that all shares had used after that
    /// decision.
    pub(super) fn take_over(&mut self, shares: Vec<Self>) {
        let (before, simulated) = (self.used, self.episodes + self.left_out);
        let ends: Vec<Vec<usize>> = shares.iter().map(|share| share.ends.clone()).collect();
        let clocks: Vec<Vec<u64>> = shares.iter().map(|share| share.clock.clone().unwrap_or_default()).collect();
        let at = |clock: &Vec<u64>, decision: usize| match clock.get(decision) {
            Some(ticks) => *ticks,
            None => clock.last().copied().unwrap_or(0),
        };
        for (share, clock) in shares.into_iter().zip(&clocks) {
            self.used += share.used;
            self.reported_ticks += share.reported_ticks;
            self.episodes += share.episodes;
            self.left_out += share.left_out;
            self.starts.extend(share.starts);
            self.first_start = earlier(self.first_start, share.first_start);
            self.stopped |= share.stopped;
            self.spent |= share.spent;
            self.failures.extend(share.failures.into_iter().map(|failure| {
                let decision = clock.partition_point(|ticks| *ticks < failure.ticks);
                let ticks = before + clocks.iter().map(|clock| at(clock, decision)).sum::<u64>();
                let ended = ends.iter().map(|ends| ends.partition_point(|end| *end <= decision) as u64);
                Failure { ticks, simulations: simulated + ended.sum::<u64>(), ..failure }
            }));
        }
        self.failures.sort_by_key(|failure| (failure.ticks, failure.start));
    }

    /// The result of the search.
    pub fn into_spent(self) -> SearchOutcome {
        SearchOutcome {
            ticks: self.used,
            episodes: self.episodes,
            left_out: self.left_out,
            starts: self.starts.into_iter().collect(),
            first_start: self.first_start,
            failures: self.failures,
            stopped: self.stopped,
        }
    }
}

/// What a decision is worth that the budget does not have.
const NO_STEP: Step = Step { reward: 0.0, terminated: true, truncated: false };

/// When the budget is used up, no episode starts and the running one is over without an outcome.
impl Simulation for BudgetedSimulation<'_> {
    fn scenario(&self) -> &Arc<Scenario> {
        &self.scenario
    }

    fn respawn(&mut self, rule: SpawnRule) {
        self.ready = None;
        self.simulation.respawn(rule);
    }

    fn place(&mut self, draw: Draw) {
        (self.progress)(self.used - self.reported_ticks);
        self.reported_ticks = self.used;
        self.stopped |= (self.stop)();
        let start = draw.number;
        let ready = self.ready.as_ref().filter(|(number, _)| *number == start).and_then(|(_, ready)| ready.snapshot());
        self.spent |= self.stopped || (ready.is_none() && self.left() < self.scenario.most_run_up().into());
        if self.spent {
            return;
        }
        self.start = start;
        self.commands.clear();
        match ready {
            Some(ready) => self.simulation = ready,
            None => {
                self.simulation.start(draw);
                let ticks = self.simulation.run_up_ticks();
                self.used += u64::from(ticks);
                self.ready = (ticks > 0).then(|| self.simulation.snapshot()).flatten().map(|ready| (start, ready));
            }
        }
    }

    fn phase(&self) -> Phase {
        if self.spent { Phase::Over } else { self.simulation.phase() }
    }

    fn decide(&mut self, commands: &[WalkCommand]) {
        let rule = &self.scenario.episode;
        self.before = self.scene().world.ticks;
        let longest = rule.hold.min(rule.ticks - self.before) + self.scenario.most_ticks_beyond();
        self.spent |= self.left() < longest.into();
        if !self.spent {
            self.simulation.decide(commands);
            self.commands.extend_from_slice(self.simulation.scene().commands());
        }
    }

    fn tick(&mut self) -> Option<Step> {
        if self.spent {
            return Some(NO_STEP);
        }
        let step = self.simulation.tick();
        if step.is_some() {
            self.used += u64::from(self.scene().world.ticks - self.before + self.simulation.ticks_beyond());
            if let Some(clock) = &mut self.clock {
                clock.push(self.used);
            }
            if let Some(outcome) = self.outcome().copied() {
                self.note(outcome);
            }
        }
        step
    }

    fn scene(&self) -> Scene<'_> {
        self.simulation.scene()
    }

    fn outcome(&self) -> Option<&Outcome> {
        self.simulation.outcome().filter(|_| !self.spent)
    }

    fn abandon(&mut self, fault: Fault) {
        self.simulation.abandon(fault);
    }

    fn run_up_ticks(&self) -> u32 {
        self.simulation.run_up_ticks()
    }

    fn failed_run_up(&self) -> Option<Fault> {
        self.simulation.failed_run_up()
    }

    fn reseed(&mut self, drivers: &Seed) {
        self.simulation.reseed(drivers);
    }

    fn state_hash(&self) -> u64 {
        self.simulation.state_hash()
    }

    fn degrees(&self) -> &[Degree] {
        self.simulation.degrees()
    }

    fn is_failure(&self) -> bool {
        self.simulation.is_failure()
    }

    fn cell(&self) -> Option<FailureCell> {
        self.simulation.cell()
    }

    fn judged_fault(&self) -> Option<bool> {
        self.simulation.judged_fault()
    }

    fn shaping(&self) -> f64 {
        self.simulation.shaping()
    }
}

/// The start with the lesser number.
fn earlier(one: Option<(u64, u64)>, other: Option<(u64, u64)>) -> Option<(u64, u64)> {
    one.into_iter().chain(other).min()
}

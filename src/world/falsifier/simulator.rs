use std::collections::BTreeSet;
use std::sync::Arc;

use super::{Failure, StartSet};
use crate::env::{FailureCell, Outcome, PedestrianEnv, Scenario, Scene};
use crate::sim::WalkCommand;
use base::seed::Seed;
use learn::Step;

/// The simulator of a falsifier: it counts ticks against a budget and stores every collision.
///
/// A decision is carried out only when the budget has all the ticks that it may take, and an episode starts only when it has those of the
/// longest run-up. So the budget is never exceeded. Ticks of a run-up count, since they cost as much as others. A start that is tried
/// again at once continues from a copy of its first tick where the drivers can be copied, so its run-up is driven and counted once. An
/// episode that is given up, or that the budget cuts off, only costs its ticks.
pub struct Simulator<'a> {
    scenario: Arc<Scenario>,
    seed: Seed,
    env: PedestrianEnv,
    budget: u64,
    used: u64,
    start: u64,
    /// The first tick of the last start that had a run-up, and its number.
    ready: Option<(u64, PedestrianEnv)>,
    commands: Vec<WalkCommand>,
    /// Memory for the commands of a decision.
    chosen: Vec<WalkCommand>,
    episodes: u64,
    left_out: u64,
    starts: BTreeSet<u64>,
    /// The least number of a start, and the hash of that start.
    first_start: Option<(u64, u64)>,
    failures: Vec<Failure>,
    spent: bool,
    stop: &'a (dyn Fn() -> bool + Sync),
    stopped: bool,
    /// Hears the ticks that were used since the last episode began.
    progress: &'a (dyn Fn(u64) + Sync),
    heard: u64,
    /// Ticks after every decision; only shares record them.
    clock: Option<Vec<u64>>,
    /// The decisions of a share that ended an episode, by their places in its clock.
    ends: Vec<usize>,
}

/// The result of a search.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct SearchOutcome {
    /// Ticks that were simulated.
    pub ticks: u64,
    /// Number of finished episodes that count.
    pub episodes: u64,
    /// Number of finished episodes that are left out ([`LeftOut`](crate::env::LeftOut)): neither they nor their starts are in other numbers.
    pub left_out: u64,
    /// The starts of these episodes.
    pub starts: StartSet,
    /// The least number of the starts of all episodes and [`Outcome::start`] of it: searches with equal ones have equal starts.
    pub first_start: Option<(u64, u64)>,
    /// The failures, in the order in which they were found.
    pub failures: Vec<Failure>,
    /// Whether it was stopped from outside.
    pub stopped: bool,
}

impl<'a> Simulator<'a> {
    /// Makes a simulator with a budget in ticks. Start *k* depends only on the seed and on *k*. `stop` is queried before every episode.
    pub fn new(scenario: Arc<Scenario>, seed: Seed, budget: u64, stop: &'a (dyn Fn() -> bool + Sync)) -> Self {
        let chosen = vec![WalkCommand::default(); scenario.cast.pedestrian_count()];
        Self {
            env: PedestrianEnv::new(scenario.clone(), seed),
            scenario,
            seed,
            budget,
            used: 0,
            start: 0,
            ready: None,
            commands: Vec::new(),
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
            heard: 0,
            clock: None,
            ends: Vec::new(),
        }
    }

    /// Reports the ticks that were used since the last report, before every episode. Shares of the budget report their own.
    pub fn with_progress(self, progress: &'a (dyn Fn(u64) + Sync)) -> Self {
        Self { progress, ..self }
    }

    /// The environment as it is now.
    pub fn env(&self) -> &PedestrianEnv {
        &self.env
    }

    /// What pedestrians see now.
    pub fn scene(&self) -> Scene<'_> {
        self.env.scene()
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
        (self.progress)(self.used - self.heard);
        self.heard = self.used;
        self.stopped |= (self.stop)();
        let ready = self.ready.as_ref().filter(|(number, _)| *number == start).and_then(|(_, env)| env.snapshot());
        self.spent |= self.stopped || (ready.is_none() && self.left() < self.scenario.most_run_up().into());
        if self.spent {
            return false;
        }
        self.start = start;
        self.commands.clear();
        match ready {
            Some(env) => self.env = env,
            None => {
                self.env.begin(start);
                self.used += u64::from(self.env.run_up_ticks());
                let has_run_up = self.env.run_up_ticks() > 0;
                self.ready = has_run_up.then(|| self.env.snapshot()).flatten().map(|env| (start, env));
            }
        }
        true
    }

    /// Carries out a decision, one command for each pedestrian; none when the budget is used up. The step reports whether the episode is
    /// over.
    pub fn step(&mut self, commands: &[WalkCommand]) -> Option<Step> {
        let rule = &self.env.scenario().episode;
        let before = self.env.world().ticks;
        let most = rule.hold.min(rule.ticks - before);
        if self.spent || self.left() < most.into() {
            self.spent = true;
            return None;
        }
        let step = self.env.carry_out(commands);
        self.used += u64::from(self.env.world().ticks - before);
        self.commands.extend_from_slice(self.env.scene().commands);
        if let Some(clock) = &mut self.clock {
            clock.push(self.used);
        }
        if let Some(outcome) = self.env.outcome().copied() {
            self.note(outcome);
        }
        Some(step)
    }

    /// Carries out the decision for a joint action, as [`Simulator::step`] does.
    pub fn act(&mut self, action: &[f64]) -> Option<Step> {
        self.decide(|scene, commands| scene.write_commands(action, commands))
    }

    /// Runs the episode to its end; none when the budget is used up before. `choose` writes the commands of each decision.
    pub fn finish(&mut self, mut choose: impl FnMut(&Scene<'_>, &mut [WalkCommand])) -> Option<Outcome> {
        loop {
            self.decide(&mut choose)?;
            if let Some(outcome) = self.env.outcome() {
                return Some(*outcome);
            }
        }
    }

    fn decide(&mut self, choose: impl FnOnce(&Scene<'_>, &mut [WalkCommand])) -> Option<Step> {
        let mut commands = std::mem::take(&mut self.chosen);
        choose(&self.env.scene(), &mut commands);
        let step = self.step(&commands);
        self.chosen = commands;
        step
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
        if let Some(cell) = FailureCell::new(&self.env).filter(|_| self.env.is_failure()) {
            let commands = self.commands.clone();
            let violation =
                self.scenario.criterion.requirement().and_then(|place| self.env.degrees().get(place).copied());
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
            self.heard += share.heard;
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

/// The start with the lesser number.
fn earlier(one: Option<(u64, u64)>, other: Option<(u64, u64)>) -> Option<(u64, u64)> {
    one.into_iter().chain(other).min()
}

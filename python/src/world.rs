//! One world: an environment, the record of its episode, and where it is in its sequence of episodes.

use std::sync::Arc;

use base::seed::Seed;
use episode::requirement::{Degree, NamedRequirement};
use episode::walker::FaultStreak;
use episode::{Draw, Observer, Outcome, Scenario, Simulation, Trace, carry_out};
use learn::Step;
use verdict::{Judged, Verdict, ViolationVerdict};
use world::sim::WalkCommand;

/// The end of an episode.
#[derive(Debug, Clone)]
pub struct End {
    /// The seed of the user that the episode belongs to.
    pub seed: u64,
    /// Its number.
    pub episode: u64,
    /// Its outcome.
    pub outcome: Outcome,
    /// The verdict of the reference drivers; `None` without a collision.
    pub verdict: Option<Verdict>,
    /// Each requirement of the scenario with its degree, and whose fault its violation is; empty without requirements, and in error.
    pub requirements: Vec<(NamedRequirement, Degree, Option<ViolationVerdict>)>,
    /// Whether the driver failed: a collision, or a violation of the goal of a search.
    pub is_failure: bool,
}

/// The seed of the starts of a campaign with a seed.
pub type Starts = Arc<dyn Fn(&Seed) -> Seed + Send + Sync>;

/// A world. Episode *k* of a seed has the start of episode *k* of every evaluation in the town that a campaign with this seed runs; in the
/// scenario of a search, start *k* of its first run.
pub struct World {
    simulation: Box<dyn Simulation>,
    trace: Trace,
    starts: Starts,
    seed: u64,
    /// Number of the present episode; `None` before the first.
    episode: Option<u64>,
    /// The state after the last step, in the units of the controller.
    pub state: Vec<f64>,
    /// The last state of an episode that ended in the last step.
    pub last_state: Vec<f64>,
    commands: Vec<WalkCommand>,
    action: Vec<f64>,
    /// The last step.
    pub step: Step,
    /// Whether the last step also started the present episode.
    started_over: bool,
    /// The end of the last episode.
    pub end: Option<End>,
    /// Whether the driver did not reach the start of the present episode in its run-up.
    pub placed: bool,
    /// The run-ups that did not reach their start, and all of them.
    pub run_ups: (u64, u64),
    faults: FaultStreak,
}

/// The step of an episode that has just started.
const FIRST: Step = Step { reward: 0.0, terminated: false, truncated: false };

impl World {
    /// A world before its first episode.
    pub fn new(scenario: &Arc<Scenario>, starts: &Starts, seed: u64) -> Self {
        let cast = &scenario.cast;
        Self {
            simulation: scenario.simulation(),
            trace: Trace::new(scenario),
            starts: starts.clone(),
            seed,
            episode: None,
            state: vec![0.0; cast.obs_dim()],
            last_state: vec![0.0; cast.obs_dim()],
            commands: vec![WalkCommand::default(); cast.pedestrians.len()],
            action: vec![0.0; cast.action_bounds().len()],
            step: FIRST,
            started_over: false,
            end: None,
            placed: false,
            run_ups: (0, 0),
            faults: FaultStreak::default(),
        }
    }

    /// The next episodes belong to this seed; the next one is number 0.
    pub fn reseed(&mut self, seed: u64) {
        (self.seed, self.episode) = (seed, None);
    }

    /// Starts an episode: that of the number, or the next one.
    pub fn reset(&mut self, episode: Option<u64>) {
        let number = episode.unwrap_or_else(|| self.episode.map_or(0, |last| last.wrapping_add(1)));
        self.simulation.start(Draw::new(&(self.starts)(&Seed::root(self.seed)), number));
        let has_run_up = self.simulation.run_up_ticks() > 0;
        self.placed = has_run_up && self.simulation.scene().world.ego().state.speed == 0.0;
        self.run_ups = (self.run_ups.0 + u64::from(self.placed), self.run_ups.1 + u64::from(has_run_up));
        self.trace.begin(&self.simulation.scene());
        self.simulation.scene().write_state(&mut self.state);
        (self.episode, self.step, self.started_over) = (Some(number), FIRST, false);
    }

    /// Starts the next episode in the step that ended the last one: its last state and its step stay visible.
    pub fn start_over(&mut self) {
        let step = self.step;
        self.last_state.copy_from_slice(&self.state);
        self.reset(None);
        self.step = step;
        self.started_over = true;
    }

    /// Takes a decision. The action is clamped to its bounds.
    pub fn decide(&mut self, action: impl Iterator<Item = f64>) {
        for ((number, (low, high)), given) in self.action.iter_mut().zip(self.simulation.scene().bounds()).zip(action) {
            *number = given.clamp(*low, *high);
        }
        self.started_over = false;
        self.simulation.scene().write_commands(&self.action, &mut self.commands);
        self.step = carry_out(&mut *self.simulation, &self.commands, &mut self.trace);
        self.simulation.scene().write_state(&mut self.state);
        if let (Some(outcome), Some(episode)) = (self.simulation.outcome(), self.episode) {
            let scenario = self.simulation.scenario();
            let pair = self.trace.main_pair(scenario);
            let Judged { outcome, verdict, degrees } = Judged::new(outcome, &pair);
            let requirements = scenario.requirements.iter().cloned().zip(degrees);
            let requirements = requirements.map(|(named, judged)| (named, judged.degree, judged.verdict)).collect();
            let is_failure = self.simulation.is_failure();
            self.faults.count(outcome.fault());
            self.end = Some(End { seed: self.seed, episode, outcome, verdict, requirements, is_failure });
        }
    }

    /// Whether an episode runs.
    pub fn is_running(&self) -> bool {
        self.episode.is_some() && (self.started_over || !self.step.done())
    }

    /// The seed and the number of the present episode; `None` before the first.
    pub fn place(&self) -> Option<(u64, u64)> {
        self.episode.map(|episode| (self.seed, episode))
    }

    /// The simulation of the present episode.
    pub fn simulation(&self) -> &dyn Simulation {
        &*self.simulation
    }

    /// The episodes in a row in which the driver failed.
    pub fn faults(&self) -> &FaultStreak {
        &self.faults
    }

    /// The record of the present episode.
    pub fn trace(&self) -> &Trace {
        &self.trace
    }
}

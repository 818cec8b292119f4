use std::ops::{ControlFlow, Range};
use std::sync::Arc;

use super::play::{advance, place, play};
use super::walker::{FaultStreak, WalkPolicy};
use crate::{Draw, Outcome, Phase, Scenario, Simulation, Trace};
use base::seed::Seed;
use world::av::Fault;
use world::sim::WalkCommand;

/// Evaluates a walk policy in this number of episodes, and reports the number of finished episodes to the observer.
///
/// Episode *k* starts the same for every policy that is evaluated with the same `episodes_seed`. The policy's own random numbers come from
/// `walker_seed`. Ends early, with the first episodes up to there, when the observer breaks or when the driver or the walk policy has failed
/// in ten episodes in a row.
///
/// Where a batch is faster for the driver ([`DrivingPolicy::clone_for_batch`](world::av::DrivingPolicy::clone_for_batch)), several
/// episodes run at once, tick by tick. That changes no outcome: episodes are independent, and when a driver fails in a batch, each
/// episode of the batch is run again alone.
pub fn evaluate(
    walker: &mut dyn WalkPolicy,
    scenario: &Arc<Scenario>,
    episodes: u32,
    episodes_seed: &Seed,
    walker_seed: &Seed,
    observer: &mut dyn FnMut(u32) -> ControlFlow<()>,
) -> Vec<Outcome> {
    let note = &mut |_: u32, outcome: &Outcome, _: &Trace| *outcome;
    evaluate_observed(walker, scenario, 0..episodes, episodes_seed, walker_seed, note, observer)
}

/// Evaluates a walk policy as [`evaluate`] does in the episodes with these numbers. `note` gets the number, the outcome and the
/// trace of each episode that is over; what it returns is collected.
///
/// An episode is the same in every range that contains it.
pub fn evaluate_observed<T>(
    walker: &mut dyn WalkPolicy,
    scenario: &Arc<Scenario>,
    episodes: Range<u32>,
    episodes_seed: &Seed,
    walker_seed: &Seed,
    note: &mut dyn FnMut(u32, &Outcome, &Trace) -> T,
    observer: &mut dyn FnMut(u32) -> ControlFlow<()>,
) -> Vec<T> {
    let mut simulation = scenario.simulation();
    let mut batch = batch(&*simulation, walker, episodes.len());
    let mut numbers = u64::from(episodes.start)..u64::from(episodes.end);
    let mut trial = Trial {
        seeds: (episodes_seed, walker_seed),
        policies: None,
        note,
        observer,
        first: numbers.start,
        notes: episodes.map(|_| None).collect(),
        done: 0,
        settled: 0,
        faults: FaultStreak::default(),
    };
    let _ = if batch.is_empty() {
        let mut trace = Trace::new(scenario);
        numbers.try_for_each(|episode| trial.alone(&mut *simulation, walker, &mut trace, episode))
    } else {
        trial.together(&mut batch, numbers)
    };
    trial.noted()
}

/// The walk policies of [`evaluate_in_batch`], by their number, and how many there are.
pub type Policies<'a> = (&'a dyn Fn(u64) -> Box<dyn WalkPolicy>, u64);

/// Evaluates in a batch several walk policies that draw nothing, from each of these starts: start by start, the policies in their order. Ends early as
/// [`evaluate_observed`] does. `None` where a batch is no faster.
pub fn evaluate_in_batch<T>(
    policies: Policies<'_>,
    scenario: &Arc<Scenario>,
    starts: Range<u32>,
    seed: &Seed,
    note: &mut dyn FnMut(&Outcome, &Trace) -> T,
    observer: &mut dyn FnMut(u32) -> ControlFlow<()>,
) -> Option<Vec<T>> {
    let [first, end] = [starts.start, starts.end].map(|start| u64::from(start) * policies.1);
    let mut batch = batch(&*scenario.simulation(), (policies.0)(0).as_ref(), (end - first) as usize);
    let mut trial = Trial {
        seeds: (seed, seed),
        policies: Some(policies),
        note: &mut |_: u32, outcome: &Outcome, trace: &Trace| note(outcome, trace),
        observer,
        first,
        notes: (first..end).map(|_| None).collect(),
        done: 0,
        settled: 0,
        faults: FaultStreak::default(),
    };
    (!batch.is_empty()).then(|| {
        let _ = trial.together(&mut batch, first..end);
        trial.noted()
    })
}

/// One episode of a batch.
struct Slot {
    simulation: Box<dyn Simulation>,
    walker: Box<dyn WalkPolicy>,
    trace: Trace,
    commands: Vec<WalkCommand>,
    episode: Option<u64>,
}

impl Slot {
    fn advance(&mut self) {
        advance(&mut *self.simulation, self.walker.as_mut(), &mut self.commands, &mut self.trace);
    }
}

/// One slot for each episode of a batch; empty if a batch is no faster than single episodes.
fn batch(simulation: &dyn Simulation, walker: &dyn WalkPolicy, episodes: usize) -> Vec<Slot> {
    let wanted = simulation.batch_size().min(episodes);
    let scenario = simulation.scenario();
    let (trace, commands) = (Trace::new(scenario), vec![WalkCommand::default(); scenario.cast.pedestrians.len()]);
    let slot = || {
        let (simulation, walker) = (simulation.clone_for_batch()?, walker.clone_for_batch()?);
        Some(Slot { simulation, walker, trace: trace.clone(), commands: commands.clone(), episode: None })
    };
    if wanted > 1 { (0..wanted).map_while(|_| slot()).collect() } else { Vec::new() }
}

struct Trial<'a, T> {
    /// Those of the episodes and of the walk policy.
    seeds: (&'a Seed, &'a Seed),
    /// Those that walk from each start, one after another; `None` if one does.
    policies: Option<Policies<'a>>,
    note: &'a mut dyn FnMut(u32, &Outcome, &Trace) -> T,
    observer: &'a mut dyn FnMut(u32) -> ControlFlow<()>,
    /// Number of the first episode.
    first: u64,
    /// The result of `note` for each episode, and the fault of the driver or controller that failed in it.
    notes: Vec<Option<(T, Option<Fault>)>>,
    done: u32,
    /// Episodes up to the first that is not finished yet.
    settled: usize,
    /// Those of these that are in error.
    faults: FaultStreak,
}

impl<T> Trial<'_, T> {
    fn begin(&self, simulation: &mut dyn Simulation, walker: &mut dyn WalkPolicy, trace: &mut Trace, episode: u64) {
        walker.begin(self.seeds.1.index(episode).stream());
        let start = self.policies.map_or(episode, |(_, count)| episode / count);
        place(simulation, Draw::new(self.seeds.0, start), trace);
    }

    /// What was noted of the episodes up to the first that is not finished.
    fn noted(self) -> Vec<T> {
        self.notes.into_iter().take(self.settled).flatten().map(|(noted, _)| noted).collect()
    }

    fn alone(
        &mut self,
        simulation: &mut dyn Simulation,
        walker: &mut dyn WalkPolicy,
        trace: &mut Trace,
        episode: u64,
    ) -> ControlFlow<()> {
        self.begin(simulation, walker, trace, episode);
        let outcome = play(simulation, walker, trace).expect("our simulator ends every episode");
        self.record(episode, &outcome, trace)
    }

    fn together(&mut self, batch: &mut [Slot], mut episodes: Range<u64>) -> ControlFlow<()> {
        loop {
            for slot in batch.iter_mut().filter(|slot| slot.episode.is_none()) {
                slot.episode = episodes.next();
                if let Some(episode) = slot.episode {
                    if let Some((policy, count)) = self.policies {
                        slot.walker = policy(episode % count);
                    }
                    self.begin(&mut *slot.simulation, slot.walker.as_mut(), &mut slot.trace, episode);
                }
            }
            let mut running: Vec<&mut Slot> = batch.iter_mut().filter(|slot| slot.episode.is_some()).collect();
            if running.is_empty() {
                return ControlFlow::Continue(());
            }
            for slot in &mut running {
                if slot.simulation.phase() == Phase::Decision {
                    slot.advance();
                }
                if slot.simulation.phase() != Phase::Over {
                    slot.simulation.prepare();
                }
            }
            let mut failed = Vec::new();
            for slot in running {
                slot.advance();
                let Some(outcome) = slot.simulation.outcome().copied() else { continue };
                let Some(episode) = slot.episode.take() else { continue };
                match outcome.fault() {
                    Some(Fault::Stopped) => return ControlFlow::Break(()),
                    Some(_) => failed.push((episode, slot)),
                    None => self.record(episode, &outcome, &slot.trace)?,
                }
            }
            failed.sort_by_key(|(episode, _)| *episode);
            for (episode, slot) in failed {
                self.alone(&mut *slot.simulation, slot.walker.as_mut(), &mut slot.trace, episode)?;
            }
        }
    }

    fn record(&mut self, episode: u64, outcome: &Outcome, trace: &Trace) -> ControlFlow<()> {
        if outcome.fault() == Some(Fault::Stopped) {
            return ControlFlow::Break(());
        }
        let noted = (self.note)(episode as u32, outcome, trace);
        self.notes[(episode - self.first) as usize] = Some((noted, outcome.fault()));
        self.done += 1;
        while let Some(Some((_, fault))) = self.notes.get(self.settled) {
            self.settled += 1;
            self.faults.count(*fault);
            if self.faults.hopeless().is_some() {
                return ControlFlow::Break(());
            }
        }
        (self.observer)(self.done)
    }
}

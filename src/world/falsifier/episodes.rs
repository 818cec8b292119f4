use std::ops::{ControlFlow, Range};
use std::sync::Arc;

use super::WalkPolicy;
use crate::av::Fault;
use crate::env::{Outcome, PedestrianEnv, Scenario, Scene, Trace};
use crate::sim::WalkCommand;
use base::seed::Seed;

/// Number of episodes in a row that a driver or a controller may fail; then no more are run.
pub(super) const MOST_FAULTS: usize = 10;

/// Evaluates a walk policy in this number of episodes, and reports the number of finished episodes to the observer.
///
/// Episode *k* starts the same for every policy that is evaluated with the same `episodes_seed`. The policy's own random numbers come from
/// `walker_seed`. Ends early, with the first episodes up to there, when the observer breaks or when the driver or the walk policy has failed
/// in ten episodes in a row.
///
/// Where a batch is faster for the driver ([`DrivingPolicy::clone_for_batch`](crate::av::DrivingPolicy::clone_for_batch)), several
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
    evaluate_noting(walker, scenario, 0..episodes, episodes_seed, walker_seed, note, observer)
}

/// Evaluates a walk policy as [`evaluate`] does in the episodes with these numbers. `note` gets the number, the outcome and the
/// trace of each episode that is over; what it returns is collected.
///
/// An episode is the same in every range that contains it.
pub fn evaluate_noting<T>(
    walker: &mut dyn WalkPolicy,
    scenario: &Arc<Scenario>,
    episodes: Range<u32>,
    episodes_seed: &Seed,
    walker_seed: &Seed,
    note: &mut dyn FnMut(u32, &Outcome, &Trace) -> T,
    observer: &mut dyn FnMut(u32) -> ControlFlow<()>,
) -> Vec<T> {
    let mut env = PedestrianEnv::new(scenario.clone(), *episodes_seed);
    let mut places = places(&env, walker, episodes.len());
    let notes = episodes.clone().map(|_| None).collect();
    let mut numbers = u64::from(episodes.start)..u64::from(episodes.end);
    let mut trial = Trial { walker_seed, note, observer, first: numbers.start, notes, done: 0, settled: 0, faults: 0 };
    let _ = if places.is_empty() {
        let mut trace = Trace::new(scenario);
        numbers.try_for_each(|episode| trial.alone(&mut env, walker, &mut trace, episode))
    } else {
        trial.together(&mut places, numbers)
    };
    trial.notes.into_iter().take(trial.settled).flatten().map(|(noted, _)| noted).collect()
}

/// One episode of a batch.
struct Place {
    env: PedestrianEnv,
    walker: Box<dyn WalkPolicy>,
    trace: Trace,
    commands: Vec<WalkCommand>,
    episode: Option<u64>,
}

impl Place {
    /// Takes the first decision if the run-up is over.
    fn meet(&mut self) {
        if !self.env.is_running_up() {
            self.trace.begin(self.env.world());
            self.decide();
        }
    }

    /// Takes a decision, or ends the episode when the walk policy fails.
    fn decide(&mut self) {
        self.walker.choose(&self.env.scene(), &mut self.commands);
        if let Some(fault) = self.walker.fault() {
            return self.env.abandon(fault);
        }
        self.env.begin_decision(&self.commands);
        self.trace.decide(self.env.world(), self.env.scene().commands);
    }
}

/// Runs the episode with this number and records its trace. `choose` writes the commands of each decision. None when `choose` returns none
/// before the end.
pub(crate) fn play(
    env: &mut PedestrianEnv,
    trace: &mut Trace,
    episode: u64,
    choose: impl FnMut(&Scene<'_>, &mut [WalkCommand]) -> Option<()>,
) -> Option<Outcome> {
    env.begin(episode);
    play_begun(env, trace, choose)
}

/// As [`play`], but the episode has begun.
pub(super) fn play_begun(
    env: &mut PedestrianEnv,
    trace: &mut Trace,
    mut choose: impl FnMut(&Scene<'_>, &mut [WalkCommand]) -> Option<()>,
) -> Option<Outcome> {
    trace.begin(env.world());
    let mut commands = vec![WalkCommand::default(); trace.pedestrian_count()];
    loop {
        choose(&env.scene(), &mut commands)?;
        trace.watch_decision(env, &commands);
        if let Some(outcome) = env.outcome() {
            return Some(*outcome);
        }
    }
}

/// One slot for each episode of a batch; none when a batch is no faster than single episodes.
fn places(env: &PedestrianEnv, walker: &dyn WalkPolicy, episodes: usize) -> Vec<Place> {
    let wanted = env.batch_size().min(episodes);
    let (trace, commands) = (Trace::new(env.scenario()), vec![WalkCommand::default(); env.world().pedestrians.len()]);
    let place = || {
        let (env, walker) = (env.clone_for_batch()?, walker.clone_for_batch()?);
        Some(Place { env, walker, trace: trace.clone(), commands: commands.clone(), episode: None })
    };
    if wanted > 1 { (0..wanted).map_while(|_| place()).collect() } else { Vec::new() }
}

struct Trial<'a, T> {
    walker_seed: &'a Seed,
    note: &'a mut dyn FnMut(u32, &Outcome, &Trace) -> T,
    observer: &'a mut dyn FnMut(u32) -> ControlFlow<()>,
    /// Number of the first episode.
    first: u64,
    /// The result of `note` for each episode, and whether the driver failed in it.
    notes: Vec<Option<(T, bool)>>,
    done: u32,
    /// Episodes up to the first that is not finished yet.
    settled: usize,
    /// The number of the last of these that are in error.
    faults: usize,
}

impl<T> Trial<'_, T> {
    fn alone(
        &mut self,
        env: &mut PedestrianEnv,
        walker: &mut dyn WalkPolicy,
        trace: &mut Trace,
        episode: u64,
    ) -> ControlFlow<()> {
        walker.begin(self.walker_seed.index(episode).stream());
        let played = play(env, trace, episode, |scene, commands| {
            walker.choose(scene, commands);
            walker.fault().is_none().then_some(())
        });
        if let (None, Some(fault)) = (played, walker.fault()) {
            env.abandon(fault);
        }
        let outcome = *env.outcome().expect("an episode ends, or its walk policy fails");
        self.record(episode, &outcome, trace)
    }

    fn together(&mut self, places: &mut [Place], mut episodes: Range<u64>) -> ControlFlow<()> {
        loop {
            for place in places.iter_mut().filter(|place| place.episode.is_none()) {
                place.episode = episodes.next();
                if let Some(episode) = place.episode {
                    place.env.place(episode);
                    place.walker.begin(self.walker_seed.index(episode).stream());
                    place.meet();
                }
            }
            let mut running: Vec<&mut Place> = places.iter_mut().filter(|place| place.episode.is_some()).collect();
            if running.is_empty() {
                return ControlFlow::Continue(());
            }
            running.iter_mut().filter(|place| place.env.outcome().is_none()).for_each(|place| place.env.prepare());
            let mut failed = Vec::new();
            for place in running {
                if place.env.is_stopped() {
                    return ControlFlow::Break(());
                }
                if place.env.outcome().is_some() {
                    // Its walk policy failed.
                    failed.extend(place.episode.take().map(|episode| (episode, place)));
                    continue;
                }
                if place.env.is_running_up() {
                    place.env.tick_run_up();
                    place.meet();
                    continue;
                }
                if place.trace.watch_tick(&mut place.env).is_none() {
                    continue;
                }
                match (place.env.outcome().copied(), place.episode) {
                    (Some(outcome), _) if outcome.fault() == Some(Fault::Stopped) => return ControlFlow::Break(()),
                    (Some(outcome), Some(episode)) => {
                        place.episode = None;
                        if outcome.fault().is_some() {
                            failed.push((episode, place));
                        } else {
                            self.record(episode, &outcome, &place.trace)?;
                        }
                    }
                    _ => place.decide(),
                }
            }
            failed.sort_by_key(|(episode, _)| *episode);
            for (episode, place) in failed {
                self.alone(&mut place.env, place.walker.as_mut(), &mut place.trace, episode)?;
            }
        }
    }

    fn record(&mut self, episode: u64, outcome: &Outcome, trace: &Trace) -> ControlFlow<()> {
        if outcome.fault() == Some(Fault::Stopped) {
            return ControlFlow::Break(());
        }
        let noted = (self.note)(episode as u32, outcome, trace);
        self.notes[(episode - self.first) as usize] = Some((noted, outcome.fault().is_some()));
        self.done += 1;
        while let Some(Some((_, failed))) = self.notes.get(self.settled) {
            self.settled += 1;
            self.faults = if *failed { self.faults + 1 } else { 0 };
            if self.faults == MOST_FAULTS {
                return ControlFlow::Break(());
            }
        }
        (self.observer)(self.done)
    }
}

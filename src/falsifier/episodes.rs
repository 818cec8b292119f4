use std::ops::{ControlFlow, Range};
use std::sync::Arc;

use super::Walker;
use crate::env::{Outcome, PedestrianEnv, Recording, Scenario};
use crate::seed::Seed;

/// Episodes in a row in which a driver may fail before no more are tried.
const MOST_FAULTS: usize = 10;

/// Tries a pedestrian in so many episodes, telling the observer how many are done.
///
/// Episode *k* begins the same for every pedestrian that is tried with the same `episodes_seed`; what the pedestrian itself
/// draws comes from `walker_seed`. Ends early, with the first episodes up to there, when the observer breaks or when the driver
/// has failed in ten episodes in a row.
///
/// Where the driver gains from it ([`DrivingPolicy::clone_for_batch`](crate::av::DrivingPolicy::clone_for_batch)), several episodes go on at
/// once, tick by tick. That changes no outcome: an episode knows nothing of the others, and when a driver fails in
/// company, each episode that it had in hand is tried again alone.
pub fn try_walker(
    walker: &mut dyn Walker,
    scenario: &Arc<Scenario>,
    episodes: u32,
    episodes_seed: &Seed,
    walker_seed: &Seed,
    observer: &mut dyn FnMut(u32) -> ControlFlow<()>,
) -> Vec<Outcome> {
    let note = &mut |_: u32, outcome: &Outcome, _: &Recording| *outcome;
    watch_walker(walker, scenario, 0..episodes, episodes_seed, walker_seed, note, observer)
}

/// Tries a pedestrian as [`try_walker`] does in the episodes with these numbers, and keeps what is noted of each when it is
/// over: its number, what became of it, and what happened.
///
/// An episode is the same in every range that holds it.
pub fn watch_walker<T>(
    walker: &mut dyn Walker,
    scenario: &Arc<Scenario>,
    episodes: Range<u32>,
    episodes_seed: &Seed,
    walker_seed: &Seed,
    note: &mut dyn FnMut(u32, &Outcome, &Recording) -> T,
    observer: &mut dyn FnMut(u32) -> ControlFlow<()>,
) -> Vec<T> {
    let mut env = PedestrianEnv::new(scenario.clone(), *episodes_seed);
    let mut places = company(&env, walker, episodes.len());
    let notes = episodes.clone().map(|_| None).collect();
    let mut numbers = u64::from(episodes.start)..u64::from(episodes.end);
    let mut trial = Trial { walker_seed, note, observer, first: numbers.start, notes, done: 0, settled: 0, faults: 0 };
    let _ = if places.is_empty() {
        let mut recording = Recording::new(&scenario.episode);
        numbers.try_for_each(|episode| trial.alone(&mut env, walker, &mut recording, episode))
    } else {
        trial.together(&mut places, numbers)
    };
    trial.notes.into_iter().take(trial.settled).flatten().map(|(noted, _)| noted).collect()
}

/// Room for one of several episodes at the same time.
struct Place {
    env: PedestrianEnv,
    walker: Box<dyn Walker>,
    recording: Recording,
    episode: Option<u64>,
}

impl Place {
    fn decide(&mut self) {
        let command = self.walker.choose(&self.env);
        self.recording.decide(command);
        self.env.set_out(command);
    }
}

/// As many places as the driver wants and there are episodes for; none when one after another is as good.
fn company(env: &PedestrianEnv, walker: &dyn Walker, episodes: usize) -> Vec<Place> {
    let wanted = env.batch_size().min(episodes);
    let recording = Recording::new(&env.scenario().episode);
    let place = || {
        Some(Place {
            env: env.clone_for_batch()?,
            walker: walker.clone_for_batch()?,
            recording: recording.clone(),
            episode: None,
        })
    };
    if wanted > 1 { (0..wanted).map_while(|_| place()).collect() } else { Vec::new() }
}

struct Trial<'a, T> {
    walker_seed: &'a Seed,
    note: &'a mut dyn FnMut(u32, &Outcome, &Recording) -> T,
    observer: &'a mut dyn FnMut(u32) -> ControlFlow<()>,
    /// Number of the first episode.
    first: u64,
    /// What was noted of each episode, and whether the driver failed in it.
    notes: Vec<Option<(T, bool)>>,
    done: u32,
    /// Episodes up to the first that is not over yet.
    settled: usize,
    /// How many of the last of these are in error.
    faults: usize,
}

impl<T> Trial<'_, T> {
    fn alone(
        &mut self,
        env: &mut PedestrianEnv,
        walker: &mut dyn Walker,
        recording: &mut Recording,
        episode: u64,
    ) -> ControlFlow<()> {
        env.begin(episode);
        recording.begin(env.world());
        walker.begin(self.walker_seed.index(episode).stream());
        let outcome = loop {
            let command = walker.choose(env);
            recording.decide(command);
            env.set_out(command);
            loop {
                let step = env.tick();
                recording.watch(env.world(), env.contact(), env.driven());
                if step.is_some() {
                    break;
                }
            }
            if let Some(outcome) = env.outcome() {
                break *outcome;
            }
        };
        self.record(episode, &outcome, recording)
    }

    fn together(&mut self, places: &mut [Place], mut episodes: Range<u64>) -> ControlFlow<()> {
        loop {
            for place in places.iter_mut().filter(|place| place.episode.is_none()) {
                place.episode = episodes.next();
                if let Some(episode) = place.episode {
                    place.env.begin(episode);
                    place.recording.begin(place.env.world());
                    place.walker.begin(self.walker_seed.index(episode).stream());
                    place.decide();
                }
            }
            let mut running: Vec<&mut Place> = places.iter_mut().filter(|place| place.episode.is_some()).collect();
            if running.is_empty() {
                return ControlFlow::Continue(());
            }
            running.iter_mut().for_each(|place| place.env.prepare());
            let mut failed = Vec::new();
            for place in running {
                let step = place.env.tick();
                place.recording.watch(place.env.world(), place.env.contact(), place.env.driven());
                let Some(_) = step else { continue };
                match (place.env.outcome().copied(), place.episode) {
                    (Some(outcome), Some(episode)) => {
                        place.episode = None;
                        if outcome.fault().is_some() {
                            failed.push((episode, place));
                        } else {
                            self.record(episode, &outcome, &place.recording)?;
                        }
                    }
                    _ => place.decide(),
                }
            }
            failed.sort_by_key(|(episode, _)| *episode);
            for (episode, place) in failed {
                self.alone(&mut place.env, place.walker.as_mut(), &mut place.recording, episode)?;
            }
        }
    }

    fn record(&mut self, episode: u64, outcome: &Outcome, recording: &Recording) -> ControlFlow<()> {
        let noted = (self.note)(episode as u32, outcome, recording);
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

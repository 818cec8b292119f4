use std::ops::{ControlFlow, Range};
use std::sync::Arc;

use super::Walker;
use crate::env::{Outcome, PedestrianEnv, Scenario};
use crate::seed::Seed;

/// Episodes in a row in which a driver may fail before no more are tried.
const MOST_FAULTS: usize = 10;

/// Tries a pedestrian in so many episodes, telling the observer how many are done.
///
/// Episode *k* begins the same for every pedestrian that is tried with the same `episodes_seed`; what the pedestrian itself
/// draws comes from `walker_seed`. Ends early, with the first episodes up to there, when the observer breaks or when the driver
/// has failed in ten episodes in a row.
///
/// Where the driver gains from it ([`DrivingPolicy::twin`](crate::av::DrivingPolicy::twin)), several episodes go on at
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
    let mut env = PedestrianEnv::new(scenario.clone(), *episodes_seed);
    let mut places = company(&env, walker, episodes);
    let outcomes = vec![None; episodes as usize];
    let mut trial = Trial { walker_seed, observer, outcomes, done: 0, settled: 0, faults: 0 };
    let mut numbers = 0..u64::from(episodes);
    let _ = if places.is_empty() {
        numbers.try_for_each(|episode| trial.alone(&mut env, walker, episode))
    } else {
        trial.together(&mut places, numbers)
    };
    trial.outcomes.into_iter().take(trial.settled).flatten().collect()
}

/// Room for one of several episodes at the same time.
struct Place {
    env: PedestrianEnv,
    walker: Box<dyn Walker>,
    episode: Option<u64>,
}

/// As many places as the driver wants and there are episodes for; none when one after another is as good.
fn company(env: &PedestrianEnv, walker: &dyn Walker, episodes: u32) -> Vec<Place> {
    let wanted = env.company().min(episodes as usize);
    let place = || Some(Place { env: env.twin()?, walker: walker.twin()?, episode: None });
    if wanted > 1 { (0..wanted).map_while(|_| place()).collect() } else { Vec::new() }
}

struct Trial<'a> {
    walker_seed: &'a Seed,
    observer: &'a mut dyn FnMut(u32) -> ControlFlow<()>,
    outcomes: Vec<Option<Outcome>>,
    done: u32,
    /// Episodes up to the first that has no outcome yet.
    settled: usize,
    /// How many of the last of these are in error.
    faults: usize,
}

impl Trial<'_> {
    fn alone(&mut self, env: &mut PedestrianEnv, walker: &mut dyn Walker, episode: u64) -> ControlFlow<()> {
        env.begin(episode);
        walker.begin(self.walker_seed.index(episode).stream());
        let outcome = loop {
            env.walk(walker.choose(env));
            if let Some(outcome) = env.outcome() {
                break *outcome;
            }
        };
        self.record(episode, outcome)
    }

    fn together(&mut self, places: &mut [Place], mut episodes: Range<u64>) -> ControlFlow<()> {
        loop {
            for place in places.iter_mut().filter(|place| place.episode.is_none()) {
                place.episode = episodes.next();
                if let Some(episode) = place.episode {
                    place.env.begin(episode);
                    place.walker.begin(self.walker_seed.index(episode).stream());
                    place.env.set_out(place.walker.choose(&place.env));
                }
            }
            let mut running: Vec<&mut Place> = places.iter_mut().filter(|place| place.episode.is_some()).collect();
            if running.is_empty() {
                return ControlFlow::Continue(());
            }
            running.iter_mut().for_each(|place| place.env.announce());
            let mut failed = Vec::new();
            for place in running {
                let Some(_) = place.env.tick() else { continue };
                match (place.env.outcome().copied(), place.episode) {
                    (Some(outcome), Some(episode)) => {
                        place.episode = None;
                        if outcome.fault().is_some() {
                            failed.push((episode, place));
                        } else {
                            self.record(episode, outcome)?;
                        }
                    }
                    _ => place.env.set_out(place.walker.choose(&place.env)),
                }
            }
            failed.sort_by_key(|(episode, _)| *episode);
            for (episode, place) in failed {
                self.alone(&mut place.env, place.walker.as_mut(), episode)?;
            }
        }
    }

    fn record(&mut self, episode: u64, outcome: Outcome) -> ControlFlow<()> {
        self.outcomes[episode as usize] = Some(outcome);
        self.done += 1;
        while let Some(Some(outcome)) = self.outcomes.get(self.settled) {
            self.settled += 1;
            self.faults = if outcome.fault().is_some() { self.faults + 1 } else { 0 };
            if self.faults == MOST_FAULTS {
                return ControlFlow::Break(());
            }
        }
        (self.observer)(self.done)
    }
}

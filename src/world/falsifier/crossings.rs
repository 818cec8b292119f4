use std::ops::{ControlFlow, Range};
use std::sync::Arc;

use super::episodes::{evaluate_noting, play_begun};
use super::{Crossing, Goal, WalkPolicy};
use crate::env::{Outcome, PedestrianEnv, Scenario, Trace};
use base::seed::Seed;

/// Evaluates every one of these crossings from each of these starts, and returns what `note` makes of each episode: start by start, the
/// crossings in their order. Start *k* depends only on the seed and on *k*.
///
/// The run-up of a start is driven once where the drivers can be copied, and a driver that is faster in a batch meets one crossing from
/// several starts at once. That changes no outcome. An episode without a result is one that was not run, since the driver or the
/// controller had failed as a program in ten episodes in a row.
pub fn evaluate_crossings<T>(
    goals: &[Goal],
    scenario: &Arc<Scenario>,
    starts: Range<u32>,
    seed: Seed,
    note: &mut dyn FnMut(&Outcome, &Trace) -> T,
) -> Vec<Option<T>> {
    let mut env = PedestrianEnv::new(scenario.clone(), seed);
    let mut notes: Vec<Option<T>> = (0..starts.len() * goals.len()).map(|_| None).collect();
    if env.batch_size() > 1 {
        for (place, goal) in goals.iter().enumerate() {
            let note = &mut |_: u32, outcome: &Outcome, trace: &Trace| note(outcome, trace);
            let (mut crossing, go_on) = (Crossing::new(*goal), &mut |_| ControlFlow::Continue(()));
            let noted = evaluate_noting(&mut crossing, scenario, starts.clone(), &seed, &seed, note, go_on);
            let (reached, all) = (noted.len(), starts.len());
            for (start, noted) in noted.into_iter().enumerate() {
                notes[start * goals.len() + place] = Some(noted);
            }
            if reached < all {
                break;
            }
        }
        return notes;
    }
    let mut trace = Trace::new(scenario);
    let mut slots = notes.iter_mut();
    for start in starts {
        let mut ready = None;
        for goal in goals {
            match ready.as_ref().and_then(PedestrianEnv::snapshot) {
                Some(copy) => env = copy,
                None => {
                    env.begin(start.into());
                    ready = env.snapshot();
                }
            }
            let mut crossing = Crossing::new(*goal);
            let outcome = play_begun(&mut env, &mut trace, |scene, commands| {
                crossing.choose(scene, commands);
                Some(())
            });
            let outcome = outcome.expect("a crossing has a command for every decision");
            *slots.next().expect("there is a slot for every episode") = Some(note(&outcome, &trace));
            if env.hopeless().is_some() {
                return notes;
            }
        }
    }
    notes
}

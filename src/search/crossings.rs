use std::ops::{ControlFlow, Range};
use std::sync::Arc;

use super::{Crossing, Goal};
use base::seed::Seed;
use episode::walker::{FaultStreak, WalkPolicy};
use episode::{Draw, Observer, Outcome, Policies, Scenario, Simulation, Trace, evaluate_in_batch, play};

/// Evaluates every one of these crossings from each of these starts, and returns what `note` makes of each episode: start by start, the
/// crossings in their order. Start *k* depends only on the seed and on *k*.
///
/// The run-up of a start is driven once where the drivers can be copied, and a driver that is faster in a batch meets several crossings at once. That changes no outcome. An episode without a result is one that was not run, since the driver or the
/// controller had failed as a program in ten episodes in a row, or `observer`, which is called after each, broke.
pub fn evaluate_crossings<T>(
    goals: &[Goal],
    scenario: &Arc<Scenario>,
    starts: Range<u32>,
    seed: Seed,
    note: &mut dyn FnMut(&Outcome, &Trace) -> T,
    observer: &mut dyn FnMut() -> ControlFlow<()>,
) -> Vec<Option<T>> {
    let episodes = starts.len() * goals.len();
    let walker = |place: u64| -> Box<dyn WalkPolicy> { Box::new(Crossing::new(goals[place as usize])) };
    let crossings: Policies<'_> = (&walker, goals.len() as u64);
    if let Some(noted) = evaluate_in_batch(crossings, scenario, starts.clone(), &seed, note, &mut |_| observer()) {
        let mut notes: Vec<Option<T>> = noted.into_iter().map(Some).collect();
        notes.resize_with(episodes, || None);
        return notes;
    }
    let mut simulation = scenario.simulation();
    let mut notes: Vec<Option<T>> = (0..episodes).map(|_| None).collect();
    let mut trace = Trace::new(scenario);
    let mut slots = notes.iter_mut();
    let mut faults = FaultStreak::default();
    for start in starts {
        let mut ready: Option<Box<dyn Simulation>> = None;
        for goal in goals {
            match ready.as_ref().and_then(|ready| ready.snapshot()) {
                Some(copy) => simulation = copy,
                None => {
                    simulation.start(Draw::new(&seed, start.into()));
                    ready = simulation.snapshot();
                }
            }
            trace.begin(&simulation.scene());
            let outcome = play(&mut *simulation, &mut Crossing::new(*goal), &mut trace);
            let outcome = outcome.expect("our simulator ends every episode");
            *slots.next().expect("there is a slot for every episode") = Some(note(&outcome, &trace));
            faults.count(outcome.fault());
            if observer().is_break() || faults.hopeless().is_some() {
                return notes;
            }
        }
    }
    notes
}

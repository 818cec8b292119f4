use std::sync::{Arc, Mutex, PoisonError};

use rand::RngExt;

use base::seed::Seed;
use episode::{Draw, EgoSpeed, Scenario, Simulation};

/// Starts of a scenario whose run-up has been driven, to be copied: a run-up takes more ticks than most episodes.
///
/// Start *k* depends only on the seed and on *k*; it is driven when it is first drawn, by whichever environment draws it. What is random in a copy from tick 0
/// on is drawn from streams of its own ([`Simulation::reseed`]), so copies share their past and not their future.
/// A bank is for trainings: an evaluation whose episodes share starts would have a narrower interval than it claims.
pub struct StartBank {
    scenario: Arc<Scenario>,
    seed: Seed,
    starts: Vec<Mutex<Entry>>,
    hard: Option<HardStarts>,
}

/// Which starts of a bank are drawn more often than others.
#[derive(Debug, Clone, Copy)]
pub struct HardStarts {
    /// The share of the copies that are of hard starts, as far as a hundred draws find them.
    pub share: f64,
    /// Whether a start is hard; it also gets the start's number.
    pub is_hard: fn(&dyn Simulation, u64) -> bool,
}

/// What is known of a start.
#[derive(Default)]
struct Entry {
    start: Option<Box<dyn Simulation>>,
    is_hard: Option<bool>,
}

/// Hard starts are looked for among this many times as many starts as the bank has others.
const WIDER: usize = 10;
/// Starts that are drawn for a hard one before any is taken.
const ATTEMPTS: u32 = 100;

impl StartBank {
    /// A bank of `size` starts; `None` if it would save nothing or change what episodes are: starts without a run-up, tests whose case depends on the
    /// number of the episode, and drivers that cannot be copied.
    pub fn new(scenario: &Arc<Scenario>, size: usize, hard: Option<HardStarts>, seed: Seed) -> Option<Self> {
        let spawn = &scenario.spawn;
        let suits = matches!(spawn.ego_speed, EgoSpeed::Steady) && spawn.target_walk.is_none() && size > 0;
        suits.then(|| scenario.simulation().snapshot())??;
        let starts = if hard.is_some() { WIDER * size } else { size };
        let starts = (0..starts).map(|_| Mutex::default()).collect();
        Some(Self { scenario: scenario.clone(), seed, starts, hard })
    }

    /// A copy of the start that this seed draws; `None` if its driver failed before tick 0.
    pub(super) fn copy(&self, seed: &Seed) -> Option<Box<dyn Simulation>> {
        let mut stream = seed.child("start").stream();
        let usual = if self.hard.is_some() { self.starts.len() / WIDER } else { self.starts.len() };
        let number = stream.random_range(0..usual);
        if let Some(HardStarts { share, is_hard }) = self.hard
            && stream.random::<f64>() < share
        {
            let mut drawn = (0..ATTEMPTS).map(|_| stream.random_range(0..self.starts.len()));
            let hard = drawn.find_map(|number| self.hard_start(number, is_hard));
            if hard.is_some() {
                return hard;
            }
        }
        let mut entry = self.starts[number].lock().unwrap_or_else(PoisonError::into_inner);
        copied(&**entry.start.get_or_insert_with(|| self.driven(number)))
    }

    /// A copy of this start if it is hard. Of others only that is kept.
    fn hard_start(&self, number: usize, is_hard: fn(&dyn Simulation, u64) -> bool) -> Option<Box<dyn Simulation>> {
        let mut entry = self.starts[number].lock().unwrap_or_else(PoisonError::into_inner);
        let Entry { start, is_hard: known } = &mut *entry;
        if known.is_none() {
            let was_kept = start.is_some();
            let driven = start.take().unwrap_or_else(|| self.driven(number));
            let found = driven.failed_run_up().is_none() && is_hard(&*driven, number as u64);
            *known = Some(found);
            *start = (found || was_kept).then_some(driven);
        }
        start.as_ref().filter(|_| *known == Some(true)).and_then(|start| copied(&**start))
    }

    fn driven(&self, number: usize) -> Box<dyn Simulation> {
        let mut simulation = self.scenario.simulation();
        simulation.start(Draw::new(&self.seed, number as u64));
        simulation
    }
}

fn copied(start: &dyn Simulation) -> Option<Box<dyn Simulation>> {
    start.failed_run_up().is_none().then(|| start.snapshot()).flatten()
}

impl std::fmt::Debug for StartBank {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("StartBank").field("starts", &self.starts.len()).finish_non_exhaustive()
    }
}

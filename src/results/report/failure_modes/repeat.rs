use std::collections::{BTreeMap, BTreeSet};

use rayon::prelude::*;

use super::sample::RunSample;
use crate::analysis::{Approach, Kind};
use crate::jobs::repeat_episodes;
use base::seed::Seed;
use learn::ActorCritic;
use world::env::{Outcome, Trace};

/// Maximum number of collisions of a kind that are repeated.
pub const MAX_REPEATED: usize = 60;

/// Repeats collisions and stores their approaches: the first of each kind, evenly over the runs. A collision that is not the same again,
/// since its driver is not deterministic, has no approach; neither has one whose pedestrian was trained and whose networks are missing.
pub fn repeat(runs: &mut [RunSample<'_>], trained: &[Option<&ActorCritic>], seed: &Seed) {
    let wanted = wanted(runs);
    runs.par_iter_mut().zip(trained).zip(wanted).for_each(|((run, trained), wanted)| {
        let scenario = &run.evaluation.scenario;
        let numbers: Vec<u32> = wanted.iter().copied().collect();
        let note =
            &mut |outcome: &Outcome, trace: &Trace| Some((outcome.digest, Approach::new(&trace.main_pair(scenario))?));
        let noted = repeat_episodes(run.evaluation, *trained, &numbers, seed, note);
        let mut seen: BTreeMap<u64, (u64, Approach)> =
            noted.into_iter().filter_map(|(episode, noted)| Some((episode.into(), noted?))).collect();
        for failure in &mut run.failures {
            let again = seen.remove(&failure.number).filter(|(digest, _)| *digest == failure.digest);
            failure.approach = again.map(|(_, approach)| approach);
        }
    });
}

/// The numbers of the episodes of each run that are to be repeated.
fn wanted(runs: &[RunSample<'_>]) -> Vec<BTreeSet<u32>> {
    let mut kinds: BTreeMap<Kind, Vec<(u32, usize)>> = BTreeMap::new();
    for (run, sample) in runs.iter().enumerate() {
        for (kind, failure) in sample.failures.iter().filter_map(|failure| Some((Kind::of(failure)?, failure))) {
            kinds.entry(kind).or_default().push((failure.number as u32, run));
        }
    }
    let mut wanted = vec![BTreeSet::new(); runs.len()];
    for failures in kinds.values_mut() {
        failures.sort_unstable();
        failures.iter().take(MAX_REPEATED).for_each(|(episode, run)| {
            wanted[*run].insert(*episode);
        });
    }
    wanted
}

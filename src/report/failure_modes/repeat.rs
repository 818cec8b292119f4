use std::collections::{BTreeMap, BTreeSet};
use std::ops::{ControlFlow, Range};

use rayon::prelude::*;

use super::sample::RunSample;
use crate::analysis::{Approach, Kind};
use crate::campaign::watch;
use crate::rl::ActorCritic;
use crate::seed::Seed;

/// Most collisions of a kind that are repeated.
pub const MOST: usize = 60;

/// Repeats collisions and stores their approaches: the first of each kind, evenly over the runs. A collision that is not the same again,
/// since its driver is not deterministic, has no approach; neither has one whose pedestrian was trained and whose networks are missing.
pub fn repeat(runs: &mut [RunSample<'_>], trained: &[Option<&ActorCritic>], seed: &Seed) {
    let wanted = wanted(runs);
    runs.par_iter_mut().zip(trained).zip(wanted).for_each(|((run, trained), wanted)| {
        if run.evaluation.training().is_some() && trained.is_none() {
            return;
        }
        let scenario = &run.evaluation.scenario;
        let mut seen: BTreeMap<u32, (String, Approach)> = BTreeMap::new();
        for range in ranges(&wanted) {
            let noted = watch(
                run.evaluation,
                *trained,
                range.clone(),
                seed,
                &mut |outcome, trace| {
                    Some((format!("{:016x}", outcome.digest), Approach::new(&trace.main_pair(scenario))?))
                },
                &mut |_| ControlFlow::Continue(()),
            );
            seen.extend(range.zip(noted).filter_map(|(episode, noted)| Some((episode, noted?))));
        }
        for sampled in run.failures.iter_mut().filter(|sampled| wanted.contains(&sampled.failure.episode)) {
            let again = seen.get(&sampled.failure.episode).filter(|(digest, _)| *digest == sampled.digest);
            sampled.failure.approach = again.map(|(_, approach)| approach.clone());
        }
    });
}

/// The numbers of the episodes of each run that are to be repeated.
fn wanted(runs: &[RunSample<'_>]) -> Vec<BTreeSet<u32>> {
    let mut kinds: BTreeMap<Kind, Vec<(u32, usize)>> = BTreeMap::new();
    for (run, sample) in runs.iter().enumerate() {
        for sampled in &sample.failures {
            kinds.entry(sampled.failure.kind).or_default().push((sampled.failure.episode, run));
        }
    }
    let mut wanted = vec![BTreeSet::new(); runs.len()];
    for failures in kinds.values_mut() {
        failures.sort_unstable();
        failures.iter().take(MOST).for_each(|(episode, run)| {
            wanted[*run].insert(*episode);
        });
    }
    wanted
}

fn ranges(episodes: &BTreeSet<u32>) -> Vec<Range<u32>> {
    let mut ranges: Vec<Range<u32>> = Vec::new();
    for episode in episodes {
        match ranges.last_mut() {
            Some(last) if *episode == last.end => last.end = episode + 1,
            _ => ranges.push(*episode..episode + 1),
        }
    }
    ranges
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn episodes_in_a_row_are_repeated_together() {
        assert_eq!(ranges(&BTreeSet::from([3, 4, 9, 20])), [3..5, 9..10, 20..21]);
        assert_eq!(ranges(&BTreeSet::new()), []);
    }
}

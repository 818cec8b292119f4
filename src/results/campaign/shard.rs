use std::collections::BTreeSet;

use super::task::parts;
use super::{Task, tasks};
use compile::Campaign;

/// One of several parts of a campaign that are run separately, for example on several machines.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shard {
    /// The number of this part, from 0.
    pub index: u32,
    /// The number of parts.
    pub count: u32,
}

/// The tasks of a shard, in the plan's order, with those of the jobs that they need.
///
/// It depends only on the plan, so every machine computes the same shards. The tasks are put in a row, each job after the
/// one that it needs. The row is cut into parts of about equal work, counted in simulator ticks that may be needed. So one shard
/// needs a training, or a few neighbouring ones do. Each of these takes the training from the store of the others, or repeats it with the
/// same result.
pub fn shard(campaign: &Campaign, shard: Shard) -> Vec<Task> {
    let mut wanted: BTreeSet<Task> = deal(campaign, shard.count)
        .into_iter()
        .filter_map(|(task, index)| (index == shard.index).then_some(task))
        .collect();
    let needed: BTreeSet<usize> = wanted.iter().filter_map(|task| campaign.jobs[task.job].origin().needs).collect();
    wanted.extend(needed.into_iter().flat_map(|job| parts(job, &campaign.jobs[job])));
    wanted.into_iter().collect()
}

/// The shard of each task.
pub fn deal(campaign: &Campaign, count: u32) -> Vec<(Task, u32)> {
    let mut row: Vec<Task> = tasks(campaign).collect();
    row.sort_by_key(|task| (campaign.jobs[task.job].origin().needs.unwrap_or(task.job), *task));
    // Simulator ticks that a task may need; at least one.
    let work = |task: &Task| u128::from(campaign.jobs[task.job].planned().ticks(task.part).max(1));
    let whole: u128 = row.iter().map(work).sum();
    let mut before = 0;
    row.into_iter()
        .map(|task| {
            let work = work(&task);
            // A task belongs to the shard that contains its middle.
            let index = (2 * before + work) * u128::from(count) / (2 * whole).max(1);
            before += work;
            (task, index.min(u128::from(count) - 1) as u32)
        })
        .collect()
}

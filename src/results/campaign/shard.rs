use std::collections::BTreeSet;

use super::run::training_of;
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

/// The tasks of a shard, in the plan's order, with the trainings that its evaluations need.
///
/// It depends only on the plan, so every machine computes the same shards. The tasks are put in a row, each training before the
/// evaluations that need it. The row is cut into parts of about equal work, counted in simulator ticks that may be needed. So one shard
/// needs a training, or a few neighbouring ones do. Each of these takes the training from the store of the others, or repeats it with the
/// same result.
pub fn shard(campaign: &Campaign, shard: Shard) -> Vec<Task> {
    let mut wanted: BTreeSet<Task> = deal(campaign, shard.count)
        .into_iter()
        .filter_map(|(task, index)| (index == shard.index).then_some(task))
        .collect();
    let needed: Vec<Task> = wanted.iter().filter_map(|task| training_of(campaign, *task)).map(Task::Training).collect();
    wanted.extend(needed);
    wanted.into_iter().collect()
}

/// The shard of each task.
pub fn deal(campaign: &Campaign, count: u32) -> Vec<(Task, u32)> {
    let mut row: Vec<Task> = tasks(campaign).collect();
    // Trained pedestrians by their training, then all others.
    row.sort_by_key(|task| match task {
        Task::Training(index) => (0, *index, *task),
        Task::Chunk { .. } => training_of(campaign, *task).map_or((1, 0, *task), |training| (0, training, *task)),
        Task::Search(_) | Task::Estimate(_) | Task::Cover(_) | Task::Harden(_) => (2, 0, *task),
    });
    let whole: u128 = row.iter().map(|task| work(campaign, *task)).sum();
    let mut before = 0;
    row.into_iter()
        .map(|task| {
            let work = work(campaign, task);
            // A task belongs to the shard that contains its middle.
            let index = (2 * before + work) * u128::from(count) / (2 * whole).max(1);
            before += work;
            (task, index.min(u128::from(count) - 1) as u32)
        })
        .collect()
}

/// Simulator ticks that a task may need; at least one.
fn work(campaign: &Campaign, task: Task) -> u128 {
    let ticks = match task {
        Task::Training(index) => {
            let training = &campaign.trainings[index];
            training.ticks(training.config.total_steps).into()
        }
        Task::Chunk { evaluation, chunk } => {
            let planned = &campaign.evaluations[evaluation];
            planned.chunk(chunk).len() as u128 * u128::from(planned.scenario.episode.ticks)
        }
        Task::Search(index) => u128::from(campaign.searches[index].budget),
        Task::Estimate(index) => u128::from(campaign.estimations[index].budget),
        Task::Harden(index) => u128::from(campaign.hardenings[index].budget()),
        Task::Cover(index) => {
            let cover = &campaign.covers[index];
            u128::from(cover.budget) * u128::from(cover.scenario.episode.ticks)
        }
    };
    ticks.max(1)
}

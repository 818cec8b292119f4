use std::collections::{BTreeMap, BTreeSet};

use compile::Campaign;
use results::campaign::{Task, deal};
use results::store::Taken;

/// A campaign with missing tasks.
#[derive(Debug)]
pub struct Incomplete {
    pub campaign: Campaign,
    /// The tasks that are not finished, in the plan's order.
    pub tasks: Vec<Missing>,
    /// The number of all its tasks.
    pub all: usize,
}

/// A task that is not finished.
#[derive(Debug)]
pub struct Missing {
    pub task: Task,
    /// What it is, for people.
    pub name: String,
    /// What the stores have of it.
    pub found: Taken,
}

impl Incomplete {
    /// The shards, out of this number, that contain the missing tasks.
    pub fn shards(&self, count: u32) -> BTreeSet<u32> {
        let deal: BTreeMap<Task, u32> = deal(&self.campaign, count).into_iter().collect();
        self.tasks.iter().map(|missing| deal[&missing.task]).collect()
    }
}

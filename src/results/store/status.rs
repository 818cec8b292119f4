//! The progress of campaigns, read from their files by another process.

use std::fs::{self, File, TryLockError};
use std::time::SystemTime;

use super::work_folder::processes;
use super::{Header, Index, Store, StoreError};
use crate::campaign::State;

/// The progress of a campaign.
#[derive(Debug)]
pub struct CampaignStatus {
    pub name: String,
    /// The command that it was last run with; empty when unknown.
    pub command: String,
    /// Whether that command has nothing left to do: a shard may be finished where the campaign is not.
    pub is_command_done: bool,
    pub tasks: Vec<TaskStatus>,
}

/// The progress of a task.
#[derive(Debug)]
pub struct TaskStatus {
    /// What it is, for people; the first word is `train`, `evaluate` or `search`.
    pub what: String,
    /// Its size: updates, episodes, ticks.
    pub amount: u64,
    /// The header of its file; `None` if no file can be read.
    pub header: Option<Header>,
    /// The time at which its file was written.
    pub written: Option<SystemTime>,
    /// Whether a process works on it.
    pub is_in_hand: bool,
}

impl TaskStatus {
    pub fn is_finished(&self) -> bool {
        self.header.as_ref().is_some_and(|header| header.state == State::Finished)
    }

    /// The amount of it that is stored.
    pub fn done(&self) -> u64 {
        match &self.header {
            Some(header) if header.state == State::Finished => self.amount,
            // A search stores nothing before its end.
            Some(header) if header.state == State::Begun => header.done.min(self.amount),
            _ => 0,
        }
    }
}

impl Store {
    /// The progress of a campaign.
    ///
    /// # Errors
    /// The list of its tasks is there and cannot be read.
    pub fn status(&self, name: &str) -> Result<CampaignStatus, StoreError> {
        let index = Index::read(self, name)?;
        let task = |(id, (what, amount)): (&String, &(String, u64))| {
            let path = self.path_of(id);
            let written = fs::metadata(&path).and_then(|data| data.modified()).ok();
            let header = self.head_of(&path).and_then(Result::ok);
            TaskStatus { what: what.clone(), amount: *amount, header, written, is_in_hand: self.is_in_hand(id) }
        };
        let is_own = |id: &String| index.own.is_empty() || index.own.contains(id);
        let all: Vec<(bool, TaskStatus)> = index.plan.iter().map(|entry| (is_own(entry.0), task(entry))).collect();
        let is_command_done = all.iter().all(|(own, task)| !own || task.is_finished());
        let tasks = all.into_iter().map(|(_, task)| task).collect();
        Ok(CampaignStatus { name: name.to_string(), command: index.command, is_command_done, tasks })
    }

    /// The number of processes that work on the folder for reports.
    pub fn processes(&self) -> usize {
        processes(self.place().beside())
    }

    fn is_in_hand(&self, id: &str) -> bool {
        let claim = File::open(self.place().root().join("claims").join(id));
        claim.is_ok_and(|claim| matches!(claim.try_lock(), Err(TryLockError::WouldBlock)))
    }
}

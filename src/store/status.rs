//! How far campaigns are, as their files tell it to whoever looks from outside.

use std::fs::{self, File, TryLockError};
use std::time::SystemTime;

use super::work_folder::processes;
use super::{Header, Index, State, Store};

/// How far a campaign is.
#[derive(Debug)]
pub struct CampaignStatus {
    /// Its name.
    pub name: String,
    /// The command that it was last run with; empty when nobody knows.
    pub command: String,
    /// Its tasks.
    pub tasks: Vec<TaskStatus>,
}

/// How far a task is.
#[derive(Debug)]
pub struct TaskStatus {
    /// What it is, for people; the first word is `train`, `evaluate` or `search`.
    pub what: String,
    /// How much it is: updates, episodes, ticks.
    pub amount: u64,
    /// What its file says; none when there is none that could be read.
    pub header: Option<Header>,
    /// When its file was written.
    pub written: Option<SystemTime>,
    /// Whether somebody is at work on it.
    pub is_in_hand: bool,
}

impl TaskStatus {
    /// Whether nothing is missing.
    pub fn is_finished(&self) -> bool {
        self.header.as_ref().is_some_and(|header| header.state == State::Finished)
    }

    /// How much of it is there.
    pub fn done(&self) -> u64 {
        match &self.header {
            Some(header) if header.state == State::Finished => self.amount,
            // Of a search nothing is kept before its end.
            Some(header) if header.state == State::Begun => header.done.min(self.amount),
            _ => 0,
        }
    }
}

impl Store {
    /// How far a campaign is.
    pub fn status(&self, name: &str) -> CampaignStatus {
        let index = Index::read(self, name);
        let task = |(id, (what, amount)): (&String, &(String, u64))| {
            let path = self.path_of(id);
            let written = fs::metadata(&path).and_then(|data| data.modified()).ok();
            let header = self.head_of(&path).and_then(Result::ok);
            TaskStatus { what: what.clone(), amount: *amount, header, written, is_in_hand: self.is_in_hand(id) }
        };
        let tasks = index.plan.iter().map(task).collect();
        CampaignStatus { name: name.to_string(), command: index.command, tasks }
    }

    /// How many processes are at work on the folder for reports.
    pub fn processes(&self) -> usize {
        processes(self.place().beside())
    }

    fn is_in_hand(&self, id: &str) -> bool {
        let claim = File::open(self.place().root().join("claims").join(id));
        claim.is_ok_and(|claim| matches!(claim.try_lock(), Err(TryLockError::WouldBlock)))
    }
}

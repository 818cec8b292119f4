//! The kinds of jobs. A folder is a kind: how it is run, what its result is, and how that is stored.

mod episodes;
mod repeat;
mod training;
mod evaluation;
mod search;
mod estimate;
mod cover;
mod harden;

use std::any::Any;
use std::fmt;

use serde::Serialize;
use serde::de::DeserializeOwned;

pub use cover::{CoverResult, FoundInBox};
pub use episodes::watch;
pub use estimate::EstimateResult;
pub use harden::HardenResult;
pub(crate) use repeat::repeat_episodes;
pub use repeat::{Repeatable, Repeated};
pub use search::{Find, SearchResult};
pub use training::{TrainingResult, networks};

use crate::campaign::{Collect, Part, State, TaskError};
use crate::record::TableReference;
use crate::report::{Findings, Table};
use compile::{Job, Planned};

/// The words of a kind of job.
#[derive(Debug)]
pub struct Kind {
    /// One of them, in files for programs.
    pub name: &'static str,
    /// Several of them.
    pub plural: &'static str,
    /// What a task of it does: the first word of the task's name.
    pub verb: &'static str,
    /// What is done while it is under way, and when it has ended.
    pub doing: [&'static str; 2],
    /// What is counted of it.
    pub unit: &'static str,
    /// Whether its results are episodes. They stay in the store, and a stored part may have fewer than are wanted.
    pub has_episodes: bool,
    /// The columns of its tables in a report.
    pub references: fn() -> Vec<TableReference>,
    /// Its tables in a report, with their names.
    pub tables: fn(&Findings<'_>) -> Vec<(&'static str, Table)>,
}

impl PartialEq for Kind {
    /// Names of kinds are unique. Addresses are not: each use of a constant may have its own.
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

/// All kinds, in the order of their jobs in a campaign.
pub const KINDS: [&Kind; 6] =
    [&training::KIND, &evaluation::KIND, &search::KIND, &estimate::KIND, &cover::KIND, &harden::KIND];

/// How a job is run and stored.
pub trait Work: Planned {
    /// Its kind.
    fn kind(&self) -> &'static Kind;

    /// Its names for people.
    fn title(&self) -> String;

    /// All its names; no other job of its campaign has the same.
    fn what(&self) -> String;

    /// Runs a part of it, stores it as far as it has ended, and reports [`Part::begin`] and [`Part::progress`]; None if the user asks to stop before there is any result.
    fn run(&self, part: &Part<'_>) -> Option<Box<dyn JobResult>>;

    /// A result from its stored form; None if that is damaged.
    fn decode(&self, bytes: &[u8]) -> Option<Box<dyn JobResult>>;

    /// The finished result that the store has; None without one.
    fn read(&self, part: &Part<'_>) -> Option<Box<dyn JobResult>> {
        let stored = part.results.get(part.task).filter(|stored| stored.state == State::Finished)?;
        let result = self.decode(&stored.bytes);
        if result.is_none() {
            part.results.damaged(part.task);
        }
        result
    }
}

/// The result of a part of a job.
pub trait JobResult: Any + fmt::Debug + Send + Sync + Collect {
    /// Why it ended early.
    fn error(&self) -> Option<&TaskError>;

    /// Whether nothing of it is missing.
    fn is_whole(&self) -> bool {
        self.error().is_none()
    }

    /// Whether a report shows something of it.
    fn is_shown(&self) -> bool {
        true
    }

    /// The units that it took.
    fn units(&self) -> u64;

    /// What came of it, for people; empty if there is nothing to say.
    fn note(&self) -> String {
        String::new()
    }

    /// Its stored form; None for what cannot be stored, or has stored itself.
    fn encode(&self) -> Option<Vec<u8>> {
        None
    }
}

/// How a job is run and stored.
pub fn work(job: &Job) -> &dyn Work {
    match job {
        Job::Training(job) => job,
        Job::Evaluation(job) => job,
        Job::Search(job) => job,
        Job::Estimation(job) => job,
        Job::Cover(job) => job,
        Job::Harden(job) => job,
    }
}

/// JSON from which the same value is read; None for what has no form in it, such as a number that is not finite.
fn json<T: Serialize + DeserializeOwned + PartialEq>(value: &T) -> Option<Vec<u8>> {
    let bytes = serde_json::to_vec(value).ok()?;
    serde_json::from_slice::<T>(&bytes).is_ok_and(|read| read == *value).then_some(bytes)
}

/// A new result of a job.
fn result(result: impl JobResult) -> Option<Box<dyn JobResult>> {
    Some(Box::new(result))
}

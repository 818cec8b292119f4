//! The kinds of jobs. A file or a folder is a kind: how it is run, what its result is and how that is stored, and what a report shows of it.

mod measurement;
mod episodes;
mod repeat;
mod training;
mod evaluation;
mod search;
mod estimate;
mod cover;
mod harden;
mod price;

use std::any::Any;
use std::fmt;

use serde::Serialize;
use serde::de::DeserializeOwned;

pub use cover::FoundInBox;
pub(crate) use cover::percent_above;
pub use episodes::watch;
pub use measurement::{Measured, Measurement};
pub(crate) use price::{NEEDLESS, PRICES, PROGRESS, SPARED, columns as price_columns};
pub use repeat::{Repeatable, Repeated};
pub use search::{SearchFailure, SearchResult};
pub use training::{TrainingResult, learning_curve_lines, networks, pedestrian_files};

use crate::campaign::{Collect, Part, State, TaskError};
use crate::record::{TableReference, in_block};
use crate::report::{Findings, Group, Manifest, SectionMaker, Table};
use compile::{Job, Planned};

/// Makes tables of a report, with their names; `None` without results.
type TablesMaker = fn(&Findings<'_>) -> Option<Vec<(&'static str, Table)>>;
/// Makes files of a report: their paths relative to its folder, and their contents.
type FilesMaker = fn(&Findings<'_>, &Manifest) -> Vec<(String, Vec<u8>)>;

/// A sentence about a driver.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Said {
    pub driver: String,
    pub text: String,
    /// Whether the driver has a fault.
    pub fails: bool,
}

/// A kind of job: its words, and what a report has of it.
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
    /// What is done when all units are, until it has ended.
    pub closing: &'static str,
    /// What is counted of it.
    pub unit: &'static str,
    /// How long a unit takes on a core (s), until the first ones are measured. What counts is how kinds differ.
    pub seconds: f64,
    /// Whether its results are episodes. They stay in the store, and a stored part may have fewer than are wanted.
    pub has_episodes: bool,
    /// The job as one of this kind; `None` for one of another kind.
    pub work: fn(&Job) -> Option<&dyn Work>,
    /// The columns of its tables in a report.
    pub references: fn() -> Vec<TableReference>,
    /// Its tables in a report, with their names; `None` without results.
    pub tables: TablesMaker,
    /// What it found, in a sentence each.
    pub answer: fn(&Findings<'_>) -> Vec<Said>,
    /// Its section in a report, and where that stands.
    pub section: Option<(Group, SectionMaker)>,
    /// The folders of its files in a report.
    pub folders: &'static [&'static str],
    /// Its files in a report beside the tables, with their paths relative to the report's folder.
    pub files: FilesMaker,
}

impl Kind {
    /// A kind of which a report has nothing of its own.
    const fn new<T: Work>(name: &'static str, plural: &'static str, verb: &'static str) -> Self {
        Self {
            name,
            plural,
            verb,
            doing: ["", ""],
            closing: "",
            unit: "ticks",
            seconds: 1e-5,
            has_episodes: false,
            work: of::<T>,
            references: Vec::new,
            tables: |_| None,
            answer: |_| Vec::new(),
            section: None,
            folders: &[],
            files: |_, _| Vec::new(),
        }
    }
}

impl PartialEq for Kind {
    /// Names of kinds are unique. Addresses are not: each use of a constant may have its own.
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

/// All kinds, in the order of their jobs in a campaign.
pub const KINDS: [&Kind; 7] =
    [&training::KIND, &evaluation::KIND, &search::KIND, &estimate::KIND, &cover::KIND, &harden::KIND, &price::KIND];

/// How a job is run and stored.
pub trait Work: Planned {
    fn kind(&self) -> &'static Kind;

    /// All its names; no other job of its campaign has the same.
    fn what(&self) -> String {
        format!("{}{}", self.title(), in_block(self.kind().name, self.origin().block))
    }

    /// Runs a part of it, stores it as far as it has ended, and reports [`Part::begin`] and [`Part::progress`]; `None` if the user asks to stop before there is any result.
    fn run(&self, part: &Part<'_>) -> Option<Box<dyn JobResult>>;

    /// A result from its stored form; `None` if that is damaged.
    fn decode(&self, bytes: &[u8]) -> Option<Box<dyn JobResult>>;

    /// What came of all parts, in their order; `None` if that cannot be said without those that are missing.
    fn join(&self, parts: Vec<Option<Box<dyn JobResult>>>) -> Option<Box<dyn JobResult>> {
        parts.into_iter().flatten().next()
    }

    /// The finished result that the store has; `None` without one.
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

    /// Its stored form; `None` for what cannot be stored, or has stored itself.
    fn encode(&self) -> Option<Vec<u8>> {
        None
    }
}

/// How a job is run and stored.
///
/// # Panics
/// If its kind is not among [`KINDS`].
pub fn work(job: &Job) -> &dyn Work {
    KINDS.iter().find_map(|kind| (kind.work)(job)).expect("every kind of job is among KINDS")
}

fn of<T: Work>(job: &Job) -> Option<&dyn Work> {
    job.of::<T>().map(|job| job as &dyn Work)
}

/// JSON from which the same value is read; `None` for what has no form in it, such as a number that is not finite.
fn json<T: Serialize + DeserializeOwned + PartialEq>(value: &T) -> Option<Vec<u8>> {
    let bytes = serde_json::to_vec(value).ok()?;
    serde_json::from_slice::<T>(&bytes).is_ok_and(|read| read == *value).then_some(bytes)
}

/// A new result of a job.
fn result(result: impl JobResult) -> Option<Box<dyn JobResult>> {
    Some(Box::new(result))
}

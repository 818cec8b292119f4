use std::path::PathBuf;

use super::{EpisodeName, OtherReport};
use export::ExportError;
use lang::Unreadable;
use results::report::{GateError, Incomparable, ReadError, WriteError};
use results::store::StoreError;

/// Why a call of a session has no result.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// Named scenario files cannot be read.
    #[error("{}", lines(files))]
    Unreadable {
        /// The files, each with the reason.
        files: Vec<Unreadable>,
    },
    /// The scenario files have errors; the observer has the diagnostics.
    #[error("{} found", if *errors == 1 { "1 error".into() } else { format!("{errors} errors") })]
    Scenario {
        /// The number of diagnostics that are errors.
        errors: usize,
    },
    /// A recording cannot be judged.
    #[error("cannot judge `{}`: {reason}", file.display())]
    Recording {
        file: PathBuf,
        /// What is wrong.
        reason: String,
    },
    /// A map is given for a town that no file declares.
    #[error("a map is given for the town `{town}`, which nothing uses")]
    UnusedMap { town: String },
    /// Results for other inputs are at the place of a report.
    #[error("`{}` holds results for other inputs, which are not replaced:\n{}", .0.folder.display(), listed(&.0.differences))]
    OtherReport(Box<OtherReport>),
    /// The files hold no campaign.
    #[error("{advice}")]
    NoCampaign {
        /// What to write or to name instead.
        advice: String,
    },
    /// A campaign that is to be run alone is not in the files.
    #[error("no campaign is called `{name}`; the files have {known}")]
    UnknownCampaign {
        name: String,
        /// The names that they have.
        known: String,
    },
    /// A gate judges no row of the campaigns.
    #[error(transparent)]
    Gate(#[from] GateError),
    /// Threads cannot be started.
    #[error("cannot start {threads} threads: {source}")]
    Threads {
        /// The number that was asked for; 0 for one a core.
        threads: u16,
        source: rayon::ThreadPoolBuildError,
    },
    /// There is no store to work with.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// Something could not be written while a campaign was run. What was finished before is stored.
    #[error("{source}\n  what was finished before is kept; run the same command again to go on (`{out}`)", out = out.display())]
    Keep {
        /// The folder for reports.
        out: PathBuf,
        /// What could not be written.
        source: KeepError,
    },
    /// A file or a table cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// An episode cannot be exported.
    #[error("cannot export {name}: {source}")]
    Export { name: EpisodeName, source: ExportError },
    /// A repetition differs from its report, so it is not exported.
    #[error("{name} differs from its report in {}, so it is not exported", columns.join(", "))]
    Differs {
        name: EpisodeName,
        /// The columns that differ.
        columns: Vec<String>,
    },
    /// A report cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// A folder to merge from does not exist.
    #[error("there is no folder `{folder}`", folder = folder.display())]
    NoFolder { folder: PathBuf },
    /// No campaign was run for a folder.
    #[error("no campaign was run in `{out}`", out = out.display())]
    NothingRun {
        /// The folder for reports.
        out: PathBuf,
        /// The cache that was named.
        cache: Option<PathBuf>,
    },
    /// A filter names what no report has.
    #[error("no report has a {what} `{word}`; known are: {known}")]
    UnknownFilter {
        /// What it is the name of.
        what: &'static str,
        word: String,
        /// The words that they have.
        known: String,
    },
    /// A folder holds no report.
    #[error("there is no report in `{folder}`", folder = folder.display())]
    NoReport { folder: PathBuf },
    /// No report of a folder has the run of an episode.
    #[error("no report in `{folder}` has a run `{}`", name.run, folder = folder.display())]
    NoRun { folder: PathBuf, name: EpisodeName },
    /// A report has the run, but not the episode or the failure.
    #[error("`{report}` has no {what} {} of {}", name.number, name.run, report = report.display())]
    NoEpisode {
        report: PathBuf,
        /// `episode`, or `failure` of a search.
        what: &'static str,
        name: EpisodeName,
    },
    /// A table has an episode name of another form.
    #[error("`{name}` in a table is no name of an episode")]
    BadName {
        /// The text.
        name: String,
    },
    /// The row of an episode in a report cannot be compared with the one that came out now.
    #[error("the row of {name} cannot be compared: {reason}")]
    Incomparable {
        name: EpisodeName,
        /// The error of the table library.
        reason: String,
    },
    /// Scenario files are not those that were run.
    #[error("{}", lines(changes))]
    Changed {
        /// What differs.
        changes: Vec<Change>,
    },
    /// A report does not hold a file of its scenario, and the file is not in its place either.
    #[error(
        "`{report}` does not hold `{path}` (BLAKE3 {}…), and there is no such file",
        blake3.get(..12).unwrap_or_default(),
        report = report.display()
    )]
    NotHeld {
        /// The path of the file in the run.
        path: String,
        report: PathBuf,
        /// Its hash, in hexadecimal digits.
        blake3: String,
    },
    /// Two reports cannot be compared.
    #[error(transparent)]
    Compare(Box<Incomparable>),
    /// The files do not hold the campaign of the report.
    #[error("the files hold no campaign `{campaign}` any more")]
    CampaignGone { campaign: String },
    /// The campaign does not have the run of an episode.
    #[error("the campaign `{campaign}` has no run `{}` any more", name.run)]
    RunGone { campaign: String, name: EpisodeName },
    /// A driver that was named is not there.
    #[error("{place} have no driver `{driver}`; they have {}", named(known))]
    NoDriver {
        driver: String,
        /// What was searched for it, in the plural.
        place: &'static str,
        /// The drivers that are there.
        known: Vec<String>,
    },
    /// No driver of a report is among the new ones.
    #[error(
        "no driver of the report is among the new ones: the report has {}, the new files have {}",
        named(before),
        named(after)
    )]
    NoSharedDriver {
        /// The drivers of the report.
        before: Vec<String>,
        /// The new drivers.
        after: Vec<String>,
    },
    /// The stored commands of a failure do not end its episode.
    #[error("the commands of {name} do not lead to the end of an episode any more")]
    CommandsDiffer {
        /// The failure.
        name: EpisodeName,
    },
}

/// What could not be written while a campaign was run.
#[derive(Debug, thiserror::Error)]
pub enum KeepError {
    /// A task.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// A part of the report.
    #[error(transparent)]
    Write(#[from] WriteError),
}

/// A difference between the files of a report and the files of now.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Change {
    /// A file was read for the report and is not read now.
    #[error("`{path}` was read then, and is not now")]
    Gone {
        /// The file.
        path: String,
    },
    /// A file has other contents.
    #[error(
        "`{path}` has changed since then: its hash was {}…, and is {}…",
        then.get(..12).unwrap_or_default(),
        now.get(..12).unwrap_or_default()
    )]
    Contents {
        /// The file.
        path: String,
        /// Its hash in the report, BLAKE3 in hexadecimal digits.
        then: String,
        /// Its hash now.
        now: String,
    },
    /// A file is read now and was not read for the report.
    #[error("`{path}` is read now, and was not")]
    New {
        /// The file.
        path: String,
    },
}

fn listed<T: std::fmt::Display>(all: &[T]) -> String {
    all.iter().map(|each| format!("  {each}")).collect::<Vec<_>>().join("\n")
}

pub(super) fn named(names: &[String]) -> String {
    if names.is_empty() {
        return "none".into();
    }
    names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ")
}

fn lines<T: std::fmt::Display>(all: &[T]) -> String {
    all.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
}

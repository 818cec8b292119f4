use std::path::PathBuf;

use super::{EpisodeName, OtherReport};
use crate::exit_code::ExitCode;
use export::ExportError;
use lang::Unreadable;
use results::report::{GateError, ReadError, WriteError};
use results::store::StoreError;

/// Why a call of a session or a command has no result. The text names the options that help.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// Named scenario files cannot be read.
    #[error("{}", lines(files))]
    Unreadable {
        /// The files, each with the reason.
        files: Vec<Unreadable>,
    },
    #[error("{} found; nothing was run", if *errors == 1 { "1 error".into() } else { format!("{errors} errors") })]
    Scenario {
        /// The number of diagnostics that are errors.
        errors: usize,
    },
    #[error("--map names the town `{town}`, which nothing uses")]
    UnusedMap { town: String },
    #[error(
        "`{}` holds results for other inputs, which are not replaced:\n{}\nnothing was run; --out DIR writes to another folder, --replace replaces \
         that report{}",
        .0.folder.display(), listed(&.0.differences), .0.advice()
    )]
    OtherReport(Box<OtherReport>),
    /// The files hold no campaign.
    #[error("{advice}")]
    NoCampaign {
        /// What to write or to name instead.
        advice: String,
    },
    /// A gate judges no row of the campaigns.
    #[error("--fail-if: {0}")]
    Gate(#[from] GateError),
    /// There is no store to work with.
    #[error(transparent)]
    Store(#[from] StoreError),
    #[error("{source}\n  what was finished before is kept; run the same command again to go on (`{out}`)", out = out.display())]
    Keep { out: PathBuf, source: KeepError },
    /// A file or a table cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    #[error("cannot export {name}: {source}")]
    Export { name: EpisodeName, source: ExportError },
    /// A report cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    #[error("there is no report in `{folder}`; name its folder with --report", folder = folder.display())]
    NoReport { folder: PathBuf },
    /// Scenario files are not those that were run.
    #[error("{}", lines(changes))]
    Changed {
        /// What differs.
        changes: Vec<Change>,
    },
    /// Something that was named is missing or cannot be used.
    #[error("{0}")]
    Usage(String),
    /// A repetition differs from its report, or cannot be made.
    #[error("{0}")]
    Differs(String),
}

impl Error {
    /// The exit code of a command that ends with it.
    pub fn exit_code(&self) -> ExitCode {
        match self {
            Self::Scenario { .. } => ExitCode::Scenario,
            Self::NoCampaign { .. } => ExitCode::Nothing,
            Self::Store(error) if error.is_misuse() => ExitCode::Usage,
            Self::Export { source: ExportError::NotRepresentable { .. }, .. } => ExitCode::Usage,
            Self::Store(_) | Self::Keep { .. } | Self::Write(_) | Self::Export { .. } => ExitCode::WriteFailed,
            Self::Changed { .. } | Self::Differs(_) => ExitCode::Differs,
            Self::Unreadable { .. }
            | Self::UnusedMap { .. }
            | Self::OtherReport(_)
            | Self::Gate(_)
            | Self::Read(_)
            | Self::NoReport { .. }
            | Self::Usage(_) => ExitCode::Usage,
        }
    }
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
    #[error("`{path}` was read then, and is not now")]
    Gone { path: String },
    #[error("`{path}` has changed since then: its hash was {}…, and is {}…", short(then), short(now))]
    Contents {
        path: String,
        /// Its hash in the report, BLAKE3 in hexadecimal digits.
        then: String,
        now: String,
    },
    #[error("`{path}` is read now, and was not")]
    New { path: String },
}

/// The start of a hash.
pub(super) fn short(hash: &str) -> &str {
    hash.get(..12).unwrap_or_default()
}

fn listed<T: std::fmt::Display>(all: &[T]) -> String {
    all.iter().map(|each| format!("  {each}")).collect::<Vec<_>>().join("\n")
}

fn lines<T: std::fmt::Display>(all: &[T]) -> String {
    all.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
}

/// Names in a sentence.
pub(crate) fn named(names: &[String]) -> String {
    if names.is_empty() {
        return "none".into();
    }
    names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ")
}

//! Options of the commands that repeat an episode of a report.

use std::path::PathBuf;

use clap::Args;

use crate::session::{self, EpisodeName};

/// Options of all commands that repeat episodes of a report.
#[derive(Debug, Args)]
pub struct RepeatOptions {
    /// Folder to which the scenario files' paths are relative, when it is not the folder of the run.
    #[arg(long, value_name = "DIR")]
    pub files: Option<PathBuf>,
    /// Let scenarios start programs as drivers again; use it only with files that you trust.
    #[arg(long)]
    pub allow_external: bool,
    /// Continue although a scenario file has changed since the run.
    #[arg(long)]
    pub anyway: bool,
}

/// Which episode, and where its report is.
#[derive(Debug, Args)]
pub struct NameOptions {
    /// The episode, or the failure of a search.
    #[arg(value_name = "RUN:EPISODE", value_parser = str::parse::<EpisodeName>)]
    pub name: EpisodeName,
    /// A report, or a folder of reports.
    #[arg(long, default_value = "reports", env = "FALSIFY_OUT", value_name = "DIR")]
    pub report: PathBuf,
    /// Options of the repetition.
    #[command(flatten)]
    pub repeat: RepeatOptions,
}

impl RepeatOptions {
    /// The same options for a session.
    pub fn repeat(&self) -> session::RepeatOptions {
        session::RepeatOptions { files: self.files.clone(), anyway: self.anyway }
    }
}

impl NameOptions {
    /// The same options for a session.
    pub fn replay(&self) -> session::ReplayOptions {
        session::ReplayOptions { name: self.name, report: self.report.clone(), repeat: self.repeat.repeat() }
    }
}

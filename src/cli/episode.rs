//! Options of the commands that repeat an episode of a report.

use std::path::PathBuf;

use clap::Args;

use crate::session::{self, EpisodeName};

/// Options of everything that repeats what a report holds.
#[derive(Debug, Args)]
pub struct RepeatOptions {
    /// Folder to which the scenario files' paths are relative, when it is not the one in which they were run.
    #[arg(long, value_name = "DIR")]
    pub files: Option<PathBuf>,
    /// Let scenarios start programs as drivers again; give it only with files that you trust.
    #[arg(long)]
    pub allow_external: bool,
    /// Go on although a scenario file is not the one that was run.
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
    /// How it is repeated.
    #[command(flatten)]
    pub repeat: RepeatOptions,
}

impl RepeatOptions {
    /// The same for a session.
    pub fn repeat(&self) -> session::RepeatOptions {
        session::RepeatOptions { files: self.files.clone(), anyway: self.anyway }
    }
}

impl NameOptions {
    /// The same for a session.
    pub fn replay(&self) -> session::ReplayOptions {
        session::ReplayOptions { name: self.name, report: self.report.clone(), repeat: self.repeat.repeat() }
    }
}

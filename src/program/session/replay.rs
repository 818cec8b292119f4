use std::path::PathBuf;

use super::{EpisodeName, Error, RepeatOptions, Repeated, Session};
use results::report::StoredReport;

/// Options of [`Session::replay`].
#[derive(Debug, Clone)]
pub struct ReplayOptions {
    /// The episode, or the failure of a search.
    pub name: EpisodeName,
    /// A report, or a folder of reports.
    pub report: PathBuf,
    /// Options of the repetition.
    pub repeat: RepeatOptions,
}

/// An episode of a report that was repeated.
#[derive(Debug, Clone)]
pub struct Replay {
    pub report: StoredReport,
    pub episode: Repeated,
}

impl Session {
    /// Repeats an episode of a report and compares it with the report.
    ///
    /// # Errors
    /// No report has it, scenario files cannot be compiled or are not those that were run, or a file of the report is damaged.
    pub fn replay(&self, options: &ReplayOptions) -> Result<Replay, Error> {
        let report = self.find(&options.report, options.name)?;
        let source = self.reopen(report, &options.repeat)?;
        let episode = source.repeat(options.name)?;
        Ok(Replay { report: source.report, episode })
    }
}

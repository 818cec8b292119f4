use std::path::PathBuf;

use super::{ChangedProgram, EpisodeName, Error, RepeatOptions, Repeated, Session};
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
    /// The programs that are not, or need not be, those of the report.
    pub programs: Vec<ChangedProgram>,
}

impl Session {
    /// Repeats an episode of a report and compares it with the report.
    ///
    /// # Errors
    /// No report has it, scenario files cannot be compiled or are not those that were run, or a file of the report is damaged.
    pub fn replay(&self, options: &ReplayOptions) -> Result<Replay, Error> {
        let report = self.find(&options.report, options.name)?;
        report.check_for_repetition()?;
        let source = self.reopen(report, &options.repeat)?;
        let episode = source.repeat(options.name)?;
        let programs = source.changed_programs();
        Ok(Replay { report: source.report, episode, programs })
    }
}

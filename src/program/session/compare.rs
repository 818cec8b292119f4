use std::path::PathBuf;

use super::{EpisodeName, Error, RepeatOptions, Session};
use results::report::{self, FailureChange, PlayedPair, ReportComparison, Side, StoredReport};

/// Options of [`Session::compare`].
#[derive(Debug, Clone, Default)]
pub struct CompareOptions {
    /// The first report, and the second one; the same twice to compare two drivers of a report.
    pub reports: [PathBuf; 2],
    /// The driving policy of each side; all of them without it.
    pub drivers: Option<[String; 2]>,
}

impl Session {
    /// Compares two reports, or two driving policies, over the starts that they share.
    ///
    /// # Errors
    /// A report cannot be read, or nothing can be compared.
    pub fn compare(&self, options: &CompareOptions) -> Result<ReportComparison, Error> {
        let [before, after] = &options.reports;
        let before = StoredReport::open(before)?;
        let after = StoredReport::open(after)?;
        for report in [&before, &after] {
            report.check_manifest()?;
            report.check_tables()?;
        }
        let driver = |side: usize| options.drivers.as_ref().map(|drivers| drivers[side].as_str());
        let first = Side { report: &before, driver: driver(0) };
        let second = Side { report: &after, driver: driver(1) };
        report::compare_reports(first, second).map_err(|error| Error::Compare(Box::new(error)))
    }

    /// Repeats both episodes of some changes, for a page that plays them side by side.
    ///
    /// # Errors
    /// Those of [`Session::replay`].
    pub fn play_changes(
        &self,
        comparison: &ReportComparison,
        changes: &[&FailureChange],
        options: &RepeatOptions,
    ) -> Result<Vec<PlayedPair>, Error> {
        if changes.is_empty() {
            return Ok(Vec::new());
        }
        let [before, after] = &comparison.folders;
        let sources =
            [self.reopen(StoredReport::open(before)?, options)?, self.reopen(StoredReport::open(after)?, options)?];
        let play = |change: &&FailureChange| {
            let side = |side: usize| -> Result<report::Replay, Error> {
                let name = EpisodeName::of_table(change.sides[side].name.clone())?;
                let again = sources[side].repeat(name)?;
                Ok(report::Replay::of_episode(&again.scenario, &again.outcome, &again.trace, again.verdict.as_ref()))
            };
            Ok(PlayedPair { change: (*change).clone(), replays: [side(0)?, side(1)?] })
        };
        changes.iter().map(play).collect()
    }
}

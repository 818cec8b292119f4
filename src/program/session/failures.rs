use std::collections::BTreeSet;
use std::path::PathBuf;

use super::{Error, Session};
use results::report::{FailureFilter, FailureOrder, ListedFailure};

/// Options of [`Session::failures`].
#[derive(Debug, Clone, Default)]
pub struct FailuresOptions {
    /// Reports, or folders of reports.
    pub reports: Vec<PathBuf>,
    /// The failures that are listed.
    pub filter: FailureFilter,
    /// Their order, over all reports.
    pub order: FailureOrder,
    /// Whether only the first of each start of a town and driver is listed.
    pub distinct: bool,
}

/// A failure, and the report that has it.
#[derive(Debug, Clone, PartialEq)]
pub struct FoundFailure {
    /// The folder of the report.
    pub report: PathBuf,
    pub failure: ListedFailure,
}

impl Session {
    /// Lists the failures of reports, of evaluations and searches alike.
    ///
    /// # Errors
    /// No report is there, or a table is damaged.
    pub fn failures(&self, options: &FailuresOptions) -> Result<Vec<FoundFailure>, Error> {
        let mut found: Vec<FoundFailure> = Vec::new();
        for folder in &options.reports {
            for report in self.open_all(folder)? {
                report.check_tables()?;
                let failures = report.failures(&options.filter)?.into_iter();
                found.extend(failures.map(|failure| FoundFailure { report: report.folder().to_path_buf(), failure }));
            }
        }
        found.sort_by(|a, b| options.order.compare(&a.failure, &b.failure));
        if options.distinct {
            let mut seen = BTreeSet::new();
            found.retain(|FoundFailure { report, failure }| {
                let ListedFailure { town, policy, start, .. } = failure;
                seen.insert((report.clone(), town.clone(), policy.clone(), *start))
            });
        }
        Ok(found)
    }
}

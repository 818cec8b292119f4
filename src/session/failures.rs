use std::path::PathBuf;

use super::{Error, Notice, Session};
use crate::report::{FailureFilter, FailureOrder, ListedFailure, StoredReport};

/// Options of [`Session::failures`].
#[derive(Debug, Clone, Default)]
pub struct FailuresOptions {
    /// Reports, or folders of reports.
    pub reports: Vec<PathBuf>,
    /// The failures that are listed.
    pub filter: FailureFilter,
    /// Their order, over all reports.
    pub order: FailureOrder,
}

/// A failure, and the report that has it.
#[derive(Debug, Clone, PartialEq)]
pub struct FoundFailure {
    /// The folder of the report.
    pub report: PathBuf,
    /// The failure.
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
            let folders = StoredReport::find(folder);
            if folders.is_empty() {
                return Err(Error::NoReport { folder: folder.clone() });
            }
            for each in &folders {
                let report = match StoredReport::open(each) {
                    Ok(report) => report,
                    Err(error) if folders.len() == 1 => return Err(error.into()),
                    Err(error) => {
                        self.observer.notice(&Notice::UnreadableReport(error));
                        continue;
                    }
                };
                let failures = report.failures(&options.filter)?.into_iter();
                found.extend(failures.map(|failure| FoundFailure { report: each.clone(), failure }));
            }
        }
        found.sort_by(|a, b| options.order.compare(&a.failure, &b.failure));
        Ok(found)
    }
}

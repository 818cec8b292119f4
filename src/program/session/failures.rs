use std::collections::BTreeSet;
use std::path::PathBuf;

use super::{Error, Session};
use results::report::{FailureFilter, FailureOrder, ListedFailure, StoredReport};

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

/// The words that reports have for a filter.
#[derive(Debug, Default)]
struct FilterWords {
    drivers: BTreeSet<String>,
    controllers: BTreeSet<String>,
    kinds: BTreeSet<String>,
    requirements: BTreeSet<String>,
}

impl FilterWords {
    /// Adds those of a report.
    fn add(&mut self, report: &StoredReport) -> Result<(), Error> {
        for run in report.run_rows()? {
            self.drivers.insert(run.key.cell.policy);
            self.controllers.insert(run.key.cell.controller);
        }
        for search in report.searches()? {
            self.drivers.insert(search.policy);
            self.controllers.insert(search.falsifier);
        }
        self.requirements.extend(report.requirements()?);
        let every = FailureFilter {
            verdicts: FailureFilter::verdict_names().map(Into::into).collect(),
            ..FailureFilter::default()
        };
        for failure in report.failures(&every)? {
            self.kinds.extend(failure.kind().split(", ").map(|word| word.replace(' ', "_")));
        }
        Ok(())
    }

    /// The first word of a filter that no report has: what it should be, the word, and the known ones.
    fn unknown(&self, filter: &FailureFilter) -> Option<(&'static str, String, String)> {
        let parts = [
            ("driver", &filter.drivers, &self.drivers),
            ("controller or falsifier", &filter.controllers, &self.controllers),
            ("word of a kind", &filter.kind, &self.kinds),
            ("requirement", &filter.requirements, &self.requirements),
        ];
        // Without any failure there is no word of a kind.
        let looked_at = parts.into_iter().filter(|(what, _, known)| !known.is_empty() || *what == "requirement");
        looked_at.into_iter().find_map(|(what, words, known)| {
            let word = words.iter().find(|word| !known.contains(&word.replace(' ', "_")))?;
            let known: Vec<&str> = known.iter().map(String::as_str).collect();
            let known = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
            Some((what, word.clone(), known))
        })
    }
}

impl Session {
    /// Lists the failures of reports, of evaluations and searches alike.
    ///
    /// # Errors
    /// No report is there, a table is damaged, or the filter names a driver, a controller or a kind that no report has.
    pub fn failures(&self, options: &FailuresOptions) -> Result<Vec<FoundFailure>, Error> {
        let mut found: Vec<FoundFailure> = Vec::new();
        let mut known = FilterWords::default();
        for folder in &options.reports {
            for report in self.open_whole(folder)? {
                report.check_tables()?;
                known.add(&report)?;
                let failures = report.failures(&options.filter)?.into_iter();
                found.extend(failures.map(|failure| FoundFailure { report: report.folder().to_path_buf(), failure }));
            }
        }
        if found.is_empty()
            && let Some((what, word, words)) = known.unknown(&options.filter)
        {
            return Err(Error::Usage(format!("no report has a {what} `{word}`; known are: {words}")));
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

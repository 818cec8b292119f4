use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use crate::record::RunKey;
use crate::report::read::StoredRun;
use crate::report::{ReadError, StoredReport};

/// One side of a comparison: a report, or one driving policy of it.
#[derive(Debug, Clone, Copy)]
pub struct Side<'a> {
    pub report: &'a StoredReport,
    /// The driving policy; all of them without it.
    pub driver: Option<&'a str>,
}

/// Why two sides cannot be compared.
#[derive(Debug, thiserror::Error)]
pub enum Incomparable {
    /// A table cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// A report has no such driving policy.
    #[error("`{report}` has no episodes of a driver `{driver}`; it has {}", known.join(", "), report = report.display())]
    NoDriver {
        /// The folder of the report.
        report: PathBuf,
        driver: String,
        /// The drivers that it has.
        known: Vec<String>,
    },
    /// No run of one side is a run of the other.
    #[error(
        "nothing can be compared: no run of `{}` has the place, controller and driver of a run of `{}`\n  the first has, for example: {}\n  the second: {}",
        folders.0.display(), folders.1.display(), examples.0, examples.1
    )]
    NoRun {
        /// The folders of the reports.
        folders: (PathBuf, PathBuf),
        /// A run of each.
        examples: (String, String),
    },
    /// Matched runs have no start in common.
    #[error("nothing can be compared: no episode of one side has the start of an episode of the other{}", because.as_ref().map_or(String::new(), |reason| format!(", since {reason}")))]
    NoStart {
        /// The likely reason.
        because: Option<String>,
    },
}

/// Runs of both sides with the same place, controller and number.
#[derive(Default)]
pub(super) struct Matched {
    pub pairs: Vec<(StoredRun, StoredRun)>,
    /// The numbers of runs without a partner.
    pub unmatched: [usize; 2],
}

/// Finds the runs of both sides that belong together.
pub(super) fn matched(before: Side<'_>, after: Side<'_>) -> Result<Matched, Incomparable> {
    let (first, second) = (before.runs()?, after.runs()?);
    let drivers = |runs: &[StoredRun]| runs.iter().map(|run| run.key.cell.policy.clone()).collect::<BTreeSet<_>>();
    let (named, other) = (drivers(&first), drivers(&second));
    // One driver on each side is the same one under two names, or two that the user compares.
    let renamed = named != other && named.len() == 1 && other.len() == 1;
    let one_report = before.report.folder() == after.report.folder();
    let names = |run: &StoredRun| names(&run.key, renamed, one_report);
    let mut partners: BTreeMap<String, StoredRun> = BTreeMap::new();
    let mut unmatched = [0; 2];
    for run in second {
        partners.entry(names(&run)).or_insert(run);
    }
    let all = partners.len();
    let mut pairs = Vec::new();
    let example = first.first().map_or(String::new(), |run| run.key.to_string());
    let other_example = partners.values().next().map_or(String::new(), |run| run.key.to_string());
    let mut seen = BTreeSet::new();
    for run in first.into_iter().filter(|run| seen.insert(names(run))) {
        match partners.remove(&names(&run)) {
            Some(partner) => pairs.push((run, partner)),
            None => unmatched[0] += 1,
        }
    }
    unmatched[1] = all - pairs.len();
    if pairs.is_empty() {
        let folders = (before.report.folder().to_path_buf(), after.report.folder().to_path_buf());
        return Err(Incomparable::NoRun { folders, examples: (example, other_example) });
    }
    Ok(Matched { pairs, unmatched })
}

/// What two runs that belong together have in common. An untrained controller is the same for all rewards.
fn names(key: &RunKey, renamed: bool, one_report: bool) -> String {
    let cell = &key.cell;
    let policy: &str = if renamed { "" } else { &cell.policy };
    // In two reports a renamed driver has pedestrians that were trained against it; in one report the pedestrian must be the same.
    let own = renamed && !one_report && cell.train_policy == cell.policy;
    let train_policy: &str = if own { "" } else { &cell.train_policy };
    let reward: &str = if cell.is_of_reward() { &cell.reward } else { "" };
    let words: [&str; 8] =
        [&cell.town, policy, &cell.vehicle, &cell.adversary, &cell.controller, reward, &cell.train_town, train_policy];
    format!("{}\0{}\0{}", words.join("\0"), cell.block, key.run)
}

impl Side<'_> {
    fn runs(&self) -> Result<Vec<StoredRun>, Incomparable> {
        let mut runs = self.report.run_rows()?;
        let Some(driver) = self.driver else { return Ok(runs) };
        let known: BTreeSet<String> = runs.iter().map(|run| run.key.cell.policy.clone()).collect();
        runs.retain(|run| run.key.cell.policy == driver);
        if runs.is_empty() {
            let (report, driver) = (self.report.folder().to_path_buf(), driver.to_string());
            return Err(Incomparable::NoDriver { report, driver, known: known.into_iter().collect() });
        }
        Ok(runs)
    }
}

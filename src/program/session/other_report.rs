//! Whether the place of a report holds a finished report for other inputs.

use std::path::PathBuf;

use super::error::named;
use super::{ChangedProgram, Error, RunOptions};
use compile::{Campaign, Training};
use results::report::{FileRecord, Manifest, ReadError, RunRecord, StoredReport, TrainingRecord};
use results::store::CODE;

/// A finished report that is not replaced, since it has results that the new one would not have.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct OtherReport {
    pub folder: PathBuf,
    /// What differs; at least one.
    pub differences: Vec<OtherInput>,
}

/// A difference between what a report is of and what would be run.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum OtherInput {
    #[error("its seed is {then}, this one is {now}")]
    Seed { then: u64, now: u64 },
    #[error("its settings are {}, these are {}", named(then), named(now))]
    Settings {
        /// The settings of the report, as `name = value`.
        then: Vec<String>,
        now: Vec<String>,
    },
    #[error("`{path}` has changed since then")]
    File { path: String },
    /// A program of the user with other files.
    #[error("{0} since then")]
    Program(ChangedProgram),
    #[error("it was made by another build of the program (code {}…, this is {}…)", then.get(..8).unwrap_or(then), &CODE[..8])]
    Code { then: String },
    #[error("{missing} of its {all} runs and trainings would be lost or shortened; the first is {first}")]
    Runs { missing: usize, all: usize, first: String },
    #[error("its manifest cannot be read, or is of a version that does not say what was run")]
    Unknown,
}

impl OtherReport {
    /// What helps after an edit of a program of the user.
    pub(super) fn advice(&self) -> String {
        if !self.differences.iter().any(|each| matches!(each, OtherInput::Program(_))) {
            return String::new();
        }
        let folder = self.folder.display();
        format!("\n`falsify recheck --allow-external {folder}` lets the new program meet the same starts")
    }
}

/// Checks that a finished report at the place of a campaign's report loses nothing when it is replaced: each of its runs is part of the
/// campaign, with at least as many episodes. So the same campaign again does not replace anything else, nor does one with further
/// drivers or more episodes.
///
/// # Errors
/// [`Error::OtherReport`].
pub(super) fn check_place(campaign: &Campaign, options: &RunOptions, files: &[FileRecord]) -> Result<(), Error> {
    if options.replace || options.smoke {
        return Ok(());
    }
    let folder = options.out.join(options.report_name(campaign));
    let differences = match StoredReport::open(&folder) {
        Ok(report) => differences(report.manifest(), campaign, options, files),
        // No report, or another file: the writer of reports refuses the latter.
        Err(ReadError::File { .. }) => Vec::new(),
        Err(_) => vec![OtherInput::Unknown],
    };
    if differences.is_empty() { Ok(()) } else { Err(Error::OtherReport(Box::new(OtherReport { folder, differences }))) }
}

/// Whether the report of a campaign comes from these files and settings.
pub(super) fn was_run_with(campaign: &Campaign, options: &RunOptions, files: &[FileRecord]) -> bool {
    let report = StoredReport::open(&options.out.join(options.report_name(campaign)));
    report.is_ok_and(|report| {
        let then = report.manifest();
        let is_same =
            |file: &FileRecord| then.files.iter().any(|old| old.path == file.path && old.blake3 == file.blake3);
        then.settings == campaign.settings && files.iter().all(is_same)
    })
}

fn differences(then: &Manifest, campaign: &Campaign, options: &RunOptions, files: &[FileRecord]) -> Vec<OtherInput> {
    let now: Vec<RunRecord> = campaign.jobs.iter().filter_map(RunRecord::of).collect();
    let lost_runs = then.runs.iter().filter(|run| !now.iter().any(|new| new.id == run.id && new.amount >= run.amount));
    let is_planned = |fingerprint: &str, run: u32| {
        campaign.all::<Training>().any(|new| new.key.run == run && new.origin.fingerprint.to_string() == *fingerprint)
    };
    let lost_trainings = then.trainings.iter().filter(|training| !is_planned(&training.fingerprint, training.run));
    let named = |training: &TrainingRecord| {
        format!(
            "training of {} in {} against {}, run {}",
            training.reward, training.town, training.driver, training.run
        )
    };
    let lost: Vec<String> = lost_runs.map(|run| run.what.clone()).chain(lost_trainings.map(named)).collect();
    let mut found = Vec::new();
    if then.runs.is_empty() && then.trainings.is_empty() {
        found.push(OtherInput::Unknown);
    }
    if then.code != CODE {
        found.push(OtherInput::Code { then: then.code.clone() });
    }
    let Some(first) = lost.first() else { return found };
    if then.seed != options.seed {
        found.push(OtherInput::Seed { then: then.seed, now: options.seed });
    }
    if then.settings != campaign.settings {
        found.push(OtherInput::Settings { then: then.settings.clone(), now: campaign.settings.clone() });
    }
    let changed = |file: &&FileRecord| then.files.iter().any(|old| old.path == file.path && old.blake3 != file.blake3);
    found.extend(files.iter().filter(changed).map(|file| OtherInput::File { path: file.path.clone() }));
    let programs = ChangedProgram::all(then, campaign).into_iter().filter(|program| !program.files.is_empty());
    found.extend(programs.map(OtherInput::Program));
    let all = then.runs.len() + then.trainings.len();
    found.push(OtherInput::Runs { missing: lost.len(), all, first: first.clone() });
    found
}

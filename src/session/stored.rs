//! Finds and reads a report, and compiles its campaign again.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::held_files::HeldFiles;
use super::{Change, EpisodeName, Error, Input, Notice, Session};
use crate::campaign;
use crate::compile::{Campaign, ControllerKind, Evaluation, Search};
use crate::report::{FileRecord, Manifest, ReadError, RunRecord, StoredReport};
use crate::rl::ActorCritic;
use crate::seed::Seed;

/// Options for repeating a report.
#[derive(Debug, Clone, Default)]
pub struct RepeatOptions {
    /// Folder whose scenario files are read instead of those that the report holds; paths are relative to it.
    pub files: Option<PathBuf>,
    /// Whether to continue although a scenario file has changed since the run.
    pub anyway: bool,
}

/// A report with its campaign.
pub(super) struct Source {
    /// The report.
    pub report: StoredReport,
    /// The campaign.
    pub campaign: Campaign,
    /// The user's seed.
    pub seed: Seed,
}

impl Session {
    /// Finds the report that holds an episode. Complete reports precede partial ones and smoke runs.
    pub(super) fn find(&self, folder: &Path, name: EpisodeName) -> Result<StoredReport, Error> {
        let mut holding = Vec::new();
        for report in self.open_all(folder)? {
            if report.holds(name.run)? {
                holding.push(report);
            }
        }
        holding.sort_by_key(|report| (report.manifest().smoke, !report.manifest().complete));
        holding.into_iter().next().ok_or_else(|| Error::NoRun { folder: folder.to_path_buf(), name })
    }

    /// Opens the report in a folder, or all reports of its subfolders. Of several, those that cannot be read are noticed and left out.
    pub(super) fn open_all(&self, folder: &Path) -> Result<Vec<StoredReport>, Error> {
        let folders = StoredReport::find(folder);
        if folders.is_empty() {
            return Err(Error::NoReport { folder: folder.to_path_buf() });
        }
        let mut reports = Vec::new();
        for each in &folders {
            match StoredReport::open(each) {
                Ok(report) => reports.push(report),
                Err(error) if folders.len() == 1 => return Err(error.into()),
                Err(error) => self.observer.notice(&Notice::UnreadableReport(error)),
            }
        }
        Ok(reports)
    }

    /// Compiles the campaign of a report again, from the files that it holds and the settings of its manifest.
    pub(super) fn reopen(&self, report: StoredReport, options: &RepeatOptions) -> Result<Source, Error> {
        let manifest = report.manifest();
        let call = &manifest.call;
        if manifest.version != env!("CARGO_PKG_VERSION") {
            self.observer.notice(&Notice::OtherVersion { version: manifest.version.clone() });
        }
        let root = options.root(Path::new(&call.folder));
        let place = |path: &str| root.as_ref().map_or_else(|| PathBuf::from(path), |root| root.join(path));
        let maps = call.maps.iter().filter_map(|map| map.split_once('='));
        let input = Input {
            files: call.scenarios.iter().map(|path| place(path)).collect(),
            maps: maps.map(|(town, file)| (town.to_string(), place(file))).collect(),
            settings: call.set.clone(),
        };
        if call.allow_external && !self.catalog.starts_programs() {
            self.observer.notice(&Notice::ProgramsNotAllowed);
        }
        let held = HeldFiles::new(&report, &place, self.reader.as_ref(), options.files.is_some());
        if let Some(file) = held.missing() {
            let (path, report) = (file.path.clone(), report.folder().to_path_buf());
            return Err(Error::NotHeld { path, report, blake3: file.blake3.clone() });
        }
        let planned = self.plan_from(&held, &input)?;
        let changes = changes(manifest, &planned.records, root.as_deref());
        if !changes.is_empty() && !options.anyway {
            return Err(Error::Changed { changes });
        }
        changes.into_iter().for_each(|change| self.observer.notice(&Notice::Changed(change)));
        let mut campaigns = planned.plan.campaigns.into_iter();
        let campaign = campaigns.find(|campaign| campaign.name == manifest.campaign);
        let mut campaign = campaign.ok_or_else(|| Error::CampaignGone { campaign: manifest.campaign.clone() })?;
        if manifest.smoke {
            campaign::smoke(&mut campaign);
        }
        name_as_in(manifest, &mut campaign);
        let seed = Seed::root(manifest.seed);
        Ok(Source { report, campaign, seed })
    }
}

/// Gives the runs of a campaign the names that the report has for them, also when files have changed since.
fn name_as_in(manifest: &Manifest, campaign: &mut Campaign) {
    campaign.name_runs(manifest.seed);
    let names: BTreeMap<&str, &str> = manifest.runs.iter().map(|run| (run.what.as_str(), run.id.as_str())).collect();
    let name = |now: &RunRecord| names.get(now.what.as_str()).and_then(|id| id.parse().ok());
    for evaluation in &mut campaign.evaluations {
        evaluation.id = name(&RunRecord::of_evaluation(evaluation)).unwrap_or(evaluation.id);
    }
    for search in &mut campaign.searches {
        search.key.id = name(&RunRecord::of_search(search)).unwrap_or(search.key.id);
    }
}

impl RepeatOptions {
    /// The folder that paths are relative to; none for the current one.
    fn root(&self, recorded: &Path) -> Option<PathBuf> {
        match &self.files {
            Some(folder) => Some(folder.clone()),
            None if std::env::current_dir().is_ok_and(|here| here == recorded) => None,
            None => Some(recorded.to_path_buf()).filter(|folder| folder.is_dir()),
        }
    }
}

/// The files that have changed since the report was made.
fn changes(manifest: &Manifest, now: &[FileRecord], root: Option<&Path>) -> Vec<Change> {
    let mut changes = Vec::new();
    let place = |path: &str| root.map_or_else(|| path.to_string(), |root| root.join(path).display().to_string());
    let known = |path: &str| manifest.files.iter().any(|file| file.path == path || place(&file.path) == path);
    for file in &manifest.files {
        let path = place(&file.path);
        match now.iter().find(|record| record.path == path || record.path == file.path) {
            None => changes.push(Change::Gone { path }),
            Some(record) if record.blake3 != file.blake3 => {
                changes.push(Change::Contents { path, then: file.blake3.clone(), now: record.blake3.clone() });
            }
            Some(_) => {}
        }
    }
    let new = now.iter().filter(|file| !known(&file.path));
    changes.extend(new.map(|file| Change::New { path: file.path.clone() }));
    changes
}

impl Source {
    /// The evaluation of this name, and its place.
    pub fn evaluation(&self, name: EpisodeName) -> Option<(usize, &Evaluation)> {
        self.campaign.evaluations.iter().enumerate().find(|(_, evaluation)| evaluation.id == name.run)
    }

    /// The search of this name.
    pub fn search(&self, name: EpisodeName) -> Option<&Search> {
        self.campaign.searches.iter().find(|search| search.key.id == name.run)
    }

    /// The networks of an evaluation's pedestrian, as the report has them; none for untrained ones.
    ///
    /// # Errors
    /// Their file cannot be read.
    pub fn trained(&self, evaluation: &Evaluation) -> Result<Option<ActorCritic>, ReadError> {
        match evaluation.controller {
            ControllerKind::Trained(_) | ControllerKind::Sampled(_) => {
                self.report.pedestrian(&evaluation.trained).map(Some)
            }
            _ => Ok(None),
        }
    }
}

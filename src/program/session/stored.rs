//! Finds and reads a report, and compiles its campaign again.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;

use super::error::short;
use super::held_files::HeldFiles;
use super::held_programs::HeldPrograms;
use super::{Change, ChangedProgram, EpisodeName, Error, Input, Notice, Session};
use base::seed::Seed;
use compile::{Campaign, Evaluation, Job, RunId, Search, Training};
use learn::ActorCritic;
use results::report::{FileRecord, Manifest, ReadError, RunRecord, StoredReport};

/// Options for repeating a report.
#[derive(Debug, Clone, Default, Args)]
pub struct RepeatOptions {
    /// Read the scenario files from this folder, instead of those that the report holds; paths are relative to it.
    #[arg(long, value_name = "DIR")]
    pub files: Option<PathBuf>,
    /// Continue although a scenario file has changed since the run.
    // The help lists it behind --allow-external.
    #[arg(long, display_order = 15)]
    pub anyway: bool,
}

/// A report with its campaign.
pub(crate) struct Source {
    pub report: StoredReport,
    pub campaign: Campaign,
    /// The user's seed.
    pub seed: Seed,
    /// The programs that have changed since, and drive as they were: from the copies of the report.
    pub held_programs: Vec<String>,
}

/// Which programs drive when a report is compiled again.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum WhichPrograms {
    /// Those of the run, as far as the report holds them.
    OfReport,
    /// Those that are there now.
    Present,
}

impl Session {
    /// Finds the report that holds an episode. Complete reports precede partial ones and smoke runs.
    pub(crate) fn find(&self, folder: &Path, name: EpisodeName) -> Result<StoredReport, Error> {
        let (mut holding, mut unread) = (Vec::new(), None);
        for report in self.open_all(folder)? {
            match report.holds(name.run) {
                Ok(true) => holding.push(report),
                Ok(false) => {}
                Err(error @ ReadError::OnlyCsv { .. }) => unread = Some(error),
                Err(error) => return Err(error.into()),
            }
        }
        holding.sort_by_key(|report| (report.manifest().smoke, !report.manifest().complete));
        let absent = || {
            let folder = folder.display();
            Error::Usage(format!("no report in `{folder}` has a run `{}`; name its folder with --report", name.run))
        };
        holding.into_iter().next().ok_or_else(|| unread.map_or_else(absent, Error::from))
    }

    /// Opens the report in a folder, or all reports of its subfolders. Of several, those that cannot be read are noticed and left out.
    pub(crate) fn open_all(&self, folder: &Path) -> Result<Vec<StoredReport>, Error> {
        let folders = StoredReport::find(folder);
        if folders.is_empty() {
            return Err(Error::NoReport { folder: folder.to_path_buf() });
        }
        let mut reports = Vec::new();
        for each in &folders {
            match StoredReport::open(each) {
                Ok(report) => reports.push(report),
                Err(error) if folders.len() == 1 => return Err(error.into()),
                Err(error) => self.notice(&Notice::Warning(error.to_string())),
            }
        }
        Ok(reports)
    }

    /// Opens reports as [`Session::open_all`] does. Of a folder with several, those of smoke runs and the partial ones beside a complete one of the
    /// same campaign are noticed and left out.
    pub(crate) fn open_whole(&self, folder: &Path) -> Result<Vec<StoredReport>, Error> {
        let reports = self.open_all(folder)?;
        let is_whole = |report: &StoredReport| !report.manifest().smoke && report.manifest().complete;
        let whole: BTreeSet<String> =
            reports.iter().filter(|report| is_whole(report)).map(|report| report.manifest().campaign.clone()).collect();
        if whole.is_empty() {
            return Ok(reports);
        }
        let keeps = |report: &StoredReport| {
            let Manifest { smoke, campaign, .. } = report.manifest();
            is_whole(report) || !smoke && !whole.contains(campaign)
        };
        let (kept, left): (Vec<_>, Vec<_>) = reports.into_iter().partition(keeps);
        if !left.is_empty() {
            let folders: Vec<_> = left.iter().map(|report| report.folder().display().to_string()).collect();
            let text = "left out, since they are of smoke runs or not complete";
            self.notice(&Notice::Note(format!("{text}: {}; name one to list it", folders.join(", "))));
        }
        Ok(kept)
    }

    /// Compiles the campaign of a report again, from the files that it holds and the settings of its manifest.
    pub(crate) fn reopen(&self, report: StoredReport, options: &RepeatOptions) -> Result<Source, Error> {
        self.announce(report.manifest());
        let (source, changes) = self.compile_again(report, options, &[], WhichPrograms::OfReport)?;
        if !changes.is_empty() && !options.anyway {
            return Err(Error::Changed { changes });
        }
        changes.into_iter().for_each(|change| self.notice(&Notice::Warning(change.to_string())));
        for name in &source.held_programs {
            let text = format!(
                "the program of `{name}` has changed since the report, which holds its files: they are used, and those that it does not declare as they are now"
            );
            self.notice(&Notice::Note(text));
        }
        let programs = source.changed_programs().into_iter().filter(|program| !program.files.is_empty());
        programs.for_each(|program| self.notice(&Notice::Warning(format!("{program} since the report"))));
        Ok(source)
    }

    /// Reports what may make a repetition differ from a report with this manifest.
    pub(crate) fn announce(&self, manifest: &Manifest) {
        if manifest.version != env!("CARGO_PKG_VERSION") {
            self.notice(&Notice::Warning(format!(
                "the report is of version {}, this is {}; episodes may come out differently",
                manifest.version,
                env!("CARGO_PKG_VERSION")
            )));
        }
        if manifest.call.allow_external && !self.catalog.starts_programs() {
            let text = "scenarios might start programs in that run; give --allow-external if they may again";
            self.notice(&Notice::Warning(text.into()));
        }
    }

    /// The campaign of a report with these settings after its own, and the files that have changed since the report was made.
    pub(crate) fn compile_again(
        &self,
        report: StoredReport,
        options: &RepeatOptions,
        settings: &[String],
        programs: WhichPrograms,
    ) -> Result<(Source, Vec<Change>), Error> {
        let manifest = report.manifest();
        let call = &manifest.call;
        let root = options.root(Path::new(&call.folder), &self.folder);
        let place = |path: &str| root.as_ref().map_or_else(|| PathBuf::from(path), |root| root.join(path));
        let maps = call.maps.iter().filter_map(|map| map.split_once('='));
        let input = Input {
            files: call.scenarios.iter().map(|path| place(path)).collect(),
            maps: maps.map(|(town, file)| (town.to_string(), place(file))).collect(),
            settings: call.set.iter().chain(settings).cloned().collect(),
        };
        let held = HeldFiles::new(&report, &place, self.reader.as_ref(), options.files.is_some());
        if let Some(file) = held.missing() {
            return Err(Error::Usage(format!(
                "`{}` does not hold `{}` (BLAKE3 {}…), and there is no such file; reports hold files of up to 4 MiB, --files DIR names the folder of \
                 larger ones",
                report.folder().display(),
                file.path,
                short(&file.blake3)
            )));
        }
        let opener = self.catalog.opener().filter(|_| programs == WhichPrograms::OfReport && options.files.is_none());
        let opener = opener.map(|opener| Arc::new(HeldPrograms::new(&report, place, opener.clone())));
        let catalog = self.catalog.clone();
        let catalog = match &opener {
            Some(opener) => catalog.with_opener(opener.clone()),
            None => catalog,
        };
        let planned = self.plan_again(&catalog, &held, &input)?;
        let changes = changes(manifest, &planned.records, root.as_deref());
        let mut campaigns = planned.plan.campaigns.into_iter();
        let campaign = campaigns.find(|campaign| campaign.name == manifest.campaign);
        let campaign = campaign
            .ok_or_else(|| Error::Differs(format!("the files hold no campaign `{}` any more", manifest.campaign)))?;
        let held_programs = opener.map_or_else(Vec::new, |opener| opener.used());
        Ok((Source { held_programs, ..Source::new(report, campaign) }, changes))
    }
}

/// Gives the runs of a campaign the names that the report has for them, also when files have changed since.
fn name_as_in(manifest: &Manifest, campaign: &mut Campaign) {
    campaign.name_runs(manifest.seed);
    let names: BTreeMap<&str, &str> = manifest.runs.iter().map(|run| (run.what.as_str(), run.id.as_str())).collect();
    campaign.rename(|job| names.get(RunRecord::of(job)?.what.as_str())?.parse().ok());
}

impl RepeatOptions {
    /// The folder that paths are relative to; `None` for the current one, which is `here`.
    fn root(&self, recorded: &Path, here: &Path) -> Option<PathBuf> {
        match &self.files {
            Some(folder) => Some(folder.clone()),
            None if here == recorded => None,
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
    /// A report with a campaign, whose runs get the names that they have in the report.
    pub fn new(report: StoredReport, mut campaign: Campaign) -> Self {
        let manifest = report.manifest();
        if manifest.smoke {
            campaign.shorten();
        }
        name_as_in(manifest, &mut campaign);
        let seed = Seed::root(manifest.seed);
        Self { report, campaign, seed, held_programs: Vec::new() }
    }

    /// The error for a run that the campaign does not have.
    pub fn run_gone(&self, run: RunId) -> Error {
        Error::Differs(format!("the campaign `{}` has no run `{run}` any more", self.campaign.name))
    }

    /// The programs that are not, or need not be, those that the report was made with.
    pub fn changed_programs(&self) -> Vec<ChangedProgram> {
        ChangedProgram::all(self.report.manifest(), &self.campaign)
    }

    /// The program of an external driver, if it is not, or need not be, the one that the report was made with. The fingerprints of its
    /// runs depend on it.
    pub fn other_program(&self, driver: &str) -> Option<ChangedProgram> {
        let Campaign { drivers, jobs, .. } = &self.campaign;
        if !drivers.iter().any(|each| each.name == driver && each.is_external()) {
            return None;
        }
        let drives = |job: &&Job| match job {
            Job::Evaluation(job) => *job.policy == *driver,
            Job::Search(job) => job.key.policy == driver,
            _ => false,
        };
        let then = &self.report.manifest().runs;
        let differs =
            |now: RunRecord| then.iter().any(|then| then.what == now.what && then.fingerprint != now.fingerprint);
        let known = self.changed_programs().into_iter().find(|program| program.name == driver);
        let differs = jobs.iter().filter(drives).filter_map(RunRecord::of).any(differs);
        let unnamed = || ChangedProgram { name: driver.to_owned(), files: Vec::new(), is_unknown: false };
        known.or_else(|| differs.then(unnamed))
    }

    pub fn evaluation(&self, name: EpisodeName) -> Option<&Evaluation> {
        self.campaign.all::<Evaluation>().find(|evaluation| evaluation.origin.id == name.run)
    }

    pub fn search(&self, name: EpisodeName) -> Option<&Search> {
        self.campaign.all::<Search>().find(|search| search.origin.id == name.run)
    }

    /// The networks of an evaluation's pedestrian, as the report has them; `None` for untrained ones.
    ///
    /// # Errors
    /// Their file cannot be read.
    pub fn trained(&self, evaluation: &Evaluation) -> Result<Option<Vec<ActorCritic>>, ReadError> {
        let training = evaluation.origin.needs.and_then(|place| self.campaign.jobs[place].of::<Training>());
        training.map(|training| self.report.pedestrian(training)).transpose()
    }
}

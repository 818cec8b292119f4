//! `falsify replay --all`: repeats what a report holds, and compares it byte for byte.

use std::collections::BTreeMap;
use std::num::NonZeroUsize;
use std::path::PathBuf;

use clap::Args;
use rand::seq::index::sample;

use crate::cli::console;
use crate::exit_code::ExitCode;
use crate::session::{ChangedProgram, EpisodeName, Error, Reason, RepeatOptions, Repeated, Session, Source, reasons};
use base::seed::Seed;
use compile::{Campaign, Job, Training, TrainingKey};
use learn::ActorCritic;
use results::campaign::{self, NoStore, Silent};
use results::jobs::TrainingResult;
use results::parallel;
use results::report::StoredReport;

/// Maximum number of differences that are shown.
const MAX_SHOWN: usize = 10;

/// Options for the repetition of a whole report.
#[derive(Debug, Clone, Default, Args)]
pub struct ReplayAllOptions {
    /// Repeat all episodes and failures of a report, compare every column byte for byte, and check the digests of its files.
    #[arg(long = "all", id = "all", value_name = "REPORT")]
    pub report: Option<PathBuf>,
    /// With --all: repeat only this number of episodes and failures, drawn at random.
    #[arg(long, value_name = "N", requires = "all")]
    pub sample: Option<NonZeroUsize>,
    /// With --all: also train every pedestrian again, and compare its networks.
    #[arg(long, requires = "all")]
    pub trainings: bool,
}

/// The result of the repetition of a report.
#[derive(Debug)]
pub struct ReplayedReport {
    pub report: StoredReport,
    /// The number of episodes and failures that were repeated.
    pub repeated: usize,
    /// The rows that name an episode which another row names.
    pub copies: usize,
    /// Those that differ, in the order of their runs.
    pub different: Vec<Repeated>,
    /// The repeated trainings, if they were asked for.
    pub trainings: Option<Retrained>,
    /// The files of the report that are not as they were written.
    pub changed_files: Vec<String>,
    /// The programs that are not, or need not be, those of the report.
    pub programs: Vec<ChangedProgram>,
}

/// Trainings that were repeated.
#[derive(Debug)]
pub struct Retrained {
    pub repeated: usize,
    /// Those whose networks differ.
    pub different: Vec<TrainingKey>,
    /// The number of trainings of drivers, which are not repeated.
    pub of_drivers: usize,
}

impl ReplayedReport {
    /// Whether everything is equal to the report.
    pub fn is_equal(&self) -> bool {
        self.copies == 0
            && self.different.is_empty()
            && self.changed_files.is_empty()
            && self.trainings.as_ref().is_none_or(|trainings| trainings.different.is_empty())
    }
}

impl Session {
    /// Compares the digests of a report's files, repeats its episodes and compares every column; on request also its trainings.
    ///
    /// # Errors
    /// Scenario files cannot be compiled or have changed since the run, or a file of the report is damaged.
    pub fn replay_all(
        &self,
        report: StoredReport,
        options: &ReplayAllOptions,
        repeat: &RepeatOptions,
    ) -> Result<ReplayedReport, Error> {
        report.check_readable()?;
        let source = self.reopen(report, repeat)?;
        let changed_files = source.report.changed_files()?;
        let mut names = chosen(&source, options.sample)?;
        let rows = names.len();
        names.sort_unstable_by_key(|name| (name.run, name.number));
        names.dedup();
        let (repeated, copies) = (names.len(), rows - names.len());
        let different = differing(&source, names)?;
        let trainings = options.trainings.then(|| retrain(&source));
        let programs = source.changed_programs();
        Ok(ReplayedReport { report: source.report, repeated, copies, different, trainings, changed_files, programs })
    }
}

/// The episodes and failures to repeat, in the order of the tables.
fn chosen(source: &Source, size: Option<NonZeroUsize>) -> Result<Vec<EpisodeName>, Error> {
    let mut all = source.report.index()?;
    all.extend(source.report.search_failures()?);
    let mut places: Vec<usize> = match size.map(NonZeroUsize::get) {
        Some(size) if size < all.len() => {
            sample(&mut Seed::root(1).child("verify").stream(), all.len(), size).into_iter().collect()
        }
        _ => (0..all.len()).collect(),
    };
    places.sort_unstable();
    let name = |place: usize| EpisodeName { run: all[place].0, number: all[place].1 };
    Ok(places.into_iter().map(name).collect())
}

/// Repeats episodes, those of a run in sequence; returns those that differ.
fn differing(source: &Source, names: Vec<EpisodeName>) -> Result<Vec<Repeated>, Error> {
    let mut runs: BTreeMap<_, Vec<EpisodeName>> = BTreeMap::new();
    for name in names {
        runs.entry(name.run).or_default().push(name);
    }
    let runs: Vec<Vec<EpisodeName>> = runs.into_values().collect();
    let different = |run: &Vec<EpisodeName>| -> Result<Vec<Repeated>, Error> {
        let repeated = run.iter().map(|name| source.repeat(*name)).collect::<Result<Vec<_>, _>>()?;
        Ok(repeated.into_iter().filter(|episode| !episode.differences.is_empty()).collect())
    };
    Ok(parallel::map(&runs, different).into_iter().collect::<Result<Vec<_>, _>>()?.concat())
}

/// Trains all pedestrians of the report again, and compares their networks bit by bit.
fn retrain(source: &Source) -> Retrained {
    let of_report = |training: &Training| source.report.pedestrian(training).is_ok();
    let is_wanted = |job: &Job| job.of().is_some_and(of_report);
    let jobs: Vec<Job> = source.campaign.jobs.iter().filter(|job| is_wanted(job)).cloned().collect();
    let repeated = jobs.len();
    let alone = Campaign { jobs, ..source.campaign.clone() };
    let finished = campaign::run(&alone, &source.seed, &NoStore, &Silent);
    let mut different = Vec::new();
    for training in finished.all::<TrainingResult>() {
        let planned = source.campaign.all::<Training>().find(|planned| planned.key == training.key);
        let stored = planned.and_then(|planned| source.report.pedestrian(planned).ok());
        let again = training.result.as_ref().ok().map(|trained| trained.policies.as_slice());
        let is_same = again.zip(stored.as_deref()).is_some_and(|(again, stored)| {
            let bytes = |networks: &ActorCritic| networks.to_safetensors(&BTreeMap::new());
            again.iter().map(bytes).eq(stored.iter().map(bytes))
        });
        if !is_same {
            different.push(training.key.clone());
        }
    }
    let of_drivers = source.campaign.all::<Training>().filter(|training| training.drive.is_some()).count();
    Retrained { repeated, different, of_drivers }
}

/// Prints the result for people; returns the exit code.
pub fn tell(replayed: &ReplayedReport) -> ExitCode {
    let ReplayedReport { repeated, different, .. } = replayed;
    for repeated in different.iter().take(MAX_SHOWN) {
        let columns: Vec<&str> = repeated.differences.iter().map(|difference| difference.column.as_str()).collect();
        let divergence =
            repeated.divergence.as_ref().map_or(String::new(), |divergence| format!("; it diverges {divergence}"));
        console::fail(&format!("{} differs from the report: {}{divergence}", repeated.name, columns.join(", ")));
    }
    if different.len() > MAX_SHOWN {
        console::fail(&format!("… and {} more", different.len() - MAX_SHOWN));
    }
    if replayed.copies > 0 {
        let rows = console::count(replayed.copies, "row");
        console::fail(&format!("{rows} of its tables name an episode or a failure that another row names"));
    }
    for file in &replayed.changed_files {
        console::fail(&format!("`{file}` is not as it was written"));
    }
    let files = replayed.report.manifest().report_files.len();
    if files > 0 {
        console::say(&format!("files of the report: {files}, {} changed", replayed.changed_files.len()));
    } else {
        console::warn("the manifest lists no files of the report: it was cut, or is of an earlier version");
    }
    console::say(&match repeated {
        0 => "episodes and failures of searches: none to repeat".to_string(),
        _ => format!("episodes and failures of searches: {repeated} repeated, {} equal", repeated - different.len()),
    });
    if let Some(trainings) = &replayed.trainings {
        for key in &trainings.different {
            console::fail(&format!("the training of {key} differs from the report"));
        }
        let equal = trainings.repeated - trainings.different.len();
        console::say(&format!("trainings: {} repeated, {equal} equal", trainings.repeated));
        if trainings.of_drivers > 0 {
            console::warn(&format!("{} not repeated", console::count(trainings.of_drivers, "training of a driver")));
        }
    }
    if replayed.is_equal() {
        return ExitCode::Done;
    }
    // If only files differ, the program and the processor have nothing to do with it.
    let only_files = different.is_empty() && replayed.trainings.as_ref().is_none_or(|again| again.different.is_empty());
    let all = reasons(&replayed.report, &replayed.programs, &replayed.changed_files);
    let told = all.iter().filter(|reason| !only_files || matches!(reason, Reason::Edited { .. }));
    told.for_each(|reason| console::say(&format!("possible reason: {reason}")));
    ExitCode::Differs
}

use std::collections::{BTreeMap, BTreeSet};
use std::num::NonZeroUsize;
use std::path::PathBuf;

use clap::Args;
use rand::seq::index::sample;
use rayon::prelude::*;

use super::stored::Source;
use super::{ChangedProgram, EpisodeName, Error, RepeatOptions, Repeated, Session};
use base::seed::Seed;
use compile::{Campaign, Training, TrainingKey};
use results::campaign::{self, InMemory, Silent};
use results::report::StoredReport;

/// The number of episodes and failures of searches that are repeated where nothing else is said.
const SAMPLE: usize = 100;

/// Options of [`Session::verify`].
#[derive(Debug, Clone, Default, Args)]
pub struct VerifyOptions {
    /// The report; with names of episodes, also a folder of reports.
    #[arg(skip)]
    pub report: PathBuf,
    /// The episodes to repeat; a sample without any.
    #[arg(skip)]
    pub episodes: Vec<EpisodeName>,
    /// Number of episodes and failures of searches to repeat, 100 without it.
    #[arg(long, value_name = "N")]
    pub sample: Option<NonZeroUsize>,
    /// Repeat all of them.
    #[arg(long, conflicts_with = "sample")]
    pub all: bool,
    /// Train every pedestrian again, too, and compare its networks.
    #[arg(long)]
    pub trainings: bool,
    /// Seed of the sample.
    #[arg(long, default_value_t = 1, value_name = "N")]
    pub seed: u64,
    /// Options of the repetitions.
    #[arg(skip)]
    pub repeat: RepeatOptions,
}

/// The result of a verification.
#[derive(Debug)]
pub struct VerifyReport {
    pub report: StoredReport,
    /// The number of episodes and failures that were repeated.
    pub repeated: usize,
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
}

impl VerifyReport {
    /// Whether everything is equal to the report.
    pub fn is_equal(&self) -> bool {
        self.different.is_empty()
            && self.changed_files.is_empty()
            && self.trainings.as_ref().is_none_or(|trainings| trainings.different.is_empty())
    }
}

impl Session {
    /// Compares the digests of a report's files, repeats episodes and compares every column; on request also its trainings.
    ///
    /// # Errors
    /// Scenario files cannot be compiled or have changed since the run, or a file of the report is damaged.
    pub fn verify(&self, options: &VerifyOptions) -> Result<VerifyReport, Error> {
        let report = match options.episodes.first() {
            Some(first) => self.find(&options.report, *first)?,
            None => StoredReport::open(&options.report)?,
        };
        let source = self.reopen(report, &options.repeat)?;
        let changed_files = source.report.changed_files()?;
        let named = !options.episodes.is_empty();
        let names = if named { options.episodes.clone() } else { chosen(&source, options)? };
        let different = differing(&source, &names)?;
        let trainings = options.trainings.then(|| retrain(&source));
        let programs = source.changed_programs();
        Ok(VerifyReport { report: source.report, repeated: names.len(), different, trainings, changed_files, programs })
    }
}

/// The episodes and failures to repeat, in the order of the tables.
fn chosen(source: &Source, options: &VerifyOptions) -> Result<Vec<EpisodeName>, Error> {
    let mut all = source.report.index()?;
    all.extend(source.report.search_failures()?);
    let places: BTreeSet<usize> = match options.sample.map_or(SAMPLE, NonZeroUsize::get) {
        size if options.all || size >= all.len() => (0..all.len()).collect(),
        size => {
            let mut stream = Seed::root(options.seed).child("verify").stream();
            sample(&mut stream, all.len(), size).into_iter().collect()
        }
    };
    let name = |place: usize| {
        let (run, number) = &all[place];
        EpisodeName::of_table(format!("{run}:{number}"))
    };
    places.into_iter().map(name).collect()
}

/// Repeats episodes, those of a run in sequence; returns those that differ.
fn differing(source: &Source, names: &[EpisodeName]) -> Result<Vec<Repeated>, Error> {
    let mut runs: BTreeMap<_, Vec<EpisodeName>> = BTreeMap::new();
    for name in names {
        runs.entry(name.run).or_default().push(*name);
    }
    let runs: Vec<Vec<EpisodeName>> = runs.into_values().collect();
    let different = |run: &Vec<EpisodeName>| -> Result<Vec<Repeated>, Error> {
        let repeated = run.iter().map(|name| source.repeat(*name)).collect::<Result<Vec<_>, _>>()?;
        Ok(repeated.into_iter().filter(|episode| !episode.differences.is_empty()).collect())
    };
    let by_run: Vec<Result<Vec<Repeated>, Error>> = runs.par_iter().map(different).collect();
    Ok(by_run.into_iter().collect::<Result<Vec<_>, _>>()?.concat())
}

/// Trains all pedestrians of the report again, and compares their networks bit by bit.
fn retrain(source: &Source) -> Retrained {
    let of_report = |training: &&Training| source.report.pedestrian(&training.key).is_ok();
    let trainings: Vec<Training> = source.campaign.trainings.iter().filter(of_report).cloned().collect();
    let repeated = trainings.len();
    let alone = Campaign {
        trainings,
        evaluations: Vec::new(),
        searches: Vec::new(),
        estimations: Vec::new(),
        covers: Vec::new(),
        hardenings: Vec::new(),
        ..source.campaign.clone()
    };
    let finished = campaign::run(&alone, &source.seed, &InMemory::default(), &Silent);
    let mut different = Vec::new();
    for training in finished.trainings {
        let again = training.result.ok().map(|trained| trained.actor_critic.to_safetensors(&BTreeMap::new()));
        let stored = source.report.pedestrian(&training.key).ok();
        let stored = stored.map(|stored| stored.to_safetensors(&BTreeMap::new()));
        if again.is_none() || again != stored {
            different.push(training.key);
        }
    }
    Retrained { repeated, different }
}

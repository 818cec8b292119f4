//! What a report records about its origin, and when it is complete.

use std::collections::BTreeMap;

use super::{Input, Planned, RunOptions, Session};
use compile::Campaign;
use results::campaign::{Finished, TrainingResult};
use results::report::{
    Call, FileRecord, Findings, Gathered, Manifest, ProgramRecord, ReportFolder, RunRecord, ScenarioFile,
    TrainingRecord, WriteError, held_places, pedestrian_file,
};
use results::store::{CODE, vector_instructions};

/// Wall times of a run (s).
pub struct Times {
    /// Of each training of the plan, also of earlier runs.
    pub trainings: Vec<f64>,
    /// Of the whole run.
    pub run: f64,
}

/// Whether the report is complete. It has all trainings, and all episodes of the plan, each with a reward
/// that is a number. Each driver reached the end of an episode in each town. All searches used their budgets.
fn is_complete(campaign: &Campaign, finished: &Finished, gathered: &Gathered) -> bool {
    let trained = finished.trainings.iter().filter(|training| training.result.is_ok()).count();
    trained == campaign.trainings.len()
        && gathered.all_tried
        && gathered.untried == 0
        && gathered.unpaid == 0
        && gathered.every_driver_drove
        && finished.searches.len() == campaign.searches.len()
        && finished.searches.iter().all(|search| search.error.is_none() && !search.spent.stopped)
        && finished.estimates.len() == campaign.estimations.len()
        && finished.estimates.iter().all(|estimate| estimate.error.is_none())
        && finished.covers.len() == campaign.covers.len()
        && finished.covers.iter().all(|cover| cover.error.is_none() && !cover.found.coverage.stopped)
        && finished.hardened.len() == campaign.hardenings.len()
        && finished.hardened.iter().all(|result| result.error.is_none())
}

impl Session {
    /// The manifest of a campaign that was run.
    pub(super) fn manifest(
        &self,
        options: &RunOptions,
        files: Vec<ScenarioFile>,
        found: &Findings<'_>,
        times: &Times,
    ) -> Manifest {
        let Findings { campaign, finished, gathered, .. } = found;
        Manifest {
            version: env!("CARGO_PKG_VERSION").into(),
            code: CODE.into(),
            campaign: campaign.name.clone(),
            seed: options.seed,
            call: self.call(&options.input),
            settings: campaign.settings.clone(),
            smoke: options.smoke,
            complete: is_complete(campaign, finished, gathered),
            stopped: finished.interrupted,
            threads: rayon::current_num_threads(),
            evaluation_ticks: gathered.ticks,
            search_ticks: finished.searches.iter().map(|search| search.spent.ticks).sum(),
            errors: gathered.errors,
            wall_time_s: times.run,
            files,
            vector_instructions: vector_instructions().into(),
            trainings: finished.trainings.iter().map(|training| record(training, campaign, times)).collect(),
            runs: runs(campaign),
            programs: campaign.programs().into_iter().map(|program| ProgramRecord::new(program)).collect(),
            // They are not written yet.
            report_files: Vec::new(),
        }
    }

    /// Adds the files of a scenario to its report, as far as they are of a moderate size and not of the standard library.
    ///
    /// # Errors
    /// A file cannot be written.
    pub(super) fn hold(&self, folder: &ReportFolder, planned: &Planned) -> Result<Vec<ScenarioFile>, WriteError> {
        let read = planned.records.iter().map(|record| record.path.as_str());
        let paths: Vec<&str> = read.filter(|path| planned.contents.contains_key(*path)).collect();
        let places: BTreeMap<&str, String> = paths.iter().copied().zip(held_places(&paths, &self.folder)).collect();
        for (path, contents) in &planned.contents {
            folder.file(&places[path.as_str()], contents)?;
        }
        let file = |FileRecord { path, blake3 }: &FileRecord| ScenarioFile {
            path: path.clone(),
            blake3: blake3.clone(),
            held: places.get(path.as_str()).cloned().unwrap_or_default(),
        };
        Ok(planned.records.iter().map(file).collect())
    }

    /// The input of the session, for a later repetition.
    fn call(&self, input: &Input) -> Call {
        Call {
            folder: self.folder.display().to_string(),
            scenarios: input.files.iter().map(|path| path.display().to_string()).collect(),
            maps: input.maps.iter().map(|(town, file)| format!("{town}={}", file.display())).collect(),
            set: input.settings.clone(),
            allow_external: self.catalog.starts_programs(),
        }
    }
}

/// The evaluations, the searches and the covers of a campaign.
pub fn runs(campaign: &Campaign) -> Vec<RunRecord> {
    let evaluations = campaign.evaluations.iter().map(RunRecord::of_evaluation);
    let searches = campaign.searches.iter().map(RunRecord::of_search);
    let estimations = campaign.estimations.iter().map(RunRecord::of_estimation);
    let covers = campaign.covers.iter().map(RunRecord::of_cover);
    let hardenings = campaign.hardenings.iter().map(RunRecord::of_harden);
    evaluations.chain(searches).chain(estimations).chain(covers).chain(hardenings).collect()
}

fn record(training: &TrainingResult, campaign: &Campaign, times: &Times) -> TrainingRecord {
    let place = campaign.trainings.iter().position(|planned| planned.key == training.key).unwrap_or(0);
    let key = &training.key;
    let fingerprint = campaign.trainings.get(place).map(|planned| planned.fingerprint.to_string());
    let last = training.result.as_ref().ok().and_then(|trained| trained.learning_curve.last());
    TrainingRecord {
        town: key.town.clone(),
        policy: key.policy.clone(),
        reward: key.reward.clone(),
        run: key.run,
        decisions: last.map_or(0, |log| log.steps),
        wall_time_s: times.trainings[place],
        pedestrian: match training.result {
            Ok(_) => pedestrian_file(key, "safetensors"),
            Err(_) => String::new(),
        },
        error: training.result.as_ref().err().map_or(String::new(), ToString::to_string),
        fingerprint: fingerprint.unwrap_or_default(),
    }
}

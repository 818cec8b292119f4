//! What a report records about its origin, and when it is complete.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::{Input, Notice, Planned, RunOptions, Session};
use compile::{Campaign, ExternalProgram, Job, Training};
use results::campaign::Finished;
use results::jobs::{SearchResult, TrainingResult, pedestrian_files};
use results::report::{
    Aggregates, Call, FileRecord, Findings, Manifest, ProgramRecord, ReportFolder, RunRecord, ScenarioFile,
    TrainingRecord, WriteError, held_places,
};
use results::store::{CODE, vector_instructions};

/// Wall times of a run (s).
pub struct Times {
    /// Of each job of the plan, also of earlier runs.
    pub jobs: Vec<f64>,
    /// Of the whole run.
    pub run: f64,
}

/// Whether the report is complete. It has the whole results of all jobs, and all episodes of the plan, each with a reward
/// that is a number. Each driver reached the end of an episode in each town.
fn is_complete(finished: &Finished, gathered: &Aggregates) -> bool {
    finished.is_whole
        && gathered.all_tried
        && gathered.untried == 0
        && gathered.unpaid == 0
        && gathered.every_driver_drove
}

impl Session {
    /// The manifest of a campaign that was run.
    pub(super) fn manifest(
        &self,
        options: &RunOptions,
        (files, programs): (Vec<ScenarioFile>, Vec<ProgramRecord>),
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
            complete: is_complete(finished, gathered),
            stopped: finished.interrupted,
            threads: rayon::current_num_threads(),
            evaluation_ticks: gathered.ticks,
            search_ticks: finished.all::<SearchResult>().iter().map(|search| search.spent.ticks).sum(),
            errors: gathered.errors,
            wall_time_s: times.run,
            answer: results::report::answer(found),
            files,
            vector_instructions: vector_instructions().into(),
            trainings: finished
                .all::<TrainingResult>()
                .iter()
                .map(|training| record(training, campaign, times))
                .collect(),
            runs: campaign.jobs.iter().filter_map(RunRecord::of).collect(),
            baselines: baselines(campaign),
            programs,
            // They are not written yet.
            report_files: Vec::new(),
        }
    }

    /// Adds the files of a scenario and of its programs to the report, as far as they are of a moderate size and not of the standard library.
    ///
    /// # Errors
    /// A file cannot be written.
    pub(super) fn hold(
        &self,
        folder: &ReportFolder,
        planned: &Planned,
        campaign: &Campaign,
    ) -> Result<(Vec<ScenarioFile>, Vec<ProgramRecord>), WriteError> {
        let read = planned.records.iter().map(|record| record.path.as_str());
        let paths: Vec<&str> = read.filter(|path| planned.contents.contains_key(*path)).collect();
        let places: BTreeMap<&str, String> = paths.iter().copied().zip(held_places(&paths, &self.folder)).collect();
        for (path, contents) in &planned.contents {
            folder.file(&places[path.as_str()], contents)?;
        }
        let file = |FileRecord { path, blake3, .. }: &FileRecord| ScenarioFile {
            path: path.clone(),
            blake3: blake3.clone(),
            held: places.get(path.as_str()).cloned().unwrap_or_default(),
        };
        let held = |program: &Arc<ExternalProgram>| {
            let (record, missing) = ProgramRecord::held(program, folder)?;
            let said = |why| format!("a replay runs `{}` as it is then, not as it was in this run: {why}", record.name);
            missing.into_iter().for_each(|why| self.notice(&Notice::Warning(said(why))));
            Ok(record)
        };
        let programs = campaign.programs().into_iter().map(held).collect::<Result<_, WriteError>>()?;
        Ok((planned.records.iter().map(file).collect(), programs))
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

/// The names of the drivers that see no pedestrians.
fn baselines(campaign: &Campaign) -> Vec<String> {
    campaign.drivers.iter().filter(|driver| driver.sees_no_pedestrians()).map(|driver| driver.name.clone()).collect()
}

fn record(training: &TrainingResult, campaign: &Campaign, times: &Times) -> TrainingRecord {
    let key = &training.key;
    let is_it = |(place, job): (usize, &'_ Job)| {
        Some((place, job.of::<Training>().filter(|planned| planned.key == *key)?.clone()))
    };
    let (place, planned) = campaign.jobs.iter().enumerate().find_map(is_it).expect("it was planned");
    let fingerprint = campaign.jobs[place].origin().fingerprint.to_string();
    TrainingRecord {
        town: key.town.clone(),
        driver: key.policy.clone(),
        reward: key.reward.clone(),
        run: key.run,
        decisions: training.decisions,
        wall_time_s: times.jobs[place],
        pedestrian: match training.result {
            Ok(_) => pedestrian_files(&planned, "safetensors").join(", "),
            Err(_) => String::new(),
        },
        error: training.result.as_ref().err().map_or(String::new(), ToString::to_string),
        fingerprint,
    }
}

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::Instant;

use super::args::RunOptions;
use super::progress::Progress;
use super::{ExitCode, front, interrupt};
use crate::campaign::{self, Finished};
use crate::compile::{Campaign, Pedestrian};
use crate::report::{self, FileRecord, Manifest, ReportFolder, TrainingRecord, WriteError};
use crate::seed::Seed;

/// `falsify run`
pub fn run(options: &RunOptions) -> ExitCode {
    let (mut plan, files) = match front::compile_files(&options.files, &options.given) {
        Ok(compiled) => compiled,
        Err(code) => return code,
    };
    if plan.campaigns.is_empty() {
        front::fail("the files hold no campaign; write `campaign NAME { … }` to say what is to be run");
        return ExitCode::Nothing;
    }
    if options.smoke {
        plan.campaigns.iter_mut().for_each(campaign::smoke);
    }
    if options.list {
        plan.campaigns.iter().for_each(list);
        return ExitCode::Done;
    }
    let pool = match rayon::ThreadPoolBuilder::new().num_threads(options.threads.into()).build() {
        Ok(pool) => pool,
        Err(error) => {
            front::fail(&format!("cannot start {} threads: {error}", options.threads));
            return ExitCode::Usage;
        }
    };
    interrupt::listen();
    let mut worst = ExitCode::Done;
    for campaign in &plan.campaigns {
        match pool.install(|| carry_out(campaign, options, &files)) {
            Ok(ExitCode::Done) => {}
            Ok(code) => worst = code,
            Err(message) => {
                front::fail(&message);
                return ExitCode::WriteFailed;
            }
        }
        if interrupt::asked() {
            return ExitCode::Interrupted;
        }
    }
    worst
}

/// Says what a campaign would run.
fn list(campaign: &Campaign) {
    front::say(&format!("campaign {}", campaign.name));
    for training in &campaign.trainings {
        let key = &training.key;
        let decisions = training.config.total_steps;
        front::say(&format!(
            "  train  {} in {} against {}, run {}: {decisions} decisions",
            key.reward, key.town, key.policy, key.run
        ));
    }
    for evaluation in &campaign.evaluations {
        let key = &evaluation.trained;
        let who = match evaluation.pedestrian {
            who @ (Pedestrian::Trained(_) | Pedestrian::Sampled(_)) => {
                format!("{} {} of {} against {}, run {}", who.name(), key.reward, key.town, key.policy, key.run)
            }
            other => format!("{} ({}, run {})", other.name(), key.reward, key.run),
        };
        let episodes = evaluation.episodes;
        front::say(&format!(
            "  try    {who} in {} against {}: {episodes} episodes",
            evaluation.town, evaluation.policy
        ));
    }
    for search in &campaign.searches {
        let key = &search.key;
        front::say(&format!(
            "  search {} in {} against {}, run {}: {} ticks",
            key.falsifier, key.town, key.policy, key.run, search.budget
        ));
    }
}

/// Runs a campaign and writes its report; the error is the message to print.
fn carry_out(campaign: &Campaign, options: &RunOptions, files: &[FileRecord]) -> Result<ExitCode, String> {
    // A trial of the machinery never replaces results.
    let name = if options.smoke { format!("{}-smoke", campaign.name) } else { campaign.name.clone() };
    let folder = ReportFolder::begin(&options.out, &name).map_err(|error| error.to_string())?;
    let began = Instant::now();
    let progress = Progress::new(campaign, options);
    let finished = campaign::run(campaign, &Seed::root(options.seed), &progress);
    let times: Vec<f64> = progress.finish().iter().map(std::time::Duration::as_secs_f64).collect();
    let wall_time_s = began.elapsed().as_secs_f64();
    let failed = finished.trainings.iter().any(|training| training.result.is_err())
        || finished.searches.iter().any(|search| search.error.is_some());
    let manifest = manifest(campaign, options, files, &finished, &times, wall_time_s);
    if finished.rows.is_empty()
        && finished.searches.is_empty()
        && finished.trainings.iter().all(|training| training.result.is_err())
    {
        front::fail("nothing was finished, so nothing was written");
        return Ok(if finished.interrupted { ExitCode::Interrupted } else { ExitCode::RunFailed });
    }
    let broken = finished.rows.iter().filter(|row| !row.outcome.reward.is_finite());
    if let Some(first) = broken.clone().next() {
        front::fail(&format!(
            "the reward `{}` was {} in {} episodes; the first is episode {} in {} against {}",
            first.trained.reward,
            first.outcome.reward,
            broken.count(),
            first.episode,
            first.town,
            first.policy
        ));
    }
    say_errors(&finished);
    interrupt::hold(true);
    let written = report::write(&folder, campaign, &finished, &manifest);
    let kept =
        |error: WriteError, place: PathBuf| format!("{error}\n  what was written is kept in `{}`", place.display());
    let place = match written {
        Ok(()) => folder.finish(manifest.complete).map_err(|(error, place)| kept(error, place))?,
        Err(error) => return Err(kept(error, folder.keep())),
    };
    interrupt::hold(false);
    print_cells(campaign, &finished).map_err(|error| error.to_string())?;
    front::say(&place.join("summary.md").display().to_string());
    let whole = manifest.complete || finished.interrupted;
    Ok(if failed || !whole || manifest.errors > 0 { ExitCode::RunFailed } else { ExitCode::Done })
}

/// Says in how many episodes a driver failed, and how in the first.
fn say_errors(finished: &Finished) {
    let mut failed = finished.rows.iter().filter_map(|row| row.outcome.fault().map(|fault| (row, fault)));
    if let Some((row, fault)) = failed.next() {
        front::fail(&format!(
            "a driver failed in {} of {} episodes, which count for nothing; the first is episode {} in {}: {} {fault}",
            failed.count() + 1,
            finished.rows.len(),
            row.episode,
            row.town,
            row.policy
        ));
    }
}

fn manifest(
    campaign: &Campaign,
    options: &RunOptions,
    files: &[FileRecord],
    finished: &Finished,
    times: &[f64],
    wall_time_s: f64,
) -> Manifest {
    let trainings = finished.trainings.iter().map(|training| {
        let place = campaign.trainings.iter().position(|planned| planned.key == training.key).unwrap_or(0);
        let key = &training.key;
        let curve = training.result.as_ref().ok().and_then(|trained| trained.learning_curve.last());
        TrainingRecord {
            town: key.town.clone(),
            policy: key.policy.clone(),
            reward: key.reward.clone(),
            run: key.run,
            decisions: curve.map_or(0, |log| log.steps),
            wall_time_s: times[place],
            pedestrian: if training.result.is_ok() {
                report::pedestrian_file(key, "safetensors")
            } else {
                String::new()
            },
            error: training.result.as_ref().err().map_or(String::new(), ToString::to_string),
        }
    });
    let planned: usize = campaign.evaluations.iter().map(|evaluation| evaluation.episodes as usize).sum();
    let all_trained = finished.trainings.len() == campaign.trainings.len();
    Manifest {
        version: env!("CARGO_PKG_VERSION").into(),
        campaign: campaign.name.clone(),
        seed: options.seed,
        settings: campaign.settings.clone(),
        smoke: options.smoke,
        complete: all_trained
            && finished.rows.len() == planned
            && finished.searches.len() == campaign.searches.len()
            && finished.searches.iter().all(|search| search.error.is_none() && !search.spent.stopped)
            && finished.rows.iter().all(|row| row.outcome.reward.is_finite())
            && every_driver_drove(finished),
        stopped: finished.interrupted,
        threads: rayon::current_num_threads(),
        evaluation_ticks: finished.rows.iter().map(|row| u64::from(row.outcome.ticks)).sum(),
        search_ticks: finished.searches.iter().map(|search| search.spent.ticks).sum(),
        errors: errors(finished),
        wall_time_s,
        files: files.to_vec(),
        vector_instructions: vector_instructions().into(),
        trainings: trainings.collect(),
    }
}

/// How many episodes a driver failed in.
fn errors(finished: &Finished) -> usize {
    finished.rows.iter().filter(|row| row.outcome.fault().is_some()).count()
}

/// Whether every driver drove at least one episode in every town to its end.
fn every_driver_drove(finished: &Finished) -> bool {
    let mut driven: BTreeMap<(&str, &str), bool> = BTreeMap::new();
    for row in &finished.rows {
        *driven.entry((&row.town, &row.policy)).or_default() |= row.outcome.fault().is_none();
    }
    driven.values().all(|drove| *drove)
}

/// The vector instructions that the networks' products may use, on which the last bits of a training depend.
fn vector_instructions() -> &'static str {
    #[cfg(target_arch = "x86_64")]
    {
        if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
            return "avx2, fma";
        }
        if is_x86_feature_detected!("avx") {
            return "avx";
        }
    }
    std::env::consts::ARCH
}

/// Prints the cells, narrow enough for a terminal.
fn print_cells(campaign: &Campaign, finished: &Finished) -> Result<(), WriteError> {
    let failed = |source| WriteError::Table { name: "cells".into(), source };
    let cells =
        report::metrics(&report::episodes(&finished.rows)).and_then(|metrics| metrics.cells()).map_err(failed)?;
    front::say(report::table(&campaign.name, &cells).trim_end());
    if !finished.searches.is_empty() {
        front::say(report::search_table(&report::search_cells(&finished.searches)).trim_end());
    }
    Ok(())
}

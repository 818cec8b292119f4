use std::collections::BTreeMap;
use std::time::Instant;

use super::args::RunOptions;
use super::progress::Progress;
use super::{ExitCode, front, interrupt};
use crate::analysis::failure_modes;
use crate::campaign::{self, EpisodeRow, Finished};
use crate::compile::{Campaign, Pedestrian};
use crate::diagnostic::Sources;
use crate::report::{self, FileRecord, Manifest, ReportFolder, TrainingRecord, WriteError};
use crate::seed::Seed;

/// `falsify run`
pub fn run(options: &RunOptions) -> ExitCode {
    let (mut plan, sources) = match front::compile_files(&options.files) {
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
    let pool = match rayon::ThreadPoolBuilder::new().num_threads(options.threads).build() {
        Ok(pool) => pool,
        Err(error) => {
            front::fail(&format!("cannot start {} threads: {error}", options.threads));
            return ExitCode::Usage;
        }
    };
    interrupt::listen();
    let mut worst = ExitCode::Done;
    for campaign in &plan.campaigns {
        match pool.install(|| carry_out(campaign, options, &sources)) {
            Ok(ExitCode::Done) => {}
            Ok(code) => worst = code,
            Err(error) => {
                front::fail(&error.to_string());
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
    anstream::println!("campaign {}", campaign.name);
    for training in &campaign.trainings {
        let key = &training.key;
        let decisions = training.config.total_steps;
        anstream::println!(
            "  train  {} in {} against {}, run {}: {decisions} decisions",
            key.reward,
            key.town,
            key.policy,
            key.run
        );
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
        anstream::println!("  try    {who} in {} against {}: {episodes} episodes", evaluation.town, evaluation.policy);
    }
}

fn carry_out(campaign: &Campaign, options: &RunOptions, sources: &Sources) -> Result<ExitCode, WriteError> {
    let folder = ReportFolder::begin(&options.out, &campaign.name)?;
    let began = Instant::now();
    let progress = Progress::new(campaign);
    let finished = campaign::run(campaign, &Seed::root(options.seed), &progress);
    let times: Vec<f64> = progress.finish().iter().map(std::time::Duration::as_secs_f64).collect();
    let wall_time_s = began.elapsed().as_secs_f64();
    let failed = finished.trainings.iter().any(|training| training.result.is_err());
    let manifest = manifest(campaign, options, sources, &finished, &times, wall_time_s);
    if finished.interrupted && finished.rows.is_empty() {
        front::fail("stopped before any episode was tried; nothing was written");
        return Ok(ExitCode::Interrupted);
    }
    write(&folder, campaign, &finished, &manifest)?;
    let place = folder.finish()?;
    print_cells(campaign, &finished)?;
    anstream::println!("{}", place.join("summary.md").display());
    Ok(if failed && !finished.interrupted { ExitCode::RunFailed } else { ExitCode::Done })
}

fn manifest(
    campaign: &Campaign,
    options: &RunOptions,
    sources: &Sources,
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
            pedestrian: if training.result.is_ok() { pedestrian_file(key) } else { String::new() },
            error: training.result.as_ref().err().map_or(String::new(), ToString::to_string),
        }
    });
    let planned: usize = campaign.evaluations.iter().map(|evaluation| evaluation.episodes as usize).sum();
    let all_trained = finished.trainings.len() == campaign.trainings.len();
    Manifest {
        version: env!("CARGO_PKG_VERSION").into(),
        campaign: campaign.name.clone(),
        seed: options.seed,
        smoke: options.smoke,
        complete: all_trained && finished.rows.len() == planned,
        threads: rayon::current_num_threads(),
        evaluation_ticks: finished.rows.iter().map(|row| u64::from(row.outcome.ticks)).sum(),
        wall_time_s,
        files: sources
            .iter()
            .map(|(_, source)| FileRecord::new(source.path.display().to_string(), &source.text))
            .collect(),
        trainings: trainings.collect(),
    }
}

fn pedestrian_file(key: &crate::compile::TrainingKey) -> String {
    format!("pedestrians/{}-{}-{}-{}.safetensors", key.reward, key.town, key.policy, key.run)
}

fn write(
    folder: &ReportFolder,
    campaign: &Campaign,
    finished: &Finished,
    manifest: &Manifest,
) -> Result<(), WriteError> {
    let failed = |name: &str| {
        let name = name.to_string();
        move |source| WriteError::Table { name, source }
    };
    let episodes = report::episodes(&finished.rows);
    let metrics = report::metrics(&episodes).map_err(failed("cells"))?;
    folder.table("episodes", &episodes)?;
    folder.table("runs", &metrics.runs)?;
    folder.table("cells", &metrics.cells)?;
    folder.table("failure_modes", &report::failure_modes(&failure_modes(&finished.rows)))?;
    folder.table("learning_curve", &report::learning_curve(&finished.trainings))?;
    for (name, svg) in report::learning_figures(&finished.trainings) {
        folder.file(&format!("{name}.svg"), svg.as_bytes())?;
    }
    for town in &campaign.towns {
        let here = |row: &&EpisodeRow| row.town == town.name && row.pedestrian == "trained";
        let rows: Vec<&EpisodeRow> = finished.rows.iter().filter(here).collect();
        folder.file(&format!("town-{}.svg", town.name), report::town_map(&town.town, &rows).as_bytes())?;
    }
    for training in &finished.trainings {
        let Ok(trained) = &training.result else { continue };
        let key = &training.key;
        let metadata: BTreeMap<String, String> = [
            ("falsify", manifest.version.clone()),
            ("campaign", campaign.name.clone()),
            ("town", key.town.clone()),
            ("policy", key.policy.clone()),
            ("reward", key.reward.clone()),
            ("run", key.run.to_string()),
            ("seed", manifest.seed.to_string()),
        ]
        .map(|(name, value)| (name.to_string(), value))
        .into();
        folder.file(&pedestrian_file(key), &trained.actor_critic.to_safetensors(&metadata))?;
    }
    let cells = metrics.cells().map_err(failed("cells"))?;
    folder.file("summary.md", report::summary(&campaign.name, &campaign.docs, &cells, manifest).as_bytes())?;
    folder.file("manifest.toml", manifest.to_toml().as_bytes())
}

/// Prints the cells, narrow enough for a terminal.
fn print_cells(campaign: &Campaign, finished: &Finished) -> Result<(), WriteError> {
    let failed = |source| WriteError::Table { name: "cells".into(), source };
    let cells =
        report::metrics(&report::episodes(&finished.rows)).and_then(|metrics| metrics.cells()).map_err(failed)?;
    anstream::print!("{}", report::table(&campaign.name, &cells));
    Ok(())
}

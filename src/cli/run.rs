use std::path::Path;
use std::time::{Duration, Instant};

use super::args::{Output, RunOptions, TableFormat};
use super::gate::Gates;
use super::progress::{Event, Progress};
use super::repeat_args::TickChoice;
use super::{ExitCode, front, interrupt, list, shard};
use crate::campaign::{self, Cell, Finished};
use crate::compile::Campaign;
use crate::report::{
    self, Episodes, FailureModes, FileRecord, Formats, Gathered, Manifest, Metrics, ReportFolder, TrainingRecord,
    Wanted, WriteError,
};
use crate::seed::Seed;
use crate::store::{CODE, Ids, Index, Kept, Limits, Note, Store, StoreError, vector_instructions};

/// `falsify run`
pub fn run(options: &RunOptions) -> ExitCode {
    let code = run_or_report(options, Work::All);
    if options.format == Output::Json {
        Event::RunEnded { exit_code: code as u8 }.tell();
    }
    code
}

/// Writes the reports of what is there already.
pub fn report(options: &RunOptions) -> ExitCode {
    run_or_report(options, Work::None)
}

/// How much is to be done.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Work {
    All,
    None,
}

/// Starts threads that work, 0 for one a core.
///
/// # Errors
/// The exit code, after the reason has been printed.
pub fn pool(threads: u16) -> Result<rayon::ThreadPool, ExitCode> {
    rayon::ThreadPoolBuilder::new().num_threads(threads.into()).build().map_err(|error| {
        front::fail(&format!("cannot start {threads} threads: {error}"));
        ExitCode::Usage
    })
}

fn run_or_report(options: &RunOptions, work: Work) -> ExitCode {
    let gates = match Gates::new(&options.gate) {
        Ok(gates) => gates,
        Err(code) => return code,
    };
    let (mut plan, files) = match front::compile_files(&options.files, &options.given) {
        Ok(compiled) => compiled,
        Err(code) => return code,
    };
    if plan.campaigns.is_empty() {
        front::fail(&plan.without_campaigns());
        return ExitCode::Nothing;
    }
    if options.smoke {
        plan.campaigns.iter_mut().for_each(campaign::smoke);
    }
    let note: Note = Box::new(front::warn);
    if options.list {
        let store = match Store::look(&options.out, options.cache.as_deref(), note) {
            Ok(store) => store,
            Err(error) => return no_store(&error),
        };
        for campaign in &plan.campaigns {
            list::list(campaign, &name(campaign, options), &store, options.seed, options.fresh);
        }
        return ExitCode::Done;
    }
    let shard = match options.shard.map(|named| named.resolve(|name| std::env::var(name).ok())).transpose() {
        Ok(shard) => shard,
        Err(message) => {
            front::fail(&message);
            return ExitCode::Usage;
        }
    };
    let pool = match pool(options.threads) {
        Ok(pool) => pool,
        Err(code) => return code,
    };
    let store = match Store::open(&options.out, options.cache.as_deref(), note) {
        Ok(store) => store,
        Err(error) => return no_store(&error),
    };
    if work == Work::All {
        interrupt::listen();
    }
    let mut worst = ExitCode::Done;
    for campaign in &plan.campaigns {
        let carry_out = || match shard {
            Some(shard) => shard::carry_out(campaign, options, shard, &store),
            None => carry_out(campaign, options, &files, &store, &gates, work),
        };
        match pool.install(carry_out) {
            Ok(ExitCode::Done) => {}
            Ok(code) => worst = code,
            Err(message) => {
                front::fail(&message);
                return ExitCode::WriteFailed;
            }
        }
        if interrupt::asked() {
            worst = ExitCode::Interrupted;
            break;
        }
    }
    if let Err(message) = gates.write() {
        front::fail(&message);
        return ExitCode::WriteFailed;
    }
    worst
}

/// The name of a campaign's report. A trial of the machinery never replaces results.
pub fn name(campaign: &Campaign, options: &RunOptions) -> String {
    if options.smoke { format!("{}-smoke", campaign.name) } else { campaign.name.clone() }
}

/// Runs a campaign and writes its report; the error is the message to print.
fn carry_out(
    campaign: &Campaign,
    options: &RunOptions,
    files: &[FileRecord],
    store: &Store,
    gates: &Gates<'_>,
    work: Work,
) -> Result<ExitCode, String> {
    let (name, seed) = (name(campaign, options), options.seed);
    let failed = |error: StoreError| kept(&error.to_string(), &options.out);
    let folder = ReportFolder::begin(&options.out, &name, &store.drafts().map_err(failed)?);
    let folder = folder.map_err(|error| error.to_string())?.in_formats(formats(options));
    let began = Instant::now();
    let mut index = Index::read(store, &name);
    if work == Work::All {
        index.command = front::command_line();
    }
    if options.fresh {
        store.forget(&Ids::new(campaign, seed), campaign).map_err(failed)?;
    }
    index.write(store, &name, campaign, seed).map_err(failed)?;
    let keeper = Kept::new(store, campaign, seed, limits(options));
    let finished = match work {
        Work::All => {
            let wanted: Vec<Cell> = campaign::cells(campaign).collect();
            let progress = Progress::new(campaign, &wanted, options);
            let finished = campaign::run(campaign, &Seed::root(seed), &keeper, &progress);
            progress.finish(wanted.len());
            finished
        }
        Work::None => campaign::collect(campaign, &keeper),
    };
    if let Some(error) = keeper.failure() {
        return Err(kept(&error, &options.out));
    }
    index.write(store, &name, campaign, seed).map_err(failed)?;
    let written = |error: WriteError| kept(&error.to_string(), &options.out);
    let mut modes = FailureModes::new(campaign, &finished.trainings, &Seed::root(seed));
    let gathered =
        report::gather(&folder, &Episodes::new(campaign, &keeper), &mut modes, &Seed::root(seed)).map_err(written)?;
    if gathered.episodes == 0
        && finished.searches.is_empty()
        && finished.trainings.iter().all(|training| training.result.is_err())
    {
        front::fail("nothing was finished, so there is no report");
        return Ok(if finished.interrupted { ExitCode::Interrupted } else { ExitCode::RunFailed });
    }
    say_errors(&gathered, &name, options.format);
    let times = (keeper.training_seconds(), began.elapsed().as_secs_f64());
    let manifest = manifest(campaign, options, files, &finished, &gathered, times);
    report::write(&folder, campaign, &finished, &gathered, modes, &manifest).map_err(written)?;
    if options.ticks != TickChoice::None {
        let all = options.ticks == TickChoice::All;
        let wanted = Wanted::of(&Episodes::new(campaign, &keeper), &finished, all).map_err(written)?;
        report::write_ticks(&folder, &Seed::root(seed), &wanted).map_err(written)?;
    }
    interrupt::hold(true);
    let place = {
        let _door = store.door();
        folder.finish(manifest.complete).map_err(written)
    };
    interrupt::hold(false);
    let place = place?;
    let metrics = cells(campaign, &finished, &gathered, options.format).map_err(|error| error.to_string())?;
    match options.format {
        Output::Human => front::say(&place.join("report.html").display().to_string()),
        Output::Json => Event::ReportWritten { campaign: &name, folder: &place, complete: manifest.complete }.tell(),
    }
    let passed = gates.judge(&manifest, &metrics);
    let failed = finished.trainings.iter().any(|training| training.result.is_err())
        || finished.searches.iter().any(|search| search.error.is_some());
    let whole = manifest.complete || finished.interrupted;
    Ok(match (failed || !whole || manifest.errors > 0, passed) {
        (true, _) => ExitCode::RunFailed,
        (false, false) => ExitCode::GateFailed,
        (false, true) => ExitCode::Done,
    })
}

/// What tables are written as.
fn formats(options: &RunOptions) -> Formats {
    let named = |format| options.formats.contains(&format);
    Formats { csv: named(TableFormat::Csv), parquet: named(TableFormat::Parquet) }
}

/// What a cell may take.
pub fn limits(options: &RunOptions) -> Limits {
    Limits {
        checkpoint: Duration::from_secs_f64(options.checkpoint),
        seconds: options.cell_time,
        ticks: options.max_ticks,
    }
}

/// Says why there is no store.
pub fn no_store(error: &StoreError) -> ExitCode {
    front::fail(&error.to_string());
    if error.is_misuse() { ExitCode::Usage } else { ExitCode::WriteFailed }
}

/// What is to be said when something cannot be written.
pub fn kept(error: &str, out: &Path) -> String {
    let again = "what was finished before is kept; run the same command again to go on";
    format!("{error}\n  {again} (`{}`)", out.display())
}

/// Says what went wrong in episodes: how often, and the first time how.
fn say_errors(gathered: &Gathered, campaign: &str, format: Output) {
    let say = |message: &str| {
        front::fail(message);
        if format == Output::Json {
            Event::Warning { campaign, message }.tell();
        }
    };
    if let Some(first) = &gathered.first_unpaid {
        say(&format!("a reward was no number in {} episodes; the first: {first}", gathered.unpaid));
    }
    if let Some(first) = &gathered.first_error {
        let Gathered { errors, untried, episodes, .. } = gathered;
        let untried = if *untried > 0 { format!(", {untried} of them not tried") } else { String::new() };
        say(&format!(
            "{errors} of {episodes} episodes are in error{untried} and count for nothing; the first is {first}"
        ));
    }
}

fn manifest(
    campaign: &Campaign,
    options: &RunOptions,
    files: &[FileRecord],
    finished: &Finished,
    gathered: &Gathered,
    (training_seconds, wall_time_s): (Vec<f64>, f64),
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
            wall_time_s: training_seconds[place],
            pedestrian: if training.result.is_ok() {
                report::pedestrian_file(key, "safetensors")
            } else {
                String::new()
            },
            error: training.result.as_ref().err().map_or(String::new(), ToString::to_string),
        }
    });
    let trained = finished.trainings.iter().filter(|training| training.result.is_ok()).count();
    Manifest {
        version: env!("CARGO_PKG_VERSION").into(),
        code: CODE.into(),
        campaign: campaign.name.clone(),
        seed: options.seed,
        call: front::call(&options.files, &options.given),
        settings: campaign.settings.clone(),
        smoke: options.smoke,
        complete: trained == campaign.trainings.len()
            && gathered.all_tried
            && gathered.untried == 0
            && gathered.unpaid == 0
            && gathered.every_driver_drove
            && finished.searches.len() == campaign.searches.len()
            && finished.searches.iter().all(|search| search.error.is_none() && !search.spent.stopped),
        stopped: finished.interrupted,
        threads: rayon::current_num_threads(),
        evaluation_ticks: gathered.ticks,
        search_ticks: finished.searches.iter().map(|search| search.spent.ticks).sum(),
        errors: gathered.errors,
        wall_time_s,
        files: files.to_vec(),
        vector_instructions: vector_instructions().into(),
        trainings: trainings.collect(),
    }
}

/// Works the cells out, and prints them for people, narrow enough for a terminal.
fn cells(campaign: &Campaign, finished: &Finished, gathered: &Gathered, format: Output) -> Result<Metrics, WriteError> {
    let failed = |source| WriteError::Table { name: "cells".into(), source };
    let metrics = Metrics::of_runs(gathered.runs.clone()).map_err(failed)?;
    if format == Output::Human {
        let cells = metrics.cells().map_err(failed)?;
        front::say(report::results_for_terminal(&campaign.name, &cells).trim_end());
        if !finished.searches.is_empty() {
            front::say(report::searches_for_terminal(&report::search_cells(&finished.searches)).trim_end());
        }
    }
    Ok(metrics)
}

//! `falsify run --list`

use std::collections::BTreeMap;

use crate::cli::console;
use crate::session::{Error, RunOptions, Session};
use compile::Campaign;
use results::campaign::{Task, tasks};
use results::jobs::work;
use results::report::StoredReport;
use results::store::{Ids, Index, Known, Store};

/// Prints what a run would do and why, and what is stored already. It changes nothing.
///
/// # Errors
/// Files that cannot be read or have errors, and a cache folder with other contents.
pub fn list(session: &Session, options: &RunOptions) -> Result<(), Error> {
    let planned = session.campaigns(options)?;
    let store = Store::look(&options.out, options.cache.as_deref(), session.note())?;
    planned.plan.campaigns.iter().try_for_each(|campaign| list_campaign(campaign, options, &store))
}

fn list_campaign(campaign: &Campaign, options: &RunOptions, store: &Store) -> Result<(), Error> {
    let name = options.report_name(campaign);
    let ids = Ids::new(campaign, options.seed);
    let index = Index::read(store, &name)?;
    let known = |task| match options.fresh {
        true => Known::Missing("--fresh".into()),
        false => index.look(store, campaign, task, &ids, options.seed),
    };
    let tasks: BTreeMap<Task, Known> = tasks(campaign).map(|task| (task, known(task))).collect();
    console::say(&format!("campaign {name}"));
    for (place, job) in campaign.jobs.iter().enumerate() {
        let (job, kind) = (work(job), work(job).kind());
        let parts: Vec<Task> = (0..job.parts()).map(|part| Task { job: place, part }).collect();
        let units: u64 = parts.iter().map(|task| task.units(campaign)).sum();
        let known: Vec<&Known> = parts.iter().map(|task| &tasks[task]).collect();
        let (verb, title, unit) = (kind.verb, job.title(), kind.unit);
        console::say(&format!("  {verb:<8} {title}: {units} {unit} [{}]", together(&known, unit)));
    }
    let all = tasks.len();
    let there = tasks.values().filter(|known| **known == Known::Finished).count();
    console::say(&format!("  {} of {all} tasks to run, {there} to reuse", all - there));
    let edited = tasks.values().any(|known| matches!(known, Known::Edited(_)));
    let report = options.out.join(&name);
    if edited && StoredReport::open(&report).is_ok() {
        console::say(&format!(
            "  `falsify recheck --allow-external {}` lets the new program meet the same starts",
            report.display()
        ));
    }
    Ok(())
}

fn told(known: &Known, unit: &str) -> String {
    match known {
        Known::Finished => "reuse".into(),
        Known::Begun(done, all) => format!("run: unfinished, {done} of {all} {unit}"),
        Known::Missing(why) => format!("run: {why}"),
        Known::Edited(files) => format!("run: {files} changed"),
    }
}

/// The parts of a job in one line: the first part that is not stored represents the others.
fn together(parts: &[&Known], unit: &str) -> String {
    let there = parts.iter().filter(|known| ***known == Known::Finished).count();
    match parts.iter().find(|known| ***known != Known::Finished) {
        None => told(&Known::Finished, unit),
        Some(first) if parts.len() == 1 => told(first, unit),
        Some(first) => format!("{}; {there} of {} parts are there", told(first, unit), parts.len()),
    }
}

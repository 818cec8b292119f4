use crate::cli::console;
use crate::session::Listing;
use results::campaign::Task;
use results::jobs::work;
use results::store::Known;

/// Prints what a run would do for a campaign and why, and what is stored already.
pub fn list(listing: &Listing) {
    let Listing { name, campaign, tasks, report } = listing;
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
    if let Some(report) = report.as_ref().filter(|_| edited) {
        console::say(&format!(
            "  `falsify recheck --allow-external {}` lets the new program meet the same starts",
            report.display()
        ));
    }
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

use crate::cli::console;
use crate::session::Listing;
use results::campaign::Task;
use results::record::RunKey;
use results::store::Known;

/// Prints what a run would do for a campaign and why, and what is stored already.
pub fn list(listing: &Listing) {
    let Listing { name, campaign, tasks, report } = listing;
    let known = |task| tasks[&task].clone();
    console::say(&format!("campaign {name}"));
    for (number, training) in campaign.trainings.iter().enumerate() {
        let decisions = results::campaign::units(campaign, Task::Training(number));
        let state = told(&known(Task::Training(number)), "updates");
        console::say(&format!("  train    {}: {decisions} decisions [{state}]", training.key));
    }
    for (number, evaluation) in campaign.evaluations.iter().enumerate() {
        let chunks = (0..evaluation.chunks()).map(|chunk| known(Task::Chunk { evaluation: number, chunk }));
        console::say(&format!(
            "  evaluate {}: {} episodes [{}]",
            RunKey::of(evaluation),
            evaluation.episodes,
            together(&chunks.collect::<Vec<_>>())
        ));
    }
    for (number, search) in campaign.searches.iter().enumerate() {
        let state = told(&known(Task::Search(number)), "episodes");
        console::say(&format!("  search   {}: {} ticks [{state}]", search.key, search.budget));
    }
    for (number, estimation) in campaign.estimations.iter().enumerate() {
        let state = told(&known(Task::Estimate(number)), "ticks");
        console::say(&format!("  estimate {}: at most {} ticks [{state}]", estimation.key, estimation.budget));
    }
    for (number, cover) in campaign.covers.iter().enumerate() {
        let state = told(&known(Task::Cover(number)), "episodes");
        console::say(&format!("  cover    {}: at most {} episodes [{state}]", cover.key, cover.budget));
    }
    for (number, harden) in campaign.hardenings.iter().enumerate() {
        let state = told(&known(Task::Harden(number)), "ticks");
        let rounds = harden.hardening.rounds;
        console::say(&format!(
            "  harden   {}: {rounds} rounds, {} ticks of searches [{state}]",
            harden.key,
            harden.budget()
        ));
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

/// The chunks of an evaluation in one line: the first chunk that is not stored represents the others.
fn together(chunks: &[Known]) -> String {
    let there = chunks.iter().filter(|known| **known == Known::Finished).count();
    match chunks.iter().find(|known| **known != Known::Finished) {
        None => told(&Known::Finished, ""),
        Some(first) if chunks.len() == 1 => told(first, "episodes"),
        Some(first) => format!("{}; {there} of {} parts are there", told(first, "episodes"), chunks.len()),
    }
}

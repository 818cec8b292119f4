//! The end of a run on a terminal: the rates, the drivers, the worst failure, and the commands to look at it.

use std::path::Path;

use crate::cli::console;
use crate::session::{CampaignReport, OverviewFiles};
use results::failure::Failure;
use results::record::EPISODES;
use results::report;

/// Prints what was found about each driver for people, and all tables if `details` are wanted; narrow enough for a terminal of 80 columns where names
/// are short.
pub fn show(report: &CampaignReport, details: bool) {
    let CampaignReport { folder, manifest, since, drivers, sections, .. } = report;
    console::say(&format!("campaign {}", manifest.campaign));
    let answer = manifest.answer.iter().chain(since);
    answer.for_each(|sentence| console::say(console::broken(sentence, console::width()).trim_end()));
    // The first section is the most important one, and the last lines are those that a reader sees.
    let texts = sections.iter().rev().map(|section| section.to_terminal(console::width(), details));
    let texts: Vec<String> = texts.filter(|text| !text.is_empty()).collect();
    texts.iter().for_each(|text| console::say(&console::broken(text, console::width())));
    if manifest.smoke {
        console::say(report::SMOKE);
    }
    if !manifest.complete {
        console::say("partial: the same command goes on");
    }
    match report::worst_failure(drivers) {
        Some(worst) => console::say(&look_at(worst, folder, manifest.call.replay_options())),
        None if drivers.iter().all(|driver| driver.episodes == 0) => {
            let learnt = learnt_drivers(folder);
            if !learnt.is_empty() {
                console::say(&format!(
                    "drivers that learnt, for `driver NAME = onnx(model: …)`:\n{}",
                    learnt.join("\n")
                ));
            } else if texts.is_empty() {
                console::say("nothing was evaluated");
            }
        }
        None => console::say("no collision was found"),
    }
    console::say(&folder.join("report.html").display().to_string());
}

/// The networks of the drivers that a report trained, in the order of their names.
fn learnt_drivers(folder: &Path) -> Vec<String> {
    let files = std::fs::read_dir(folder.join("drivers")).into_iter().flatten().flatten();
    let mut names: Vec<String> = files.map(|file| format!("  {}", file.path().display())).collect();
    names.sort();
    names
}

/// Prints the overview of several reports.
pub fn show_overview(overview: &OverviewFiles) {
    console::say(&format!("\n{}\n\n{}", overview.text.trim_end(), overview.page.display()));
}

/// A failure in a line, and the commands that show it.
fn look_at(worst: &Failure, folder: &Path, options: &str) -> String {
    let cell = &worst.key.cell;
    let (what, name) = (worst.in_words(), worst.name());
    let worst = format!("worst: {} in {}, {what}, by {}", cell.policy, cell.place(), worst.finder());
    if !folder.join(format!("{EPISODES}.parquet")).is_file() {
        return format!("{worst}\n  the tables are CSV only; --formats csv,parquet writes what `falsify replay` reads");
    }
    let folder = quoted(&folder.display().to_string());
    format!(
        "{worst}\n  falsify replay {options}{name} --report {folder}\n  falsify export {options}{name} --as animation --report {folder}"
    )
}

/// A word as a user would type it into a shell.
pub fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || "-_./=:,@%+".contains(c);
    if !word.is_empty() && word.chars().all(plain) { word.into() } else { format!("'{}'", word.replace('\'', "'\\''")) }
}

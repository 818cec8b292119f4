//! A line for each job that has ended.

use indicatif::HumanCount;

use super::board::Board;
use super::job::Job;

/// The line of a job that has ended, with what came of it.
pub fn line(board: &Board, job: &Job, note: &str) -> String {
    let total = board.jobs.len();
    let place = format!("[{:width$}/{total}]", board.ended(), width = total.to_string().len());
    let note = if note.is_empty() { String::new() } else { format!(": {note}") };
    let verb = if job.error().is_some() { job.kind.doing() } else { job.kind.done() };
    format!("{place} {verb} {}{note} ({})", job.name, pace(job))
}

/// How long a job took, and how fast it was.
fn pace(job: &Job) -> String {
    let time = format!("{:.1} s", job.time().as_secs_f64());
    match job.rate() {
        Some(rate) => format!("{time}, {} {}/s", HumanCount(rate.round() as u64), job.kind.unit()),
        None => time,
    }
}

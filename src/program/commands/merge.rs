use std::collections::BTreeSet;
use std::sync::Arc;

use clap::Args;

use super::run::{RunArgs, RunReporter, ended, finished};
use crate::cli::failure::{failed, misused};
use crate::cli::input::session;
use crate::cli::{console, interrupt};
use crate::exit_code::{Ended, ExitCode};
use crate::session::{self, Event, Incomplete, Notice, Observer};
use results::jobs::work;
use results::store::Taken;

/// The most tasks that are named one by one.
const SHOWN: usize = 10;

/// Shown after the help.
pub const EXAMPLES: &str = "\
Examples:
  falsify run --shard 0/2 --out a my.scn     on one machine
  falsify run --shard 1/2 --out b my.scn     on another one
  falsify merge my.scn --from a b --out reports --shards 2
                                             the report that one machine would have written, byte for byte
  falsify merge my.scn --out shared          when all shards wrote to one folder

Exit codes: 0 done   9 tasks are missing, which are named, with the shards that make them   others as of `run`";

/// Options of `falsify run` on how to work, which a merge does not have.
const IDLE: [&str; 7] = ["list", "fresh", "shard", "tasks", "checkpoint", "task_time", "max_ticks"];

/// Options of `falsify merge`. The help omits options without effect there.
#[derive(Debug, Args)]
#[command(mut_args(|arg| if IDLE.contains(&arg.get_id().as_str()) { arg.hide(true) } else { arg }))]
pub struct MergeArgs {
    /// The options of the run.
    #[command(flatten)]
    pub run: RunArgs,
    /// Where the tasks are.
    #[command(flatten)]
    pub merge: session::MergeOptions,
    /// The number of shards, to list those that must be run again.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub shards: Option<u32>,
}

/// `falsify merge`
pub fn merge(options: &MergeArgs) -> Ended {
    ended(options.run.format, put_together(options))
}

fn put_together(options: &MergeArgs) -> Ended {
    let run = &options.run;
    if run.shard.is_some() || run.list || run.run.fresh {
        return Err(misused("a merge runs nothing; --shard, --list and --fresh are options of `falsify run`"));
    }
    let wanted = session::MergeOptions { run: run.wanted()?, ..options.merge.clone() };
    let reporter = MergeReporter { inner: run.reporter(), shards: options.shards };
    let session = session(run.given.allow_external).with_observer(Arc::new(reporter));
    match session.merge(&wanted).map_err(failed)? {
        Some(report) => finished(run, &report),
        None if interrupt::stop().is_asked() => Ok(ExitCode::Interrupted),
        None => Ok(ExitCode::Incomplete),
    }
}

/// Reports as a run does, and the shards that contain the missing tasks.
struct MergeReporter {
    inner: RunReporter,
    shards: Option<u32>,
}

impl Observer for MergeReporter {
    fn event(&self, event: &Event<'_>) {
        match event {
            Event::Notice(Notice::Incomplete(incomplete)) => console::fail(&lack(incomplete, self.shards)),
            other => self.inner.event(other),
        }
    }
}

/// The missing tasks, and the shards that contain them.
fn lack(incomplete: &Incomplete, shards: Option<u32>) -> String {
    let Incomplete { campaign, tasks, all } = incomplete;
    let mut text =
        format!("{} of the {all} tasks of `{}` are not there as they should be:", tasks.len(), campaign.name);
    for missing in tasks.iter().take(SHOWN) {
        let why = match &missing.found {
            Taken::Part(done) => {
                format!("unfinished, {done} {}", work(&incomplete.campaign.jobs[missing.task.job]).kind().unit)
            }
            Taken::Damaged(path) => format!("`{}` is damaged", path.display()),
            Taken::Differ(one, other) => {
                format!("`{}` and `{}` differ, so one is not what it says; remove it", one.display(), other.display())
            }
            _ => "missing".into(),
        };
        text.push_str(&format!("\n  {}: {why}", missing.name));
    }
    if tasks.len() > SHOWN {
        text.push_str(&format!("\n  … and {} more", tasks.len() - SHOWN));
    }
    match shards {
        Some(count) => {
            let shards = ranges(&incomplete.shards(count));
            text.push_str(&format!("\n  do again, of {count} shards: {shards}"));
        }
        None => text
            .push_str("\n  `falsify run` with the same files does only these; give --shards to see which shards would"),
    }
    text
}

/// Numbers in the form that job arrays take: `2,7-9`.
fn ranges(numbers: &BTreeSet<u32>) -> String {
    let mut ranges: Vec<(u32, u32)> = Vec::new();
    for number in numbers {
        match ranges.last_mut() {
            Some((_, last)) if *last + 1 == *number => *last = *number,
            _ => ranges.push((*number, *number)),
        }
    }
    let told = |(first, last): (u32, u32)| if first == last { first.to_string() } else { format!("{first}-{last}") };
    ranges.into_iter().map(told).collect::<Vec<_>>().join(",")
}

#[cfg(test)]
mod tests {
    use super::ranges;

    #[test]
    fn neighbours_are_joined() {
        assert_eq!(ranges(&[2, 7, 8, 9, 11, 12].into()), "2,7-9,11-12");
        assert_eq!(ranges(&[0].into()), "0");
    }
}

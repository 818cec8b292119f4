use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::sync::Arc;

use clap::{Args, value_parser};

use super::run::{RunArgs, ended, finished};
use crate::cli::failure::{failed, misused};
use crate::cli::input::session;
use crate::cli::{console, interrupt};
use crate::exit_code::{Ended, ExitCode};
use crate::session::{Error, Event, Notice, RunOptions, RunReport, Session, Work, pool};
use compile::Campaign;
use results::campaign::{Task, deal, tasks};
use results::jobs::work;
use results::parallel;
use results::store::{Ids, Store, Taken, task_name};

/// Maximum number of tasks that are named one by one.
const MAX_SHOWN: usize = 10;

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
    /// Folders with the tasks of shards (their --out or their --cache), in addition to those that are in the folder for the reports
    /// already.
    #[arg(long, num_args = 1.., value_name = "DIR")]
    pub from: Vec<PathBuf>,
    /// Write the finished part as NAME-partial when something is missing.
    #[arg(long, display_order = 100)]
    pub partial: bool,
    /// The number of shards, to list those that must be run again.
    #[arg(long, value_name = "N", value_parser = value_parser!(u32).range(1..))]
    pub shards: Option<u32>,
}

pub fn merge(options: &MergeArgs) -> Ended {
    ended(options.run.format, put_together(options))
}

fn put_together(options: &MergeArgs) -> Ended {
    let run = &options.run;
    if run.shard.is_some() || run.list || run.run.fresh {
        return Err(misused("a merge runs nothing; --shard, --list and --fresh are options of `falsify run`"));
    }
    let session = session(run.given.allow_external).with_observer(Arc::new(run.reporter()));
    match merged(&session, &run.wanted()?, options).map_err(failed)? {
        Some(report) => finished(run, &report),
        None if interrupt::stop().is_asked() => Ok(ExitCode::Interrupted),
        None => Ok(ExitCode::Incomplete),
    }
}

/// Imports the tasks of shards, and writes the reports when all are there. `None` if tasks are missing, which are named, or the session was
/// stopped.
fn merged(session: &Session, run: &RunOptions, options: &MergeArgs) -> Result<Option<RunReport>, Error> {
    let planned = session.campaigns(run)?;
    if let Some(missing) = options.from.iter().find(|folder| !folder.is_dir()) {
        return Err(Error::Usage(format!("there is no folder `{}`", missing.display())));
    }
    // A damaged task is reported together with a remedy.
    let store = Store::open(&run.out, run.cache.as_deref(), Box::new(|_| {}))?;
    let others = options.from.iter().map(|folder| Store::within(folder, Box::new(|_| {})));
    let others = others.collect::<Result<Vec<Store>, _>>()?;
    for (folder, _) in options.from.iter().zip(&others).filter(|(_, store)| !store.is_there()) {
        session.notice(&Notice::Warning(format!(
            "there are no tasks in `{}`; where a shard was given --cache, name that folder",
            folder.display()
        )));
    }
    let pool = pool(run.threads)?;
    session.tell(Event::Begun);
    let mut whole = true;
    for campaign in &planned.plan.campaigns {
        let missing = pool.install(|| imported(session, campaign, run, &store, &others))?;
        if session.stop.is_asked() {
            return Ok(None);
        }
        if !missing.is_empty() {
            whole = false;
            console::fail(&lack(campaign, &missing, options.shards));
        }
    }
    drop((store, pool));
    if whole || options.partial { session.run_plan(run, &planned, Work::None).map(Some) } else { Ok(None) }
}

/// Imports all tasks of a campaign; returns those that are missing, with what the stores have of them.
fn imported(
    session: &Session,
    campaign: &Campaign,
    run: &RunOptions,
    store: &Store,
    others: &[Store],
) -> Result<Vec<(Task, Taken)>, Error> {
    let ids = Ids::new(campaign, run.seed);
    let take = |task: Task| {
        if session.stop.is_asked() {
            return Ok((task, Taken::Missing));
        }
        let has_episodes = work(&campaign.jobs[task.job]).kind().has_episodes;
        let amount = has_episodes.then(|| task.units(campaign));
        store.take(ids.get(task), amount, others).map(|taken| (task, taken))
    };
    let all: Vec<Task> = tasks(campaign).collect();
    let taken = parallel::map(&all, |task| take(*task)).into_iter().collect::<Result<Vec<_>, _>>();
    let missing = taken.map_err(|error| run.keep(error))?.into_iter();
    Ok(missing.filter(|(_, found)| !matches!(found, Taken::Whole | Taken::Failed(_))).collect())
}

/// The missing tasks, and the shards that contain them.
fn lack(campaign: &Campaign, missing: &[(Task, Taken)], shards: Option<u32>) -> String {
    let (count, all, name) = (missing.len(), tasks(campaign).count(), &campaign.name);
    let mut text = format!("{count} of the {all} tasks of `{name}` are missing or damaged:");
    for (task, found) in missing.iter().take(MAX_SHOWN) {
        let why = match found {
            Taken::Part(done) => format!("unfinished, {done} {}", work(&campaign.jobs[task.job]).kind().unit),
            Taken::Damaged(path, reason) => format!("`{}` {reason}", path.display()),
            Taken::Differ(one, other) => {
                format!("`{}` and `{}` differ, so one is not what it says; remove it", one.display(), other.display())
            }
            _ => "missing".into(),
        };
        text.push_str(&format!("\n  {}: {why}", task_name(campaign, *task)));
    }
    if count > MAX_SHOWN {
        text.push_str(&format!("\n  … and {} more", count - MAX_SHOWN));
    }
    text.push_str(&match shards {
        Some(shards) => {
            let deal: BTreeMap<Task, u32> = deal(campaign, shards).into_iter().collect();
            let numbers = missing.iter().map(|(task, _)| deal[task]).collect();
            format!("\n  do again, of {shards} shards: {}", ranges(&numbers))
        }
        None => "\n  `falsify run` with the same files does only these; give --shards to see which shards would".into(),
    });
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

use std::path::PathBuf;

use clap::Args;
use rayon::prelude::*;

use super::run::{Work, pool};
use super::{Error, Event, Incomplete, Missing, Notice, RunOptions, RunReport, Session};
use compile::Campaign;
use results::campaign::{Task, tasks};
use results::jobs::work;
use results::store::{Ids, Store, Taken, task_name};

/// Options of [`Session::merge`].
#[derive(Debug, Clone, Default, Args)]
pub struct MergeOptions {
    /// The options of the run. Those on how it was run (`fresh`, `checkpoint`, `task_time`, `max_ticks`, `command`) have no effect here.
    #[arg(skip)]
    pub run: RunOptions,
    /// Folders with the tasks of shards (their --out or their --cache), in addition to those that are in the folder for the reports
    /// already.
    #[arg(long, num_args = 1.., value_name = "DIR")]
    pub from: Vec<PathBuf>,
    /// Write the finished part as NAME-partial when something is missing.
    #[arg(long, display_order = 100)]
    pub partial: bool,
}

impl Session {
    /// Imports the tasks of shards, and writes the reports when all are there. The observer gets the missing tasks. None when reports were
    /// not written: tasks are missing, or the session was stopped.
    ///
    /// # Errors
    /// Those of [`Session::run`], and a folder that does not exist.
    pub fn merge(&self, options: &MergeOptions) -> Result<Option<RunReport>, Error> {
        let planned = self.campaigns(&options.run)?;
        if let Some(missing) = options.from.iter().find(|folder| !folder.is_dir()) {
            return Err(Error::Usage(format!("there is no folder `{}`", missing.display())));
        }
        // A damaged task is reported together with a remedy.
        let store = Store::open(&options.run.out, options.run.cache.as_deref(), Box::new(|_| {}))?;
        let others: Vec<Store> = options.from.iter().map(|folder| Store::within(folder, Box::new(|_| {}))).collect();
        for (folder, _) in options.from.iter().zip(&others).filter(|(_, store)| !store.is_there()) {
            self.notice(&Notice::NoTasks { folder: folder.clone() });
        }
        let pool = pool(options.run.threads)?;
        self.tell(Event::Begun);
        let mut whole = true;
        for campaign in &planned.plan.campaigns {
            let incomplete = pool.install(|| self.take_over(campaign, &options.run, &store, &others))?;
            if self.stop.is_asked() {
                return Ok(None);
            }
            if let Some(incomplete) = incomplete {
                whole = false;
                self.notice(&Notice::Incomplete(Box::new(incomplete)));
            }
        }
        drop((store, pool));
        if whole || options.partial { self.run_plan(&options.run, &planned, Work::None).map(Some) } else { Ok(None) }
    }

    /// Imports all tasks of a campaign; returns those that are missing, if any.
    fn take_over(
        &self,
        campaign: &Campaign,
        options: &RunOptions,
        store: &Store,
        others: &[Store],
    ) -> Result<Option<Incomplete>, Error> {
        let ids = Ids::new(campaign, options.seed);
        let take = |task: Task| {
            if self.stop.is_asked() {
                return Ok((task, Taken::Missing));
            }
            let has_episodes = work(&campaign.jobs[task.job]).kind().has_episodes;
            let amount = has_episodes.then(|| task.units(campaign));
            store.take(ids.get(task), amount, others).map(|taken| (task, taken))
        };
        let all: Vec<Task> = tasks(campaign).collect();
        let taken = all.par_iter().map(|task| take(*task)).collect::<Result<Vec<_>, _>>();
        let missing = taken.map_err(|error| options.keep(error))?.into_iter();
        let missing = missing.filter(|(_, found)| !matches!(found, Taken::Whole | Taken::Failed(_)));
        let tasks: Vec<Missing> =
            missing.map(|(task, found)| Missing { task, name: task_name(campaign, task), found }).collect();
        let incomplete = Incomplete { campaign: campaign.clone(), tasks, all: all.len() };
        Ok(Some(incomplete).filter(|incomplete| !incomplete.tasks.is_empty()))
    }
}

use super::run::pool;
use super::{Error, Event, RunOptions, Session, ShardReport};
use compile::Campaign;
use results::campaign::{self, Shard, Task};
use results::store::{CampaignStore, Ids, Index, State, Store};

/// Options of [`Session::run_shard`], in addition to those of a run.
#[derive(Debug, Clone, Copy)]
pub struct ShardOptions {
    /// Which part of each campaign.
    pub shard: Shard,
    /// Whether to run only its trainings, each in one shard.
    pub only_trainings: bool,
}

impl Session {
    /// Runs one of several parts of each campaign. The store keeps its tasks, and no report is written. A run that is stopped returns the
    /// shards up to there.
    ///
    /// # Errors
    /// Those of [`Session::run`].
    pub fn run_shard(&self, options: &RunOptions, part: &ShardOptions) -> Result<Vec<ShardReport>, Error> {
        let planned = self.campaigns(options)?;
        let pool = pool(options.threads)?;
        let store = Store::open(&options.out, options.cache.as_deref(), self.note())?;
        self.tell(Event::Begun);
        let mut reports = Vec::new();
        for campaign in &planned.plan.campaigns {
            let report = pool.install(|| self.carry_out_shard(campaign, options, part, &store))?;
            self.tell(Event::ShardEnded(&report));
            reports.push(report);
            if self.stop.is_asked() {
                break;
            }
        }
        Ok(reports)
    }

    fn carry_out_shard(
        &self,
        campaign: &Campaign,
        options: &RunOptions,
        part: &ShardOptions,
        store: &Store,
    ) -> Result<ShardReport, Error> {
        let name = options.report_name(campaign);
        let tasks = part.tasks(campaign);
        let mut index = Index::read(store, &name).map_err(|error| options.keep(error))?;
        index.command.clone_from(&options.command);
        index.write(store, &name, campaign, options.seed).map_err(|error| options.keep(error))?;
        let results =
            CampaignStore::new(store, campaign, options.seed, options.limits()).continuing(&index, options.seed);
        self.run_tasks(campaign, &tasks, options, store, &results);
        if let Some(error) = results.take_failure() {
            return Err(options.keep(error));
        }
        let ids = Ids::new(campaign, options.seed);
        let is_finished = |task: &&Task| {
            store.head(ids.get(**task)).is_some_and(|head| head.is_ok_and(|header| header.state == State::Finished))
        };
        Ok(ShardReport {
            shard: part.shard,
            name,
            finished: tasks.iter().filter(is_finished).count(),
            all: tasks.len(),
        })
    }
}

impl ShardOptions {
    fn tasks(&self, campaign: &Campaign) -> Vec<Task> {
        if !self.only_trainings {
            return campaign::shard(campaign, self.shard);
        }
        let own = |(task, index)| (index == self.shard.index && matches!(task, Task::Training(_))).then_some(task);
        let mut tasks: Vec<Task> = campaign::deal(campaign, self.shard.count).into_iter().filter_map(own).collect();
        tasks.sort();
        tasks
    }
}

use super::run::{CampaignRun, Work, pool};
use super::{Error, Event, RunOptions, Session, ShardReport};
use compile::{Campaign, Job};
use results::campaign::{self, Shard, State, Task};
use results::store::{Ids, Store};

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
            let run = CampaignRun {
                session: self,
                options,
                planned: &planned,
                campaign,
                store: &store,
                work: Work::All,
                name: options.report_name(campaign),
            };
            let report = pool.install(|| run.carry_out_shard(part))?;
            self.tell(Event::ShardEnded(&report));
            reports.push(report);
            if self.stop.is_asked() {
                break;
            }
        }
        Ok(reports)
    }
}

impl CampaignRun<'_> {
    fn carry_out_shard(self, part: &ShardOptions) -> Result<ShardReport, Error> {
        let tasks = part.tasks(self.campaign);
        let results = self.results(&self.begin_index(&tasks)?);
        self.run_tasks(&tasks, &results);
        self.check(&results)?;
        let ids = Ids::new(self.campaign, self.options.seed);
        let is_finished = |task: &&Task| {
            let head = self.store.head(ids.get(**task));
            head.is_some_and(|head| head.is_ok_and(|header| header.state == State::Finished))
        };
        let finished = tasks.iter().filter(is_finished).count();
        Ok(ShardReport { shard: part.shard, name: self.name, finished, all: tasks.len() })
    }
}

impl ShardOptions {
    fn tasks(&self, campaign: &Campaign) -> Vec<Task> {
        if !self.only_trainings {
            return campaign::shard(campaign, self.shard);
        }
        let is_training = |task: Task| matches!(campaign.jobs[task.job], Job::Training(_));
        let own = |(task, index)| (index == self.shard.index && is_training(task)).then_some(task);
        let mut tasks: Vec<Task> = campaign::deal(campaign, self.shard.count).into_iter().filter_map(own).collect();
        tasks.sort();
        tasks
    }
}

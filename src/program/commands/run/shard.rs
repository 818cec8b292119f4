//! `falsify run --shard`: one of several parts of each campaign.

use std::str::FromStr;

use crate::session::{CampaignRun, Error, Event, RunOptions, Session, ShardReport, Work, pool};
use compile::{Campaign, Job};
use results::campaign::{self, Shard, State, Task};
use results::store::{Ids, Store};

/// The variables in which job engines give a task its number, counted from 0 as shards are.
const NUMBERS: [&str; 2] = ["SLURM_ARRAY_TASK_ID", "JOB_COMPLETION_INDEX"];

/// A shard on the command line: `3/16`, or `auto/16` to take the number from the environment.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NamedShard {
    index: Option<u32>,
    count: u32,
}

/// Why a text is not a shard.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum NoShard {
    #[error("write INDEX/COUNT, such as 3/16, or auto/16")]
    Form,
    #[error("there must be at least one shard")]
    Count,
    #[error("{count} shards are counted from 0 to {}", count - 1)]
    Index { count: u32 },
    #[error("--shard auto/{count} needs {} or {} in the environment", NUMBERS[0], NUMBERS[1])]
    NoNumber { count: u32 },
    #[error("{variable} is `{value}`, but {count} shards are counted from 0 to {}", count - 1)]
    Number { variable: &'static str, value: String, count: u32 },
}

impl FromStr for NamedShard {
    type Err = NoShard;

    fn from_str(text: &str) -> Result<Self, NoShard> {
        let (index, count) = text.split_once('/').ok_or(NoShard::Form)?;
        let count: u32 = count.parse().map_err(|_| NoShard::Form)?;
        let index = if index == "auto" { None } else { Some(index.parse().map_err(|_| NoShard::Form)?) };
        match index {
            _ if count == 0 => Err(NoShard::Count),
            Some(index) if index >= count => Err(NoShard::Index { count }),
            _ => Ok(Self { index, count }),
        }
    }
}

impl NamedShard {
    /// The shard; its number comes from the environment if the user did not give one.
    ///
    /// # Errors
    /// The environment has no number, or one that is not a shard.
    pub fn resolve(self, variable: impl Fn(&str) -> Option<String>) -> Result<Shard, NoShard> {
        let Self { index, count } = self;
        if let Some(index) = index {
            return Ok(Shard { index, count });
        }
        let found = NUMBERS.iter().find_map(|name| Some((*name, variable(name)?)));
        let (variable, value) = found.ok_or(NoShard::NoNumber { count })?;
        match value.parse() {
            Ok(index) if index < count => Ok(Shard { index, count }),
            _ => Err(NoShard::Number { variable, value, count }),
        }
    }
}

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
    pub(super) fn run_shard(&self, options: &RunOptions, part: &ShardOptions) -> Result<Vec<ShardReport>, Error> {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_are_counted_from_zero() {
        let named = |text: &str| NamedShard::from_str(text).and_then(|named| named.resolve(|_| None));
        assert_eq!(named("3/16"), Ok(Shard { index: 3, count: 16 }));
        assert!(named("16/16").unwrap_err().to_string().contains("from 0 to 15"));
        for wrong in ["3", "3/", "/4", "a/4", "1/0", "-1/4", "1/4/4"] {
            assert!(NamedShard::from_str(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn the_number_comes_from_the_environment() {
        let auto = NamedShard::from_str("auto/16").unwrap();
        let with =
            |name: &'static str, value: &'static str| move |asked: &str| (asked == name).then(|| value.to_string());
        for name in NUMBERS {
            assert_eq!(auto.resolve(with(name, "7")), Ok(Shard { index: 7, count: 16 }));
            assert!(auto.resolve(with(name, "16")).unwrap_err().to_string().contains(name));
        }
        assert!(auto.resolve(|_| None).unwrap_err().to_string().contains("SLURM_ARRAY_TASK_ID"));
    }
}

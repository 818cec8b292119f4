//! `falsify run --shard`: one of several parts of a campaign, whose cells are kept and of which no report is made.

use std::str::FromStr;

use super::args::{Only, RunOptions};
use super::progress::Progress;
use super::{ExitCode, front, interrupt, run};
use crate::campaign::{self, Cell, Shard};
use crate::compile::Campaign;
use crate::seed::Seed;
use crate::store::{Ids, Index, Kept, State, Store};

/// The variables in which engines tell a task its number, counted from 0 as they are used here.
const NUMBERS: [&str; 2] = ["SLURM_ARRAY_TASK_ID", "JOB_COMPLETION_INDEX"];

/// A shard as the user names it: `3/16`, or `auto/16` where an engine says which.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Named {
    index: Option<u32>,
    count: u32,
}

impl FromStr for Named {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let form = || "write INDEX/COUNT, such as 3/16, or auto/16".to_string();
        let (index, count) = text.split_once('/').ok_or_else(form)?;
        let count: u32 = count.parse().map_err(|_| form())?;
        let index = if index == "auto" { None } else { Some(index.parse().map_err(|_| form())?) };
        match index {
            _ if count == 0 => Err("there must be at least one shard".into()),
            Some(index) if index >= count => Err(format!("{count} shards are counted from 0 to {}", count - 1)),
            _ => Ok(Self { index, count }),
        }
    }
}

impl Named {
    /// Which shard it is, asking the environment if need be.
    ///
    /// # Errors
    /// What to tell the user.
    pub fn resolve(self, variable: impl Fn(&str) -> Option<String>) -> Result<Shard, String> {
        let Self { index, count } = self;
        if let Some(index) = index {
            return Ok(Shard { index, count });
        }
        let (name, value) = NUMBERS
            .iter()
            .find_map(|name| Some((name, variable(name)?)))
            .ok_or_else(|| format!("--shard auto/{count} needs {} or {} in the environment", NUMBERS[0], NUMBERS[1]))?;
        match value.parse() {
            Ok(index) if index < count => Ok(Shard { index, count }),
            _ => Err(format!("{name} is `{value}`, but {count} shards are counted from 0 to {}", count - 1)),
        }
    }
}

/// Does a shard of a campaign; the error is the message to print.
pub fn carry_out(campaign: &Campaign, options: &RunOptions, shard: Shard, store: &Store) -> Result<ExitCode, String> {
    let (name, seed) = (run::name(campaign, options), options.seed);
    let mut wanted = campaign::shard(campaign, shard);
    if options.only == Some(Only::Trainings) {
        let here = |(cell, index)| (index == shard.index && matches!(cell, Cell::Training(_))).then_some(cell);
        wanted = campaign::deal(campaign, shard.count).into_iter().filter_map(here).collect();
        wanted.sort();
    }
    let failed = |error: crate::store::StoreError| run::kept(&error.to_string(), &options.out);
    let mut index = Index::read(store, &name);
    index.command = front::command_line();
    index.write(store, &name, campaign, seed).map_err(failed)?;
    let keeper = Kept::new(store, campaign, seed, run::limits(options));
    let progress = Progress::new(campaign, &wanted, options);
    campaign::run_cells(campaign, &wanted, &Seed::root(seed), &keeper, &progress);
    progress.finish(wanted.len());
    if let Some(error) = keeper.failure() {
        return Err(run::kept(&error, &options.out));
    }
    let ids = Ids::new(campaign, seed);
    let is_done = |cell: &&Cell| {
        store.head(ids.get(**cell)).is_some_and(|head| head.is_ok_and(|header| header.state == State::Finished))
    };
    let (done, all) = (wanted.iter().filter(is_done).count(), wanted.len());
    let Shard { index, count } = shard;
    if options.format == super::args::Output::Human {
        front::say(&format!("{name}, shard {index} of {count}: {done} of {all} cells are there"));
    }
    Ok(if done == all || interrupt::asked() { ExitCode::Done } else { ExitCode::RunFailed })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_are_counted_from_zero() {
        let named = |text: &str| Named::from_str(text).and_then(|named| named.resolve(|_| None));
        assert_eq!(named("3/16"), Ok(Shard { index: 3, count: 16 }));
        assert!(named("16/16").unwrap_err().contains("from 0 to 15"));
        for wrong in ["3", "3/", "/4", "a/4", "1/0", "-1/4", "1/4/4"] {
            assert!(Named::from_str(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn the_number_comes_from_whoever_started_the_task() {
        let auto = Named::from_str("auto/16").unwrap();
        let with =
            |name: &'static str, value: &'static str| move |asked: &str| (asked == name).then(|| value.to_string());
        for name in NUMBERS {
            assert_eq!(auto.resolve(with(name, "7")), Ok(Shard { index: 7, count: 16 }));
            assert!(auto.resolve(with(name, "16")).unwrap_err().contains(name));
        }
        assert!(auto.resolve(|_| None).unwrap_err().contains("SLURM_ARRAY_TASK_ID"));
    }
}

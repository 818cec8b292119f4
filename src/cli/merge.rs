//! `falsify merge`: the report of a campaign whose cells were made apart.

use std::collections::{BTreeMap, BTreeSet};

use rayon::prelude::*;

use super::args::{MergeOptions, Output};
use super::progress::Event;
use super::{ExitCode, front, interrupt, run};
use crate::campaign::{self, Cell, cells};
use crate::compile::Campaign;
use crate::store::{Ids, Store, StoreError, Taken, cell_name};

/// Most cells that are named one by one.
const SHOWN: usize = 10;

/// `falsify merge`
pub fn merge(options: &MergeOptions) -> ExitCode {
    let code = put_together(options);
    if options.run.format == Output::Json {
        Event::RunEnded { exit_code: code as u8 }.tell();
    }
    code
}

fn put_together(options: &MergeOptions) -> ExitCode {
    let work = &options.run;
    if work.shard.is_some() || work.list || work.fresh {
        front::fail("a merge does nothing but put together; leave --shard, --list and --fresh to `falsify run`");
        return ExitCode::Usage;
    }
    let mut plan = match front::compile_files(&work.files, &work.given) {
        Ok((plan, _)) => plan,
        Err(code) => return code,
    };
    if work.smoke {
        plan.campaigns.iter_mut().for_each(campaign::smoke);
    }
    if let Some(missing) = options.from.iter().find(|folder| !folder.is_dir()) {
        front::fail(&format!("there is no folder `{}`", missing.display()));
        return ExitCode::Usage;
    }
    // What is damaged is told below, with what to do about it.
    let store = match Store::open(&work.out, work.cache.as_deref(), Box::new(|_| {})) {
        Ok(store) => store,
        Err(error) => return run::no_store(&error),
    };
    let others: Vec<Store> = options.from.iter().map(|folder| Store::within(folder, Box::new(|_| {}))).collect();
    for (folder, _) in options.from.iter().zip(&others).filter(|(_, store)| !store.is_there()) {
        let folder = folder.display();
        front::warn(&format!("there are no cells in `{folder}`; where a shard was given --cache, name that folder"));
    }
    let pool = match run::pool(work.threads) {
        Ok(pool) => pool,
        Err(code) => return code,
    };
    interrupt::listen();
    let mut whole = true;
    for campaign in &plan.campaigns {
        match pool.install(|| gather(campaign, options, &store, &others)) {
            Ok(there) => whole &= there,
            Err(error) => {
                front::fail(&run::kept(&error.to_string(), &work.out));
                return ExitCode::WriteFailed;
            }
        }
        if interrupt::asked() {
            return ExitCode::Interrupted;
        }
    }
    drop(store);
    if whole || options.partial { run::report(work) } else { ExitCode::Incomplete }
}

/// Takes all cells of a campaign over; says what is missing, and whether nothing is.
fn gather(campaign: &Campaign, options: &MergeOptions, store: &Store, others: &[Store]) -> Result<bool, StoreError> {
    let ids = Ids::new(campaign, options.run.seed);
    let take = |cell: Cell| {
        if interrupt::asked() {
            return Ok((cell, Taken::Missing));
        }
        let amount = match cell {
            Cell::Chunk { evaluation, chunk } => Some(campaign.evaluations[evaluation].chunk(chunk).len() as u64),
            _ => None,
        };
        store.take(ids.get(cell), amount, others).map(|taken| (cell, taken))
    };
    let all: Vec<Cell> = cells(campaign).collect();
    let taken: Vec<(Cell, Taken)> = all.par_iter().map(|cell| take(*cell)).collect::<Result<_, StoreError>>()?;
    if interrupt::asked() {
        return Ok(false);
    }
    let lacking: Vec<&(Cell, Taken)> =
        taken.iter().filter(|(_, taken)| !matches!(taken, Taken::Whole | Taken::Failed(_))).collect();
    if lacking.is_empty() {
        return Ok(true);
    }
    front::fail(&lack(campaign, options, &lacking, all.len()));
    Ok(false)
}

/// Says what is lacking, and what would make it.
fn lack(campaign: &Campaign, options: &MergeOptions, lacking: &[&(Cell, Taken)], all: usize) -> String {
    let mut text =
        format!("{} of the {all} cells of `{}` are not there as they should be:", lacking.len(), campaign.name);
    for (cell, taken) in lacking.iter().take(SHOWN) {
        let why = match taken {
            Taken::Part(done) => format!("unfinished, {done} {}", unit(*cell)),
            Taken::Damaged(path) => format!("`{}` is damaged", path.display()),
            Taken::Differ(one, other) => {
                format!("`{}` and `{}` differ, so one is not what it says; remove it", one.display(), other.display())
            }
            _ => "missing".into(),
        };
        text.push_str(&format!("\n  {}: {why}", cell_name(campaign, *cell)));
    }
    if lacking.len() > SHOWN {
        text.push_str(&format!("\n  … and {} more", lacking.len() - SHOWN));
    }
    match options.shards {
        Some(count) => {
            let deal: BTreeMap<Cell, u32> = campaign::deal(campaign, count).into_iter().collect();
            let shards: BTreeSet<u32> = lacking.iter().map(|(cell, _)| deal[cell]).collect();
            text.push_str(&format!("\n  do again, of {count} shards: {}", ranges(&shards)));
        }
        None => text
            .push_str("\n  `falsify run` with the same files does only these; give --shards to see which shards would"),
    }
    text
}

fn unit(cell: Cell) -> &'static str {
    match cell {
        Cell::Training(_) => "updates",
        Cell::Chunk { .. } | Cell::Search(_) => "episodes",
    }
}

/// Numbers as job arrays take them: `2,7-9`.
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

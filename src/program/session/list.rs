use std::collections::BTreeMap;
use std::path::PathBuf;

use super::{Error, RunOptions, Session};
use compile::Campaign;
use results::campaign::{Task, tasks};
use results::report::StoredReport;
use results::store::{Ids, Index, Known, Store};

/// What a run would do for a campaign.
#[derive(Debug)]
pub struct Listing {
    /// The name that its report would have.
    pub name: String,
    pub campaign: Campaign,
    /// What the store has of each task.
    pub tasks: BTreeMap<Task, Known>,
    /// Its report, if there is one.
    pub report: Option<PathBuf>,
}

impl Session {
    /// Finds out what a run would do. It changes nothing.
    ///
    /// # Errors
    /// Files that cannot be read or have errors, and a cache folder with other contents.
    pub fn list(&self, options: &RunOptions) -> Result<Vec<Listing>, Error> {
        let planned = self.campaigns(options)?;
        let store = Store::look(&options.out, options.cache.as_deref(), self.note())?;
        planned.plan.campaigns.into_iter().map(|campaign| listing(campaign, options, &store)).collect()
    }
}

fn listing(campaign: Campaign, options: &RunOptions, store: &Store) -> Result<Listing, Error> {
    let name = options.report_name(&campaign);
    let ids = Ids::new(&campaign, options.seed);
    let index = Index::read(store, &name)?;
    let known = |task| match options.fresh {
        true => Known::Missing("--fresh".into()),
        false => index.look(store, &campaign, task, &ids, options.seed),
    };
    let tasks = tasks(&campaign).map(|task| (task, known(task))).collect();
    let folder = options.out.join(&name);
    let report = StoredReport::open(&folder).is_ok().then_some(folder);
    Ok(Listing { name, campaign, tasks, report })
}

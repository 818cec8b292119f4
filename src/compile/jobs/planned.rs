use std::any::Any;
use std::fmt;
use std::sync::Arc;

use crate::{Fingerprint, Programs, RunId};
use episode::Scenario;

/// Where a job comes from, whatever its kind is.
#[derive(Debug, Clone)]
pub struct Origin {
    /// Its short name; a training has none.
    pub id: RunId,
    /// Number of its block among those of this kind in its campaign, from 0.
    pub block: u32,
    /// Number of its run, from 0. Jobs that differ only in it differ in what they draw.
    pub run: u32,
    /// The digest of what the files say about it, without the job that it needs.
    pub fingerprint: Fingerprint,
    /// The programs of the user that it depends on, without those of the job that it needs.
    pub programs: Programs,
    /// The job that ends before it begins, by its place in [`Campaign::jobs`](crate::Campaign::jobs).
    pub needs: Option<usize>,
}

/// A job that comes from a block.
pub trait Originated {
    fn origin(&self) -> &Origin;
}

/// What the plan says about a job, whatever its kind is.
pub trait Planned: Originated + Any + fmt::Debug + Send + Sync {
    /// Its names for people.
    fn title(&self) -> String;

    /// Its scenarios, with the names of their towns.
    fn places(&self) -> Vec<(&str, &Arc<Scenario>)>;

    /// Number of tasks that it is divided into.
    fn parts(&self) -> u32 {
        1
    }

    /// The size of a part, in units of its kind: decisions, episodes, or simulator ticks at most.
    fn units(&self, part: u32) -> u64;

    /// Simulator ticks that a part may need.
    fn ticks(&self, part: u32) -> u64 {
        self.units(part)
    }

    /// All that its results depend on, beside the user's seed, the code and the job that it needs. Jobs with equal inputs are the same work.
    /// What [`Planned::shorten`] changes belongs to it.
    fn inputs(&self) -> String {
        format!("{:?}", self.names(None))
    }

    /// Whether the last bits of its results depend on the processor.
    fn depends_on_processor(&self) -> bool {
        false
    }

    /// The digest that it shares with shorter jobs which it continues.
    fn lineage(&self) -> Option<Fingerprint> {
        None
    }

    /// Shortens it for a quick check of the whole pipeline.
    fn shorten(&mut self);

    /// What its short name is made of, where it needs this job; empty for a job without one.
    fn names(&self, _needed: Option<&dyn Planned>) -> Vec<String> {
        Vec::new()
    }
}

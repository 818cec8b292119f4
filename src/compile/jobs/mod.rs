//! The jobs of a campaign. A kind is a file or a folder with the keys of its block, the jobs that a block adds, and what the plan says about them:
//! [`Planned`].

mod training;
mod drive;
mod evaluation;
mod search;
mod estimate;
mod cover;
mod harden;
mod price;

use std::any::Any;
use std::fmt;
use std::sync::Arc;

pub use cover::Cover;
pub use estimate::Estimation;
pub use evaluation::{CHUNK, ControllerKind, Evaluation, UNTRAINED, episodes_seed};
pub(crate) use evaluation::{STOCHASTIC, TRAINED};
pub use harden::{Harden, VariedKey, WrittenPolicy};
pub use price::Pricing;
pub use search::{Search, SearchKey};
pub use training::{NO_REWARD, Training, TrainingKey};

use super::grid::{Grid, Nested};
use super::lowering::Lowering;
use super::{Campaign, ExternalProgram, Fingerprint, Programs, RunId};
use base::signature::{DeclarationId, Signature};
use episode::Scenario;
use lang::hir::Block;

/// A kind of block that adds jobs to a campaign.
pub(crate) struct JobBlock {
    pub signature: fn() -> Signature,
    /// The drivers of a block that are under test.
    pub drivers: fn(&Block) -> Vec<DeclarationId>,
    /// Adds the jobs of a block to its campaign.
    pub lower: fn(&mut Lowering<'_>, Nested<'_>, &mut Grid),
}

/// All blocks with jobs, in the order of the jobs.
pub(crate) const BLOCKS: [JobBlock; 7] =
    [training::BLOCK, drive::BLOCK, evaluation::BLOCK, search::BLOCK, estimate::BLOCK, cover::BLOCK, harden::BLOCK];

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
    /// The job that ends before it begins, by its place in [`Campaign::jobs`].
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
        format!("{:?}", self.names(&[]))
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

    /// What its short name is made of; empty for a job without one.
    fn names(&self, _jobs: &[Job]) -> Vec<String> {
        Vec::new()
    }
}

macro_rules! kinds {
    ($($kind:ident),*) => {
        /// A job of a campaign.
        #[derive(Debug, Clone)]
        pub enum Job {
            $($kind($kind)),*
        }

        impl Job {
            /// What all kinds have in common.
            pub fn planned(&self) -> &dyn Planned {
                match self {
                    $(Self::$kind(job) => job),*
                }
            }

            fn planned_mut(&mut self) -> &mut dyn Planned {
                match self {
                    $(Self::$kind(job) => job),*
                }
            }

            fn origin_mut(&mut self) -> &mut Origin {
                match self {
                    $(Self::$kind(job) => &mut job.origin),*
                }
            }
        }

        $(impl Originated for $kind {
            fn origin(&self) -> &Origin {
                &self.origin
            }
        }

        impl From<$kind> for Job {
            fn from(job: $kind) -> Self {
                Self::$kind(job)
            }
        })*
    };
}

kinds!(Training, Evaluation, Search, Estimation, Cover, Harden, Pricing);

impl Job {
    pub fn origin(&self) -> &Origin {
        self.planned().origin()
    }

    /// The job, if it is of this kind.
    pub fn of<T: Planned>(&self) -> Option<&T> {
        (self.planned() as &dyn Any).downcast_ref()
    }
}

impl Campaign {
    /// The jobs of a kind, in order.
    pub fn all<T: Planned>(&self) -> impl Iterator<Item = &T> + Clone {
        self.jobs.iter().filter_map(Job::of)
    }

    /// The job of a kind with this number, from 0.
    ///
    /// # Panics
    /// If there are fewer.
    pub fn nth<T: Planned>(&self, number: usize) -> &T {
        self.all().nth(number).expect("the campaign has as many jobs of this kind")
    }

    /// The programs of the user that its jobs depend on, each once.
    pub fn programs(&self) -> Vec<&Arc<ExternalProgram>> {
        let mut all: Vec<&Arc<ExternalProgram>> = Vec::new();
        for program in self.jobs.iter().flat_map(|job| job.origin().programs.iter()) {
            if !all.contains(&program) {
                all.push(program);
            }
        }
        all
    }

    /// One scenario for every spawn rule in every town, with the town's name, each once.
    pub fn starts(&self) -> Vec<(&str, &Arc<Scenario>)> {
        let mut all: Vec<(&str, &Arc<Scenario>)> = Vec::new();
        for (town, scenario) in self.jobs.iter().flat_map(|job| job.planned().places()) {
            if all.iter().all(|(other, known)| *other != town || known.spawn != scenario.spawn) {
                all.push((town, scenario));
            }
        }
        all
    }

    /// Shortens it to a quick check of the whole pipeline: the first run of each job, with less work.
    pub fn shorten(&mut self) {
        let is_first: Vec<bool> = self.jobs.iter().map(|job| job.origin().run == 0).collect();
        let place = |old: usize| is_first[..old].iter().filter(|first| **first).count();
        self.jobs.retain(|job| job.origin().run == 0);
        for job in &mut self.jobs {
            job.planned_mut().shorten();
            let origin = job.origin_mut();
            origin.needs = origin.needs.map(place);
        }
    }

    /// Gives jobs the short names that this function has for them, if it has any.
    pub fn rename(&mut self, mut name: impl FnMut(&Job) -> Option<RunId>) {
        for job in &mut self.jobs {
            if let Some(new) = name(job) {
                job.origin_mut().id = new;
            }
        }
    }
}

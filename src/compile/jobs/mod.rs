//! The jobs of a campaign. A kind is a file with its names, what the plan says about it, and [`Planned`].

mod training;
mod evaluation;
mod search;
mod estimate;
mod cover;
mod harden;

use std::any::Any;
use std::fmt;
use std::sync::Arc;

pub use cover::{Cover, CoverKey};
pub use estimate::{Estimation, EstimationKey};
pub use evaluation::{CHUNK, ControllerKind, Evaluation, episodes_seed};
pub(crate) use harden::PARAMETERS;
pub use harden::{Harden, HardenKey, VariedKey, WrittenPolicy};
pub use search::{Search, SearchKey};
pub use training::{NO_REWARD, Training, TrainingKey};

use super::{Campaign, ExternalProgram, Fingerprint, Programs, RunId};
use world::env::Scenario;

/// What the plan says about a job, whatever its kind is.
pub trait Planned: Any + fmt::Debug + Send + Sync {
    /// Number of its run, from 0. Jobs that differ only in it differ in what they draw.
    fn run_number(&self) -> u32 {
        0
    }

    /// Its scenarios, with the names of their towns.
    fn places(&self) -> Vec<(&str, &Arc<Scenario>)>;

    /// The programs of the user that it depends on, without those of the job that it needs.
    fn programs(&self) -> &Programs;

    /// The digest of what the files say about it, without the job that it needs.
    fn fingerprint(&self) -> Fingerprint;

    /// The job that ends before it begins, by its place in [`Campaign::jobs`].
    fn needs(&self) -> Option<usize> {
        None
    }

    /// [`Planned::needs`], to be changed.
    fn needs_mut(&mut self) -> Option<&mut usize> {
        None
    }

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
    fn inputs(&self) -> String;

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

    /// What its short name is made of; None for a job without one.
    fn names(&self, _jobs: &[Job]) -> Option<Vec<String>> {
        None
    }

    /// Its short name.
    fn id(&self) -> Option<RunId> {
        None
    }

    /// [`Planned::id`], to be changed.
    fn id_mut(&mut self) -> Option<&mut RunId> {
        None
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
        }

        $(impl From<$kind> for Job {
            fn from(job: $kind) -> Self {
                Self::$kind(job)
            }
        })*
    };
}

kinds!(Training, Evaluation, Search, Estimation, Cover, Harden);

impl Job {
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
        for program in self.jobs.iter().flat_map(|job| job.planned().programs().iter()) {
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
        let is_first: Vec<bool> = self.jobs.iter().map(|job| job.planned().run_number() == 0).collect();
        let place = |old: usize| is_first[..old].iter().filter(|first| **first).count();
        self.jobs.retain(|job| job.planned().run_number() == 0);
        for job in self.jobs.iter_mut().map(Job::planned_mut) {
            job.shorten();
            if let Some(needed) = job.needs_mut() {
                *needed = place(*needed);
            }
        }
    }

    /// Gives jobs the short names that this function has for them, if it has any.
    pub fn rename(&mut self, mut name: impl FnMut(&Job) -> Option<RunId>) {
        for job in &mut self.jobs {
            if let Some(new) = name(job)
                && let Some(id) = job.planned_mut().id_mut()
            {
                *id = new;
            }
        }
    }
}

use std::fmt;
use std::path::PathBuf;
use std::sync::Arc;

use super::{ExternalProgram, Job, Planned, RunId};
use base::signature::{Arguments, Keys};
use episode::requirement::NamedRequirement;
use episode::{PolicyMaker, Scenario};
use road::Town;
use world::av::CruiseKeys;
use world::av::external::ExternalKeys;
use world::av::onnx::OnnxKeys;
use world::av::sensors::SensorModel;

/// Everything that is run.
#[derive(Debug, Clone, Default)]
pub struct Plan {
    /// The campaigns of the files the user named, in order.
    pub campaigns: Vec<Campaign>,
    /// The towns that these files declare themselves, in order.
    pub towns: Vec<NamedTown>,
    /// The drivers that these files declare themselves, in order.
    pub drivers: Vec<NamedDriver>,
    /// Campaigns of imported files, which are not run, with their files.
    pub imported_campaigns: Vec<(String, PathBuf)>,
    /// The settings from outside the files.
    pub settings: Vec<OutsideSetting>,
}

/// A setting from outside the files, and what depends on it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct OutsideSetting {
    /// As `name = value`.
    pub text: String,
    /// The names of the campaigns of the plan that it reaches, and of the others.
    pub campaigns: [Vec<String>; 2],
}

/// `ppo_paper.steps = 10000 reaches fast, slow; not third`.
impl fmt::Display for OutsideSetting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { text, campaigns: [reached, others] } = self;
        match (reached.as_slice(), others.as_slice()) {
            ([], _) => write!(f, "`{text}` reaches no campaign"),
            (reached, []) => write!(f, "`{text}` reaches {}", reached.join(", ")),
            (reached, others) => write!(f, "`{text}` reaches {}, and not {}", reached.join(", "), others.join(", ")),
        }
    }
}

impl Plan {
    /// Why there is nothing to run, and what to do about it.
    pub fn without_campaigns(&self) -> String {
        match self.imported_campaigns.as_slice() {
            [] => "the files hold no campaign; write `campaign NAME { … }` to say what is to be run".into(),
            [(name, file), ..] => format!(
                "the files hold no campaign of their own, and `{name}` is imported: give its file, `{}`, to run it",
                file.display()
            ),
        }
    }

    /// A setting from outside the files, with the campaigns that it reaches.
    pub(super) fn reached_by(&self, text: String) -> OutsideSetting {
        let names = |reached: bool| {
            let chosen = self.campaigns.iter().filter(|campaign| campaign.settings.contains(&text) == reached);
            chosen.map(|campaign| campaign.name.clone()).collect()
        };
        OutsideSetting { campaigns: [names(true), names(false)], text }
    }

    /// Whether a town of this name is declared or used.
    pub fn has_town(&self, name: &str) -> bool {
        let used = self.campaigns.iter().flat_map(|campaign| &campaign.towns);
        self.towns.iter().chain(used).any(|town| town.name == name)
    }
}

/// A campaign: a list of jobs, and what reports say about them.
#[derive(Debug, Clone)]
pub struct Campaign {
    pub name: String,
    /// Its documentation, one string a line.
    pub docs: Vec<String>,
    /// The settings from outside the files that it depends on, and the combination of its `matrix`, as `name = value`.
    pub settings: Vec<String>,
    /// The documented declarations that it uses, in the order of the files.
    pub words: Vec<Documented>,
    /// What it requires of episodes beside no collision, in the order of the file.
    pub requirements: Arc<[NamedRequirement]>,
    /// The towns that it uses, each once.
    pub towns: Vec<NamedTown>,
    /// The drivers that it uses, each once.
    pub drivers: Vec<Driver>,
    /// What is run: trainings, evaluations, searches, estimates, covers, hardenings and prices, in this order, each in the order of its blocks and
    /// their keys. A job comes after the one that it needs.
    pub jobs: Vec<Job>,
    /// Published results, to be compared with its figures.
    pub published: Vec<Published>,
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

/// A published table.
#[derive(Debug, Clone, PartialEq)]
pub struct Published {
    /// Where it is from.
    pub source: String,
    /// Its `///` lines; they may explain why our figures differ.
    pub docs: String,
    /// The number of trainings its figures are averaged over.
    pub runs: u32,
    pub cells: Vec<PublishedCell>,
}

/// A cell of a published table: it is compared with every cell of ours with one of these rewards, towns and policies.
#[derive(Debug, Clone, PartialEq)]
pub struct PublishedCell {
    pub rewards: Vec<String>,
    pub towns: Vec<String>,
    /// Names of drivers.
    pub policies: Vec<String>,
    pub figures: Vec<PublishedFigure>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PublishedFigure {
    /// Our column for it, without `_mean`.
    pub column: &'static str,
    /// The mean over the published runs.
    pub mean: f64,
    /// Their sample standard deviation, if it is given.
    pub sd: Option<f64>,
}

/// A declaration that a campaign uses, with its documentation.
#[derive(Debug, Clone, PartialEq)]
pub struct Documented {
    pub form: &'static str,
    pub name: String,
    /// Its `///` lines.
    pub docs: String,
}

impl Documented {
    /// The first sentence of what is said about it.
    pub fn first_sentence(&self) -> &str {
        self.docs.split_inclusive(". ").next().unwrap_or_default().trim_end()
    }
}

/// A town under the name that the files give it.
#[derive(Debug, Clone)]
pub struct NamedTown {
    pub name: String,
    /// The roads.
    pub town: Arc<Town>,
}

/// A driver under the name that the files give it.
#[derive(Clone)]
pub struct NamedDriver {
    pub name: String,
    /// What makes it.
    pub policy: PolicyMaker,
    /// What a recurrent network carries from tick to tick, in words.
    pub carries: Option<String>,
}

impl fmt::Debug for NamedDriver {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("NamedDriver").field("name", &self.name).finish_non_exhaustive()
    }
}

/// The description of a driver in reports.
#[derive(Debug, Clone, PartialEq)]
pub struct Driver {
    /// The name that the files give it.
    pub name: String,
    pub kind: &'static str,
    /// Its keys with their values, except `sensors`.
    pub settings: Arguments,
    /// The keys of it and of its sensors that differ from their defaults, as `margin: 1 m`.
    pub changed: Vec<String>,
    /// The name of its sensors, if any.
    pub sensors: Option<String>,
    /// The model of its sensors, if any.
    pub sensor_model: Option<Arc<SensorModel>>,
    /// See [`Signature::surrogate`](base::signature::Signature::surrogate).
    pub surrogate: &'static str,
}

impl Driver {
    /// Whether it perceives no pedestrians, so that each of them can hit it. Reports show such a driver apart from those under test.
    pub fn sees_no_pedestrians(&self) -> bool {
        self.kind == CruiseKeys::KIND
    }

    /// Whether the user wrote or trained it.
    pub fn is_own(&self) -> bool {
        self.is_external() || self.kind == OnnxKeys::KIND
    }

    /// Whether it is a program of the user.
    pub fn is_external(&self) -> bool {
        self.kind == ExternalKeys::KIND
    }
}

use std::fmt;

use crate::campaign::Task;
use compile::{CHUNK, Campaign, Cover, Estimation, Evaluation, Harden, Search, Training};

/// The version of the code that affects numbers, as 16 hexadecimal digits.
pub const CODE: &str = env!("FALSIFY_CODE");

/// The version of the input of a task's digest.
const VERSION: &str = "falsify task 1";

/// The name of a task: a digest of everything that its bytes depend on.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Id([u8; 16]);

impl fmt::Display for Id {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

impl fmt::Debug for Id {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{self}")
    }
}

impl Id {
    fn of(parts: &[&[u8]]) -> Self {
        let mut digest = blake3::Hasher::new();
        for part in [VERSION.as_bytes(), CODE.as_bytes()].iter().chain(parts) {
            digest.update(&(part.len() as u64).to_le_bytes());
            digest.update(part);
        }
        Self(*digest.finalize().as_bytes().first_chunk().expect("a digest has more bytes"))
    }
}

/// The names of all tasks of a campaign.
#[derive(Debug, Clone)]
pub struct Ids {
    trainings: Vec<Id>,
    evaluations: Vec<Id>,
    searches: Vec<Id>,
    estimations: Vec<Id>,
    covers: Vec<Id>,
    hardenings: Vec<Id>,
}

impl Ids {
    /// Computes them for a seed.
    pub fn new(campaign: &Campaign, seed: u64) -> Self {
        let trainings: Vec<Id> = campaign.trainings.iter().map(|each| training(each, seed)).collect();
        let evaluation = |each: &Evaluation| {
            let first = || each.first.as_deref().map(|first| training(first, seed));
            evaluation(each, each.training().map(|place| trainings[place]).or_else(first), seed)
        };
        Self {
            evaluations: campaign.evaluations.iter().map(evaluation).collect(),
            searches: campaign.searches.iter().map(|each| search(each, seed)).collect(),
            estimations: campaign.estimations.iter().map(|each| estimation(each, seed)).collect(),
            covers: campaign.covers.iter().map(|each| cover(each, seed)).collect(),
            hardenings: campaign.hardenings.iter().map(|each| harden(each, seed)).collect(),
            trainings,
        }
    }

    /// The name of a task.
    ///
    /// The name of a chunk does not depend on the number of episodes that the campaign asks for: the first ones are always the same.
    pub fn get(&self, task: Task) -> Id {
        match task {
            Task::Training(index) => self.trainings[index],
            Task::Chunk { evaluation, chunk } => {
                let first = u64::from(chunk) * u64::from(CHUNK);
                Id::of(&[b"chunk", &self.evaluations[evaluation].0, &first.to_le_bytes()])
            }
            Task::Search(index) => self.searches[index],
            Task::Estimate(index) => self.estimations[index],
            Task::Cover(index) => self.covers[index],
            Task::Harden(index) => self.hardenings[index],
        }
    }
}

fn training(training: &Training, seed: u64) -> Id {
    let (key, config) = (&training.key, &training.config);
    let vectors = if config.portable_bits { "portable" } else { vector_instructions() };
    Id::of(&[
        b"training",
        vectors.as_bytes(),
        &seed.to_le_bytes(),
        key.town.as_bytes(),
        key.policy.as_bytes(),
        key.reward.as_bytes(),
        &key.run.to_le_bytes(),
        training.fingerprint.bytes(),
        // A smoke run takes fewer steps than the files say.
        &config.total_steps.to_le_bytes(),
    ])
}

fn evaluation(evaluation: &Evaluation, training: Option<Id>, seed: u64) -> Id {
    Id::of(&[
        b"evaluation",
        &seed.to_le_bytes(),
        evaluation.town.as_bytes(),
        evaluation.policy.as_bytes(),
        evaluation.controller.name().as_bytes(),
        &evaluation.trained.run.to_le_bytes(),
        evaluation.fingerprint.bytes(),
        training.as_ref().map_or(&[], |training| &training.0),
    ])
}

fn search(search: &Search, seed: u64) -> Id {
    let key = &search.key;
    Id::of(&[
        b"search",
        // Some falsifiers learn.
        vector_instructions().as_bytes(),
        &seed.to_le_bytes(),
        key.falsifier.as_bytes(),
        key.town.as_bytes(),
        key.policy.as_bytes(),
        &key.run.to_le_bytes(),
        search.fingerprint.bytes(),
        &search.budget.to_le_bytes(),
        &search.tries.to_le_bytes(),
    ])
}

fn estimation(estimation: &Estimation, seed: u64) -> Id {
    let key = &estimation.key;
    Id::of(&[
        b"estimate",
        &seed.to_le_bytes(),
        key.walker.as_bytes(),
        key.town.as_bytes(),
        key.policy.as_bytes(),
        &key.block.to_le_bytes(),
        &key.run.to_le_bytes(),
        estimation.fingerprint.bytes(),
        &estimation.budget.to_le_bytes(),
        &estimation.relative_error.to_bits().to_le_bytes(),
        estimation.event.name().as_bytes(),
    ])
}

fn harden(harden: &Harden, seed: u64) -> Id {
    let key = &harden.key;
    Id::of(&[
        b"harden",
        &seed.to_le_bytes(),
        key.policy.as_bytes(),
        &key.block.to_le_bytes(),
        &key.run.to_le_bytes(),
        harden.fingerprint.bytes(),
        harden.settings().as_bytes(),
    ])
}

fn cover(cover: &Cover, seed: u64) -> Id {
    let key = &cover.key;
    Id::of(&[
        b"cover",
        &seed.to_le_bytes(),
        key.pedestrian.as_bytes(),
        key.town.as_bytes(),
        key.policy.as_bytes(),
        &key.block.to_le_bytes(),
        cover.fingerprint.bytes(),
        cover.failure_name().as_bytes(),
        &cover.epsilon.to_le_bytes(),
        &cover.budget.to_le_bytes(),
    ])
}

/// The vector instructions that the networks' products may use. The last bits of a training depend on them.
pub fn vector_instructions() -> &'static str {
    #[cfg(target_arch = "x86_64")]
    {
        if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
            return "avx2, fma";
        }
        if is_x86_feature_detected!("avx") {
            return "avx";
        }
    }
    std::env::consts::ARCH
}

use std::fmt;

use crate::campaign::Task;
use compile::{Campaign, Job};

/// The version of the code that affects numbers, as 16 hexadecimal digits.
pub const CODE: &str = env!("FALSIFY_CODE");

/// The version of the input of a task's digest.
const VERSION: &str = "falsify task 2";

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
    /// Those of its jobs.
    jobs: Vec<Id>,
}

impl Ids {
    /// Computes them for a seed.
    pub fn new(campaign: &Campaign, seed: u64) -> Self {
        let mut jobs: Vec<Id> = Vec::with_capacity(campaign.jobs.len());
        for job in campaign.jobs.iter().map(Job::planned) {
            let vectors = if job.depends_on_processor() { vector_instructions() } else { "" };
            // A job comes after the one that it needs.
            let needed = job.origin().needs.map(|place| jobs[place]);
            let needed = needed.as_ref().map_or(&[][..], |id| &id.0);
            jobs.push(Id::of(&[vectors.as_bytes(), &seed.to_le_bytes(), job.inputs().as_bytes(), needed]));
        }
        Self { jobs }
    }

    /// The name of a task.
    ///
    /// The name of a part of an evaluation does not depend on the number of episodes that the campaign asks for: the first ones are always the same.
    pub fn get(&self, task: Task) -> Id {
        Id::of(&[b"part", &self.jobs[task.job].0, &task.part.to_le_bytes()])
    }
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

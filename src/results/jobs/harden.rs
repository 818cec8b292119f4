use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use super::{JobResult, Kind, Work, json, result};
use crate::campaign::{Part, TaskError};
use crate::report::{HARDENED, hardened_columns, hardened_in_words, hardened_table};
use compile::{Harden, HardenKey, WrittenPolicy};
use world::hardening::{Hardened, Hardening, harden};

pub(super) const KIND: Kind = Kind {
    name: "harden",
    plural: "hardenings",
    verb: "harden",
    doing: ["hardening", "hardened"],
    unit: "ticks",
    has_episodes: false,
    references: || vec![hardened_columns().reference()],
    tables: |found| match found.finished.all() {
        [] => Vec::new(),
        all => vec![(HARDENED, hardened_table(all))],
    },
};

/// The result of a hardening.
#[derive(Debug, Clone)]
pub struct HardenResult {
    pub key: HardenKey,
    /// What was asked for.
    pub plan: Arc<Hardening>,
    pub written: Arc<WrittenPolicy>,
    /// Maximum number of simulator ticks of its searches.
    pub budget: u64,
    /// None when it failed.
    pub found: Option<Hardened>,
    /// Why it failed.
    pub error: Option<TaskError>,
}

impl HardenResult {
    fn new(plan: &Harden, found: Result<Hardened, TaskError>) -> Self {
        let (found, error) = match found {
            Ok(found) => (Some(found), None),
            Err(error) => (None, Some(error)),
        };
        let (key, budget) = (plan.key.clone(), plan.budget());
        Self { key, plan: plan.hardening.clone(), written: plan.written.clone(), budget, found, error }
    }
}

impl JobResult for HardenResult {
    fn error(&self) -> Option<&TaskError> {
        self.error.as_ref()
    }

    fn units(&self) -> u64 {
        self.budget
    }

    fn note(&self) -> String {
        hardened_in_words(self)
    }

    /// An episode in error may end otherwise another time. Such a hardening is run again.
    fn encode(&self) -> Option<Vec<u8>> {
        let found = self.found.as_ref()?;
        let traffic = found.traffic.iter().map(|traffic| traffic.errors);
        let errors: u64 = traffic.chain(found.tests.iter().map(|test| test.errors)).sum();
        if errors > 0 { None } else { json(found) }
    }
}

impl Work for Harden {
    fn kind(&self) -> &'static Kind {
        &KIND
    }

    fn title(&self) -> String {
        self.key.to_string()
    }

    fn what(&self) -> String {
        format!("{}, block {}", self.key, self.key.block)
    }

    fn decode(&self, bytes: &[u8]) -> Option<Box<dyn JobResult>> {
        result(HardenResult::new(self, Ok(serde_json::from_slice(bytes).ok()?)))
    }

    fn run(&self, part: &Part<'_>) -> Option<Box<dyn JobResult>> {
        let failed = |error| result(HardenResult::new(self, Err(error)));
        if let Some(limit @ TaskError::Ticks { .. }) = part.limit(self.budget()) {
            return failed(limit);
        }
        part.begin(0);
        let used = AtomicU64::new(0);
        let progress = |ticks: u64| part.progress(used.fetch_add(ticks, Ordering::Relaxed) + ticks);
        let found = harden(&self.hardening, &self.seed(part.seed), &|| part.is_late(), &progress);
        if let Some(limit) = part.limit(0).filter(|_| !part.stop()) {
            return failed(limit);
        }
        match found {
            Ok(found) => result(HardenResult::new(self, Ok(found?))),
            Err(error) => failed(TaskError::Training(error)),
        }
    }
}

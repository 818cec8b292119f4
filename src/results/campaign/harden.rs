use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use super::run::Shared;
use super::{Event, Task, TaskError};
use compile::{Harden, HardenKey, WrittenPolicy};
use world::hardening::{Hardened, Hardening, harden};

/// The result of a hardening.
#[derive(Debug, Clone)]
pub struct HardenResult {
    pub key: HardenKey,
    /// What was asked for.
    pub plan: Arc<Hardening>,
    pub written: Arc<WrittenPolicy>,
    /// None when it failed.
    pub found: Option<Hardened>,
    /// Why it failed.
    pub error: Option<TaskError>,
}

impl HardenResult {
    /// The result of a hardening of the plan.
    pub fn new(plan: &Harden, found: Result<Hardened, TaskError>) -> Self {
        let (found, error) = match found {
            Ok(found) => (Some(found), None),
            Err(error) => (None, Some(error)),
        };
        Self { key: plan.key.clone(), plan: plan.hardening.clone(), written: plan.written.clone(), found, error }
    }
}

/// Hardens a driver; none when the user asks to stop before its end.
pub(super) fn carry_out(shared: Shared<'_>, index: usize) -> Option<HardenResult> {
    let Shared { campaign, seed, results, .. } = shared;
    let plan = &campaign.hardenings[index];
    let task = Task::Harden(index);
    if shared.stop() {
        return None;
    }
    if let Some(limit @ TaskError::Ticks { .. }) = results.limit(task, plan.budget()) {
        return Some(HardenResult::new(plan, Err(limit)));
    }
    shared.tell(Event::Begun(task));
    let late = || shared.stop() || results.limit(task, 0).is_some();
    let used = AtomicU64::new(0);
    let progress = |ticks: u64| {
        let ticks = used.fetch_add(ticks, Ordering::Relaxed) + ticks;
        shared.tell(Event::Hardening { harden: index, ticks });
    };
    let found = harden(&plan.hardening, &plan.seed(seed), &late, &progress);
    if let Some(limit) = results.limit(task, 0).filter(|_| !shared.stop()) {
        return Some(HardenResult::new(plan, Err(limit)));
    }
    match found {
        Ok(found) => Some(HardenResult::new(plan, Ok(found?))),
        Err(error) => Some(HardenResult::new(plan, Err(TaskError::Training(error)))),
    }
}

mod files;
mod picture;
mod section;
mod table;
mod validation;

use std::any::Any;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, Ordering};

use super::{JobResult, Kind, Work, result};
use crate::campaign::{Part, State, Stored, TaskError};
use crate::report::Group;
use compile::{Evaluation, Planned, Training, TrainingKey};
pub use files::pedestrian_files;
use learn::{ActorCritic, Trained, UpdateLog};
use search::{TrainError, TrainingRun};
pub use table::learning_curve_lines;

/// Number of decisions of a training between two reports to the observer.
const REPORT_INTERVAL: u64 = 16;

pub(super) const KIND: Kind = Kind {
    doing: ["training", "trained"],
    unit: "decisions",
    seconds: 1e-4,
    references: || vec![table::columns().reference()],
    tables: |found| Some(vec![("learning_curve", table::learning_curve(found.finished.all()))]),
    section: Some((Group::Comparisons, section::trainings)),
    folders: &["drivers", "pedestrians"],
    files: files::files,
    ..Kind::new::<Training>("training", "trainings", "train")
};

#[derive(Debug, Clone)]
pub struct TrainingResult {
    pub key: TrainingKey,
    /// The trained networks, or the error that ended the training.
    pub result: Result<Trained, TaskError>,
    /// Decisions that it took, demonstrations and those of all candidates included.
    pub decisions: u64,
    /// What an episode of each candidate earned on the validation starts, on average; empty without validation. The first of the greatest is kept.
    pub validation: Vec<f64>,
}

impl TrainingResult {
    /// The number of the candidate that is kept, from 0.
    pub fn kept(&self) -> usize {
        let best = self.validation.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        self.validation.iter().position(|reward| *reward == best).unwrap_or_default()
    }
}

impl JobResult for TrainingResult {
    fn error(&self) -> Option<&TaskError> {
        self.result.as_ref().err()
    }

    fn is_shown(&self) -> bool {
        self.result.is_ok()
    }

    fn units(&self) -> u64 {
        self.decisions
    }

    fn note(&self) -> String {
        self.validation.iter().map(|reward| format!("validation {reward:.3}")).collect::<Vec<_>>().join(", ")
    }
}

/// The networks of an evaluation's pedestrian; `None` if it is untrained, or if its training failed.
pub fn networks<'a>(evaluation: &Evaluation, trainings: &'a [TrainingResult]) -> Option<&'a [ActorCritic]> {
    evaluation.origin.needs?;
    let training = trainings.iter().find(|training| training.key == *evaluation.trained)?;
    Some(&training.result.as_ref().ok()?.policies)
}

impl Work for Training {
    fn kind(&self) -> &'static Kind {
        &KIND
    }

    fn what(&self) -> String {
        self.key.to_string()
    }

    fn decode(&self, bytes: &[u8]) -> Option<Box<dyn JobResult>> {
        let trained = Trained::from_safetensors(bytes).ok()?;
        let decisions = taken(self, &trained.learning_curve);
        let validation = if self.is_validated() { vec![validation::read(bytes)?] } else { Vec::new() };
        result(TrainingResult { key: self.key.clone(), result: Ok(trained), decisions, validation })
    }

    fn run(&self, part: &Part<'_>) -> Option<Box<dyn JobResult>> {
        let (mut decisions, mut validation) = (0, Vec::new());
        let trained = train(self, part, &mut decisions, &mut validation);
        result(TrainingResult { key: self.key.clone(), result: trained, decisions, validation })
    }

    /// The candidate that earned most on the validation starts; one that failed fails the training.
    fn join(&self, parts: Vec<Option<Box<dyn JobResult>>>) -> Option<Box<dyn JobResult>> {
        let candidates =
            parts.into_iter().map(|part| Some(*(part? as Box<dyn Any>).downcast::<TrainingResult>().ok()?));
        let mut candidates = candidates.collect::<Option<Vec<_>>>()?;
        let decisions = candidates.iter().map(|candidate| candidate.decisions).sum();
        let validation = candidates.iter().flat_map(|candidate| candidate.validation.clone()).collect();
        let whole =
            TrainingResult { key: self.key.clone(), result: Err(TaskError::NoEncounter), decisions, validation };
        let failed = candidates.iter().position(|candidate| candidate.result.is_err());
        let shown = candidates.swap_remove(failed.unwrap_or(whole.kept()));
        result(TrainingResult { result: shown.result, ..whole })
    }
}

/// The decisions of a training with this learning curve, demonstrations included.
fn taken(plan: &Training, curve: &[UpdateLog]) -> u64 {
    plan.demonstrations() + curve.last().map_or(0, |log| log.steps)
}

/// Trains a candidate. `decided` gets its decisions, `validation` its reward on the validation starts if it is validated.
fn train(plan: &Training, part: &Part<'_>, decided: &mut u64, validation: &mut Vec<f64>) -> Result<Trained, TaskError> {
    let scenarios = plan.scenarios();
    let seed = plan.candidate_seed(part.task.part, part.seed);
    let (environments, config) = (plan.config.environments, &plan.config);
    let is_overdue = || part.results.is_overdue(part.task, part.stop());
    let resume =
        |state: Vec<u8>| TrainingRun::resume(&state, &scenarios, plan.drive.as_ref(), environments, config, &seed).ok();
    // A stop that the user did not ask for is the limit of the task.
    let ended = |error: TrainError| {
        let limited = error.is_stopped() && !part.stop();
        limited.then(|| part.limit(0)).flatten().unwrap_or(TaskError::Training(error))
    };
    // The whole state, from which a training with more steps continues. The networks and the curve are read from it, too.
    let keep = |run: &TrainingRun, state: State, metadata: &BTreeMap<String, String>| {
        let done = taken(plan, run.learning_curve()).min(plan.units(0));
        part.put(&Stored { state, done, error: String::new(), bytes: run.state(metadata) });
    };
    let none = BTreeMap::new();
    // A state that does not fit counts as missing: the training restarts.
    let begun = part.results.get(part.task).and_then(|stored| resume(stored.bytes));
    let before = begun.as_ref().map_or(0, |run| taken(plan, run.learning_curve()));
    part.begin(before);
    let mut run = match begun {
        Some(run) => run,
        None => {
            // An imitation is not begun for nothing.
            if let Some(limit @ TaskError::Ticks { .. }) = part.limit(plan.ticks_of(0)) {
                return Err(limit);
            }
            let watch = |share: f64| {
                part.progress((share * plan.demonstrations() as f64) as u64);
                is_overdue()
            };
            let begun = match &plan.drive {
                None => TrainingRun::begin(&scenarios, environments, config, &seed),
                Some(rule) => TrainingRun::begin_driving(&scenarios, rule, environments, config, &seed, &watch),
            };
            begun.map_err(ended)?
        }
    };
    part.curve(run.learning_curve(), false);
    let decisions = AtomicU64::new(taken(plan, run.learning_curve()));
    while !run.is_done() {
        // A slow driver may need minutes for an update. Then the work of the update is lost.
        let overdue = || {
            let taken = decisions.fetch_add(1, Ordering::Relaxed);
            if taken.is_multiple_of(REPORT_INTERVAL) {
                part.progress(taken);
            }
            is_overdue()
        };
        run.update_unless(&overdue).map_err(ended)?;
        let log = run.learning_curve().last().expect("an update has just ended");
        *decided = taken(plan, run.learning_curve());
        part.progress(*decided);
        part.curve(run.learning_curve(), true);
        if let Some(limit) = part.limit(plan.ticks_of(log.steps)).filter(|_| !run.is_done()) {
            keep(&run, State::Begun, &none);
            return Err(limit);
        }
        let stop = part.stop() && !run.is_done();
        if stop || (!run.is_done() && part.results.is_due(part.task)) {
            keep(&run, State::Begun, &none);
        }
        if stop {
            return Err(TaskError::Training(learn::TrainError::Stopped { update: log.update }.into()));
        }
    }
    *decided = taken(plan, run.learning_curve());
    if !plan.is_validated() {
        keep(&run, State::Finished, &none);
        return Ok(run.finish());
    }
    keep(&run, State::Begun, &none);
    let stopped =
        || TaskError::Training(learn::TrainError::Stopped { update: run.learning_curve().len() as u64 }.into());
    let reward = validation::reward(plan, run.policies(), part).ok_or_else(stopped)?;
    keep(&run, State::Finished, &validation::metadata(reward));
    validation.push(reward);
    Ok(run.finish())
}

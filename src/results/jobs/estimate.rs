use super::{JobResult, Kind, Work, json, result};
use crate::campaign::{Part, TaskError};
use crate::report::{ESTIMATES, estimate_columns, estimate_table};
use base::seed::Seed;
use compile::{Estimation, EstimationKey};
use world::likelihood::{self, Encounters, Estimate, Limits};

pub(super) const KIND: Kind = Kind {
    name: "estimate",
    plural: "estimates",
    verb: "estimate",
    doing: ["estimating", "estimated"],
    unit: "ticks",
    has_episodes: false,
    references: || vec![estimate_columns().reference()],
    tables: |found| match found.finished.all() {
        [] => Vec::new(),
        all => vec![(ESTIMATES, estimate_table(all))],
    },
};

/// The result of an estimate.
#[derive(Debug, Clone)]
pub struct EstimateResult {
    pub key: EstimationKey,
    /// Encounters per hour and per 1,000 km, as far as the user states them.
    pub exposure: [Option<f64>; 2],
    /// Whether driver or pedestrian is a program of the user.
    pub has_program: bool,
    /// None when it failed.
    pub estimate: Option<Estimate>,
    /// Why it failed.
    pub error: Option<TaskError>,
}

impl EstimateResult {
    fn new(plan: &Estimation, estimate: Result<Estimate, TaskError>) -> Self {
        let (estimate, error) = match estimate {
            Ok(estimate) => (Some(estimate), None),
            Err(error) => (None, Some(error)),
        };
        let has_program = plan.programs.iter().next().is_some();
        Self { key: plan.key.clone(), exposure: plan.exposure, has_program, estimate, error }
    }
}

impl JobResult for EstimateResult {
    fn error(&self) -> Option<&TaskError> {
        self.error.as_ref()
    }

    fn units(&self) -> u64 {
        self.estimate.as_ref().map_or(0, |estimate| estimate.ticks)
    }

    fn note(&self) -> String {
        self.estimate.as_ref().map_or_else(String::new, |estimate| format!("{} encounters", estimate.encounters))
    }

    fn encode(&self) -> Option<Vec<u8>> {
        json(self.estimate.as_ref()?)
    }
}

impl Work for Estimation {
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
        result(EstimateResult::new(self, Ok(serde_json::from_slice(bytes).ok()?)))
    }

    fn run(&self, part: &Part<'_>) -> Option<Box<dyn JobResult>> {
        let failed = |error| result(EstimateResult::new(self, Err(error)));
        if let Some(limit @ TaskError::Ticks { .. }) = part.limit(self.budget) {
            return failed(limit);
        }
        part.begin(0);
        let limits = Limits {
            event: self.event,
            relative_error: self.relative_error,
            budget: self.budget,
            stop: &|| part.is_late(),
            progress: &|ticks| part.progress(ticks),
        };
        let make = || {
            let mut encounters = Encounters::new(&self.scenario, self.walker.walk_policy(), self.criterion);
            move |number: u64, seed: &Seed| encounters.run(number, seed)
        };
        let estimate = likelihood::estimate(&make, &self.drawn(part.seed), limits);
        if let Some(limit) = part.limit(0).filter(|_| !part.stop()) {
            return failed(limit);
        }
        if estimate.stopped {
            return None;
        }
        let estimate = if estimate.counted == 0 { Err(TaskError::NoEncounter) } else { Ok(estimate) };
        result(EstimateResult::new(self, estimate))
    }
}

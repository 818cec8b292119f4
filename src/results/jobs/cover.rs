use std::ops::ControlFlow;

use serde::{Deserialize, Serialize};

use super::{JobResult, Kind, Work, json, result};
use crate::campaign::{Part, TaskError};
use crate::report::{
    COVER_POINTS, COVERS, cover_columns, cover_in_words, cover_point_columns, cover_point_table, cover_table,
};
use compile::{Cover, CoverKey};
use world::env::{DrawnParameter, Outcome, Trace};
use world::judge::{Blame, Judged};
use world::likelihood::{BoxOfStarts, CoverConfig, Coverage, cover};

/// Maximum number of episodes in a row in which a driver or a controller may fail; then no more are run.
const MAX_ERRORS: u32 = 10;

pub(super) const KIND: Kind = Kind {
    name: "cover",
    plural: "covers",
    verb: "cover",
    doing: ["covering", "covered"],
    unit: "episodes",
    has_episodes: false,
    references: || vec![cover_columns().reference(), cover_point_columns().reference()],
    tables: |found| match found.finished.all() {
        [] => Vec::new(),
        all => vec![(COVERS, cover_table(&found.covers)), (COVER_POINTS, cover_point_table(all))],
    },
};

/// The result of a cover.
#[derive(Debug, Clone)]
pub struct CoverResult {
    pub key: CoverKey,
    /// The name of what it counts.
    pub failure: String,
    /// The parameters of the box, in the order of the coordinates of its points.
    pub parameters: Vec<DrawnParameter>,
    /// The parameters of the picture, by their places: one or two.
    pub picture: Vec<usize>,
    /// The share of the box that is small enough.
    pub epsilon: f64,
    /// The greatest number of episodes.
    pub budget: u32,
    pub found: FoundInBox,
    /// Why it ended early.
    pub error: Option<TaskError>,
}

/// What a cover found.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FoundInBox {
    pub coverage: Coverage,
    /// Points of the box for which no place on the road was found. They count as passed.
    pub unplaced: u64,
    /// Episodes that are left out ([`LeftOut`](world::env::LeftOut)). They count as passed.
    pub left_out: u64,
    /// Episodes in which a driver or a controller failed as a program. They count as passed.
    pub errors: u64,
    /// Simulator ticks of all episodes.
    pub ticks: u64,
}

impl CoverResult {
    /// What was planned, with what was found.
    fn new(cover: &Cover, found: FoundInBox, error: Option<TaskError>) -> Self {
        Self {
            key: cover.key.clone(),
            failure: cover.failure_name().to_string(),
            parameters: cover.scenario.start_parameters(),
            picture: cover.picture.clone(),
            epsilon: cover.epsilon,
            budget: cover.budget,
            found,
            error,
        }
    }

    /// The bound of the share of the box that is worse than the picture; none before the first look has ended.
    pub fn bound(&self) -> Option<f64> {
        self.found.coverage.best().map(|look| look.bound)
    }

    /// Whether the bound is small enough.
    pub fn is_covered(&self) -> bool {
        self.bound().is_some_and(|bound| bound <= self.epsilon)
    }
}

impl JobResult for CoverResult {
    fn error(&self) -> Option<&TaskError> {
        self.error.as_ref()
    }

    fn is_whole(&self) -> bool {
        self.error.is_none() && !self.found.coverage.stopped
    }

    /// It may end before its budget.
    fn units(&self) -> u64 {
        self.budget.into()
    }

    fn note(&self) -> String {
        cover_in_words(self)
    }

    /// An episode in error may end otherwise another time. Such a cover is run again.
    fn encode(&self) -> Option<Vec<u8>> {
        if self.found.errors > 0 { None } else { json(&self.found) }
    }
}

impl Work for Cover {
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
        result(CoverResult::new(self, serde_json::from_slice(bytes).ok()?, None))
    }

    fn run(&self, part: &Part<'_>) -> Option<Box<dyn JobResult>> {
        part.begin(0);
        let seed = self.seed(part.seed);
        let walker = self.walker.walk_policy();
        let mut starts = BoxOfStarts::new(&self.scenario, walker, seed.child("starts"));
        let dimensions = starts.parameters().len();
        let config = CoverConfig { dimensions, epsilon: self.epsilon, budget: self.budget.into() };
        let [mut unplaced, mut left_out, mut errors, mut ticks] = [0; 4];
        let (mut in_a_row, mut error) = (0, None);
        let mut experiment = |at: &[f64], number: u64| {
            part.progress(number);
            error = part.limit(ticks);
            if part.stop() || error.is_some() {
                return ControlFlow::Break(());
            }
            let Some((outcome, trace)) = starts.run(at, number) else {
                unplaced += 1;
                return ControlFlow::Continue(false);
            };
            ticks += u64::from(outcome.ticks) + u64::from(outcome.run_up);
            if outcome.fault().is_some() {
                errors += 1;
                in_a_row += 1;
                if in_a_row == MAX_ERRORS {
                    error = Some(TaskError::Hopeless);
                    return ControlFlow::Break(());
                }
                return ControlFlow::Continue(false);
            }
            in_a_row = 0;
            left_out += u64::from(outcome.left_out.is_some());
            ControlFlow::Continue(outcome.counts() && has_failed(self, &outcome, trace))
        };
        let coverage: Coverage = cover(&config, &seed.child("points"), &mut experiment);
        result(CoverResult::new(self, FoundInBox { coverage, unplaced, left_out, errors, ticks }, error))
    }
}

/// Whether an episode is what a cover counts.
fn has_failed(cover: &Cover, outcome: &Outcome, trace: &Trace) -> bool {
    let Cover { criterion, blame, scenario, .. } = cover;
    let judged = || Judged::by(*criterion, outcome, &trace.main_pair(scenario));
    criterion.is_met(outcome, trace.degrees()) && (*blame == Blame::Any || judged().is(*criterion, *blame))
}

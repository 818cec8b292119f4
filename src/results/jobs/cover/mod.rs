mod picture;
mod section;
mod table;

use std::ops::ControlFlow;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::{Kind, Measurement};
use crate::campaign::{Part, TaskError};
use crate::report::Group;
use base::seed::Seed;
use compile::Cover;
use episode::{Criterion, Outcome, Trace};
use search::likelihood::{BoxOfStarts, CoverConfig, Coverage, cover, encounters_needed};
pub use section::percent_above;
use table::{COVER_POINTS, COVERS, Covering};
use verdict::{Blame, Judged};

/// Maximum number of episodes in a row in which a driver or a controller may fail; then no more are run.
const MAX_ERRORS: u32 = 10;

pub(super) const KIND: Kind = Kind {
    doing: ["covering", "covered"],
    answer: section::answer,
    unit: "episodes",
    seconds: 3e-3,
    references: || vec![table::columns().reference(), table::point_columns().reference()],
    tables: |found| {
        let rows: Vec<Row<'_>> = found.finished.found_if_any()?;
        let points =
            rows.iter().flat_map(|(job, found)| (0..).zip(&found.coverage.points).map(move |point| (*job, point)));
        let points: Vec<Covering<'_>> = points.map(|(job, (number, point))| (job, number, point)).collect();
        Some(vec![(COVERS, table::columns().frame(&rows)), (COVER_POINTS, table::point_columns().frame(&points))])
    },
    section: Some((Group::Failures, section::covers)),
    ..Kind::new::<Cover>("cover", "covers", "cover")
};

type Row<'a> = (&'a Cover, &'a FoundInBox);

/// What a cover found.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FoundInBox {
    pub coverage: Coverage,
    /// In how many starts of the box a driver that never brakes fails, and how many of these it tried.
    pub unbraked: (u64, u64),
    /// The share of the box that the picture of the look with the least bound shows as failing; `None` if it ended before its first look.
    pub shown: Option<f64>,
    /// Points of the box for which no place on the road was found. They count as passed.
    pub unplaced: u64,
    /// Episodes that are left out ([`LeftOut`](episode::LeftOut)). They count as passed.
    pub left_out: u64,
    /// Episodes in which a driver or a controller failed as a program. They count as passed.
    pub errors: u64,
    /// Simulator ticks of all episodes.
    pub ticks: u64,
}

impl FoundInBox {
    /// The bound of the share of the box that is worse than the picture; `None` before the first look has ended.
    pub fn bound(&self) -> Option<f64> {
        self.coverage.best().map(|look| look.bound)
    }

    /// The share of the box in which a driver that never brakes fails.
    pub fn unbraked_share(&self) -> f64 {
        self.unbraked.0 as f64 / self.unbraked.1 as f64
    }

    /// Whether the bound is small enough for its cover.
    pub fn is_covered(&self, cover: &Cover) -> bool {
        self.bound().is_some_and(|bound| bound <= cover.epsilon)
    }
}

impl Measurement for Cover {
    type Found = FoundInBox;

    const KIND: &'static Kind = &KIND;

    /// It may end before its budget.
    fn units_of(&self, _: Option<&FoundInBox>) -> u64 {
        self.budget.into()
    }

    fn note(&self, found: &FoundInBox) -> String {
        let coverage = &found.coverage;
        let episodes = coverage.points.len();
        match coverage.best() {
            None => format!("{episodes} episodes, and no check"),
            Some(look) => {
                format!("{} failures, bound {} in {episodes} episodes", coverage.failures(), percent_above(look.bound))
            }
        }
    }

    fn is_whole(found: &FoundInBox) -> bool {
        !found.coverage.stopped
    }

    fn errors(found: &FoundInBox) -> u64 {
        found.errors
    }

    fn measure(&self, part: &Part<'_>) -> (Option<FoundInBox>, Option<TaskError>) {
        let seed = self.seed(part.seed);
        let unbraked = match unbraked(self, part, &seed.child("unbraked")) {
            Ok(unbraked) => unbraked,
            Err(error) => return (None, error),
        };
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
        let shown = coverage.best().map(|look| coverage.shown(&coverage.picture(look)));
        (Some(FoundInBox { coverage, unbraked, shown, unplaced, left_out, errors, ticks }), error)
    }
}

/// In how many starts of the box of a cover a driver that never brakes fails, and how many it tried: so many that none bounds its share by the epsilon. Then
/// that driver is covered, too, and the cover is refused, unless it is about another requirement, which such a driver may hold.
fn unbraked(cover: &Cover, part: &Part<'_>, seed: &Seed) -> Result<(u64, u64), Option<TaskError>> {
    let scenario = Arc::new(cover.scenario.unbraked());
    let mut starts = BoxOfStarts::new(&scenario, cover.walker.walk_policy(), seed.child("starts"));
    let wanted = encounters_needed(cover.epsilon);
    let tried = wanted.min(cover.budget.into());
    let mut failed = 0;
    for number in 0..tried {
        if part.stop() {
            return Err(None);
        }
        let at = starts.any_point(&mut seed.child("points").index(number).stream());
        let fails = |(outcome, trace): (Outcome, &Trace)| outcome.counts() && has_failed(cover, &outcome, trace);
        failed += u64::from(starts.run(&at, number).is_some_and(fails));
    }
    if failed == 0 && tried == wanted && cover.criterion == Criterion::Collision {
        return Err(Some(TaskError::CannotFail { points: tried }));
    }
    Ok((failed, tried))
}

/// Whether an episode is what a cover counts.
fn has_failed(cover: &Cover, outcome: &Outcome, trace: &Trace) -> bool {
    let Cover { criterion, blame, scenario, .. } = cover;
    let judged = || Judged::by(*criterion, outcome, &trace.main_pair(scenario));
    criterion.is_met(outcome, trace.degrees()) && (*blame == Blame::Any || judged().is(*criterion, *blame))
}

//! Events for programs: one JSON object a line on the output. `reports/README.md` explains them.

use std::path::Path;

use serde::Serialize;

use super::board::Board;
use super::job::{Job, Kind};
use super::learnt::Learnt;
use crate::cli::console;

/// An event.
#[derive(Debug, Serialize)]
#[serde(tag = "event", rename_all = "snake_case")]
pub enum Event<'a> {
    /// A campaign starts.
    CampaignBegun {
        /// Its name.
        campaign: &'a str,
        /// How many jobs of each kind it has.
        trainings: usize,
        /// The number of evaluations.
        evaluations: usize,
        /// The number of searches.
        searches: usize,
    },
    /// Learning curves grow in files while trainings run.
    LearningCurves {
        /// The campaign.
        campaign: &'a str,
        /// The folder of the files.
        folder: &'a Path,
    },
    /// A job of work begins.
    TaskBegun(About<'a>),
    /// A job of work has come further; told about once a second.
    Progress {
        /// The piece and its progress.
        #[serde(flatten)]
        about: About<'a>,
        /// Units per second.
        rate_per_s: Option<f64>,
        /// Time until it ends at this rate (s).
        left_s: Option<f64>,
        /// Time until the campaign ends (s).
        campaign_left_s: Option<f64>,
        /// What a training has learnt up to now.
        #[serde(skip_serializing_if = "Option::is_none")]
        learning: Option<Learnt>,
    },
    /// A job of work has ended.
    TaskFinished {
        /// The piece and its progress.
        #[serde(flatten)]
        about: About<'a>,
        /// Units that an earlier run of the program had done.
        reused: u64,
        /// Its wall time (s).
        took_s: f64,
        /// Units per second.
        rate_per_s: Option<f64>,
        /// Its result, for people.
        note: &'a str,
        /// Its error.
        error: Option<&'a str>,
        /// What a training has learnt.
        #[serde(skip_serializing_if = "Option::is_none")]
        learning: Option<Learnt>,
    },
    /// A problem that does not end the run.
    Warning {
        /// The campaign.
        campaign: &'a str,
        /// The problem, for people.
        message: &'a str,
    },
    /// A report is in its place.
    ReportWritten {
        /// The campaign.
        campaign: &'a str,
        /// Its folder.
        folder: &'a Path,
        /// Whether it is complete.
        complete: bool,
    },
    /// The overview of several reports is in its place.
    OverviewWritten {
        /// Its page.
        page: &'a Path,
    },
    /// The program ends.
    RunEnded {
        /// The exit code.
        exit_code: u8,
    },
}

/// A job of work, and how far it is.
#[derive(Debug, Serialize)]
pub struct About<'a> {
    campaign: &'a str,
    kind: Kind,
    /// Its place among those of its kind, in the order of `falsify run --list`.
    place: usize,
    name: &'a str,
    done: u64,
    total: u64,
    unit: &'static str,
    /// Time since the start of the campaign (s).
    time_s: f64,
}

impl<'a> About<'a> {
    fn new(board: &'a Board<'_>, job: &'a Job) -> Self {
        Self {
            campaign: &board.campaign.name,
            kind: job.kind,
            place: job.place,
            name: &job.name,
            done: job.done(),
            total: job.total,
            unit: job.kind.unit(),
            time_s: board.began.elapsed().as_secs_f64(),
        }
    }
}

impl<'a> Event<'a> {
    /// A campaign starts.
    pub fn campaign_begun(board: &'a Board<'_>) -> Self {
        let count = |kind| board.jobs.iter().filter(|job| job.kind == kind).count();
        Self::CampaignBegun {
            campaign: &board.campaign.name,
            trainings: count(Kind::Training),
            evaluations: count(Kind::Evaluation),
            searches: count(Kind::Search),
        }
    }

    /// Learning curves grow in files of this folder.
    pub fn curves_grow(board: &'a Board<'_>, folder: &'a Path) -> Self {
        Self::LearningCurves { campaign: &board.campaign.name, folder }
    }

    /// A job of work begins.
    pub fn begun(board: &'a Board<'_>, job: &'a Job) -> Self {
        Self::TaskBegun(About::new(board, job))
    }

    /// A job of work has come further.
    pub fn progress(board: &'a Board<'_>, job: &'a Job) -> Self {
        Self::Progress {
            about: About::new(board, job),
            rate_per_s: job.rate(),
            left_s: job.left().map(|left| left.as_secs_f64()),
            campaign_left_s: board.left().map(|left| left.as_secs_f64()),
            learning: job.learnt(),
        }
    }

    /// A job of work has ended.
    pub fn finished(board: &'a Board<'_>, job: &'a Job, note: &'a str, error: Option<&'a str>) -> Self {
        Self::TaskFinished {
            about: About::new(board, job),
            reused: job.before(),
            took_s: job.time().as_secs_f64(),
            rate_per_s: job.rate(),
            note,
            error,
            learning: job.learnt(),
        }
    }

    /// Prints it.
    pub fn tell(&self) {
        console::say(&serde_json::to_string(self).expect("texts and numbers have a form in JSON"));
    }
}

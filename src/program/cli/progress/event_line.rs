//! Events for programs: one JSON object a line on the output. `reports/README.md` explains them.

use std::collections::BTreeMap;
use std::path::Path;

use serde::Serialize;

use super::board::Board;
use super::job::Job;
use super::learnt::Learnt;
use crate::cli::console;

/// An event for programs.
#[derive(Debug, Serialize)]
#[serde(tag = "event", rename_all = "snake_case")]
pub enum EventLine<'a> {
    /// A campaign starts.
    CampaignBegun {
        campaign: &'a str,
        /// The number of each kind, such as `trainings`.
        #[serde(flatten)]
        jobs: BTreeMap<&'static str, usize>,
    },
    /// Learning curves grow in files of this folder while trainings run.
    LearningCurves { campaign: &'a str, folder: &'a Path },
    /// A job of work begins.
    TaskBegun(About<'a>),
    /// A job of work has come further; told about once a second.
    Progress {
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
        error: Option<&'a str>,
        /// What a training has learnt.
        #[serde(skip_serializing_if = "Option::is_none")]
        learning: Option<Learnt>,
    },
    /// A problem that does not end the run.
    Warning { campaign: &'a str, message: &'a str },
    /// A report is in its place.
    ReportWritten { campaign: &'a str, folder: &'a Path, complete: bool, tasks: usize, reused: usize },
    /// The overview of several reports is in its place.
    OverviewWritten { page: &'a Path },
    /// The program ends.
    RunEnded { exit_code: u8 },
}

/// A job of work, and how far it is.
#[derive(Debug, Serialize)]
pub struct About<'a> {
    campaign: &'a str,
    kind: &'static str,
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
    /// A job of a campaign, and how far it is now.
    pub fn new(board: &'a Board, job: &'a Job) -> Self {
        Self {
            campaign: &board.campaign,
            kind: job.kind.name,
            place: job.number,
            name: &job.name,
            done: job.done(),
            total: job.total,
            unit: job.kind.unit,
            time_s: board.began.elapsed().as_secs_f64(),
        }
    }
}

impl EventLine<'_> {
    /// Prints it.
    pub fn tell(&self) {
        console::say_object(self);
    }
}

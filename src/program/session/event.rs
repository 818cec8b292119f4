use std::path::Path;

use super::{CampaignOutcome, ShardReport};
use base::diagnostic::{Diagnostic, Sources};
use compile::Campaign;
use results::campaign::{self, Task};
use results::report::{Caution, Doubt};

/// What happens during a call of a session.
pub enum Event<'a> {
    /// The files were checked, with these diagnostics. [`Session::check`](super::Session::check) does not report this when all files could be read: its result
    /// has the diagnostics.
    Diagnostics(&'a [Diagnostic], &'a Sources),
    /// A fact that does not end the call.
    Notice(&'a Notice),
    /// The options and files are valid, and work starts now.
    Begun,
    /// These tasks of a campaign start now.
    TasksBegun(&'a Campaign, &'a [Task]),
    /// The learning curves of the campaign grow in files of this folder; before the first training that has updates to make.
    CurvesGrow(&'a Path),
    /// Something happens in the tasks that were begun last.
    Campaign(&'a campaign::Event<'a>),
    /// The last of the tasks has ended.
    TasksEnded,
    /// This number of all episodes of a stage was played; also at its start, and perhaps from several threads out of order.
    Played { stage: Stage, done: u64, all: u64 },
    /// A shard of a campaign was run.
    ShardEnded(&'a ShardReport),
    /// A campaign was run, and its report is in its place.
    Ended(&'a CampaignOutcome),
}

/// A stage of a call that plays many episodes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// A recheck meets the failures of the report again.
    Failures,
    /// The drivers of a recheck meet the fixed list of crossings.
    Crossings,
    /// The causes of failures are sought, in at most all of these episodes.
    Causes,
}

/// Observes the calls of a session.
pub trait Observer: Send + Sync {
    /// Called with what happens. It may be called from several threads.
    fn event(&self, event: &Event<'_>);
}

/// Ignores everything.
#[derive(Debug, Clone, Copy, Default)]
pub struct Silent;

impl Observer for Silent {
    fn event(&self, _: &Event<'_>) {}
}

/// A fact that does not end a call.
#[derive(Debug, thiserror::Error)]
pub enum Notice {
    /// A fact.
    #[error("{0}")]
    Note(String),
    /// A problem that does not end the call.
    #[error("{0}")]
    Warning(String),
    /// Warnings about the files, which the run of the present report has told.
    #[error("{warnings} warning{} about the files as before; `falsify check` tells {}", if *warnings == 1 { "" } else { "s" }, if *warnings == 1 { "it" } else { "them" })]
    ToldBefore { warnings: usize },
    #[error("a reward was no number in {episodes} episodes; the first: {first}")]
    Unpaid {
        campaign: String,
        episodes: u64,
        /// The first of them, with its reward.
        first: String,
    },
    #[error(
        "{errors} of {episodes} episodes are in error{} and count for nothing; the first is {first}",
        match (untried, are_few) {
            (_, true) => ", at most one in a hundred of those in other simulators,".into(),
            (0, _) => String::new(),
            _ => format!(", {untried} of them not run"),
        }
    )]
    EpisodesInError {
        campaign: String,
        errors: u64,
        episodes: u64,
        /// Those in error that were not simulated.
        untried: u64,
        /// The first of them, with its error.
        first: String,
        /// Whether the run does not fail by them.
        are_few: bool,
    },
    /// Trainings of a campaign may have learnt nothing, or disagree.
    #[error("{doubt}")]
    DoubtfulTraining {
        campaign: String,
        /// The reason, and what to try.
        doubt: Box<Doubt>,
    },
    /// What a reader must know before the figures of a campaign.
    #[error("{caution}")]
    Caution { campaign: String, caution: Box<Caution> },
}

/// How much a notice matters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Level {
    Note,
    Warning,
    Error,
}

impl Notice {
    /// How much it matters.
    pub fn level(&self) -> Level {
        match self {
            Self::Unpaid { .. } | Self::EpisodesInError { are_few: false, .. } => Level::Error,
            Self::Note(_) | Self::ToldBefore { .. } => Level::Note,
            _ => Level::Warning,
        }
    }
}

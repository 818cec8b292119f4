use std::path::PathBuf;
use std::time::Duration;

use super::Input;
use crate::report::{Formats, Gate};
use crate::store::Limits;

/// Options of [`Session::run`](super::Session::run).
#[derive(Debug, Clone)]
pub struct RunOptions {
    /// The files; their campaigns are run in order.
    pub input: Input,
    /// Folder for the reports, one folder in it for each campaign.
    pub out: PathBuf,
    /// Folder for finished and half-finished work, which several folders for reports may share; `OUT/.falsify` without it.
    pub cache: Option<PathBuf>,
    /// Number from which everything random follows.
    pub seed: u64,
    /// Threads that work; results do not depend on it. 0: one for each core.
    pub threads: u16,
    /// What each table of a report is written as.
    pub formats: Formats,
    /// Whether only enough is run to see that everything works; reports are then named `NAME-smoke`.
    pub smoke: bool,
    /// Whether all work is done again, also what is stored.
    pub fresh: bool,
    /// What a task may take, and how often it is saved.
    pub limits: Limits,
    /// Episodes that a report also holds tick by tick.
    pub ticks: Ticks,
    /// Conditions under which a campaign fails.
    pub gates: Vec<Gate>,
    /// How the caller goes on with this run, for `falsify status`; may be empty.
    pub command: String,
}

impl Default for RunOptions {
    /// Seed 1, all cores, all formats, reports in `reports`, checkpoints after five seconds.
    fn default() -> Self {
        Self {
            input: Input::default(),
            out: "reports".into(),
            cache: None,
            seed: 1,
            threads: 0,
            formats: Formats { csv: true, parquet: true },
            smoke: false,
            fresh: false,
            limits: Limits { checkpoint: Duration::from_secs(5), seconds: None, ticks: None },
            ticks: Ticks::None,
            gates: Vec::new(),
            command: String::new(),
        }
    }
}

/// Episodes that a report holds tick by tick.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Ticks {
    /// None.
    #[default]
    None,
    /// Those that end in a collision.
    Failures,
    /// All.
    All,
}

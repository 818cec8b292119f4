use std::path::PathBuf;
use std::time::Duration;

use super::Input;
use results::report::{Formats, Gate};
use results::store::Limits;

/// Options of [`Session::run`](super::Session::run).
#[derive(Debug, Clone)]
pub struct RunOptions {
    /// The files; their campaigns are run in order.
    pub input: Input,
    /// Folder for the reports, one folder in it for each campaign.
    pub out: PathBuf,
    /// Folder for finished and unfinished work, which several folders for reports may share; `OUT/.falsify` without it.
    pub cache: Option<PathBuf>,
    /// The seed of all random numbers.
    pub seed: u64,
    /// The number of threads; results do not depend on it. 0: one for each core.
    pub threads: u16,
    /// The file formats of the tables of a report.
    pub formats: Formats,
    /// Whether to run only a quick check of the whole pipeline. Reports are then named `NAME-smoke`.
    pub smoke: bool,
    /// Whether to repeat all work, also what is stored.
    pub fresh: bool,
    /// Whether a finished report of something else may be replaced.
    pub replace: bool,
    /// The limits of a task, and the time between its checkpoints.
    pub limits: Limits,
    /// Episodes that a report also holds tick by tick.
    pub ticks: Ticks,
    /// Folder for TensorBoard's event files of the trainings, `CAMPAIGN/TRAINING` below it; none without it.
    pub tensorboard: Option<PathBuf>,
    /// Conditions under which a campaign fails.
    pub gates: Vec<Gate>,
    /// The command that continues this run, for `falsify status`; may be empty.
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
            replace: false,
            limits: Limits { checkpoint: Duration::from_secs(5), seconds: None, ticks: None },
            ticks: Ticks::None,
            tensorboard: None,
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
    All,
}

use std::ops::RangeInclusive;
use std::path::PathBuf;
use std::time::Duration;

use clap::{Args, ValueEnum, value_parser};

use super::Input;
use results::report::{Formats, Gate};
use results::store::Limits;

/// Options of [`Session::run`](super::Session::run).
#[derive(Debug, Clone, Args)]
pub struct RunOptions {
    /// The files; their campaigns are run in order.
    #[arg(skip)]
    pub input: Input,
    /// Folder for the reports, one folder in it for each campaign.
    #[arg(long, short, default_value = "reports", env = "FALSIFY_OUT", value_name = "DIR", help_heading = "Output")]
    pub out: PathBuf,
    /// Folder for finished and unfinished work, which several folders for reports may share. Without it, OUT/.falsify.
    #[arg(long, env = "FALSIFY_CACHE", value_name = "DIR", help_heading = "Work")]
    pub cache: Option<PathBuf>,
    /// Seed of all random numbers.
    #[arg(long, default_value_t = 1, env = "FALSIFY_SEED", value_name = "N", value_parser = value_parser!(u64).range(..=i64::MAX as u64), help_heading = "What runs")]
    pub seed: u64,
    /// Number of threads; results do not depend on it. 0: one for every core.
    #[arg(long, short = 'j', default_value_t = 0, env = "FALSIFY_THREADS", value_name = "N", value_parser = value_parser!(u16).range(..=256), allow_negative_numbers = true, help_heading = "Work")]
    pub threads: u16,
    /// File formats of the tables of a report.
    #[arg(long, value_enum, value_delimiter = ',', default_values_t = [TableFormat::Csv, TableFormat::Parquet], env = "FALSIFY_FORMATS", value_name = "FORMATS", help_heading = "Output")]
    pub formats: Vec<TableFormat>,
    /// Write a dossier, too: what was tested, how far that reaches, what was found and why, as a page to print. Failures are repeated for it.
    #[arg(long, help_heading = "Output")]
    pub dossier: bool,
    /// Run only a quick check of the whole pipeline: one run, two updates, five episodes. Reports go to NAME-smoke.
    #[arg(long, help_heading = "What runs")]
    pub smoke: bool,
    /// Run only these campaigns of the files; may be given several times.
    #[arg(long, value_name = "CAMPAIGN", help_heading = "What runs")]
    pub only: Vec<String>,
    /// Repeat all work, also what is stored.
    #[arg(long, help_heading = "What runs")]
    pub fresh: bool,
    /// Replace a finished report of another scenario, setting or seed. Without it such a report is an error.
    #[arg(long, help_heading = "Output")]
    pub replace: bool,
    /// Seconds between saves of unfinished work: at most this much is lost when the program is killed.
    #[arg(long, default_value_t = 5.0, value_name = "SECONDS", value_parser = seconds, help_heading = "Work")]
    pub checkpoint: f64,
    /// Stop a training, 10,000 episodes or a search after this time (s). It is then in error, and the next run continues it. With 0 it ends
    /// after one update, if that takes less than a second, or one episode.
    #[arg(long, value_name = "SECONDS", help_heading = "Work")]
    pub task_time: Option<u64>,
    /// Stop them after this number of simulator ticks.
    #[arg(long, value_name = "N", value_parser = value_parser!(u64).range(1..), help_heading = "Work")]
    pub max_ticks: Option<u64>,
    /// The seeds, one after the other, instead of `seed`; their reports are pooled.
    #[arg(skip)]
    pub seeds: Option<RangeInclusive<u64>>,
    /// Conditions under which a campaign fails.
    #[arg(skip)]
    pub gates: Vec<Gate>,
    /// The command that continues this run, for `falsify status`; may be empty.
    #[arg(skip)]
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
            formats: vec![TableFormat::Csv, TableFormat::Parquet],
            dossier: false,
            smoke: false,
            only: Vec::new(),
            fresh: false,
            replace: false,
            checkpoint: 5.0,
            task_time: None,
            max_ticks: None,
            seeds: None,
            gates: Vec::new(),
            command: String::new(),
        }
    }
}

impl RunOptions {
    pub(crate) fn formats(&self) -> Formats {
        let named = |format| self.formats.contains(&format);
        Formats { csv: named(TableFormat::Csv), parquet: named(TableFormat::Parquet) }
    }

    pub(crate) fn limits(&self) -> Limits {
        let checkpoint = Duration::try_from_secs_f64(self.checkpoint).unwrap_or_default();
        Limits { checkpoint, seconds: self.task_time, ticks: self.max_ticks }
    }
}

/// Reads a time from 0.001 s to an hour (s).
///
/// # Errors
/// Another text, as clap shows it to the user.
pub(crate) fn seconds(text: &str) -> Result<f64, String> {
    let seconds: f64 = text.parse().map_err(|_| "not a number".to_string())?;
    if (0.001..=3600.0).contains(&seconds) { Ok(seconds) } else { Err("must be from 0.001 to 3600".into()) }
}

/// File formats of a table.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum TableFormat {
    /// Comma-separated values.
    Csv,
    /// Apache Parquet.
    Parquet,
}

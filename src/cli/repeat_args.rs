use std::path::PathBuf;
use std::str::FromStr;

use clap::Args;

use crate::compile::RunId;

pub(super) const REPLAY_EXAMPLES: &str = "\
Examples:
  falsify replay 1a2b3c4d:17                 repeat an episode of a report in reports/, tell what happened
  falsify replay 1a2b3c4d:17 --report nightly/first_look
                                             of that report
  falsify replay 1a2b3c4d:17 --ticks way.csv
                                             also write every tick as a table, .csv or .parquet

Names of failures are in failure_modes.csv (`example`), episodes.csv (`run_id`, `episode`) and search_failures.csv (`run_id`, `failure`).

Exit codes: 0 it came out as in the report   2 no such episode, or a file is missing   3 errors in a scenario
  6 a file cannot be written   8 it came out differently, or a scenario file is another one now";

pub(super) const RENDER_EXAMPLES: &str = "\
Examples:
  falsify render 1a2b3c4d:17                 1a2b3c4d-17.svg: six frames, and the speeds of both
  falsify render 1a2b3c4d:17 --animate -o hit.svg
                                             a picture that moves; open it in a browser

Exit codes: as those of `falsify replay`";

pub(super) const VERIFY_EXAMPLES: &str = "\
Examples:
  falsify verify reports/first_look          repeat 100 episodes, compare every column byte for byte
  falsify verify --all reports/first_look    all of them
  falsify verify --trainings reports/first_look
                                             also train every pedestrian again

Exit codes: 0 all are equal   2 no report   3 errors in a scenario   8 something came out differently";

/// The name of an episode or of a failure of a search, `RUN:EPISODE`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Name {
    /// The run or the search.
    pub run: RunId,
    /// Number of the episode, or of the failure of the search.
    pub number: u32,
}

impl FromStr for Name {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || "write RUN:EPISODE, as in 1a2b3c4d:17: eight hexadecimal digits and a number".to_string();
        let (run, number) = text.split_once(':').ok_or_else(wrong)?;
        let number = Some(number).filter(|number| number.bytes().all(|byte| byte.is_ascii_digit()));
        Ok(Self {
            run: run.parse().map_err(|_| wrong())?,
            number: number.and_then(|number| number.parse().ok()).ok_or_else(wrong)?,
        })
    }
}

impl std::fmt::Display for Name {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}:{}", self.run, self.number)
    }
}

/// Options of everything that repeats what a report holds.
#[derive(Debug, Args)]
pub struct RepeatOptions {
    /// Folder to which the scenario files' paths are relative, when it is not the one in which they were run.
    #[arg(long, value_name = "DIR")]
    pub files: Option<PathBuf>,
    /// Let scenarios start programs as drivers again; give it only with files that you trust.
    #[arg(long)]
    pub allow_external: bool,
    /// Go on although a scenario file is not the one that was run.
    #[arg(long)]
    pub anyway: bool,
}

/// Which episode, and where its report is.
#[derive(Debug, Args)]
pub struct NameOptions {
    /// The episode, or the failure of a search.
    #[arg(value_name = "RUN:EPISODE", value_parser = str::parse::<Name>)]
    pub name: Name,
    /// A report, or a folder of reports.
    #[arg(long, default_value = "reports", env = "FALSIFY_OUT", value_name = "DIR")]
    pub report: PathBuf,
    /// How it is repeated.
    #[command(flatten)]
    pub repeat: RepeatOptions,
}

/// Options of `falsify replay`.
#[derive(Debug, Args)]
pub struct ReplayOptions {
    /// Which episode.
    #[command(flatten)]
    pub which: NameOptions,
    /// Write every tick as a table; the end of the name says whether as .csv or .parquet.
    #[arg(long, value_name = "FILE", value_parser = table_file)]
    pub ticks: Option<PathBuf>,
    /// Tell it as one JSON object, for programs.
    #[arg(long)]
    pub json: bool,
}

fn table_file(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    let known = path.extension().is_some_and(|extension| extension == "csv" || extension == "parquet");
    if known { Ok(path) } else { Err("the name must end in .csv or .parquet".into()) }
}

/// Options of `falsify render`.
#[derive(Debug, Args)]
pub struct RenderOptions {
    /// Which episode.
    #[command(flatten)]
    pub which: NameOptions,
    /// The picture; by default RUN-EPISODE.svg in this folder.
    #[arg(long, short, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// One picture that moves, instead of six that stand.
    #[arg(long)]
    pub animate: bool,
}

/// Options of `falsify verify`.
#[derive(Debug, Args)]
pub struct VerifyOptions {
    /// A report.
    #[arg(value_name = "DIR")]
    pub report: PathBuf,
    /// How many episodes and failures of searches are repeated.
    #[arg(long, default_value_t = 100, value_name = "N")]
    pub sample: usize,
    /// Repeat all of them.
    #[arg(long, conflicts_with = "sample")]
    pub all: bool,
    /// Train every pedestrian again, too, and compare its networks.
    #[arg(long)]
    pub trainings: bool,
    /// Number from which the choice of the sample follows.
    #[arg(long, default_value_t = 1, value_name = "N")]
    pub seed: u64,
    /// How they are repeated.
    #[command(flatten)]
    pub repeat: RepeatOptions,
}

/// Options that make a run pass or fail.
#[derive(Debug, Default, Args)]
pub struct GateOptions {
    /// Fail (exit code 7) when a cell is so, as 'preventable_rate > 0.05' or 'collision_rate_wilson_low > 0.2 and town == village':
    /// columns of the table `cells`; may be given several times.
    #[arg(long, value_name = "CONDITION")]
    pub fail_if: Vec<String>,
    /// Also write what came out as JUnit XML, one test case for each cell.
    #[arg(long, value_name = "FILE")]
    pub junit: Option<PathBuf>,
}

/// Which episodes a report holds tick by tick.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum TickChoice {
    /// None.
    None,
    /// The collisions.
    Failures,
    /// All.
    All,
}

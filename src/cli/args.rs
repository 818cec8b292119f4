use std::path::PathBuf;

use super::later::Later;
use super::repeat_args::{
    GateOptions, RENDER_EXAMPLES, REPLAY_EXAMPLES, RenderOptions, ReplayOptions, TickChoice, VERIFY_EXAMPLES,
    VerifyOptions,
};
use super::shard::Named as Shard;
use clap::{Args, Parser, Subcommand, ValueEnum};

use crate::compile::Overrides;

const EXAMPLES: &str = "\
Examples:
  falsify run scenarios/*.scn                run all campaigns, reports go to reports/
  falsify run --smoke scenarios/*.scn        see in seconds whether everything works
  falsify run --list scenarios/*.scn         see what would be run and why, and what is there already
  falsify run --set 'ppo_paper.steps=10000' my.scn
                                             change a value without touching the file
  falsify run --fail-if 'preventable_rate > 0.05' --junit out.xml my.scn
                                             pass or fail, for continuous integration
  falsify replay 1a2b3c4d:17                 see a failure again, `render` draws it
  falsify check my.scn                       find mistakes without running anything
  falsify check --sample 1000 my.scn         see where episodes would begin, and what is rejected
  falsify av check -- python3 my_av.py       see whether a driver of your own speaks the protocol
  falsify new my.scn                         begin with a commented file
  falsify explain missing-unit               what a message means
  falsify map Town02.xodr --waypoints 2      draw a map, list what it holds

Exit codes:
  0 done   1 internal error   2 wrong usage or missing file   3 errors in a scenario
  4 nothing to run   5 a run or a driver failed   6 a report cannot be written   7 a --fail-if holds
  8 what was repeated came out differently   9 cells to merge are missing   130 stopped by Ctrl-C or SIGTERM";

/// Finds the ways a self-driving car hits a pedestrian.
#[derive(Debug, Parser)]
#[command(version, after_help = EXAMPLES, max_term_width = 100)]
pub struct Arguments {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
    /// When to colour the output.
    #[arg(long, global = true, value_enum, default_value_t = Colouring::Auto, value_name = "WHEN")]
    pub color: Colouring,
}

/// What the program can do.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Train pedestrians and try them, as the campaigns of the files say.
    #[command(after_help = EXAMPLES)]
    Run(Later<RunOptions>),
    /// Put together what the shards of a run have made, and write its reports.
    #[command(after_help = MERGE_EXAMPLES)]
    Merge(Later<MergeOptions>),
    /// Say how far the campaigns of a folder are, whether anybody is at work on them, and how to go on.
    #[command(after_help = STATUS_EXAMPLES)]
    Status(Later<StatusOptions>),
    /// Show the settings of this folder, from flags, the environment and falsify.toml.
    #[command(after_help = CONFIG_EXAMPLES)]
    Config,
    /// Repeat an episode of a report, tell what happened in it and whether it is the same.
    #[command(after_help = REPLAY_EXAMPLES)]
    Replay(Later<ReplayOptions>),
    /// Draw an episode of a report, as a strip of six pictures or as one that moves.
    #[command(after_help = RENDER_EXAMPLES)]
    Render(Later<RenderOptions>),
    /// Repeat a sample of what a report holds and compare it byte for byte.
    #[command(after_help = VERIFY_EXAMPLES)]
    Verify(Later<VerifyOptions>),
    /// Say how much finished work is kept for the campaigns of a folder, and remove what none of them wants any more.
    #[command(after_help = CELLS_EXAMPLES)]
    Cells(Later<CellsOptions>),
    /// Find mistakes in scenario files without running anything.
    #[command(after_help = CHECK_EXAMPLES)]
    Check(Later<CheckOptions>),
    /// Explain a diagnostic, a form, a kind or a key of the language.
    #[command(after_help = EXPLAIN_EXAMPLES)]
    Explain(Later<ExplainOptions>),
    /// Write a commented scenario to begin with.
    #[command(after_help = NEW_EXAMPLES)]
    New(Later<NewOptions>),
    /// Give scenario files their canonical layout.
    #[command(after_help = FMT_EXAMPLES)]
    Fmt(Later<FmtOptions>),
    /// Draw a town, and say what its map holds and what was skipped.
    #[command(after_help = MAP_EXAMPLES)]
    Map(Later<MapOptions>),
    /// Work on a driver of your own.
    #[command(subcommand)]
    Av(AvCommand),
    /// Show what becomes of a file on the way to a run.
    #[command(after_help = DEBUG_EXAMPLES)]
    Debug(Later<DebugOptions>),
    /// Serve an editor: mistakes, help, completion, definitions, layout. It speaks the language server protocol on the standard streams.
    #[command(after_help = LSP_EXAMPLES)]
    Lsp {
        /// Accepted because many editors pass it; there is no other way.
        #[arg(long)]
        stdio: bool,
    },
    /// Print a completion script for a shell.
    #[command(after_help = COMPLETIONS_EXAMPLES)]
    Completions {
        /// The shell.
        shell: clap_complete::Shell,
    },
}

/// Options of `falsify run`.
#[derive(Debug, Args)]
pub struct RunOptions {
    /// Scenario files; their campaigns are run in order.
    #[arg(required = true, value_name = "FILE")]
    pub files: Vec<PathBuf>,
    /// What replaces parts of the files.
    #[command(flatten)]
    pub given: GivenOptions,
    /// Folder for the reports, one folder in it for each campaign.
    #[arg(long, short, default_value = "reports", env = "FALSIFY_OUT", value_name = "DIR")]
    pub out: PathBuf,
    /// Folder for finished and half-finished work, which several folders for reports may share. Without it, OUT/.cells.
    #[arg(long, env = "FALSIFY_CACHE", value_name = "DIR")]
    pub cache: Option<PathBuf>,
    /// Number from which everything random follows.
    #[arg(long, default_value_t = 1, env = "FALSIFY_SEED", value_name = "N", value_parser = clap::value_parser!(u64).range(..=i64::MAX as u64))]
    pub seed: u64,
    /// Threads that work; results do not depend on it. 0: one for every core.
    #[arg(long, short = 'j', default_value_t = 0, env = "FALSIFY_THREADS", value_name = "N", value_parser = clap::value_parser!(u16).range(..=256), allow_negative_numbers = true)]
    pub threads: u16,
    /// Files that each table of a report is written as.
    #[arg(long, value_enum, value_delimiter = ',', default_values_t = [TableFormat::Csv, TableFormat::Parquet], env = "FALSIFY_FORMATS", value_name = "FORMATS")]
    pub formats: Vec<TableFormat>,
    /// What the output is for; `json` is one event a line (reports/README.md).
    #[arg(long, value_enum, default_value_t = Output::Human, env = "FALSIFY_FORMAT", value_name = "FORMAT")]
    pub format: Output,
    /// How progress is shown on the error stream.
    #[arg(long, value_enum, default_value_t = Showing::Auto, env = "FALSIFY_PROGRESS", value_name = "HOW")]
    pub progress: Showing,
    /// Say what would be run and why, and what is there already; then stop.
    #[arg(long)]
    pub list: bool,
    /// Run only enough to see that everything works: one run, two updates, five episodes. Reports go to NAME-smoke.
    #[arg(long)]
    pub smoke: bool,
    /// Do everything again, whatever is there.
    #[arg(long)]
    pub fresh: bool,
    /// Do one of several parts, as 3/16, and write no report; `auto/16` takes the number from SLURM_ARRAY_TASK_ID or JOB_COMPLETION_INDEX.
    #[arg(long, value_name = "I/N", conflicts_with_all = ["fresh", "list", "ticks", "fail_if", "junit"])]
    pub shard: Option<Shard>,
    /// Of a shard, do only these; other shards then find them.
    #[arg(long, value_enum, value_name = "CELLS", requires = "shard")]
    pub only: Option<Only>,
    /// Seconds after which what is under way is saved, so that no more is lost when the program is killed.
    #[arg(long, default_value_t = 5.0, value_name = "SECONDS", value_parser = seconds)]
    pub checkpoint: f64,
    /// Give a training, 10,000 episodes or a search up after so many seconds; it is an error then, and goes on in the next run. With 0 it
    /// gets no further than one update or episode.
    #[arg(long, value_name = "SECONDS")]
    pub cell_time: Option<u64>,
    /// Give them up after so many simulator ticks.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    pub max_ticks: Option<u64>,
    /// Which episodes are also written tick by tick, as ticks.parquet; they are simulated once more for it.
    #[arg(long, value_enum, default_value_t = TickChoice::None, value_name = "WHICH")]
    pub ticks: TickChoice,
    /// What makes it pass or fail.
    #[command(flatten)]
    pub gate: GateOptions,
}

const CELLS_EXAMPLES: &str = "\
Examples:
  falsify cells                              what is kept in reports/.cells, by campaign
  falsify cells --prune                      remove what belongs to no campaign as it was run last
  falsify cells --cache /scratch/cells --prune --gone
                                             of a shared folder, also what was for reports that are deleted now";

/// Options of `falsify cells`.
#[derive(Debug, Args)]
pub struct CellsOptions {
    /// The folder for reports.
    #[arg(default_value = "reports", env = "FALSIFY_OUT", value_name = "DIR")]
    pub out: PathBuf,
    /// The folder that `run` was given as --cache.
    #[arg(long, env = "FALSIFY_CACHE", value_name = "DIR")]
    pub cache: Option<PathBuf>,
    /// Remove cells that no campaign wanted when it was run last, whichever folder for reports it was run for.
    #[arg(long)]
    pub prune: bool,
    /// Also give up what was run for folders that are not there, or not to be seen from here.
    #[arg(long, requires = "prune")]
    pub gone: bool,
}

/// What of a shard is done.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Only {
    /// Its trainings, each by one shard.
    Trainings,
}

/// Options of `falsify run` that say how to work, which a merge does not.
const IDLE: [&str; 7] = ["list", "fresh", "shard", "only", "checkpoint", "cell_time", "max_ticks"];

/// Options of `falsify merge`. What means nothing there is left out of the help.
#[derive(Debug, Args)]
#[command(mut_args(|arg| if IDLE.contains(&arg.get_id().as_str()) { arg.hide(true) } else { arg }))]
pub struct MergeOptions {
    /// What was run.
    #[command(flatten)]
    pub run: RunOptions,
    /// Folders with the cells of shards, their --out or their --cache, beside those that are in the folder for the reports already.
    #[arg(long, num_args = 1.., value_name = "DIR")]
    pub from: Vec<PathBuf>,
    /// How many shards there were, to be told which of them to do again.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub shards: Option<u32>,
    /// Write what is there as NAME-partial even if something is missing.
    #[arg(long)]
    pub partial: bool,
}

/// Options of `falsify status`.
#[derive(Debug, Args)]
pub struct StatusOptions {
    /// The folder for the reports.
    #[arg(default_value = "reports", env = "FALSIFY_OUT", value_name = "DIR")]
    pub out: PathBuf,
    /// The folder that `run` was given as --cache.
    #[arg(long, env = "FALSIFY_CACHE", value_name = "DIR")]
    pub cache: Option<PathBuf>,
    /// What the output is for; `json` is one object for each campaign.
    #[arg(long, value_enum, default_value_t = Output::Human, env = "FALSIFY_FORMAT", value_name = "FORMAT")]
    pub format: Output,
}

const STATUS_EXAMPLES: &str = "\
Examples:
  falsify status                             the campaigns of reports/
  falsify status --format json shared        one JSON object for each campaign, for programs

Exit codes: 0 finished or at work   2 nothing was run there   9 something is missing and nobody is at work on it";

const MERGE_EXAMPLES: &str = "\
Examples:
  falsify run --shard 0/2 --out a my.scn     on one machine
  falsify run --shard 1/2 --out b my.scn     on another one
  falsify merge my.scn --from a b --out reports --shards 2
                                             the report that one machine would have written, byte for byte
  falsify merge my.scn --out shared          when all shards wrote to one folder

Exit codes: 0 done   9 cells are missing, which are named, with the shards that make them   others as of `run`";

/// What a table is written as.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum TableFormat {
    /// Comma-separated values.
    Csv,
    /// Apache Parquet.
    Parquet,
}

/// Who reads the output of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Output {
    /// Tables for people.
    Human,
    /// One JSON object a line, for programs.
    Json,
}

/// How progress is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Showing {
    /// Bars on a terminal, lines elsewhere.
    Auto,
    /// Bars for what is under way, with rates and the time left.
    Bars,
    /// A line for each piece that is finished.
    Lines,
    /// Not at all.
    None,
}

const CONFIG_EXAMPLES: &str = "\
Examples:
  falsify config                             every setting, its value and where it comes from
  falsify config --seed 7 > falsify.toml     begin a file of settings

A flag comes before the environment, which comes before falsify.toml, in this folder or the nearest one above.";

/// Options of `falsify check`.
#[derive(Debug, Args)]
pub struct CheckOptions {
    /// How mistakes are shown.
    #[arg(long, value_enum, default_value_t = Format::Human, value_name = "FORMAT")]
    pub format: Format,
    /// Scenario files.
    #[arg(required = true, value_name = "FILE")]
    pub files: Vec<PathBuf>,
    /// What replaces parts of the files.
    #[command(flatten)]
    pub given: GivenOptions,
    /// Also draw so many beginnings of every spawn in every town, and say how many satisfy each constraint; also where nobody
    /// can be placed, to see what stands in the way. Not with SARIF, which has no place for it.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000_000))]
    pub sample: Option<u32>,
    /// Folder for the pictures of `--sample`, `spawn-CAMPAIGN-SPAWN-TOWN.svg`.
    #[arg(long, short, default_value = ".", value_name = "DIR", requires = "sample")]
    pub out: PathBuf,
    /// Number from which the beginnings of `--sample` follow.
    #[arg(long, default_value_t = 1, value_name = "N", requires = "sample")]
    pub seed: u64,
}

/// Options that replace parts of the files.
#[derive(Debug, Default, Args)]
pub struct GivenOptions {
    /// Take the roads of a town from an OpenDRIVE map instead; buildings are kept.
    #[arg(long, value_name = "TOWN=FILE", value_parser = town_and_file)]
    pub map: Vec<(String, PathBuf)>,
    /// Give a parameter or a key of a declaration another value, as `far=20 m` or `ppo_paper.steps=1000`.
    #[arg(long, value_name = "NAME=VALUE")]
    pub set: Vec<String>,
    /// Let scenarios name programs as drivers, which `run` starts; give it only with files that you trust.
    #[arg(long)]
    pub allow_external: bool,
}

impl GivenOptions {
    /// What they replace.
    pub fn overrides(&self) -> Overrides {
        let (maps, settings) = (self.map.iter().cloned().collect(), self.set.clone());
        Overrides { maps, settings, ..Overrides::default() }
    }
}

fn town_and_file(text: &str) -> Result<(String, PathBuf), String> {
    let (town, file) = text.split_once('=').ok_or("write TOWN=FILE")?;
    Ok((town.to_string(), PathBuf::from(file)))
}

const CHECK_EXAMPLES: &str = "\
Examples:
  falsify check my.scn                       draw every mistake under its line
  falsify check --format json my.scn         one JSON object a line, for programs
  falsify check --format sarif my.scn        SARIF 2.1.0, which code hosts show beside the lines
  falsify check --sample 1000 --format json my.scn
                                             where episodes would begin, for programs

Exit codes: 0 no errors   2 missing file   3 errors";

/// How mistakes are shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// Drawn under the line, on the error stream.
    Human,
    /// One JSON object a line, on the output.
    Json,
    /// A SARIF 2.1.0 log, on the output.
    Sarif,
}

const EXPLAIN_EXAMPLES: &str = "\
Examples:
  falsify explain                            list everything
  falsify explain missing-unit               a diagnostic, with a bad and a good example
  falsify explain policy idm                 the keys of a kind, with types, units and defaults
  falsify explain training ppo gamma         one key
  falsify explain matrix                     a word of the language, with an example";

/// Options of `falsify explain`.
#[derive(Debug, Args)]
pub struct ExplainOptions {
    /// A code; a form, a form and a kind, and a key of it; a word such as `param` or `normal`; an event, a variable; or `events`,
    /// `variables`, `units`.
    #[arg(value_name = "WORD")]
    pub words: Vec<String>,
}

const NEW_EXAMPLES: &str = "\
Examples:
  falsify new                                write scenario.scn
  falsify new night.scn && falsify run --smoke night.scn";

/// Options of `falsify new`.
#[derive(Debug, Args)]
pub struct NewOptions {
    /// The file; one that exists is never replaced.
    #[arg(default_value = "scenario.scn", value_name = "PATH")]
    pub path: PathBuf,
}

const DEBUG_EXAMPLES: &str = "\
Examples:
  falsify debug ast my.scn                   what was written
  falsify debug hir my.scn                   what is meant: names resolved, SI values, defaults filled in
  falsify debug plan my.scn                  what would be run, with every figure
  falsify debug hir --set 'far=20 m' my.scn  the same with another value";

/// Options of `falsify debug`.
#[derive(Debug, Args)]
pub struct DebugOptions {
    /// Which tree.
    #[arg(value_enum)]
    pub tree: Tree,
    /// A scenario file.
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
    /// What replaces parts of the file; maps matter to the plan alone.
    #[command(flatten)]
    pub given: GivenOptions,
}

/// What can be shown of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Tree {
    /// What was written.
    Ast,
    /// What is meant: names resolved, SI values, defaults filled in.
    Hir,
    /// What would be run.
    Plan,
}

const LSP_EXAMPLES: &str = "\
Examples (see grammar/README.md for editors' settings):
  falsify lsp                                an editor starts it and speaks to it";

const COMPLETIONS_EXAMPLES: &str = "\
Examples:
  falsify completions bash > ~/.local/share/bash-completion/completions/falsify";

const MAP_EXAMPLES: &str = "\
Examples:
  falsify map Town02.xodr                    Town02.svg, and what the map holds
  falsify map my.scn --out maps              every town of a scenario, imported ones, too";

const FMT_EXAMPLES: &str = "\
Examples:
  falsify fmt my.scn                         lay the file out anew
  falsify fmt --check scenarios/*.scn        only say which files are not laid out; exit code 3 if any is not
  falsify fmt --stdin < my.scn               for editors: from the input to the output";

/// Options of `falsify fmt`.
#[derive(Debug, Args)]
pub struct FmtOptions {
    /// Scenario files.
    #[arg(required_unless_present = "stdin", value_name = "FILE")]
    pub files: Vec<PathBuf>,
    /// Change nothing; name the files that would change.
    #[arg(long)]
    pub check: bool,
    /// Read from the input and write to the output.
    #[arg(long, conflicts_with = "files")]
    pub stdin: bool,
}

/// Options of `falsify map`.
#[derive(Debug, Args)]
pub struct MapOptions {
    /// An OpenDRIVE map, or a scenario file with towns.
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
    /// Folder for the picture, `NAME.svg`.
    #[arg(long, short, default_value = ".", value_name = "DIR")]
    pub out: PathBuf,
    /// Also write the waypoints of all driving lanes, so many metres apart, as CARLA would: `NAME_waypoints.csv`.
    #[arg(long, value_name = "METRES", value_parser = spacing)]
    pub waypoints: Option<f64>,
}

fn spacing(text: &str) -> Result<f64, String> {
    let spacing: f64 = text.parse().map_err(|_| "not a number".to_string())?;
    if (0.01..=1000.0).contains(&spacing) { Ok(spacing) } else { Err("must be from 0.01 to 1000".into()) }
}

/// What can be done with a driver.
#[derive(Debug, Subcommand)]
pub enum AvCommand {
    /// See whether a program speaks the protocol of scenarios/external/README.md and drives the same way twice.
    Check(AvCheckOptions),
}

/// Options of `falsify av check`.
#[derive(Debug, Args)]
pub struct AvCheckOptions {
    /// The program and its arguments, after `--`.
    #[arg(required = true, last = true, value_name = "COMMAND")]
    pub command: Vec<String>,
    /// Seconds that it has for the answer to a tick.
    #[arg(long, default_value_t = 1.0, value_name = "SECONDS", value_parser = seconds)]
    pub timeout: f64,
    /// Seconds that it has for its greeting.
    #[arg(long, default_value_t = 30.0, value_name = "SECONDS", value_parser = seconds)]
    pub start_timeout: f64,
    /// Show the first messages.
    #[arg(long)]
    pub show: bool,
}

fn seconds(text: &str) -> Result<f64, String> {
    let seconds: f64 = text.parse().map_err(|_| "not a number".to_string())?;
    if (0.001..=3600.0).contains(&seconds) { Ok(seconds) } else { Err("must be from 0.001 to 3600".into()) }
}

/// When to colour the output.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum Colouring {
    /// On a terminal, unless NO_COLOR is set.
    Auto,
    /// Always.
    Always,
    /// Never.
    Never,
}

impl Colouring {
    /// Makes it hold for everything that is printed.
    pub fn apply(self) {
        let choice = match self {
            Self::Auto => anstream::ColorChoice::Auto,
            Self::Always => anstream::ColorChoice::Always,
            Self::Never => anstream::ColorChoice::Never,
        };
        choice.write_global();
    }
}

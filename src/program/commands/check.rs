mod driver_trial;
mod world_trial;
mod manoeuvres;
mod empty_road;
mod sample;
mod fix;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::{Args, ValueEnum};

use crate::cli::console;
use crate::cli::failure::{failed, misused};
use crate::cli::input::{GivenArgs, checking_session, session_through};
use crate::exit_code::{Ended, ExitCode};
use crate::session::{Checked, Disk, Error};
use base::diagnostic::records;
use base::files;
use driver_trial::{TrialArgs, try_declared, try_driver};
use fix::fix;
use lang::{Reader, reason};
use world::av::external::Opener;
use world_trial::{compare_lanes, try_world};

pub const EXAMPLES: &str = "\
Examples:
  falsify check my.scn                       draw every error under its line
  falsify check --fix my.scn                 repair what a message says how to repair
  falsify check - < my.scn                   from the standard input
  falsify check --format json my.scn         one JSON object a line, for programs
  falsify check --sample 1000 --format json my.scn
                                             where episodes would start, for programs
  falsify check -- python3 my_av.py          see whether a driver of your own speaks the protocol of
                                             scenarios/external/README.md and drives the same way twice
  falsify check --driver sumo                the same for a driver that others wrote; says what is not installed
  falsify check my.scn --driver mine --allow-external
                                             the same for a driver of a file, as it is declared there: its keys,
                                             parameters, sensors and number of worlds, its towns and its car
  falsify check --world 'python3 mine.py'    see whether a bridge to another simulator speaks the protocol of
                                             docs/src/how-to/worlds.md, and moves cars and pedestrians as it is told
  falsify check --world metadrive my.scn     compare the lanes of the towns in a file

Exit codes: 0 no errors   2 missing file   3 errors   5 the driver or the world failed";

/// Options of `falsify check`.
#[derive(Debug, Args)]
pub struct CheckArgs {
    /// Format of the diagnostics.
    #[arg(long, value_enum, default_value_t = Format::Human, value_name = "FORMAT")]
    pub format: Format,
    /// Scenario files; `-` is the standard input.
    #[arg(required_unless_present = "tried", conflicts_with = "driver", value_name = "FILE")]
    pub files: Vec<PathBuf>,
    /// Replacements of parts of the files.
    #[command(flatten)]
    pub given: GivenArgs,
    /// Apply each repair that a message offers without an alternative, then check again.
    #[arg(long, conflicts_with_all = ["map", "set", "tried"])]
    pub fix: bool,
    /// Also draw this number of starts of every spawn in every town, and show how many satisfy each constraint. This includes spawns that
    /// cannot place a pedestrian.
    #[arg(long, value_name = "N", conflicts_with = "tried", value_parser = clap::value_parser!(u32).range(1..=10_000_000))]
    pub sample: Option<u32>,
    /// Folder for the pictures of `--sample`, `spawn-CAMPAIGN-SPAWN-TOWN.svg`.
    #[arg(long, short, default_value = ".", value_name = "DIR", requires = "sample")]
    pub out: PathBuf,
    /// Seed of the starts of `--sample`.
    #[arg(long, default_value_t = 1, value_name = "N", requires = "sample")]
    pub seed: u64,
    /// A driver of your own instead of files.
    #[command(flatten)]
    pub trial: TrialArgs,
}

/// Format of the diagnostics.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// Drawn under the line, on the error stream.
    Human,
    /// One JSON object a line, on the output.
    Json,
}

/// The name of the standard input among the files.
const INPUT: &str = "-";

/// Reads the standard input under the name `-`, and files.
struct InputAndFiles(String);

impl Reader for InputAndFiles {
    fn text(&self, path: &Path) -> std::io::Result<String> {
        if path == Path::new(INPUT) { Ok(self.0.clone()) } else { Disk.text(path) }
    }

    fn bytes(&self, path: &Path) -> std::io::Result<Vec<u8>> {
        Disk.bytes(path)
    }

    fn identity(&self, path: &Path) -> PathBuf {
        Disk.identity(path)
    }
}

pub fn check(options: &CheckArgs) -> Ended {
    if let Some(world) = &options.trial.world {
        return if options.files.is_empty() {
            Ok(try_world(&options.trial, world))
        } else {
            compare_lanes(options, world)
        };
    }
    let words = options.trial.words().filter(|_| options.files.is_empty());
    if let Some(words) = words {
        return Ok(try_driver(&options.trial, words));
    }
    // The words of a driver's command without `--` before them.
    if let [first, .., last] = options.files.as_slice()
        && !first.exists()
        && first.extension().is_none()
        && last.extension().is_none_or(|kind| kind != "scn")
    {
        let words: Vec<String> = options.files.iter().map(|file| file.display().to_string()).collect();
        return Err(misused(format!(
            "there is no file `{}`; to try a driver, write `falsify check -- {}`",
            first.display(),
            words.join(" ")
        )));
    }
    let input = options.given.input(&options.files);
    let declared = options.trial.stack.as_deref();
    let opener = || options.given.allow_external.then(|| Arc::new(options.trial.opener()) as Arc<dyn Opener>);
    let checking = || checking_session(options.given.allow_external);
    let mut session = declared.map_or_else(checking, |_| session_through(opener()));
    if options.files.iter().any(|file| file.as_os_str() == INPUT) {
        if options.fix {
            return Err(misused("--fix changes files, and `-` is the standard input"));
        }
        let text = files::text_of(std::io::stdin());
        let text = text.map_err(|error| misused(format!("cannot read the standard input: {}", reason(&error))))?;
        session = session.with_reader(InputAndFiles(text));
    }
    if let Some(name) = declared {
        return try_declared(&session.plan(&input).map_err(failed)?.plan, name).map_err(misused);
    }
    let found = if options.fix { fix(&session, &input)? } else { session.check(&input).map_err(failed)? };
    let checked = match options.format {
        Format::Human => for_people(&found),
        Format::Json => json(&found),
    };
    let plan = found.compiled.plan.as_ref().or(found.compiled.unplaced.as_ref());
    let sampled = options.sample.zip(plan).map(|(count, plan)| sample::sample(plan, count, options));
    // The program ends here; taking the plan apart first costs time.
    std::mem::forget(found);
    if checked == ExitCode::Done { sampled.unwrap_or(Ok(checked)) } else { Ok(checked) }
}

fn for_people(found: &Checked) -> ExitCode {
    console::show(&found.compiled.diagnostics, &found.sources);
    let plan = match found.plan() {
        Ok(plan) => plan,
        Err(error @ Error::Scenario { .. }) => {
            console::fail(&format!("{} found", console::count(found.errors(), "error")));
            return error.exit_code();
        }
        Err(other) => return failed(other),
    };
    let own = found.records.iter().filter(|record| !lang::library::holds(std::path::Path::new(&record.path))).count();
    let files = console::count(own, "file");
    let campaigns = console::count(plan.campaigns.len(), "campaign");
    plan.settings.iter().for_each(|setting| console::note(&setting.to_string()));
    console::say(&format!("{files} and {campaigns} checked: no errors"));
    let carried = plan.drivers.iter().filter_map(|driver| Some((&driver.name, driver.carries.as_ref()?)));
    carried.for_each(|(name, carries)| console::say(&format!("driver {name} {carries}")));
    if plan.campaigns.is_empty() && !plan.imported_campaigns.is_empty() {
        console::say(&plan.without_campaigns());
    }
    ExitCode::Done
}

/// Maximum number of diagnostics that are written for programs.
const MAX_LISTED: usize = 1_000;

/// Prints the diagnostics for programs, one object a line.
fn json(found: &Checked) -> ExitCode {
    let all = &found.compiled.diagnostics;
    if all.len() > MAX_LISTED {
        console::note(&format!("the first {MAX_LISTED} of {} are listed", console::count(all.len(), "mistake")));
    }
    console::say_objects(&records(&all[..all.len().min(MAX_LISTED)], &found.sources));
    if found.errors() > 0 { ExitCode::Scenario } else { ExitCode::Done }
}

//! A first result without a file: the scenario is inside the program.

use std::path::{Path, PathBuf};

use clap::{Args, Command, FromArgMatches};

use super::new::write_new;
use super::run::{self, RunArgs};
use crate::cli::console;
use crate::cli::failure::unwritten;
use crate::exit_code::{Ended, ExitCode};

pub const EXAMPLES: &str = "\
Examples:
  falsify demo                               falsify-demo/demo/report.html
  falsify demo --out /tmp/look";

/// Options of `falsify demo`.
#[derive(Debug, Args)]
pub struct DemoArgs {
    /// Folder for the scenario and its report.
    #[arg(long, short, default_value = "falsify-demo", value_name = "DIR")]
    pub out: PathBuf,
    /// Run only a quick check of the whole pipeline.
    #[arg(long)]
    pub smoke: bool,
}

const SCENARIO: &str = include_str!("templates/demo.scn");

pub fn demo(options: &DemoArgs) -> Ended {
    let file = options.out.join("demo.scn");
    place(&file)?;
    console::note(
        "two pedestrians learn to cause collisions, and a search looks for faults of its driver: about ten seconds",
    );
    let code = run::run(&run_options(&file, options))?;
    if code == ExitCode::Done {
        let report = options.out.join(if options.smoke { "demo-smoke" } else { "demo" });
        console::say(&format!("open {} in a browser", report.join("report.html").display()));
        console::say(&format!("next: read {}, or write a scenario with: falsify new my.scn", file.display()));
    }
    Ok(code)
}

/// Writes the scenario. A file with the same text stays.
///
/// # Errors
/// The exit code, after the reason has been printed.
fn place(file: &Path) -> Result<(), ExitCode> {
    if base::files::text(file).is_ok_and(|text| text == SCENARIO) {
        return Ok(());
    }
    if let Some(folder) = file.parent()
        && let Err(error) = std::fs::create_dir_all(folder)
    {
        return Err(unwritten(format!("cannot make the folder `{}`: {error}", folder.display())));
    }
    write_new(file, SCENARIO)
}

/// The options of `falsify run` for this file, with the settings of the environment.
fn run_options(file: &Path, options: &DemoArgs) -> RunArgs {
    let mut words = vec!["run".into(), file.as_os_str().to_owned(), "--out".into(), options.out.as_os_str().to_owned()];
    // Its scenario never changes, so what is there is the same report of this or of another version of the program.
    words.push("--replace".into());
    if options.smoke {
        words.push("--smoke".into());
    }
    let matches = RunArgs::augment_args(Command::new("run").disable_help_flag(true)).get_matches_from(words);
    RunArgs::from_arg_matches(&matches).expect("the words are those of `falsify run`")
}

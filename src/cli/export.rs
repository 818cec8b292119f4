use std::path::PathBuf;

use clap::builder::PossibleValue;
use clap::{Args, ValueEnum};

use super::episode::{Named, RepeatOptions, resolved};
use super::exit_code::ExitCode;
use super::input::session;
use super::{console, failure};
use crate::export::{self, EXPORTERS, EgoDriver, Exporter, Variant, Walking};
use crate::session;

/// Shown after the help.
pub const EXAMPLES: &str = "\
Examples:
  falsify export 1a2b3c4d:17 --as xosc-1.3   1a2b3c4d-17.xosc and its map, both actors on their tracks
  falsify export 1a2b3c4d:17 --as xosc-1.3 --ego user --pedestrians released
                                             drive against the pedestrian with your own controller
  falsify export 1a2b3c4d:17 5e6f7a8b:0 --as xodr --out maps
                                             several episodes, into a folder
  falsify failures reports/first_look --names --top 5 | falsify export - --as osi
                                             the five worst failures of a report
  falsify export 1a2b3c4d:17 --as carla --ego user
                                             a script for CARLA in which its agent drives
  falsify export --formats                   list the formats and what each approximates

Exit codes: 0 done   2 no such episode, or the format cannot represent it   3 errors in a scenario
  6 a file cannot be written, or its encoder is missing   8 an episode differs from its report, or a scenario file has changed";

/// Options of `falsify export`.
#[derive(Debug, Args)]
pub struct ExportOptions {
    /// Episodes, or failures of searches; a path before the name is that of the report. `-` reads names from the input, one a line.
    #[arg(value_name = "[PATH/]RUN:EPISODE", required_unless_present = "formats", value_parser = str::parse::<Named>)]
    pub names: Vec<Named>,
    /// The format.
    #[arg(long = "as", value_name = "FORMAT", required_unless_present = "formats", value_parser = format)]
    pub format: Option<Format>,
    /// List the formats.
    #[arg(long)]
    pub formats: bool,
    /// The driver of the ego.
    #[arg(long, value_enum, default_value = "recorded")]
    pub ego: EgoDriver,
    /// When the pedestrians walk.
    #[arg(long, value_enum, default_value = "recorded")]
    pub pedestrians: Walking,
    /// The folder for the files.
    #[arg(long, short, default_value = ".", value_name = "DIR")]
    pub out: PathBuf,
    /// A report, or a folder of reports.
    #[arg(long, default_value = "reports", env = "FALSIFY_OUT", value_name = "DIR")]
    pub report: PathBuf,
    /// Options of the repetition.
    #[command(flatten)]
    pub repeat: RepeatOptions,
}

/// A format of the command line.
#[derive(Clone, Copy)]
pub struct Format(&'static dyn Exporter);

impl std::fmt::Debug for Format {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.0.name())
    }
}

fn format(text: &str) -> Result<Format, String> {
    let names = || EXPORTERS.iter().map(|exporter| exporter.name()).collect::<Vec<_>>().join(", ");
    export::exporter(text).map(Format).ok_or_else(|| format!("the formats are {}", names()))
}

impl ValueEnum for EgoDriver {
    fn value_variants<'a>() -> &'a [Self] {
        &[Self::Recorded, Self::User]
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(match self {
            Self::Recorded => PossibleValue::new("recorded").help("The ego follows its recorded track"),
            Self::User => PossibleValue::new("user").help("The ego starts as recorded, and your controller drives it"),
        })
    }
}

impl ValueEnum for Walking {
    fn value_variants<'a>() -> &'a [Self] {
        &[Self::Recorded, Self::Released]
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(match self {
            Self::Recorded => PossibleValue::new("recorded").help("Pedestrians walk at the recorded times"),
            Self::Released => {
                PossibleValue::new("released").help("Pedestrians start when the ego is as near as it was when they did")
            }
        })
    }
}

/// `falsify export`
pub fn export(options: &ExportOptions) -> ExitCode {
    let Some(Format(exporter)) = options.format.filter(|_| !options.formats) else {
        for exporter in EXPORTERS {
            let name = exporter.name();
            console::say(&format!(
                "{name:12} {}\n{:12} approximated: {}",
                exporter.about(),
                "",
                exporter.approximates()
            ));
        }
        return ExitCode::Done;
    };
    let episodes = match resolved(&options.names) {
        Ok(episodes) => episodes,
        Err(code) => return code,
    };
    let call = session::ExportOptions {
        episodes,
        report: options.report.clone(),
        repeat: options.repeat.repeat(),
        exporter,
        variant: Variant { ego: options.ego, walking: options.pedestrians },
        out: options.out.clone(),
    };
    let mut code = ExitCode::Done;
    session(options.repeat.allow_external).export_files(&call, &mut |exported| match exported {
        Ok(exported) => {
            let files: Vec<String> = exported.files.iter().map(|file| file.display().to_string()).collect();
            console::say(&format!("{}  {}", exported.name, files.join("  ")));
        }
        Err(error) => {
            let failed = failure::failed(&error);
            if code == ExitCode::Done {
                code = failed;
            }
        }
    });
    code
}

use std::io::BufRead;
use std::path::PathBuf;

use clap::builder::PossibleValue;
use clap::{Args, ValueEnum};

use super::episode::RepeatOptions;
use super::exit_code::ExitCode;
use super::input::session;
use super::{console, failure};
use crate::export::{self, EXPORTERS, EgoDriver, Exporter, Variant, Walking};
use crate::session::{self, NamedEpisode};

/// Shown after the help.
pub const EXAMPLES: &str = "\
Examples:
  falsify export 1a2b3c4d:17 --as xosc-1.3   1a2b3c4d-17.xosc and its map, both actors on their tracks
  falsify export 1a2b3c4d:17 --as xosc-1.3 --ego user --pedestrians released
                                             drive against the pedestrian with your own controller
  falsify export 1a2b3c4d:17 5e6f7a8b:0 --as xodr --out maps
                                             several episodes, into a folder
  cut -d, -f1 names.txt | falsify export - --as xosc-1.2
                                             names from the standard input, one a line
  falsify export --formats                   list the formats and what each approximates

Exit codes: 0 done   2 no such episode, or the format cannot represent it   3 errors in a scenario
  6 a file cannot be written   8 an episode differs from its report, or a scenario file has changed";

/// Options of `falsify export`.
#[derive(Debug, Args)]
pub struct ExportOptions {
    /// The episodes, or failures of searches, each perhaps with its report: REPORT/RUN:EPISODE. `-` reads the standard input: the first
    /// word of each line.
    #[arg(value_name = "RUN:EPISODE", required_unless_present = "formats")]
    pub names: Vec<String>,
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
    let episodes = match episodes(&options.names) {
        Ok(episodes) => episodes,
        Err(message) => {
            console::fail(&message);
            return ExitCode::Usage;
        }
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

/// The episodes that names mean; `-` is the standard input.
fn episodes(names: &[String]) -> Result<Vec<NamedEpisode>, String> {
    let mut episodes = Vec::new();
    let parse = |text: &str, place: &str| {
        text.parse::<NamedEpisode>().map_err(|error| format!("`{text}`{place} is no name of an episode: {error}"))
    };
    for name in names {
        if name != "-" {
            episodes.push(parse(name, "")?);
            continue;
        }
        for (number, line) in std::io::stdin().lock().lines().enumerate() {
            let line = line.map_err(|error| format!("the standard input cannot be read: {error}"))?;
            if let Some(word) = line.split_whitespace().next() {
                episodes.push(parse(word, &format!(" in line {} of the standard input", number + 1))?);
            }
        }
    }
    if episodes.is_empty() {
        return Err("there is no name of an episode on the standard input".to_owned());
    }
    Ok(episodes)
}

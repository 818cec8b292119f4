use std::path::{Path, PathBuf};

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};

use super::episode::{Named, RepeatArgs, resolved};
use crate::cli::choice::choice;
use crate::cli::console;
use crate::cli::failure::{failed, misused};
use crate::cli::input::session;
use crate::exit_code::{Ended, ExitCode};
use crate::session::{self, Drawing, EpisodePath, Picture};
use export::{EXPORTERS, EgoDriver, Exporter, Variant, Walking};

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
  falsify export 1a2b3c4d:17 --as svg        six frames in a picture, and the speeds of both
  falsify failures --names --top 5 | falsify export - --as animation
                                             the five worst failures of reports/, for a browser
  falsify export 1a2b3c4d:17 --as carla --ego user
                                             a script for CARLA in which its agent drives
  falsify export --formats                   list the formats and what each approximates

Exit codes: 0 done   2 no such episode, or the format cannot represent it   3 errors in a scenario
  6 a file cannot be written, or its encoder is missing   8 an episode differs from its report, or a scenario file has changed";

/// Options of `falsify export`.
#[derive(Debug, Args)]
pub struct ExportArgs {
    /// Episodes, or failures of searches; a path before the name is that of the report. `-` reads names from the input, one a line.
    #[arg(value_name = "[PATH/]RUN:EPISODE", required_unless_present = "formats", value_parser = str::parse::<Named>)]
    pub names: Vec<Named>,
    /// The format; `--formats` says what each approximates.
    #[arg(long = "as", value_name = "FORMAT", required_unless_present = "formats", value_parser = formats())]
    pub format: Option<Format>,
    /// List the formats.
    #[arg(long)]
    pub formats: bool,
    /// The driver of the ego. `commonroad` has `user` unless you say otherwise, all others have `recorded`.
    #[arg(long, value_parser = choice([
        ("recorded", EgoDriver::Recorded, "The ego follows its recorded track"),
        ("user", EgoDriver::User, "The ego starts as recorded, and your controller drives it"),
    ]))]
    pub ego: Option<EgoDriver>,
    /// When the pedestrians walk. Both are the same for a pedestrian that walks from the first tick on; the file says so.
    #[arg(long, default_value = "recorded", value_parser = choice([
        ("recorded", Walking::Recorded, "Pedestrians walk at the recorded times"),
        ("released", Walking::Released, "Pedestrians start when the ego is as near as it was when they did"),
    ]))]
    pub pedestrians: Walking,
    /// The folder for the files.
    #[arg(long, short, default_value = ".", value_name = "DIR")]
    pub out: PathBuf,
    /// A report, or a folder of reports.
    #[arg(long, default_value = "reports", env = "FALSIFY_OUT", value_name = "DIR")]
    pub report: PathBuf,
    /// Options of the repetition.
    #[command(flatten)]
    pub repeat: RepeatArgs,
}

/// A format of the command line.
#[derive(Clone, Copy)]
pub enum Format {
    /// One of another program.
    Foreign(&'static dyn Exporter),
    /// A picture of ours.
    Drawing(Drawing),
}

/// The pictures: what they are called, what they are, and what they are drawn as.
const DRAWINGS: [(&str, &str, Drawing); 2] = [
    ("svg", "six frames side by side, and the speeds of both actors", Drawing::Strip),
    ("animation", "an animation as SVG, for a browser", Drawing::Animation),
];

/// Reads the name of a format.
fn formats() -> impl TypedValueParser<Value = Format> {
    let foreign = EXPORTERS.iter().map(|exporter| PossibleValue::new(exporter.name()).help(exporter.about()));
    let drawn = DRAWINGS.iter().map(|(name, about, _)| PossibleValue::new(*name).help(*about));
    PossibleValuesParser::new(foreign.chain(drawn)).map(|word| {
        let drawing = DRAWINGS.iter().find(|(name, ..)| *name == word).map(|(.., drawing)| Format::Drawing(*drawing));
        let found = drawing.or_else(|| export::exporter(&word).map(Format::Foreign));
        found.expect("it is one of the names")
    })
}

impl std::fmt::Debug for Format {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Foreign(exporter) => f.write_str(exporter.name()),
            Self::Drawing(drawing) => drawing.fmt(f),
        }
    }
}

/// `falsify export`
pub fn export(options: &ExportArgs) -> Ended {
    let Some(format) = options.format.filter(|_| !options.formats) else {
        list();
        return Ok(ExitCode::Done);
    };
    if is_named_like_a_file(&options.out) {
        let out = options.out.display();
        return Err(misused(format!(
            "--out names a folder, and `{out}` is named like a file: give a folder; the files in it are called RUN-EPISODE and the ending of the format"
        )));
    }
    let episodes = resolved(&options.names)?;
    let variant_of = |ego: EgoDriver| Variant { ego: options.ego.unwrap_or(ego), walking: options.pedestrians };
    let exporter = match format {
        Format::Foreign(exporter) => exporter,
        Format::Drawing(_) if variant_of(EgoDriver::Recorded) != Variant::default() => {
            return Err(misused("a picture shows the recorded episode: leave out --ego and --pedestrians"));
        }
        Format::Drawing(drawing) => return Ok(draw(drawing, episodes, options)),
    };
    let variant = variant_of(exporter.usual_ego());
    let call = session::ExportOptions {
        episodes,
        report: options.report.clone(),
        repeat: options.repeat.repeat.clone(),
        exporter,
        variant,
        out: options.out.clone(),
    };
    let mut code = ExitCode::Done;
    session(options.repeat.allow_external).export_files(&call, &mut |exported| match exported {
        Ok(exported) => {
            let files: Vec<String> = exported.files.iter().map(|file| file.display().to_string()).collect();
            console::say(&format!("{}  {}", exported.name, files.join("  ")));
        }
        Err(error) => code = code.or(failed(error)),
    });
    Ok(code)
}

/// The endings of the files that exports write.
const ENDINGS: [&str; 14] =
    ["svg", "html", "xosc", "xodr", "osi", "mcap", "gif", "mp4", "png", "py", "xml", "json", "csv", "parquet"];

/// Whether there is no folder of this name, and it ends as a file of an export does.
fn is_named_like_a_file(out: &Path) -> bool {
    let ending = out.extension().map(|ending| ending.to_string_lossy().to_lowercase());
    !out.is_dir() && ending.is_some_and(|ending| ENDINGS.contains(&ending.as_str()))
}

/// Lists the formats.
fn list() {
    for exporter in EXPORTERS {
        console::say(&format!("{:12} {}", exporter.name(), exporter.about()));
        console::say(&format!("{:12} approximated: {}", "", exporter.approximates()));
    }
    for (name, about, _) in DRAWINGS {
        console::say(&format!("{name:12} {about}"));
    }
}

/// Draws episodes, each as `RUN-EPISODE.svg` or `RUN-EPISODE-animation.svg`.
fn draw(drawing: Drawing, episodes: Vec<EpisodePath>, options: &ExportArgs) -> ExitCode {
    let session = session(options.repeat.allow_external);
    let mut ended = ExitCode::Done;
    for EpisodePath { report, name } in episodes {
        let report = report.unwrap_or_else(|| options.report.clone());
        let which = session::ReplayOptions { name, report, repeat: options.repeat.repeat.clone() };
        let kind = if drawing == Drawing::Animation { "-animation" } else { "" };
        let path = options.out.join(format!("{}-{}{kind}.svg", name.run, name.number));
        let picture = Picture { drawing, path: path.clone() };
        let drawn = session.export(&which, &picture).map_err(failed).and_then(|replay| {
            console::say(&format!("{name}  {}", path.display()));
            if replay.episode.differences.is_empty() {
                return Ok(ExitCode::Done);
            }
            console::fail(&format!("{name} differs from its report; `falsify replay {name}` shows where"));
            Err(ExitCode::Differs)
        });
        ended = ended.or(drawn.unwrap_or_else(|code| code));
    }
    ended
}

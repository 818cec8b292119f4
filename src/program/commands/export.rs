use std::path::{Path, PathBuf};

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};

use super::episode::{Named, RepeatArgs, resolved};
use crate::cli::choice::choice;
use crate::cli::console;
use crate::cli::failure::{failed, misused};
use crate::cli::input::session;
use crate::exit_code::{Ended, ExitCode};
use crate::session::{EpisodePath, Error, Repeated, Session, Source};
use episode::{Scenario, Trace};
use export::{EXPORTERS, EgoDriver, Episode, ExportError, ExportFile, Exporter, Variant, Walking};
use results::report;
use verdict::Verdict;
use verdict::cause::{MAX_RUNS, Questions, RunLimit};

pub const EXAMPLES: &str = "\
Examples:
  falsify export 1a2b3c4d:17 --as xosc-1.3   1a2b3c4d-17.xosc and its map, both actors on their tracks
  falsify export 1a2b3c4d:17 --as xosc-1.3 --ego user --pedestrians released
                                             drive against the pedestrian with your own driver
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
    pub format: Option<&'static Exporter>,
    /// List the formats.
    #[arg(long)]
    pub formats: bool,
    /// The driver of the ego. `commonroad` has `user` unless you say otherwise, all others have `recorded`.
    #[arg(long, value_parser = choice([
        ("recorded", EgoDriver::Recorded, "The ego follows its recorded track"),
        ("user", EgoDriver::User, "The ego starts as recorded, and your driver drives it"),
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
    /// The failure with the fewest commands, as `falsify shrink` finds it.
    #[arg(long)]
    pub shrunk: bool,
    /// Options of the repetition.
    #[command(flatten)]
    pub repeat: RepeatArgs,
}

/// The pictures of an episode, as SVG.
static DRAWINGS: [Exporter; 2] = [
    Exporter {
        name: "svg",
        about: "six frames side by side, and the speeds of both actors",
        files: |episode, _| drawn(episode, ".svg", report::strip),
        ..Exporter::RECORDED
    },
    Exporter {
        name: "animation",
        about: "an animation as SVG, for a browser",
        files: |episode, _| drawn(episode, "-animation.svg", report::animation),
        ..Exporter::RECORDED
    },
];

/// Draws an episode with its verdict, a headline and a title.
type Draw = fn(&Scenario, &Trace, Option<&Verdict>, &str, &str) -> String;

/// A picture, as a file whose name has this ending.
fn drawn(episode: &Episode<'_>, ending: &str, draw: Draw) -> Result<Vec<ExportFile>, ExportError> {
    let Episode { name, title, scenario, trace, outcome, verdict, .. } = episode;
    let what = match (outcome.impact_speed(), verdict) {
        (Some(speed), Some(verdict)) => format!("collision at {speed:.1} m/s, {}", verdict.word()),
        _ => format!("no collision, minimum gap {:.2} m", outcome.least_gap),
    };
    let text = draw(scenario, trace, *verdict, &format!("{name}: {what}"), title);
    Ok(vec![ExportFile { name: format!("{}{ending}", name.replace(':', "-")), bytes: text.into_bytes() }])
}

/// All formats: those of other programs, and the pictures.
fn all_formats() -> impl Iterator<Item = &'static Exporter> {
    EXPORTERS.into_iter().chain(&DRAWINGS)
}

/// Reads the name of a format.
fn formats() -> impl TypedValueParser<Value = &'static Exporter> {
    let names = all_formats().map(|exporter| PossibleValue::new(exporter.name).help(exporter.about));
    PossibleValuesParser::new(names)
        .map(|word| all_formats().find(|exporter| exporter.name == word).expect("it is one of the names"))
}

pub fn export(options: &ExportArgs) -> Ended {
    let Some(exporter) = options.format.filter(|_| !options.formats) else {
        for exporter in all_formats() {
            console::say(&format!("{:12} {}", exporter.name, exporter.about));
            console::say(&format!("{:12} approximated: {}", "", exporter.approximates));
        }
        return Ok(ExitCode::Done);
    };
    if is_named_like_a_file(&options.out) {
        let out = options.out.display();
        return Err(misused(format!(
            "--out names a folder, and `{out}` is named like a file: give a folder; the files in it are called RUN-EPISODE and the ending of the format"
        )));
    }
    let variant = Variant { ego: options.ego.unwrap_or(exporter.usual_ego), walking: options.pedestrians };
    let session = session(options.repeat.allow_external);
    let (mut code, mut open, mut written) = (ExitCode::Done, None, false);
    for episode in resolved(&options.names)? {
        if session.stop.is_asked() {
            break;
        }
        let exported = repeated(&session, &episode, options, &mut open)
            .and_then(|repeated| write(&repeated, exporter, variant, &options.out));
        match exported {
            Ok(files) => {
                let files: Vec<String> = files.iter().map(|file| file.display().to_string()).collect();
                console::say(&format!("{}  {}", episode.name, files.join("  ")));
                written = true;
            }
            Err(error) => code = code.or(failed(error)),
        }
    }
    if written {
        console::note(console::wrapped(&format!("approximated: {}", exporter.approximates)).trim_end());
    }
    Ok(code)
}

/// Repeats an episode. The campaign of the last one stays compiled, since lists have many of one report.
///
/// # Errors
/// The episode cannot be repeated, or differs from its report.
fn repeated(
    session: &Session,
    EpisodePath { report, name }: &EpisodePath,
    options: &ExportArgs,
    open: &mut Option<Source>,
) -> Result<Repeated, Error> {
    let is_there = |source: &Source| {
        let here = report.as_ref().is_none_or(|report| report == source.report.folder());
        here && (source.evaluation(*name).is_some() || source.search(*name).is_some())
    };
    let source = match open.take().filter(is_there) {
        Some(source) => source,
        None => {
            let found = session.find(report.as_ref().unwrap_or(&options.report), *name)?;
            found.check_for_repetition()?;
            session.reopen(found, &options.repeat.repeat)?
        }
    };
    let repeated = open.insert(source).repeat(*name)?;
    if options.shrunk {
        let shrunk = repeated.shrink(MAX_RUNS)?;
        return Ok(repeated.replaced_by(shrunk));
    }
    if repeated.differences.is_empty() || options.repeat.repeat.anyway {
        return Ok(repeated);
    }
    let columns: Vec<&str> = repeated.differences.iter().map(|each| each.column.as_str()).collect();
    Err(Error::Differs(format!(
        "{name} differs from its report in {}, so it is not exported; `falsify replay {name}` shows where, and --anyway exports it all the same",
        columns.join(", ")
    )))
}

/// Writes the files of an episode; returns them, the one to open first.
fn write(repeated: &Repeated, exporter: &Exporter, variant: Variant, out: &Path) -> Result<Vec<PathBuf>, Error> {
    let name = repeated.name.to_string();
    let cause = repeated.cause(Questions::OfCopied, RunLimit::default()).map(|cause| cause.sentence());
    let episode = Episode {
        cause: cause.as_deref(),
        name: &name,
        title: &repeated.title,
        scenario: &repeated.scenario,
        trace: &repeated.trace,
        outcome: &repeated.judged.outcome,
        verdict: repeated.judged.verdict.as_ref(),
    };
    let files = export::export(exporter, &episode, variant);
    let files = files.map_err(|source| Error::Export { name: repeated.name, source })?;
    let write = |file: &ExportFile| {
        // In the current folder its name alone.
        let path = if out == Path::new(".") { PathBuf::from(&file.name) } else { out.join(&file.name) };
        report::write_new_file(&path, &file.bytes)?;
        Ok(path)
    };
    files.iter().map(write).collect()
}

/// The endings of the files that exports write.
const ENDINGS: [&str; 14] =
    ["svg", "html", "xosc", "xodr", "osi", "mcap", "gif", "mp4", "png", "py", "xml", "json", "csv", "parquet"];

/// Whether there is no folder of this name, and it ends as a file of an export does.
fn is_named_like_a_file(out: &Path) -> bool {
    let ending = out.extension().map(|ending| ending.to_string_lossy().to_lowercase());
    !out.is_dir() && ending.is_some_and(|ending| ENDINGS.contains(&ending.as_str()))
}

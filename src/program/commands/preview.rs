//! `falsify preview`: a page of the towns of a scenario that follows the file while it is edited, or of an OpenDRIVE map.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use clap::Args;

use super::map::{map, spacing};
use crate::cli::exit_code::{Ended, ExitCode};
use crate::cli::failure::unwritten;
use crate::cli::input::{GivenArgs, session};
use crate::cli::{console, interrupt};
use crate::session::{self, Preview};
use results::report;

/// Shown after the help.
pub const EXAMPLES: &str = "\
Examples:
  falsify preview my.scn                     write my.preview.html and follow my.scn until Ctrl-C
  falsify preview my.scn --once              write the page and end
  falsify preview Town02.xodr                Town02.svg and Town02.html, and what the map holds

Exit codes: 0 the page is written   3 --once, and the scenario has errors   6 the page cannot be written   130 Ctrl-C";

/// Between two looks at the files.
const PAUSE: Duration = Duration::from_millis(250);

/// Options of `falsify preview`.
#[derive(Debug, Args)]
pub struct PreviewArgs {
    /// A scenario file, or an OpenDRIVE map.
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
    /// Replacements of parts of the file.
    #[command(flatten)]
    pub given: GivenArgs,
    /// Folder for the page, `NAME.preview.html`, and the script that tells it of a new version, `NAME.preview.js`; of a map for `NAME.svg` and
    /// `NAME.html`.
    #[arg(long, short, default_value = ".", value_name = "DIR")]
    pub out: PathBuf,
    /// Write the page once and end.
    #[arg(long)]
    pub once: bool,
    /// The starts.
    #[command(flatten)]
    pub starts: session::PreviewOptions,
    /// Of a map: also write the waypoints of all driving lanes at this distance (m), as CARLA would: `NAME_waypoints.csv`.
    #[arg(long, value_name = "METRES", value_parser = spacing)]
    pub waypoints: Option<f64>,
}

/// `falsify preview`
pub fn preview(options: &PreviewArgs) -> Ended {
    if options.file.extension().is_none_or(|extension| extension != "scn") {
        return map(options);
    }
    let session = session(options.given.allow_external);
    let input = options.given.input(std::slice::from_ref(&options.file));
    let wanted = session::PreviewOptions { input, ..options.starts.clone() };
    if options.once {
        let preview = session.preview(&wanted, &Preview::default());
        let page = write(&preview, options, None)?;
        preview.problems.iter().for_each(|problem| console::note(problem));
        console::say(&page.display().to_string());
        return if preview.errors == 0 { Ok(ExitCode::Done) } else { Err(ExitCode::Scenario) };
    }
    interrupt::end_when_asked();
    let mut preview = Preview::default();
    for version in 1u64.. {
        // Changes while the files are read count as later ones.
        let mut known = stamps(&preview.files);
        preview = session.preview(&wanted, &preview);
        if known.len() != preview.files.len() {
            known = stamps(&preview.files);
        }
        // A page of an earlier call has another number.
        let stamp = format!("{}-{version}", std::process::id());
        let page = write(&preview, options, Some(stamp))?;
        if version == 1 {
            console::say(&format!("open {} in a browser; Ctrl-C ends", page.display()));
        }
        console::say(&match preview.errors {
            0 => "no errors".to_string(),
            errors => console::count(errors, "error"),
        });
        while stamps(&preview.files) == known {
            std::thread::sleep(PAUSE);
        }
    }
    Ok(ExitCode::Done)
}

/// When each file was last changed, and its length; nothing of a file that is not there.
fn stamps(files: &[PathBuf]) -> Vec<Option<(SystemTime, u64)>> {
    let stamp = |file: &PathBuf| {
        let data = std::fs::metadata(file).ok()?;
        Some((data.modified().ok()?, data.len()))
    };
    files.iter().map(stamp).collect()
}

/// Writes the page and, if it has a version, the script that names it; the error is the exit code, after the reason has been printed.
fn write(preview: &Preview, options: &PreviewArgs, version: Option<String>) -> Result<PathBuf, ExitCode> {
    let place = |ending: &str| {
        let mut name = OsString::from(options.file.file_stem().unwrap_or_default());
        name.push(ending);
        options.out.join(name)
    };
    let page = place(".preview.html");
    let script = place(".preview.js");
    let name = |path: &Path| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let follows = version.as_ref().map(|version| (address(&name(&script)), version.clone()));
    let text = preview.page(&name(&options.file), follows);
    let written = report::write_file(&page, text.as_bytes()).and_then(|()| match version {
        // The page is there before the script names it.
        Some(version) => report::write_file(&script, format!("falsifyVersion(\"{version}\");\n").as_bytes()),
        None => Ok(()),
    });
    written.map(|()| page).map_err(unwritten)
}

/// A file name in a relative address.
fn address(name: &str) -> String {
    let plain = |byte: u8| byte.is_ascii_alphanumeric() || b"-_.~".contains(&byte);
    name.bytes().map(|byte| if plain(byte) { char::from(byte).to_string() } else { format!("%{byte:02X}") }).collect()
}

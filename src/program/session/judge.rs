use std::path::{Path, PathBuf};

use clap::Args;

use super::{Error, Input, Session};
use lang::reason;
use world::env::Scenario;
use world::judge::{Encountered, Recording, RecordingFileError, Sizes};

/// Options of [`Session::judge`].
#[derive(Debug, Clone, Default, Args)]
pub struct JudgeOptions {
    /// A recording: CSV with a header and a row for each instant.
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
    /// Length of the car (m); without it that of the paper's car, 4.79.
    #[arg(long, value_name = "METRES")]
    pub length: Option<f64>,
    /// Width of the car (m); without it that of the paper's car, 2.16.
    #[arg(long, value_name = "METRES")]
    pub width: Option<f64>,
    /// Radius of the pedestrian (m); without it that of the paper's pedestrian, 0.188.
    #[arg(long, value_name = "METRES")]
    pub radius: Option<f64>,
}

/// The paper's car and pedestrian, whose sizes and grip a recording has when nothing else is stated.
const PAPER: &str = "\
edition 1
import \"std/paper.scn\"
import \"std/drivers.scn\"
import \"std/towns.scn\"
campaign recording {
  vehicle: model3  adversary: suicidal  spawn: ahead  episode: thirty_seconds
  evaluate { towns: [harbour]  policies: [blind]  pedestrians: [random]  episodes: 1 }
}
";
/// Its name among the files of a session.
const PAPER_FILE: &str = "recording.scn";

impl Session {
    /// Judges the first touch of a car and a pedestrian that were recorded elsewhere, on a plane without obstacles.
    ///
    /// # Errors
    /// [`Error::Recording`]: the file cannot be read, holds no recording, or a size is out of its range.
    pub fn judge(&self, options: &JudgeOptions) -> Result<Encountered, Error> {
        let refused = |reason: String| Error::Recording { file: options.file.clone(), reason };
        let text = self.reader.text(&options.file).map_err(|error| refused(reason(&error)))?;
        let recording = Recording::from_csv(&text).map_err(|error| refused(error.to_string()))?;
        let mut scenario = paper()?;
        let sizes = Sizes { length: options.length, width: options.width, radius: options.radius };
        sizes.apply(&mut scenario).map_err(|error| refused(RecordingFileError::from(error).to_string()))?;
        Ok(recording.judged_without_obstacles(&scenario))
    }
}

/// The scenario with the paper's car and pedestrian.
fn paper() -> Result<Scenario, Error> {
    let session = Session::default().with_reader(|path: &Path| match path.to_str() {
        Some(PAPER_FILE) => Ok(PAPER.to_string()),
        _ => Err(std::io::Error::from(std::io::ErrorKind::NotFound)),
    });
    let checked = session.check(&Input::file(PAPER_FILE))?;
    Ok(Scenario::clone(&checked.plan()?.campaigns[0].evaluations[0].scenario))
}

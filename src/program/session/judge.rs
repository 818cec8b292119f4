use std::path::{Path, PathBuf};

use super::{Error, Input, Session};
use lang::reason;
use world::env::Scenario;
use world::judge::{Encountered, Recording, RecordingFileError, Sizes};

/// Options of [`Session::judge`].
#[derive(Debug, Clone, Default)]
pub struct JudgeOptions {
    /// The recording: CSV, as [`Recording::from_csv`] reads it.
    pub file: PathBuf,
    /// Sizes in the place of the paper's.
    pub sizes: Sizes,
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
        let refused =
            |source: RecordingFileError| Error::Recording { file: options.file.clone(), reason: source.to_string() };
        let text = self
            .reader
            .text(&options.file)
            .map_err(|error| Error::Recording { file: options.file.clone(), reason: reason(&error) })?;
        let recording = Recording::from_csv(&text).map_err(refused)?;
        let mut scenario = paper()?;
        options.sizes.apply(&mut scenario).map_err(|error| refused(error.into()))?;
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

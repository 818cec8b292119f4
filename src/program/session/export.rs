//! Episodes in the formats of other programs. Each format is one writer.

use std::path::PathBuf;

use super::{Error, Repeated, Replay, ReplayOptions, Session};
use results::report::{self, WriteError};

/// Writes an episode in a format.
pub trait Export {
    /// Writes the episode: its scenario, its trace, and the verdict.
    ///
    /// # Errors
    /// A file that cannot be written.
    fn write(&self, episode: &Repeated) -> Result<(), WriteError>;
}

impl Session {
    /// Repeats an episode of a report and passes it to a writer, even when it differs from the report.
    ///
    /// # Errors
    /// Those of [`Session::replay`], and those of the writer.
    pub fn export(&self, options: &ReplayOptions, writer: &dyn Export) -> Result<Replay, Error> {
        let replay = self.replay(options)?;
        writer.write(&replay.episode)?;
        Ok(replay)
    }
}

/// A table with a row for each tick; the end of the name says whether it is CSV or Parquet.
#[derive(Debug, Clone)]
pub struct TickTable {
    /// The file.
    pub path: PathBuf,
}

impl Export for TickTable {
    fn write(&self, episode: &Repeated) -> Result<(), WriteError> {
        let Repeated { name, scenario, trace, .. } = episode;
        report::write_table(&self.path, &report::ticks(name.run, name.number, scenario, trace))
    }
}

/// A picture, as SVG.
#[derive(Debug, Clone)]
pub struct Picture {
    pub drawing: Drawing,
    /// The file.
    pub path: PathBuf,
}

/// What a picture shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Drawing {
    /// Six frames side by side with the speeds of both actors.
    Strip,
    /// The episode as it runs.
    Animation,
}

impl Export for Picture {
    fn write(&self, episode: &Repeated) -> Result<(), WriteError> {
        let Repeated { scenario, trace, verdict, title, .. } = episode;
        let draw = match self.drawing {
            Drawing::Strip => report::strip,
            Drawing::Animation => report::animation,
        };
        let page = draw(scenario, trace, verdict.as_ref(), &headline(episode), title);
        report::write_new_file(&self.path, page.as_bytes())
    }
}

/// The end of the episode, in a line.
fn headline(episode: &Repeated) -> String {
    let what = match (episode.outcome.impact_speed(), &episode.verdict) {
        (Some(speed), Some(verdict)) => {
            format!("hit at {speed:.1} m/s, {}", verdict.word())
        }
        _ => format!("no hit, least gap {:.2} m", episode.outcome.least_gap),
    };
    format!("{}: {what}", episode.name)
}

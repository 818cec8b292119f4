use super::{Episode, ExportError};

/// The date in the files (ISO 8601). It is that of the first writer, so that the same episode gives the same bytes at any time.
pub(super) const DATE: &str = "2026-11-22T00:00:00";

/// The name of the program in the files.
pub(super) const AUTHOR: &str = concat!("falsify ", env!("CARGO_PKG_VERSION"));

/// A format.
#[derive(Debug)]
pub struct Exporter {
    /// The name on the command line.
    pub name: &'static str,
    /// The format and its use, in a line.
    pub about: &'static str,
    /// What differs from the episode in the simulator, in a line.
    pub approximates: &'static str,
    /// The driver of the ego unless the user chooses one.
    pub usual_ego: EgoDriver,
    /// Whether the format can hold these parts of an episode.
    pub holds: fn(Variant) -> bool,
    /// Makes the files of an episode. The first one is the one to open. An error names a part of the episode that the format cannot hold.
    pub files: fn(&Episode<'_>, Variant) -> Result<Vec<ExportFile>, ExportError>,
}

impl Exporter {
    /// A format without a name that holds recorded tracks.
    pub const RECORDED: Self = Self {
        name: "",
        about: "",
        approximates: "nothing",
        usual_ego: EgoDriver::Recorded,
        holds: |variant| variant.ego == EgoDriver::Recorded && variant.walking == Walking::Recorded,
        files: |_, _| Ok(Vec::new()),
    };
}

/// The parts of the recorded episode that an export repeats.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Variant {
    /// Who drives the ego.
    pub ego: EgoDriver,
    /// When the pedestrians walk.
    pub walking: Walking,
}

/// The driver of the ego in an export.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum EgoDriver {
    /// The recorded track: an exact repetition.
    #[default]
    Recorded,
    /// The controller of the user, from the recorded start and speed.
    User,
}

/// The time at which the pedestrians of an export walk.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Walking {
    #[default]
    Recorded,
    /// As soon as the ego is as near as it was when the pedestrian of the verdict set off. A pedestrian that walks from the first tick on
    /// walks at the recorded times.
    Released,
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ExportFile {
    /// Its name, without a folder.
    pub name: String,
    /// Its contents.
    pub bytes: Vec<u8>,
}

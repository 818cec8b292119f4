//! A failure for other programs: one file per format, each an [`Exporter`].
//!
//! An exporter receives an [`Episode`] and returns [`ExportFile`]s. It writes nothing itself, knows no path and no clock, and gives the same
//! bytes for the same episode. A part of the episode that its format cannot hold is an [`ExportError`] that names the part. What a format
//! approximates is in [`Exporter::approximates`], in the files themselves where they have a place for it, and in
//! `docs/src/how-to/export.md`.
//!
//! Two approximations are common to formats that know boxes only: a pedestrian's disc becomes the square around it, and cars get a height.

mod error;
mod episode;
mod xml;
mod lane_bounds;
mod opendrive;
mod openscenario;
mod commonroad;
mod osi;
mod recording;
mod foxglove;
mod carla;
mod canvas;
mod film;
mod gif;

pub use episode::Episode;
pub use error::ExportError;
pub use opendrive::town;

/// The date in the files (ISO 8601). It is that of the first writer, so that the same episode gives the same bytes at any time.
const DATE: &str = "2026-11-22T00:00:00";

/// The name of the program in the files.
const AUTHOR: &str = concat!("falsify ", env!("CARGO_PKG_VERSION"));

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

/// All formats.
pub const EXPORTERS: [&Exporter; 8] = [
    &openscenario::XOSC_1_3,
    &openscenario::XOSC_1_0,
    &opendrive::XODR,
    &osi::OSI,
    &foxglove::FOXGLOVE,
    &commonroad::COMMONROAD,
    &carla::CARLA,
    &gif::GIF,
];

/// The format with this name.
pub fn exporter(name: &str) -> Option<&'static Exporter> {
    EXPORTERS.into_iter().find(|exporter| exporter.name == name)
}

/// Makes the files of an episode in a format.
///
/// # Errors
/// Those of [`Exporter::files`], and a variant that the format does not have.
pub fn export(exporter: &Exporter, episode: &Episode<'_>, variant: Variant) -> Result<Vec<ExportFile>, ExportError> {
    if episode.ticks() == 0 {
        let what = "an episode without a tick".to_owned();
        return Err(ExportError::NotRepresentable { format: exporter.name, what });
    }
    if !(exporter.holds)(variant) {
        let what = match (exporter.holds)(Variant { walking: Walking::Recorded, ..variant }) {
            true => "pedestrians that are released: they walk at the recorded times",
            false => "an ego that the user drives, or pedestrians that are released: it holds the recorded tracks",
        };
        return Err(ExportError::NotRepresentable { format: exporter.name, what: what.to_owned() });
    }
    (exporter.files)(episode, variant)
}

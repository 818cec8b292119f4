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
mod format;
mod xml;
mod lane_bounds;
mod opendrive;
mod openscenario;
mod commonroad;
mod recording;
mod osi;
mod foxglove;
mod carla;
mod canvas;
mod film;
mod gif;

pub use episode::Episode;
pub use error::ExportError;
pub use format::{EgoDriver, ExportFile, Exporter, Variant, Walking};
pub use opendrive::town;
pub use osi::{TraceError, read as read_trace};

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

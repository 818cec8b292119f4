//! The standard library: scenario files that come with the program.

use std::path::{Path, PathBuf};

/// The folder under which its files are shown and know each other; no file system has it.
const FOLDER: &str = "<std>";

/// Its files.
const FILES: &[(&str, &str)] = &[
    ("carla_towns.scn", include_str!("../../scenarios/lib/carla_towns.scn")),
    ("drivers.scn", include_str!("../../scenarios/lib/drivers.scn")),
    ("paper.scn", include_str!("../../scenarios/lib/paper.scn")),
    ("paper_tables.scn", include_str!("../../scenarios/lib/paper_tables.scn")),
    ("rewards.scn", include_str!("../../scenarios/lib/rewards.scn")),
    ("sensors.scn", include_str!("../../scenarios/lib/sensors.scn")),
    ("towns.scn", include_str!("../../scenarios/lib/towns.scn")),
];

/// Its files: names and texts.
pub(super) fn files() -> impl Iterator<Item = (&'static str, &'static str)> {
    FILES.iter().copied()
}

/// The names of its files, as they stand after `std/` in an import.
pub fn names() -> impl Iterator<Item = &'static str> {
    FILES.iter().map(|(name, _)| *name)
}

/// The place of a file that is imported as `std/…`.
pub fn place(import: &str) -> Option<PathBuf> {
    import.strip_prefix("std/").map(|name| Path::new(FOLDER).join(name))
}

/// Whether a path leads into the library.
pub fn holds(path: &Path) -> bool {
    path.starts_with(FOLDER)
}

/// The text of a file of the library.
///
/// # Errors
/// There is no such file.
pub fn read(path: &Path) -> std::io::Result<&'static str> {
    let name = path.strip_prefix(FOLDER).ok().and_then(Path::to_str);
    let found = FILES.iter().find(|(known, _)| Some(*known) == name);
    found.map(|(_, text)| *text).ok_or_else(|| {
        let known = names().map(|name| format!("`std/{name}`")).collect::<Vec<_>>().join(", ");
        std::io::Error::other(format!("the standard library holds {known}"))
    })
}

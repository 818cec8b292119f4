use std::path::Path;

use super::site::{Drawn, Site};
use base::diagnostic::Diagnostic;
use base::keys;
use lang::hir::Declaration;
use lang::{Reader, diagnostics};
use road::{AssumedLimit, MapFile, TownParts, opendrive};

keys! {
    /// A town from an OpenDRIVE map, with its speed limits and its signs. Such maps hold no buildings; they can be added here.
    pub struct OpenDriveKeys = "opendrive" {
        /// The map, relative to the folder of this file.
        file: String as Path,
    }
}

/// The parts of the map; nothing if another map replaces it.
pub(super) fn build(declaration: &Declaration, site: &mut Site<'_>) -> Option<Drawn> {
    let parts = match site.map {
        Some(_) => TownParts::default(),
        None => {
            let folder = site.sources.get(declaration.source).path.parent().unwrap_or(Path::new("")).to_path_buf();
            let OpenDriveKeys { file } = declaration.block.keys();
            let shown = (file.as_str(), "the folder of the file that names them");
            read(declaration, &folder.join(&file), shown, site.read, site.said)?
        }
    };
    Some(Drawn { parts, half_width: f64::INFINITY })
}

/// Reads a map; `shown` is its path in messages, and what that is relative to.
pub(super) fn read(
    declaration: &Declaration,
    file: &Path,
    (shown, relative_to): (&str, &str),
    reader: &dyn Reader,
    said: &mut Vec<Diagnostic>,
) -> Option<TownParts> {
    let place = declaration.block.place("file");
    let mut missing = false;
    let text = reader.text(file).map_err(|error| {
        missing = error.kind() == std::io::ErrorKind::NotFound;
        lang::reason(&error)
    });
    match text.and_then(|text| opendrive::read(&text, &declaration.name).map_err(|error| error.to_string())) {
        Ok(mut parts) => {
            // What has no effect is listed by `falsify preview`; it is not a mistake of the file.
            let mistakes = parts.warnings.iter().filter(|warning| !warning.problem.is_unused());
            let assumed = AssumedLimit::of(&parts.roads, &parts.speed_signs).map(|assumed| assumed.to_string());
            let warnings: Vec<String> = assumed.into_iter().chain(mistakes.map(ToString::to_string)).collect();
            if !warnings.is_empty() {
                said.push(diagnostics::map_warning(place, shown, &warnings));
            }
            let blake3 = parts.map.as_ref().map(|text| blake3::hash(text.as_bytes()).to_hex().to_string());
            parts.map_file = blake3.map(|blake3| MapFile { path: reader.identity(file), blake3 });
            Some(parts)
        }
        Err(reason) => {
            let unusable = diagnostics::unusable_map(place, shown, &reason);
            let help = || format!("paths are relative to {relative_to}");
            said.push(if missing { unusable.help(help()) } else { unusable });
            None
        }
    }
}

//! The standard library: scenario files that come with the program.

use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use super::parse;
use base::diagnostic::{Sources, Span};

/// The folder in which its files are shown and import each other; it exists in no file system.
const FOLDER: &str = "<std>";

const FILES: &[(&str, &str)] = &[
    ("carla_towns.scn", include_str!("library/carla_towns.scn")),
    ("drivers.scn", include_str!("library/drivers.scn")),
    ("fmvss127.scn", include_str!("library/fmvss127.scn")),
    ("ncap.scn", include_str!("library/ncap.scn")),
    ("paper.scn", include_str!("library/paper.scn")),
    ("paper_tables.scn", include_str!("library/paper_tables.scn")),
    ("pedestrians.scn", include_str!("library/pedestrians.scn")),
    ("r152.scn", include_str!("library/r152.scn")),
    ("requirements.scn", include_str!("library/requirements.scn")),
    ("rewards.scn", include_str!("library/rewards.scn")),
    ("sensors.scn", include_str!("library/sensors.scn")),
    ("towns.scn", include_str!("library/towns.scn")),
];

/// The networks that they name.
const NETWORKS: &[(&str, &[u8])] = &[
    ("hunter.onnx", include_bytes!("library/hunter.onnx")),
    ("hunter_child.onnx", include_bytes!("library/hunter_child.onnx")),
];

/// A declaration or a parameter of the library.
struct Statement {
    file: &'static str,
    /// The form; `param` of a parameter.
    form: String,
    name: String,
    /// Its text, with its documentation.
    text: &'static str,
}

/// All statements with a name, by file. Only messages and explanations need them, so they are read once, on demand.
static STATEMENTS: LazyLock<Vec<Statement>> = LazyLock::new(|| {
    let read = |(file, text): &(&'static str, &'static str)| {
        let tree = parse(Sources::default().add(file, *text), text).0;
        let (file, text) = (*file, *text);
        let statement = move |form: &str, name: &str, span: Span| {
            let (form, name, text) = (form.to_string(), name.to_string(), &text[span.start..span.end]);
            Statement { file, form, name, text }
        };
        let params: Vec<_> = tree.params.iter().map(|param| statement("param", &param.name.text, param.span)).collect();
        let declared = tree.declarations.into_iter().filter_map(move |each| {
            let name = each.name.as_ref()?;
            Some(statement(&each.form.text, &name.text, each.span))
        });
        params.into_iter().chain(declared)
    };
    FILES.iter().flat_map(read).collect()
});

/// The file that declares something.
pub(super) fn home(form: &str, name: &str) -> Option<&'static str> {
    STATEMENTS.iter().find(|each| each.form == form && each.name == name).map(|each| each.file)
}

/// The statements that declare something of this name, each with its file.
pub fn statements(name: &str) -> impl Iterator<Item = (&'static str, &'static str)> {
    STATEMENTS.iter().filter(move |each| each.name == name).map(|each| (each.file, each.text))
}

/// The first comment of the file `std/NAME.scn`, and the names that it declares; `None` without such a file.
pub fn about(name: &str) -> Option<(String, Vec<&'static str>)> {
    let (file, text) = FILES.iter().find(|(file, _)| file.strip_suffix(".scn") == Some(name))?;
    let comment: Vec<&str> = text.lines().map_while(|line| line.strip_prefix("//")).map(str::trim).collect();
    let names = STATEMENTS.iter().filter(|each| each.file == *file).map(|each| each.name.as_str());
    Some((comment.join("\n"), names.collect()))
}

/// The names of its files, as written after `std/` in an import.
pub fn names() -> impl Iterator<Item = &'static str> {
    FILES.iter().map(|(name, _)| *name)
}

/// The place of a file that is imported as `std/…`.
pub fn place(import: &str) -> Option<PathBuf> {
    import.strip_prefix("std/").map(|name| Path::new(FOLDER).join(name))
}

/// A network of the library, at this path; `None` for other paths.
pub fn network(path: &Path) -> Option<&'static [u8]> {
    let name = path.strip_prefix(FOLDER).ok()?.to_str()?;
    NETWORKS.iter().find(|(known, _)| *known == name).map(|(_, bytes)| *bytes)
}

/// Whether a path leads into the library.
pub fn holds(path: &Path) -> bool {
    path.starts_with(FOLDER)
}

/// The text of a file of the library.
///
/// # Errors
/// The library has no such file.
pub fn read(path: &Path) -> std::io::Result<&'static str> {
    let name = path.strip_prefix(FOLDER).ok().and_then(Path::to_str);
    let found = FILES.iter().find(|(known, _)| Some(*known) == name);
    found.map(|(_, text)| *text).ok_or_else(|| {
        let known = names().map(|name| format!("`std/{name}`")).collect::<Vec<_>>().join(", ");
        std::io::Error::other(format!("the standard library holds {known}"))
    })
}

//! Follows imports: paths → files, each read once.

use std::collections::BTreeMap;
use std::path::{Component, Path, PathBuf};

use super::ast::File;
use super::diagnostics::reason;
use super::tokens::{TokenKind, tokens};
use super::{diagnostics, library, parse};
use base::diagnostic::{Diagnostic, SourceId, Sources, Span};

/// Reads files; the front end's only access to the outside. A function that returns a file's text is a reader.
pub trait Reader {
    /// The text of a file.
    ///
    /// # Errors
    /// It cannot be read, or is not text.
    fn text(&self, path: &Path) -> std::io::Result<String>;

    /// The bytes of a file that is not text.
    ///
    /// # Errors
    /// It cannot be read.
    fn bytes(&self, path: &Path) -> std::io::Result<Vec<u8>> {
        self.text(path).map(String::into_bytes)
    }

    /// The same path for all paths of one file, as far as the reader knows.
    fn identity(&self, path: &Path) -> PathBuf {
        path.to_path_buf()
    }
}

impl<F: Fn(&Path) -> std::io::Result<String>> Reader for F {
    fn text(&self, path: &Path) -> std::io::Result<String> {
        self(path)
    }
}

/// A named file that cannot be read.
#[derive(Debug, thiserror::Error)]
#[error("cannot read `{path}`: {reason}", path = path.display(), reason = reason(source))]
pub struct Unreadable {
    pub path: PathBuf,
    pub source: std::io::Error,
}

/// Everything that was read.
#[derive(Debug, Clone)]
pub struct Loaded {
    /// The trees, in the order of the sources.
    pub files: Vec<File>,
    /// The files that the user named, as opposed to imported ones.
    pub roots: Vec<SourceId>,
    pub diagnostics: Vec<Diagnostic>,
}

/// Reads the named files and all they import, adding each text to the sources once.
///
/// # Errors
/// The first named file that cannot be read, with the reason. An import that cannot be read is a diagnostic instead.
pub fn load(paths: &[PathBuf], read: &dyn Reader, sources: &mut Sources) -> Result<Loaded, Unreadable> {
    let (known, files, diagnostics) = (BTreeMap::new(), Vec::new(), Vec::new());
    let mut loader = Loader { read, sources, known, files, diagnostics };
    let mut roots = Vec::new();
    for path in paths {
        let source = loader.file(path, &mut Vec::new()).map_err(|source| Unreadable { path: path.clone(), source })?;
        if !roots.contains(&source) {
            roots.push(source);
        }
    }
    let Loader { mut files, mut diagnostics, sources, .. } = loader;
    diagnostics::explain_foreign(&mut diagnostics, sources);
    files.sort_by_key(|file| file.source);
    Ok(Loaded { files, roots, diagnostics })
}

/// Maximum length of a chain of imports (files).
const MAX_CHAIN: usize = 256;

struct Loader<'a> {
    read: &'a dyn Reader,
    sources: &'a mut Sources,
    known: BTreeMap<PathBuf, SourceId>,
    files: Vec<File>,
    diagnostics: Vec<Diagnostic>,
}

impl Loader<'_> {
    fn file(&mut self, path: &Path, importers: &mut Vec<SourceId>) -> std::io::Result<SourceId> {
        let of_library = library::holds(path);
        let key = if of_library { normal(path) } else { normal(&self.read.identity(path)) };
        if let Some(source) = self.known.get(&key) {
            return Ok(*source);
        }
        if importers.len() > MAX_CHAIN {
            let reason = format!("it stands at the end of {MAX_CHAIN} files that import each other in a row");
            return Err(std::io::Error::other(reason));
        }
        let source = if of_library {
            self.sources.add_builtin(path, library::read(path)?)
        } else {
            let text = self.read.text(path)?;
            // Messages quote the files of a scenario. A file that an import names may be anything, such as a list of passwords.
            if !importers.is_empty() && !starts_with_edition(&text) {
                return Err(std::io::Error::other("it is not a scenario: it does not start with `edition 1`"));
            }
            self.sources.add_file(path, text)
        };
        self.known.insert(key, source);
        let text = &self.sources.get(source).text;
        let (mut file, mut diagnostics) = parse(source, text);
        let unread = !diagnostics.is_empty();
        self.diagnostics.append(&mut diagnostics);
        if file.edition.is_none() && !unread {
            self.diagnostics.push(diagnostics::missing_edition(Span { source, start: 0, end: 0 }));
        }
        if let Some((edition, span)) = file.edition
            && edition != 1.0
        {
            self.diagnostics.push(diagnostics::unknown_edition(span, edition));
        }
        importers.push(source);
        for import in &mut file.imports {
            let place = path.parent().unwrap_or(Path::new("")).join(&import.path);
            // The folder of the library is a name for messages only.
            let mut found = match library::holds(&place) && !of_library {
                true => Err(std::io::ErrorKind::NotFound.into()),
                false => self.file(&place, importers),
            };
            // A file of the user's has precedence over the library's.
            if let (Err(error), Some(place)) = (&found, library::place(&import.path))
                && error.kind() == std::io::ErrorKind::NotFound
            {
                found = self.file(&place, importers);
            }
            match found {
                Ok(imported) if importers.contains(&imported) => {
                    let circle = importers.iter().skip_while(|file| **file != imported);
                    let circle: Vec<String> =
                        circle.map(|file| self.sources.get(*file).path.display().to_string()).collect();
                    self.diagnostics.push(diagnostics::import_cycle(import.span, &import.path, &circle));
                }
                Ok(imported) => import.source = Some(imported),
                Err(error) => self.diagnostics.push(diagnostics::import_not_found(import.span, &import.path, &error)),
            }
        }
        importers.pop();
        self.files.push(file);
        Ok(source)
    }
}

/// Whether the first word of a text is `edition`, in any case.
fn starts_with_edition(text: &str) -> bool {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let word = tokens(text).find(|token| !token.kind.is_trivia() && token.kind != TokenKind::Doc);
    word.is_some_and(|word| text[word.range()].eq_ignore_ascii_case("edition"))
}

/// The same path for `a/../b` and `b`, without asking the file system.
pub fn normal(path: &Path) -> PathBuf {
    let mut result = PathBuf::new();
    for component in path.components() {
        match component {
            Component::CurDir => {}
            Component::ParentDir if matches!(result.components().next_back(), Some(Component::Normal(_))) => {
                result.pop();
            }
            other => result.push(other),
        }
    }
    result
}

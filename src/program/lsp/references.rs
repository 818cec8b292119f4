//! All places of a name, and a new name for it.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use super::cursor::{Cursor, Place, places};
use super::documents::Documents;
use super::visible::{Visible, referred};
use super::workspace::{MAX_FILES, Scenarios, scenarios};
use base::diagnostic::{Severity, Sources, Span};
use compile::{Catalog, compile};
use lang::tokens::{TokenKind, is_word, tokens};
use lang::{Loaded, ast, library, normal};

/// A name with its places in all files that see it.
pub struct Places {
    pub name: String,
    /// The form of the declaration; `None` for a parameter.
    form: Option<String>,
    /// The file that declares it, and the first byte of the name there.
    pub declared: (PathBuf, usize),
    /// The files that see the declaration: their texts and the places, in order.
    pub files: BTreeMap<PathBuf, (String, Vec<Span>)>,
    /// Whether the folders of the editor have more scenarios than are looked at.
    is_cut: bool,
}

/// The names that a file declares, with the forms of declarations.
pub fn declared_names(file: &ast::File) -> impl Iterator<Item = (&ast::Name, Option<&ast::Name>)> {
    let declarations = file.declarations.iter().filter(|each| !each.is_inline);
    let names = declarations.filter_map(|each| Some((each.name.as_ref()?, Some(&each.form))));
    names.chain(file.params.iter().map(|param| (&param.name, None)))
}

/// The name at a byte that a file declares there.
pub fn own_name(file: &ast::File, byte: usize) -> Option<Span> {
    let mut own = declared_names(file).map(|(name, _)| name.span);
    own.find(|span| (span.start..=span.end).contains(&byte))
}

/// The name in the declaration that the word at a byte refers to, or the start of the file that an import names.
pub fn target(cursor: &Cursor, byte: usize, loaded: &Loaded, sources: &Sources) -> Option<Span> {
    let root = loaded.files.iter().find(|file| loaded.roots.contains(&file.source))?;
    let import = root.imports.iter().find(|import| (import.span.start..=import.span.end).contains(&byte));
    let visible = Visible { loaded, sources };
    let word = cursor.word;
    let declared = |form: Option<&str>| Some(visible.declaration(form, word)?.name.as_ref()?.span);
    let param = || Some(visible.param(word)?.name.span);
    match (import, cursor.place) {
        (Some(import), _) => Some(Span { source: import.source?, start: 0, end: 0 }),
        (None, Place::Formula | Place::EventWord(_)) if is_of_requirement(&sources.get(root.source).text, byte) => {
            declared(Some("requirement")).or_else(param)
        }
        (None, Place::Value(wanted)) => match referred(&wanted.ty) {
            Some(form) => declared(Some(form)).or_else(param),
            None => param(),
        },
        (None, Place::Imported(_)) => {
            // The file may have a name of its own that is the same.
            let at_byte = |name: &ast::Name| (name.span.start..=name.span.end).contains(&byte);
            let source =
                root.imports.iter().find(|import| import.names.iter().any(at_byte)).and_then(|import| import.source);
            let file = loaded.files.iter().find(|file| Some(file.source) == source);
            let mut names = file.into_iter().flat_map(declared_names).map(|(name, _)| name);
            names.find(|name| name.text == word).map(|name| name.span).or_else(|| declared(None)).or_else(param)
        }
        (None, Place::ParamValue { .. } | Place::AxisValue(_)) => declared(None).or_else(param),
        (None, Place::Formula | Place::Param | Place::Axis) => param(),
        _ => None,
    }
}

/// Whether the word at a byte is in the parentheses of `violated` or `robustness`.
fn is_of_requirement(text: &str, byte: usize) -> bool {
    let before = text[..byte].trim_end_matches(|last: char| last.is_ascii() && is_word(last as u8));
    let owner = before.trim_end().strip_suffix('(').map(str::trim_end);
    let owner = owner.and_then(|owner| owner.rsplit(|last: char| !last.is_ascii() || !is_word(last as u8)).next());
    matches!(owner, Some("violated" | "robustness"))
}

/// The place of the name in its declaration, for a word of a file: the declaration itself, or what refers to it.
fn declaration(cursor: &Cursor, byte: usize, loaded: &Loaded, sources: &Sources) -> Option<Span> {
    let root = loaded.files.iter().find(|file| loaded.roots.contains(&file.source))?;
    own_name(root, byte).or_else(|| target(cursor, byte, loaded, sources)).filter(|span| span.start < span.end)
}

/// All places of the name at a byte of an open document: in its file, in the files that it imports, in open documents, in the scenarios
/// beside the declaration, and in those below the folders that the editor has open.
pub fn places_of(
    cursor: &Cursor,
    byte: usize,
    loaded: &Loaded,
    sources: &Sources,
    documents: &Documents,
    folders: &[PathBuf],
    catalog: &Catalog,
) -> Option<Places> {
    let span = declaration(cursor, byte, loaded, sources)?;
    let file = loaded.files.iter().find(|file| file.source == span.source)?;
    let (name, form) = declared_names(file).find(|(name, _)| name.span == span)?;
    let home = normal(&sources.get(span.source).path);
    let mut files: BTreeSet<PathBuf> = documents.paths().into_iter().collect();
    files.extend(sources.iter().map(|(_, source)| normal(&source.path)));
    files.extend(beside(&home));
    // Names of the standard library stay, and have uses everywhere.
    let below = if library::holds(&home) { Scenarios::default() } else { scenarios(folders) };
    files.extend(below.paths);
    let mut found = Places {
        name: name.text.clone(),
        form: form.map(|form| form.text.clone()),
        declared: (home, span.start),
        files: BTreeMap::new(),
        is_cut: below.is_cut,
    };
    for path in files {
        if let Some(places) = found.in_file(&path, documents, catalog) {
            found.files.insert(path, places);
        }
    }
    Some(found)
}

/// The scenarios in the folder of a file.
fn beside(file: &Path) -> Vec<PathBuf> {
    let entries = file.parent().filter(|_| !library::holds(file)).and_then(|folder| std::fs::read_dir(folder).ok());
    let paths = entries.into_iter().flatten().filter_map(|entry| Some(entry.ok()?.path()));
    paths.filter(|path| path.extension().is_some_and(|end| end == "scn")).collect()
}

/// A file with its imports, as the editor sees it.
fn load(path: &Path, documents: &Documents) -> Option<(Loaded, Sources)> {
    let mut sources = Sources::default();
    let loaded = lang::load(&[path.to_path_buf()], documents, &mut sources).ok()?;
    Some((loaded, sources))
}

impl Places {
    /// The text of a file and the places of the name in it; `None` for a file that does not see the declaration.
    fn in_file(&self, path: &Path, documents: &Documents, catalog: &Catalog) -> Option<(String, Vec<Span>)> {
        let (loaded, sources) = load(path, documents)?;
        let is_declared = |span: Span| (normal(&sources.get(span.source).path), span.start) == self.declared;
        let root = *loaded.roots.first()?;
        sources.iter().find(|(_, source)| normal(&source.path) == self.declared.0)?;
        let text = &sources.get(root).text;
        let words = places(text, catalog).into_iter().filter(|(span, _)| text[span.clone()] == self.name);
        let here = words.filter(|(span, place)| {
            let cursor = Cursor { word: &text[span.clone()], place: *place, signature: None };
            declaration(&cursor, span.start, &loaded, &sources).is_some_and(is_declared)
        });
        let spans = here.map(|(span, _)| Span { source: root, start: span.start, end: span.end }).collect();
        Some((text.to_string(), spans))
    }

    /// The files with the new name in place of the old one.
    fn renamed(&self, new: &str) -> BTreeMap<PathBuf, String> {
        let renamed = |(text, spans): &(String, Vec<Span>)| {
            let mut text = text.clone();
            spans.iter().rev().for_each(|span| text.replace_range(span.start..span.end, new));
            text
        };
        self.files.iter().map(|(path, file)| (path.clone(), renamed(file))).collect()
    }

    /// Checks that this name can be given up for another.
    ///
    /// # Errors
    /// Why it cannot, as a sentence.
    pub fn check_old_name(&self) -> Result<(), String> {
        let old = &self.name;
        if library::holds(&self.declared.0) || !self.files.contains_key(&self.declared.0) {
            return Err(format!("`{old}` is declared in the standard library: declare one of your own"));
        }
        if self.is_cut {
            return Err(format!(
                "the open folder has more than {MAX_FILES} scenarios, and some that use `{old}` might be missed: open a smaller folder"
            ));
        }
        Ok(())
    }

    /// Checks that a new name can take the place of this one.
    ///
    /// # Errors
    /// Why it cannot, as a sentence.
    pub fn check_new_name(&self, new: &str, documents: &Documents, catalog: &Catalog) -> Result<(), String> {
        let old = &self.name;
        self.check_old_name()?;
        if new == old {
            return Ok(());
        }
        let mut words = tokens(new);
        if !matches!((words.next(), words.next()), (Some(only), None) if only.kind == TokenKind::Name) {
            return Err(format!(
                "`{new}` is not a name: a name is a word of letters, digits and `_` that is not a keyword"
            ));
        }
        for path in self.files.keys() {
            let Some((loaded, sources)) = load(path, documents) else { continue };
            let visible = Visible { loaded: &loaded, sources: &sources };
            if visible.param(new).is_some() || visible.declaration(self.form.as_deref(), new).is_some() {
                return Err(format!("`{new}` is taken: {} sees another declaration of this name", path.display()));
            }
        }
        // A name may be taken in other ways, such as by a variable of formulas.
        let texts = self.renamed(new);
        let read = |path: &Path| match texts.get(&normal(path)) {
            Some(text) => Ok(text.clone()),
            None => documents.read(path),
        };
        for path in self.files.keys() {
            let before = errors(path, &|path: &Path| documents.read(path), catalog);
            let after = errors(path, &read, catalog);
            if after.len() > before.len() {
                let reason = after.iter().find(|message| !before.contains(message)).unwrap_or(&after[0]);
                return Err(format!("`{new}` cannot take the place of `{old}` in {}: {reason}", path.display()));
            }
        }
        Ok(())
    }
}

/// The errors of a scenario.
fn errors(path: &Path, read: &dyn lang::Reader, catalog: &Catalog) -> Vec<String> {
    let compiled = compile(&[path.to_path_buf()], catalog, read, &mut Sources::default());
    let all = compiled.map(|compiled| compiled.diagnostics).unwrap_or_default();
    all.into_iter().filter(|each| each.severity == Severity::Error).map(|each| each.message).collect()
}

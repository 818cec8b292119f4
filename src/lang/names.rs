//! The names that a file can see: its own declarations and parameters, and those of the files it imports.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Bound;

use super::ast::{File, Import, Name};
use super::diagnostics;
use super::hir::ParamId;
use super::library;
use super::suggest::nearest;
use base::diagnostic::{Diagnostic, SourceId, Sources, Span};
use base::signature::{DeclarationId, Form};

/// The names a file can see.
#[derive(Debug, Clone, Default)]
pub(super) struct Names<'a> {
    known: BTreeMap<(&'a str, &'a str), (DeclarationId, Span)>,
    /// The number of the first declaration of the file; the others follow it.
    first: usize,
    params: BTreeMap<&'a str, (ParamId, Span)>,
    /// Names of statements that could not be read.
    unread: BTreeSet<&'a str>,
    /// Whether there may be other names, in statements that could not be read.
    torn: bool,
    /// The word after which an import would be added; none for a text that is not a file.
    imports: Option<Span>,
    /// The paths from which single names are imported, with the place of the last name of each.
    selective: BTreeMap<&'a str, Span>,
}

impl<'a> Names<'a> {
    pub fn find(&self, form: &str, name: &str) -> Option<DeclarationId> {
        self.known.get(&(form, name)).map(|(id, _)| *id)
    }

    /// The declaration at an index of the file.
    pub fn own(&self, index: usize) -> DeclarationId {
        DeclarationId(self.first + index)
    }

    /// A declaration with the place of its name.
    pub fn find_with_place(&self, form: &str, name: &str) -> Option<(DeclarationId, Span)> {
        self.known.get(&(form, name)).copied()
    }

    /// The names of a form, in order.
    pub fn of_form(&self, form: &'a str) -> impl Iterator<Item = &'a str> {
        self.known.range((form, "")..).take_while(move |((f, _), _)| *f == form).map(|((_, name), _)| *name)
    }

    pub fn param(&self, name: &str) -> Option<ParamId> {
        self.params.get(name).map(|(id, _)| *id)
    }

    /// The names of all parameters, in order.
    pub fn params(&self) -> impl Iterator<Item = &'a str> {
        self.params.keys().copied()
    }

    /// Another form with a declaration of this name.
    pub fn other_form(&self, forms: &'a [Form], name: &str) -> Option<&'a str> {
        forms.iter().map(|form| form.name).find(|form| self.known.contains_key(&(*form, name)))
    }

    /// Whether a declaration of this name has a form that is none of these, which has been reported.
    pub fn has_form_beside(&self, forms: &[Form], name: &str) -> bool {
        // A hostile file may have any number of forms.
        const MOST: usize = 100;
        let mut after = Bound::Unbounded;
        for _ in 0..MOST {
            let Some(((form, _), _)) = self.known.range((after, Bound::Unbounded)).next() else { break };
            if !forms.iter().any(|known| known.name == *form) && self.known.contains_key(&(*form, name)) {
                return true;
            }
            // A character that follows every possible name.
            after = Bound::Excluded((*form, "\u{10ffff}"));
        }
        false
    }

    /// Whether an unknown name may be declared in a statement that could not be read, which has been reported.
    /// A name similar to a known one is probably a typo of that one instead.
    pub fn may_be_unread<'b>(&self, name: &str, known: impl IntoIterator<Item = &'b str>) -> bool {
        // The same number of names as for a suggestion.
        const MOST: usize = 200;
        self.unread.contains(name) || self.torn && nearest(name, known.into_iter().take(MOST)).is_none()
    }

    /// The import that would add a name of the standard library, and its place.
    pub fn another_import(&self, name: &str, file: &str, sources: &Sources) -> Option<(Span, String)> {
        let path = format!("std/{file}");
        if let Some(last) = self.selective.get(path.as_str()) {
            return Some((Span { start: last.end, ..*last }, format!(", {name}")));
        }
        let word = self.imports?;
        // A whole file cannot be imported if it has a name that the user declares. A user with very many names gets the error then.
        const MOST: usize = 1000;
        let own = self.known.iter().filter(|(_, (_, span))| span.source == word.source).take(MOST);
        let clash = own.map(|((form, name), _)| library::home(form, name)).any(|home| home == Some(file));
        let import = if clash { format!("import {name} from \"{path}\"") } else { format!("import \"{path}\"") };
        let text = &sources.get(word.source).text;
        let line = text[word.end..].lines().next().unwrap_or_default();
        // A comment stays with the line that it describes.
        let comment = line.trim_start().starts_with("//");
        let at = word.end + if comment { line.len() } else { 0 };
        let line_end = if text.contains("\r\n") { "\r\n" } else { "\n" };
        let added = if at > 0 { format!("{line_end}{import}") } else { format!("{import}{line_end}") };
        Some((Span { source: word.source, start: at, end: at }, added))
    }

    pub fn has_params(&self) -> bool {
        !self.params.is_empty()
    }

    /// Adds the names of an import, or all names of its file.
    fn import(&mut self, import: &'a Import, other: &Names<'a>, diagnostics: &mut Vec<Diagnostic>) {
        let named: BTreeSet<&str> = import.names.iter().map(|name| name.text.as_str()).collect();
        let wanted = |name: &str| named.is_empty() || named.contains(name);
        for ((form, name), (id, span)) in &other.known {
            if wanted(name) {
                self.declare(form, name, *id, *span, diagnostics);
            }
        }
        for (name, (id, span)) in &other.params {
            if wanted(name) {
                self.declare_param(name, *id, *span, diagnostics);
            }
        }
        self.unread.extend(other.unread.iter().filter(|name| wanted(name)));
        if named.is_empty() {
            self.torn |= other.torn;
            return;
        }
        let offered: BTreeSet<&str> =
            other.known.keys().map(|(_, name)| *name).chain(other.params.keys().copied()).collect();
        let missing = |name: &&Name| !offered.contains(name.text.as_str());
        for name in import.names.iter().filter(missing) {
            if other.may_be_unread(&name.text, offered.iter().copied()) {
                self.unread.insert(&name.text);
                continue;
            }
            // Neither the written name nor the suggested one is reported again where it is used.
            self.unread.insert(&name.text);
            self.unread.extend(nearest(&name.text, offered.iter().copied()));
            diagnostics.push(diagnostics::unknown_import(name.span, &name.text, &import.path, offered.iter().copied()));
        }
    }

    fn declare(&mut self, form: &'a str, name: &'a str, id: DeclarationId, span: Span, said: &mut Vec<Diagnostic>) {
        match self.known.insert((form, name), (id, span)) {
            Some((other, first)) if other != id => {
                said.push(diagnostics::duplicate_declaration(span, form, name, first));
            }
            _ => {}
        }
    }

    fn declare_param(&mut self, name: &'a str, id: ParamId, span: Span, said: &mut Vec<Diagnostic>) {
        match self.params.insert(name, (id, span)) {
            Some((other, first)) if other != id => {
                said.push(diagnostics::duplicate_declaration(span, "param", name, first));
            }
            _ => {}
        }
    }
}

/// The names that each file can see, in the order of the files.
pub(super) fn names_of_all<'a>(
    files: &'a [File],
    ids: &BTreeMap<SourceId, Vec<DeclarationId>>,
    diagnostics: &mut Vec<Diagnostic>,
) -> Vec<Names<'a>> {
    let mut done: BTreeMap<SourceId, Names<'a>> = BTreeMap::new();
    for file in files {
        visit(file, files, ids, &mut done, diagnostics);
    }
    files.iter().map(|file| done.remove(&file.source).expect("each file is visited")).collect()
}

// Imports have no cycles: the loader has removed them.
fn visit<'a>(
    file: &'a File,
    files: &'a [File],
    ids: &BTreeMap<SourceId, Vec<DeclarationId>>,
    done: &mut BTreeMap<SourceId, Names<'a>>,
    diagnostics: &mut Vec<Diagnostic>,
) {
    if done.contains_key(&file.source) {
        return;
    }
    let unread = file.unread.iter().map(String::as_str).collect();
    let start = Span { source: file.source, start: 0, end: 0 };
    let before = file.imports.iter().map(|import| import.span).max();
    let imports = before.or(file.edition.map(|(_, span)| span)).unwrap_or(start);
    let several = file.imports.iter().filter_map(|import| Some((import.path.as_str(), import.names.last()?.span)));
    let selective = several.collect();
    let first = ids[&file.source].first().map_or(0, |id| id.0);
    let mut names = Names { unread, torn: file.torn, imports: Some(imports), selective, first, ..Names::default() };
    for import in &file.imports {
        let Some(source) = import.source else {
            // The names that it would have imported are not known.
            names.torn |= import.names.is_empty();
            names.unread.extend(import.names.iter().map(|name| name.text.as_str()));
            continue;
        };
        let imported = files.binary_search_by_key(&source, |file| file.source).expect("imports are loaded, in order");
        visit(&files[imported], files, ids, done, diagnostics);
        names.import(import, &done[&source], diagnostics);
    }
    let declared = file.declarations.iter().zip(&ids[&file.source]).filter(|(declaration, _)| !declaration.is_inline);
    for (declaration, id) in declared {
        match &declaration.name {
            Some(name) => names.declare(&declaration.form.text, &name.text, *id, name.span, diagnostics),
            // It may be a name without its form.
            None => drop(names.unread.insert(&declaration.form.text)),
        }
    }
    for (index, param) in file.params.iter().enumerate() {
        names.declare_param(&param.name.text, (file.source, index), param.name.span, diagnostics);
    }
    done.insert(file.source, names);
}

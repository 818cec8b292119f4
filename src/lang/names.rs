//! The names that a file can see: its own declarations and parameters, and those of the files it imports.

use std::collections::{BTreeMap, BTreeSet};

use super::ast::{File, Import, Name};
use super::diagnostics;
use super::hir::ParamId;
use base::diagnostic::{Diagnostic, SourceId, Sources, Span};
use base::signature::{DeclarationId, Form};
use base::suggest::nearest;

/// The names a file can see.
#[derive(Debug, Clone, Default)]
pub(super) struct Names<'a> {
    known: BTreeMap<(&'a str, &'a str), (DeclarationId, Span)>,
    /// The number of the first declaration of the file; the others follow it.
    first: usize,
    params: BTreeMap<&'a str, (ParamId, Span)>,
    /// Whether there may be other names, in statements that could not be read or have an unknown form.
    torn: bool,
    /// The place after which an import would be added; `None` for a text that is not a file.
    imports: Option<Span>,
}

impl<'a> Names<'a> {
    pub fn find(&self, form: &str, name: &str) -> Option<DeclarationId> {
        self.known.get(&(form, name)).map(|(id, _)| *id)
    }

    /// The declaration at an index of the file.
    pub fn own(&self, index: usize) -> DeclarationId {
        DeclarationId(self.first + index)
    }

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

    /// Whether an unknown name may be declared in a statement that could not be read, which has been reported.
    /// A name similar to a known one is probably a typo of that one instead.
    pub fn may_be_unread<'b>(&self, name: &str, known: impl IntoIterator<Item = &'b str>) -> bool {
        // The same number of names as for a suggestion.
        const MAX_COMPARED: usize = 200;
        self.torn && nearest(name, known.into_iter().take(MAX_COMPARED)).is_none()
    }

    /// The import that would add a name of the standard library, and its place.
    pub fn another_import(&self, name: &str, file: &str, sources: &Sources) -> Option<(Span, String)> {
        let last = self.imports?;
        let import = format!("import {name} from \"std/{file}\"");
        let line = sources.get(last.source).text[last.end..].lines().next().unwrap_or_default();
        // A comment stays with the line that it describes.
        let at = last.end + if line.trim_start().starts_with("//") { line.len() } else { 0 };
        let added = if at > 0 { format!("\n{import}") } else { format!("{import}\n") };
        Some((Span { source: last.source, start: at, end: at }, added))
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
        self.torn |= other.torn;
        let offered: BTreeSet<&str> =
            other.known.keys().map(|(_, name)| *name).chain(other.params.keys().copied()).collect();
        let missing = |name: &&Name| !offered.contains(name.text.as_str());
        for name in import.names.iter().filter(missing) {
            // The name is not reported again where it is used.
            self.torn = true;
            if !other.may_be_unread(&name.text, offered.iter().copied()) {
                let known: Vec<&str> = offered.iter().copied().collect();
                diagnostics.push(diagnostics::unknown_import(name.span, &name.text, &import.path, &known));
            }
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
    forms: &[Form],
    diagnostics: &mut Vec<Diagnostic>,
) -> Vec<Names<'a>> {
    let mut done: BTreeMap<SourceId, Names<'a>> = BTreeMap::new();
    for file in files {
        visit(file, files, ids, forms, &mut done, diagnostics);
    }
    files.iter().map(|file| done.remove(&file.source).expect("each file is visited")).collect()
}

// Imports have no cycles: the loader has removed them.
fn visit<'a>(
    file: &'a File,
    files: &'a [File],
    ids: &BTreeMap<SourceId, Vec<DeclarationId>>,
    forms: &[Form],
    done: &mut BTreeMap<SourceId, Names<'a>>,
    diagnostics: &mut Vec<Diagnostic>,
) {
    if done.contains_key(&file.source) {
        return;
    }
    let start = Span { source: file.source, start: 0, end: 0 };
    let before = file.imports.iter().map(|import| import.span).max();
    let imports = before.or(file.edition.map(|(_, span)| span)).unwrap_or(start);
    let known = |form: &Name| forms.iter().any(|known| known.name == form.text);
    let torn = file.torn || file.declarations.iter().any(|each| each.name.is_none() || !known(&each.form));
    let first = ids[&file.source].first().map_or(0, |id| id.0);
    let mut names = Names { torn, imports: Some(imports), first, ..Names::default() };
    for import in &file.imports {
        let Some(source) = import.source else {
            // The names that it would have imported are not known.
            names.torn = true;
            continue;
        };
        let imported = files.binary_search_by_key(&source, |file| file.source).expect("imports are loaded, in order");
        visit(&files[imported], files, ids, forms, done, diagnostics);
        names.import(import, &done[&source], diagnostics);
    }
    let declared = file.declarations.iter().zip(&ids[&file.source]).filter(|(declaration, _)| !declaration.is_inline);
    for (declaration, id) in declared {
        if let Some(name) = &declaration.name {
            names.declare(&declaration.form.text, &name.text, *id, name.span, diagnostics);
        }
    }
    for (index, param) in file.params.iter().enumerate() {
        names.declare_param(&param.name.text, (file.source, index), param.name.span, diagnostics);
    }
    done.insert(file.source, names);
}

//! What a file can see: its own declarations and parameters, and those of the files it imports.

use std::collections::{BTreeMap, BTreeSet};

use super::ast::{File, Import};
use super::codes;
use crate::diagnostic::{Diagnostic, SourceId, Span};
use crate::signature::DeclarationId;

/// Names a parameter: its file and its place in it.
pub(super) type ParamId = (SourceId, usize);

/// The names a file can see.
#[derive(Debug, Clone, Default)]
pub(super) struct Names<'a> {
    known: BTreeMap<(&'a str, &'a str), (DeclarationId, Span)>,
    params: BTreeMap<&'a str, (ParamId, Span)>,
}

impl<'a> Names<'a> {
    pub fn find(&self, form: &str, name: &str) -> Option<DeclarationId> {
        self.known.get(&(form, name)).map(|(id, _)| *id)
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

    pub fn has_params(&self) -> bool {
        !self.params.is_empty()
    }

    /// Takes over what an import names, or everything.
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
        if named.is_empty() {
            return;
        }
        let offered: BTreeSet<&str> =
            other.known.keys().map(|(_, name)| *name).chain(other.params.keys().copied()).collect();
        for name in import.names.iter().filter(|name| !offered.contains(name.text.as_str())) {
            diagnostics.push(codes::unknown_import(name.span, &name.text, &import.path, offered.iter().copied()));
        }
    }

    fn declare(&mut self, form: &'a str, name: &'a str, id: DeclarationId, span: Span, said: &mut Vec<Diagnostic>) {
        match self.known.insert((form, name), (id, span)) {
            Some((other, first)) if other != id => {
                said.push(codes::duplicate_declaration(span, form, name, first));
            }
            _ => {}
        }
    }

    fn declare_param(&mut self, name: &'a str, id: ParamId, span: Span, said: &mut Vec<Diagnostic>) {
        match self.params.insert(name, (id, span)) {
            Some((other, first)) if other != id => said.push(codes::duplicate_declaration(span, "param", name, first)),
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

// Imports form no circles: the loader has cut them.
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
    let mut names = Names::default();
    for import in &file.imports {
        let Some(source) = import.source else { continue };
        let imported = files.binary_search_by_key(&source, |file| file.source).expect("imports are loaded, in order");
        visit(&files[imported], files, ids, done, diagnostics);
        names.import(import, &done[&source], diagnostics);
    }
    for (declaration, id) in file.declarations.iter().zip(&ids[&file.source]) {
        if let Some(name) = &declaration.name {
            names.declare(&declaration.form.text, &name.text, *id, name.span, diagnostics);
        }
    }
    for (index, param) in file.params.iter().enumerate() {
        names.declare_param(&param.name.text, (file.source, index), param.name.span, diagnostics);
    }
    done.insert(file.source, names);
}

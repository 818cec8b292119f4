//! From a name to its declaration, and what a file declares.

use lsp_types::{DocumentSymbol, Location, SymbolKind};

use super::cursor::{Cursor, Place};
use super::documents::{Documents, range};
use super::hover::{has_name, referred};
use crate::diagnostic::{Lines, Sources, Span};
use crate::lang::{Loaded, ast};

/// Where the word at a byte is declared, or the file that an import names.
pub fn definition(
    cursor: &Cursor,
    byte: usize,
    loaded: &Loaded,
    sources: &Sources,
    documents: &Documents,
) -> Option<Location> {
    let root = loaded.files.iter().find(|file| loaded.roots.contains(&file.source))?;
    let import = root.imports.iter().find(|import| (import.span.start..=import.span.end).contains(&byte));
    let target = match (import, cursor.place) {
        (Some(import), _) => Span { source: import.source?, start: 0, end: 0 },
        (None, Place::Value(param)) => {
            let form = referred(&param.ty);
            let all = loaded.files.iter().flat_map(|file| &file.declarations);
            let named = |each: &&ast::Declaration| has_name(each, cursor.word);
            // A word of another type may still name something, such as a parameter.
            let found = match form {
                Some(form) => all.clone().find(|each| each.form.text == form && has_name(each, cursor.word)),
                None => all.clone().find(named),
            };
            found?.name.as_ref()?.span
        }
        (None, Place::Formula) => {
            let mut all = loaded.files.iter().flat_map(|file| &file.declarations);
            all.find(|each| has_name(each, cursor.word))?.name.as_ref()?.span
        }
        _ => return None,
    };
    let source = sources.get(target.source);
    Some(Location { uri: documents.uri(&source.path)?, range: range(&Lines::new(&source.text), target) })
}

/// The declarations of a file.
#[expect(deprecated, reason = "the protocol's type has a field that is not to be used and cannot be left out")]
pub fn symbols(file: &ast::File, text: &str) -> Vec<DocumentSymbol> {
    let lines = Lines::new(text);
    let symbol = |declaration: &ast::Declaration| {
        let place = range(&lines, declaration.head);
        let name = declaration.name.as_ref().unwrap_or(&declaration.form);
        DocumentSymbol {
            name: name.text.clone(),
            detail: Some(declaration.form.text.clone()),
            kind: SymbolKind::CLASS,
            tags: None,
            deprecated: None,
            range: place,
            selection_range: place,
            children: None,
        }
    };
    file.declarations.iter().map(symbol).collect()
}

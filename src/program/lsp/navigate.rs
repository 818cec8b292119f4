//! From a name to its declaration, and the declarations of a file.

use std::sync::Arc;

use lsp_types::{DocumentSymbol, Location, SymbolKind};

use super::cursor::Cursor;
use super::documents::{Documents, range};
use super::references::{own_name, target};
use base::diagnostic::{Lines, Sources};
use lang::{Loaded, ast};

/// Where the word at a byte is declared, or the file that an import names. The name of a declaration is declared where it stands.
pub fn definition(
    cursor: &Cursor,
    byte: usize,
    loaded: &Loaded,
    sources: &Sources,
    documents: &Documents,
) -> Option<Location> {
    let root = loaded.files.iter().find(|file| loaded.roots.contains(&file.source));
    let own = root.and_then(|root| own_name(root, byte));
    let target = own.or_else(|| target(cursor, byte, loaded, sources))?;
    let source = sources.get(target.source);
    Some(Location { uri: documents.uri_to_show(&source.path)?, range: range(&Lines::new(&source.text), target) })
}

/// The declarations and parameters of a file, in order.
#[expect(deprecated, reason = "the protocol's type has a field that is not to be used and cannot be left out")]
pub fn symbols(file: &ast::File, text: &str) -> Vec<DocumentSymbol> {
    let lines = Lines::new(text);
    let symbol = |declaration: &Arc<ast::Declaration>| {
        let (place, head) = (range(&lines, declaration.span), range(&lines, declaration.head));
        let name = declaration.name.as_ref().unwrap_or(&declaration.form);
        DocumentSymbol {
            name: name.text.clone(),
            detail: Some(declaration.form.text.clone()),
            kind: SymbolKind::CLASS,
            tags: None,
            deprecated: None,
            range: place,
            selection_range: head,
            children: None,
        }
    };
    let param = |param: &ast::Param| {
        let place = range(&lines, param.name.span.to(param.value.span));
        DocumentSymbol {
            name: param.name.text.clone(),
            detail: Some(format!("param {}", param.ty.text)),
            kind: SymbolKind::CONSTANT,
            tags: None,
            deprecated: None,
            range: place,
            selection_range: range(&lines, param.name.span),
            children: None,
        }
    };
    let mut all: Vec<DocumentSymbol> =
        file.params.iter().map(param).chain(file.declarations.iter().map(symbol)).collect();
    all.sort_by_key(|symbol| symbol.range.start);
    all
}

//! From a name to its declaration, and the declarations of a file.

use std::sync::Arc;

use lsp_types::{DocumentSymbol, Location, SymbolKind};

use super::cursor::{Cursor, Place};
use super::documents::{Documents, range};
use super::hover::referred;
use super::references::{declared_names, own_name};
use super::visible::Visible;
use base::diagnostic::{Lines, Sources, Span};
use lang::tokens::is_word;
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

use lsp_types::{Hover, HoverContents, MarkupContent, MarkupKind};

use super::cursor::{Cursor, Place};
use super::references::own_name;
use super::visible::{Visible, referred};
use base::signature::Type;
use compile::{Catalog, block, key};
use lang::ast;

/// The hover text of the word at the cursor; of the name of a declaration it is the same as where the name is used.
pub fn hover(cursor: &Cursor, byte: usize, catalog: &Catalog, visible: Visible) -> Option<Hover> {
    let text = own(byte, visible).or_else(|| describe(cursor, catalog, visible))?;
    Some(Hover {
        contents: HoverContents::Markup(MarkupContent { kind: MarkupKind::Markdown, value: text }),
        range: None,
    })
}

/// The declaration of the file whose name is at a byte.
fn own(byte: usize, visible: Visible) -> Option<String> {
    let root = visible.loaded.files.iter().find(|file| visible.loaded.roots.contains(&file.source))?;
    let span = own_name(root, byte)?;
    let named = |name: &ast::Name| name.span == span;
    let declared = root.declarations.iter().find(|each| each.name.as_ref().is_some_and(named));
    let param = || root.params.iter().find(|param| named(&param.name)).map(|found| param_text(found, visible));
    declared.map(|found| declaration(found)).or_else(param)
}

/// A parameter as declared, with its documentation.
fn param_text(found: &ast::Param, visible: Visible) -> String {
    format!("```scn\n{}\n```\n\n{}", visible.declared(found), found.docs.join("\n"))
}

fn describe(cursor: &Cursor, catalog: &Catalog, visible: Visible) -> Option<String> {
    let word = cursor.word;
    let declared = |form: Option<&str>| visible.declaration(form, word).map(declaration);
    let param = || visible.param(word).map(|found| param_text(found, visible));
    match cursor.place {
        _ if word.is_empty() => None,
        Place::Form | Place::Type | Place::Unit(_) => catalog.page(&[word]),
        Place::Kind(form) => catalog.page(&[form, word]),
        Place::Event => catalog.page(&["on", word]),
        Place::EventWord(event) => catalog.page(&["on", event]),
        Place::Key => {
            let signature = cursor.signature?;
            let own = signature.params.iter().find(|param| param.name == word).map(key);
            own.or_else(|| signature.children.iter().find(|child| child.name == word).map(block))
        }
        Place::Value(wanted) => match referred(&wanted.ty) {
            Some(form) => declared(Some(form)).or_else(param),
            None if speaks(&wanted.ty) => catalog.page(&[word]).or_else(param).or_else(|| Some(key(wanted))),
            None => param().or_else(|| Some(key(wanted))),
        },
        Place::Formula => catalog.page(&[word]).or_else(param),
        Place::ParamValue { .. } | Place::AxisValue(_) => param().or_else(|| declared(None)),
        Place::Imported(_) => declared(None).or_else(param),
        Place::Param | Place::Axis => param(),
        Place::Import(_) | Place::Nothing => None,
    }
}

/// Whether a value is a formula.
fn speaks(ty: &Type) -> bool {
    match ty {
        Type::Condition(_) | Type::Formula(_) | Type::Requirement(_) => true,
        Type::List(item) => speaks(item),
        _ => false,
    }
}

/// A declaration's head and documentation.
fn declaration(found: &ast::Declaration) -> String {
    let name = found.name.as_ref().map_or("", |name| name.text.as_str());
    let kind = found.kind.as_ref().map_or(String::new(), |kind| format!(" = {}", kind.text));
    format!("```scn\n{} {name}{kind}\n```\n\n{}", found.form.text, found.docs.join("\n"))
}

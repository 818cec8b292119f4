use lsp_types::{Hover, HoverContents, MarkupContent, MarkupKind};

use super::cursor::{Cursor, Place};
use super::references::own_name;
use super::visible::Visible;
use base::signature::{Param, Type};
use base::units::parse_unit;
use compile::Catalog;
use lang::{DIMENSIONS, ast, functions, temporal_operators};

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
    if word.is_empty() {
        return None;
    }
    let declared = |form: Option<&str>| visible.declaration(form, word).map(declaration);
    let param = || visible.param(word).map(|found| param_text(found, visible));
    match cursor.place {
        Place::Form => {
            let form = catalog.forms.iter().find(|form| form.name == word)?;
            let kinds: Vec<String> = form.kinds.iter().map(|kind| format!("`{}`: {}", kind.name, kind.doc)).collect();
            Some(format!("**{word}** {}\n\n{}", form.doc, kinds.join("\n\n")))
        }
        Place::Kind(form) => {
            let form = catalog.forms.iter().find(|each| each.name == form)?;
            let kind = form.kinds.iter().find(|kind| kind.name == word)?;
            let keys: Vec<String> = kind.params.iter().map(|param| format!("- {}", one_line(param))).collect();
            Some(format!("**{word}** {}\n\n{}", kind.doc, keys.join("\n")))
        }
        Place::Key => {
            let signature = cursor.signature?;
            if let Some(param) = signature.params.iter().find(|param| param.name == word) {
                return Some(key(param));
            }
            let child = signature.children.iter().find(|child| child.name == word)?;
            Some(format!("**{word}** {}", child.doc))
        }
        Place::Value(wanted) => match referred(&wanted.ty) {
            Some(form) => declared(Some(form)).or_else(param),
            None if speaks(&wanted.ty) => part(word, catalog).or_else(param).or_else(|| Some(key(wanted))),
            None => param().or_else(|| Some(key(wanted))),
        },
        Place::ParamValue { .. } | Place::AxisValue(_) => param().or_else(|| declared(None)),
        Place::Imported(_) => declared(None).or_else(param),
        Place::Param | Place::Axis => param(),
        Place::Type => {
            if let Some(form) = catalog.forms.iter().find(|form| form.name == word) {
                return Some(format!("**{word}** The name of one: {}", form.doc));
            }
            let (_, dimension) = DIMENSIONS.iter().find(|(name, _)| *name == word)?;
            let units: Vec<String> = dimension.usual_units().iter().map(|unit| format!("`{unit}`")).collect();
            Some(format!("**{word}** {}", if units.is_empty() { "without a unit".into() } else { units.join(", ") }))
        }
        Place::Unit(_) => {
            let unit = parse_unit(word).ok()?;
            Some(format!("**{word}**: {}", unit.dimension))
        }
        Place::Formula => part(word, catalog).or_else(param),
        Place::Event => {
            let event = catalog.vocabulary.events.iter().find(|event| event.name == word)?;
            Some(format!("**{word}** {}\n\nVariables: {}", event.doc, event.variables.join(", ")))
        }
        Place::EventWord(event) => {
            let event = catalog.vocabulary.events.iter().find(|each| each.name == event)?;
            let words: Vec<String> = event.words.iter().map(|word| format!("`{word}`")).collect();
            Some(format!("**{}({word})** {}\n\nIn the parentheses: {}", event.name, event.doc, words.join(", ")))
        }
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

/// A function or a variable of formulas.
fn part(word: &str, catalog: &Catalog) -> Option<String> {
    if let Some((_, doc)) = functions().chain(temporal_operators()).find(|(name, _)| *name == word) {
        return Some(format!("**{word}(…)** {doc}"));
    }
    let variable = catalog.vocabulary.variables.iter().find(|variable| variable.name == word)?;
    Some(format!("**{word}** ({}): {}", variable.within(), variable.doc))
}

/// The form that a key's values name.
pub fn referred(ty: &Type) -> Option<&'static str> {
    match ty {
        Type::Reference(form) | Type::WordOrReference(_, form) => Some(form),
        Type::List(item) => referred(item),
        _ => None,
    }
}

/// A declaration's head and documentation.
fn declaration(found: &ast::Declaration) -> String {
    let name = found.name.as_ref().map_or("", |name| name.text.as_str());
    let kind = found.kind.as_ref().map_or(String::new(), |kind| format!(" = {}", kind.text));
    format!("```scn\n{} {name}{kind}\n```\n\n{}", found.form.text, found.docs.join("\n"))
}

/// A key with its type, units and default.
pub fn one_line(param: &Param) -> String {
    let default = match param.default {
        None => "must be given".into(),
        Some("") => "may be left out".into(),
        Some(text) => format!("default `{text}`"),
    };
    format!("`{}`: {}; {default}", param.name, param.ty.describe_bounded())
}

fn key(param: &Param) -> String {
    format!("{}\n\n{}", one_line(param), param.doc)
}

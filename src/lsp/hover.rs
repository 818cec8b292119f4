use lsp_types::{Hover, HoverContents, MarkupContent, MarkupKind};

use super::cursor::{Cursor, Place};
use crate::compile::Catalog;
use crate::lang::ast;
use crate::signature::{Param, Type};
use crate::units::{UNIT_NAMES, parse_unit};

/// What is to be said about the word at the cursor; `declared` are the declarations that can be seen.
pub fn hover<'a>(
    cursor: &Cursor,
    catalog: &Catalog,
    declared: impl Iterator<Item = &'a ast::Declaration>,
) -> Option<Hover> {
    let text = describe(cursor, catalog, declared)?;
    Some(Hover {
        contents: HoverContents::Markup(MarkupContent { kind: MarkupKind::Markdown, value: text }),
        range: None,
    })
}

fn describe<'a>(
    cursor: &Cursor,
    catalog: &Catalog,
    mut declared: impl Iterator<Item = &'a ast::Declaration>,
) -> Option<String> {
    let word = cursor.word;
    if word.is_empty() {
        return None;
    }
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
        Place::Value(param) => match referred(&param.ty) {
            Some(form) => {
                let found = declared.find(|each| each.form.text == form && has_name(each, word))?;
                let kind = found.kind.as_ref().map_or(String::new(), |kind| format!(" = {}", kind.text));
                Some(format!("```scn\n{form} {word}{kind}\n```\n\n{}", found.docs.join("\n")))
            }
            None => Some(key(param)),
        },
        Place::Unit(_) => {
            let unit = parse_unit(word).ok()?;
            Some(format!("**{word}**: {}", unit.dimension)).filter(|_| UNIT_NAMES.iter().any(|(name, _)| *name == word))
        }
        Place::Formula => {
            let variable = catalog.vocabulary.variables.iter().find(|variable| variable.name == word)?;
            Some(format!("**{word}** ({}): {}", variable.dimension, variable.doc))
        }
        Place::Event => {
            let event = catalog.vocabulary.events.iter().find(|event| event.name == word)?;
            Some(format!("**{word}** {}\n\nVariables: {}", event.doc, event.variables.join(", ")))
        }
        Place::EventWord(_) | Place::Import | Place::Nothing => None,
    }
}

/// The form that a key's values name.
pub fn referred(ty: &Type) -> Option<&'static str> {
    match ty {
        Type::Reference(form) => Some(form),
        Type::List(item) => referred(item),
        _ => None,
    }
}

/// Whether a declaration has this name.
pub fn has_name(declaration: &ast::Declaration, name: &str) -> bool {
    declaration.name.as_ref().is_some_and(|known| known.text == name)
}

/// A key with its type, units and default.
pub fn one_line(param: &Param) -> String {
    let default = match param.default {
        None => "must be given".into(),
        Some("") => "may be left out".into(),
        Some(text) => format!("default `{text}`"),
    };
    format!("`{}`: {}; {default}", param.name, param.ty.describe())
}

fn key(param: &Param) -> String {
    format!("{}\n\n{}", one_line(param), param.doc)
}

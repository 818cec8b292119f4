use lsp_types::{CompletionItem, CompletionItemKind, Documentation, InsertTextFormat};

use super::cursor::{Cursor, Place};
use super::hover::{one_line, referred};
use crate::compile::Catalog;
use crate::lang::{ast, functions, library};
use crate::signature::{Param, Signature, Type};
use crate::units::{Dimension, UNIT_NAMES};

/// What could stand at the cursor; `declared` are the declarations that can be seen.
pub fn complete(cursor: &Cursor, catalog: &Catalog, declared: &[&ast::Declaration]) -> Vec<CompletionItem> {
    match cursor.place {
        Place::Form => {
            let forms = catalog.forms.iter().map(|form| {
                let body = if form.plain.is_some() { "{\n  $0\n}" } else { "= $0" };
                snippet(form.name, form.doc, format!("{} ${{1:name}} {body}", form.name))
            });
            forms.chain(["edition", "import"].map(|word| item(word, CompletionItemKind::KEYWORD, ""))).collect()
        }
        Place::Kind(form) => {
            let kinds = catalog.forms.iter().filter(|each| each.name == form).flat_map(|form| &form.kinds);
            kinds.map(|kind| snippet(kind.name, kind.doc, format!("{}($0)", kind.name))).collect()
        }
        Place::Key => cursor.signature.map_or_else(Vec::new, keys),
        Place::Value(param) => values(param, catalog, declared),
        Place::Unit(param) => units(param),
        Place::Formula => formula(catalog),
        Place::Event => {
            let events = &catalog.vocabulary.events;
            events.iter().map(|event| item(event.name, CompletionItemKind::EVENT, event.doc)).collect()
        }
        Place::EventWord(event) => {
            let words = catalog.vocabulary.events.iter().filter(|each| each.name == event).flat_map(|each| each.words);
            words.map(|word| item(word, CompletionItemKind::ENUM_MEMBER, "")).collect()
        }
        Place::Import => {
            library::names().map(|name| item(&format!("std/{name}"), CompletionItemKind::FILE, "")).collect()
        }
        Place::Nothing => Vec::new(),
    }
}

fn item(label: &str, kind: CompletionItemKind, doc: &str) -> CompletionItem {
    let documentation = (!doc.is_empty()).then(|| Documentation::String(doc.into()));
    CompletionItem { label: label.into(), kind: Some(kind), documentation, ..CompletionItem::default() }
}

fn snippet(label: &str, doc: &str, text: String) -> CompletionItem {
    CompletionItem {
        insert_text: Some(text),
        insert_text_format: Some(InsertTextFormat::SNIPPET),
        ..item(label, CompletionItemKind::CLASS, doc)
    }
}

fn keys(signature: &Signature) -> Vec<CompletionItem> {
    let keys = signature.params.iter().map(|param| CompletionItem {
        detail: Some(one_line(param)),
        insert_text: Some(format!("{}: ", param.name)),
        ..item(param.name, CompletionItemKind::PROPERTY, param.doc)
    });
    let blocks =
        signature.children.iter().map(|child| snippet(child.name, child.doc, format!("{} {{\n  $0\n}}", child.name)));
    let clause = signature.clauses.then(|| snippet("on", "", "on ${1:hit} => $0".into()));
    keys.chain(blocks).chain(clause).collect()
}

fn values(param: &Param, catalog: &Catalog, declared: &[&ast::Declaration]) -> Vec<CompletionItem> {
    let words = |words: &[&str]| words.iter().map(|word| item(word, CompletionItemKind::ENUM_MEMBER, "")).collect();
    let mut ty = &param.ty;
    while let Type::List(inner) = ty {
        ty = inner;
    }
    match ty {
        Type::Boolean => words(&["true", "false"]),
        Type::Choice(choices) => words(choices),
        Type::Condition(_) | Type::Formula(_) => formula(catalog),
        other => referred(other).map_or_else(Vec::new, |form| {
            let named = declared.iter().filter(|each| each.form.text == form);
            let items = named.filter_map(|each| {
                let name = each.name.as_ref()?;
                Some(item(&name.text, CompletionItemKind::VARIABLE, &each.docs.join("\n")))
            });
            items.collect()
        }),
    }
}

/// Units, those that fit the key first.
fn units(param: Option<&Param>) -> Vec<CompletionItem> {
    let dimension = param.and_then(|param| dimension(&param.ty));
    let usual = dimension.map_or(&[][..], Dimension::usual_units);
    let rest = UNIT_NAMES.iter().map(|(name, _)| *name).filter(|name| !usual.contains(name));
    let all = usual.iter().copied().chain(rest).enumerate();
    let sorted = all.map(|(index, name)| CompletionItem {
        sort_text: Some(format!("{index:03}")),
        ..item(name, CompletionItemKind::UNIT, "")
    });
    sorted.collect()
}

fn dimension(ty: &Type) -> Option<Dimension> {
    match ty {
        Type::Quantity { dimension, .. } | Type::Range { dimension, .. } => Some(*dimension),
        Type::Point | Type::Pose => Some(Dimension::LENGTH),
        Type::List(inner) => dimension(inner),
        _ => None,
    }
}

fn formula(catalog: &Catalog) -> Vec<CompletionItem> {
    let variables = &catalog.vocabulary.variables;
    let variables = variables.iter().map(|variable| CompletionItem {
        detail: Some(variable.dimension.to_string()),
        ..item(variable.name, CompletionItemKind::VARIABLE, variable.doc)
    });
    let functions = functions().map(|name| item(name, CompletionItemKind::FUNCTION, ""));
    let words = ["and", "or", "not", "in"].map(|word| item(word, CompletionItemKind::KEYWORD, ""));
    variables.chain(functions).chain(words).collect()
}

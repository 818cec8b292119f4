use std::path::Path;

use lsp_types::{CompletionItem, CompletionItemKind, Documentation, InsertTextFormat};

use super::cursor::{Cursor, Place};
use super::visible::{Visible, dimension as measured, fits, referred};
use super::workspace::beside;
use base::signature::{Param, Signature, Type};
use base::units::{Dimension, UNIT_NAMES};
use compile::{Catalog, short_key};
use lang::{DIMENSIONS, OTHER_TYPES, ast, distributions, functions, library, temporal_operators};

/// The possible completions at the cursor of a file.
pub fn complete(cursor: &Cursor, catalog: &Catalog, visible: Visible, file: &Path) -> Vec<CompletionItem> {
    match cursor.place {
        Place::Form => {
            let forms = catalog.forms.iter().map(|form| {
                let body = if form.plain.is_some() { "{\n  $0\n}" } else { "= $0" };
                snippet(form.name, form.doc, format!("{} ${{1:name}} {body}", form.name))
            });
            let words = ["edition", "import"].map(|word| item(word, CompletionItemKind::KEYWORD, ""));
            let param = snippet("param", "A value with a name.", "param ${1:name}: ${2:length} = $0".into());
            forms.chain(words).chain([param]).collect()
        }
        Place::Kind(form) => {
            let kinds = catalog.forms.iter().filter(|each| each.name == form).flat_map(|form| &form.kinds);
            kinds.map(|kind| snippet(kind.name, kind.doc, format!("{}($0)", kind.name))).collect()
        }
        Place::Key => cursor.signature.map_or_else(Vec::new, keys),
        Place::Value(param) => values(param, catalog, visible),
        Place::Unit(dimension) => units(dimension),
        Place::Formula => {
            let quantities = params(visible, |param| measured(&param.ty.text).is_some());
            formula(catalog, None).into_iter().chain(quantities).collect()
        }
        Place::Type => {
            let words = DIMENSIONS.iter().map(|(name, _)| *name).chain(OTHER_TYPES.iter().copied());
            let forms = catalog.forms.iter().map(|form| item(form.name, CompletionItemKind::CLASS, form.doc));
            words.map(|word| item(word, CompletionItemKind::TYPE_PARAMETER, "")).chain(forms).collect()
        }
        Place::ParamValue { name, ty } => of_type(ty, visible).into_iter().filter(|item| item.label != name).collect(),
        Place::AxisValue(name) => visible.param(name).map_or_else(Vec::new, |param| of_type(&param.ty.text, visible)),
        Place::Axis => {
            let axis = |param: CompletionItem| CompletionItem {
                insert_text: Some(format!("{}: [$0]", param.label)),
                insert_text_format: Some(InsertTextFormat::SNIPPET),
                ..param
            };
            params(visible, |_| true).into_iter().map(axis).collect()
        }
        Place::Imported(_) => {
            let named = visible.declarations().filter_map(declared).chain(params(visible, |_| true));
            named.collect()
        }
        Place::Event => {
            let events = catalog.vocabulary.events.iter().filter(|event| event.answered);
            events.map(|event| item(event.name, CompletionItemKind::EVENT, event.doc)).collect()
        }
        Place::EventWord(event) => {
            let words = catalog.vocabulary.events.iter().filter(|each| each.name == event).flat_map(|each| each.words);
            words.map(|word| item(word, CompletionItemKind::ENUM_MEMBER, "")).collect()
        }
        Place::Import(typed) => {
            let library = library::names().map(|name| item(&format!("std/{name}"), CompletionItemKind::FILE, ""));
            let beside = beside(file, typed).into_iter().map(|path| {
                let kind = if path.ends_with('/') { CompletionItemKind::FOLDER } else { CompletionItemKind::FILE };
                item(&path, kind, "")
            });
            library.chain(beside).collect()
        }
        Place::Param | Place::Nothing => Vec::new(),
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
        detail: Some(short_key(param)),
        insert_text: Some(format!("{}: ", param.name)),
        ..item(param.name, CompletionItemKind::PROPERTY, param.doc)
    });
    let blocks =
        signature.children.iter().map(|child| snippet(child.name, child.doc, format!("{} {{\n  $0\n}}", child.name)));
    let clause = signature.clauses.then(|| snippet("on", "", "on ${1:hit} => $0".into()));
    keys.chain(blocks).chain(clause).collect()
}

fn declared(declaration: &ast::Declaration) -> Option<CompletionItem> {
    let name = declaration.name.as_ref()?;
    let item = item(&name.text, CompletionItemKind::VARIABLE, &declaration.docs.join("\n"));
    Some(CompletionItem { detail: Some(declaration.form.text.clone()), ..item })
}

/// Parameters of some types.
fn params(visible: Visible, wanted: impl Fn(&ast::Param) -> bool) -> Vec<CompletionItem> {
    let named = visible.params().filter(|param| wanted(param)).map(|param| CompletionItem {
        detail: Some(visible.declared(param)),
        ..item(&param.name.text, CompletionItemKind::CONSTANT, &param.docs.join("\n"))
    });
    named.collect()
}

/// The possible values of a parameter, by the word for its type.
fn of_type(word: &str, visible: Visible) -> Vec<CompletionItem> {
    let own = if word == "boolean" { &["true", "false"][..] } else { &[] };
    let own = own.iter().map(|word| item(word, CompletionItemKind::ENUM_MEMBER, ""));
    let dimension = measured(word);
    let alike =
        params(visible, |param| param.ty.text == word || dimension.is_some() && measured(&param.ty.text).is_some());
    own.chain(visible.of_form(word).filter_map(declared)).chain(alike).collect()
}

fn values(param: &Param, catalog: &Catalog, visible: Visible) -> Vec<CompletionItem> {
    let words = |words: &[&str]| words.iter().map(|word| item(word, CompletionItemKind::ENUM_MEMBER, "")).collect();
    let mut ty = &param.ty;
    while let Type::List(inner) = ty {
        ty = inner;
    }
    let own: Vec<CompletionItem> = match ty {
        Type::Boolean => words(&["true", "false"]),
        Type::Choice(choices) | Type::Step(choices) | Type::WordOrPoint(choices) => words(choices),
        Type::WordOrReference(choices, form) => {
            let declared = visible.of_form(form).filter_map(declared);
            words(choices).into_iter().chain(declared).collect()
        }
        Type::Condition(event) | Type::Formula(event) => formula(catalog, Some(event)),
        Type::Requirement(event) => {
            let operators = temporal_operators().map(|(name, doc)| item(name, CompletionItemKind::FUNCTION, doc));
            operators.chain(formula(catalog, Some(event))).collect()
        }
        Type::Distribution { .. } => distributions().map(|name| item(name, CompletionItemKind::FUNCTION, "")).collect(),
        other => referred(other).map_or_else(Vec::new, |form| visible.of_form(form).filter_map(declared).collect()),
    };
    own.into_iter().chain(params(visible, |param| fits(&param.ty.text, ty))).collect()
}

/// Units; those of the expected dimension come first.
fn units(dimension: Option<Dimension>) -> Vec<CompletionItem> {
    let usual = dimension.map_or(&[][..], Dimension::usual_units);
    // If the dimension is not known, it may be any.
    let compound = ["m/s", "km/h", "m/s^2", "deg/s"].into_iter().filter(|_| dimension.is_none());
    let rest = compound.chain(UNIT_NAMES.iter().map(|(name, _)| *name)).filter(|name| !usual.contains(name));
    let all = usual.iter().copied().chain(rest).enumerate();
    let sorted = all.map(|(index, name)| CompletionItem {
        sort_text: Some(format!("{index:03}")),
        ..item(name, CompletionItemKind::UNIT, "")
    });
    sorted.collect()
}

/// The parts that a formula may contain, for an event if one is given.
fn formula(catalog: &Catalog, event: Option<&str>) -> Vec<CompletionItem> {
    let known = catalog.vocabulary.events.iter().find(|known| Some(known.name) == event);
    let available = |name: &str| known.is_none_or(|event| event.variables.contains(&name));
    let variables = catalog.vocabulary.variables.iter().filter(|variable| available(variable.name));
    let variables = variables.map(|variable| CompletionItem {
        detail: Some(variable.measures()),
        ..item(variable.name, CompletionItemKind::VARIABLE, variable.doc)
    });
    let functions = functions().map(|(name, doc)| item(name, CompletionItemKind::FUNCTION, doc));
    let words = ["and", "or", "not", "implies", "in"].map(|word| item(word, CompletionItemKind::KEYWORD, ""));
    variables.chain(functions).chain(words).collect()
}

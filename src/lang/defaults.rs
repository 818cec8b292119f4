//! The defaults of signatures: written as in a file, each read once for all files and all their variants.

use std::collections::BTreeMap;

use super::names::Names;
use super::parse;
use super::value::{Context, value};
use crate::diagnostic::Sources;
use crate::signature::{Param, Type, Value, Vocabulary};

/// What the language offers formulas, and the defaults that have been read with it.
#[derive(Debug)]
pub struct Defaults<'f> {
    vocabulary: &'f Vocabulary,
    /// By the address of the parameter, which is borrowed as long.
    known: BTreeMap<*const Param, Value>,
}

impl<'f> Defaults<'f> {
    /// Begins with none.
    pub fn new(vocabulary: &'f Vocabulary) -> Self {
        Self { vocabulary, known: BTreeMap::new() }
    }

    pub(super) fn vocabulary(&self) -> &'f Vocabulary {
        self.vocabulary
    }

    /// The default `text` of a key, for a file that sees these names.
    pub(super) fn value(&mut self, param: &'f Param, text: &str, names: &Names) -> Value {
        if let Type::Reference(form) = param.ty {
            // A default declaration is one of the standard library's, and may not be imported.
            return names.find(form, text).map_or(Value::Absent, Value::Reference);
        }
        self.known.entry(param).or_insert_with(|| read(param, text, self.vocabulary)).clone()
    }
}

fn read(param: &Param, text: &str, vocabulary: &Vocabulary) -> Value {
    let mut sources = Sources::default();
    let source = sources.add(format!("<default of {}>", param.name), text);
    let mut diagnostics = Vec::new();
    let names = Names::default();
    let inner = Context { vocabulary, names: &names, sources: &sources };
    let checked = parse::parse_value(source, text)
        .ok()
        .and_then(|expression| value(&expression, &param.ty, &inner, &mut diagnostics));
    checked.unwrap_or_else(|| panic!("the default `{text}` of `{}` does not fit its type: {diagnostics:?}", param.name))
}

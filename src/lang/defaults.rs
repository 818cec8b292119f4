//! The defaults of signatures: written as in a file, each read once for all files and all their variants.

use std::collections::BTreeMap;

use super::ast::Expression;
use super::library;
use super::names::Names;
use super::parse::parse_value;
use super::value::{Context, value};
use base::diagnostic::Sources;
use base::signature::{Param, Type, Value, Vocabulary};

/// The names that formulas may use, and the defaults that have been read with them.
#[derive(Debug)]
pub struct Defaults<'f> {
    vocabulary: &'f Vocabulary,
    sources: Sources,
    /// By their text, which many keys share.
    written: BTreeMap<&'static str, Expression>,
    /// By the address of the parameter, which is borrowed for as long.
    known: BTreeMap<*const Param, Value>,
}

impl<'f> Defaults<'f> {
    /// Starts with none.
    pub fn new(vocabulary: &'f Vocabulary) -> Self {
        Self { vocabulary, sources: Sources::default(), written: BTreeMap::new(), known: BTreeMap::new() }
    }

    pub(super) fn vocabulary(&self) -> &'f Vocabulary {
        self.vocabulary
    }

    /// The default `text` of a key, for a file that sees these names.
    pub(super) fn value(&mut self, param: &'f Param, text: &'static str, names: &Names, sources: &Sources) -> Value {
        if let Type::Reference(form) = param.ty {
            // A default declaration is in the standard library, and may not be imported. A user's declaration of that name is another.
            let found = names.find_with_place(form, text);
            let found = found.filter(|(_, place)| library::holds(&sources.get(place.source).path));
            return found.map_or(Value::Absent, |(id, _)| Value::Reference(id));
        }
        if let Some(known) = self.known.get(&std::ptr::from_ref(param)) {
            return known.clone();
        }
        let value = self.read(param, text);
        self.known.insert(param, value.clone());
        value
    }

    fn read(&mut self, param: &Param, text: &'static str) -> Value {
        let written = self.written.entry(text).or_insert_with(|| {
            let source = self.sources.add_builtin("<default>", text);
            parse_value(source, text).unwrap_or_else(|said| panic!("the default of `{}`: {said:?}", param.name))
        });
        let mut diagnostics = Vec::new();
        let names = Names::default();
        let context = Context { vocabulary: self.vocabulary, forms: &[], names: &names, sources: &self.sources };
        let checked = value(written, &param.ty, &context, &mut diagnostics);
        checked.unwrap_or_else(|| panic!("the default of `{}` does not fit its type: {diagnostics:?}", param.name))
    }
}

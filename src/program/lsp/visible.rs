//! The names that a file can use: declarations and parameters, its own and imported ones.

use std::collections::BTreeSet;
use std::sync::Arc;

use base::diagnostic::{SourceId, Sources};
use base::signature::Type;
use base::units::Dimension;
use lang::{DIMENSIONS, Loaded, ast};

/// The form that a key's values name.
pub fn referred(ty: &Type) -> Option<&'static str> {
    match ty {
        Type::Reference(form) | Type::WordOrReference(_, form) => Some(form),
        Type::List(item) => referred(item),
        _ => None,
    }
}

/// A file with all that it imports.
#[derive(Clone, Copy)]
pub struct Visible<'a> {
    /// The trees.
    pub loaded: &'a Loaded,
    /// Their texts.
    pub sources: &'a Sources,
}

impl<'a> Visible<'a> {
    pub fn declarations(self) -> impl Iterator<Item = &'a ast::Declaration> {
        self.loaded.files.iter().flat_map(|file| file.declarations.iter().map(Arc::as_ref))
    }

    /// The declarations of a form that the file may name: not those that its imports leave out.
    pub fn of_form(self, form: &str) -> impl Iterator<Item = &'a ast::Declaration> {
        let (whole, names) = self.taken_over();
        let seen = move |file: &ast::File, declaration: &ast::Declaration| {
            let is_named = |name: &ast::Name| names.contains(name.text.as_str());
            whole.contains(&file.source) || declaration.name.as_ref().is_some_and(is_named)
        };
        let files = self.loaded.files.iter();
        let all = files.flat_map(|file| file.declarations.iter().map(move |declaration| (file, declaration.as_ref())));
        all.filter(move |(file, each)| each.form.text == form && seen(file, each)).map(|(_, each)| each)
    }

    /// The files of which the named ones see all declarations, and the names that they take over from others.
    fn taken_over(self) -> (BTreeSet<SourceId>, BTreeSet<&'a str>) {
        let mut whole: BTreeSet<SourceId> = BTreeSet::new();
        let mut names = BTreeSet::new();
        let mut open = self.loaded.roots.clone();
        while let Some(source) = open.pop() {
            let file = self.loaded.files.iter().find(|file| file.source == source);
            let Some(file) = file.filter(|_| whole.insert(source)) else { continue };
            for import in &file.imports {
                names.extend(import.names.iter().map(|name| name.text.as_str()));
                open.extend(import.source.filter(|_| import.names.is_empty()));
            }
        }
        (whole, names)
    }

    /// The declaration of this name, of a form if one is given.
    pub fn declaration(self, form: Option<&str>, name: &str) -> Option<&'a ast::Declaration> {
        let named = |each: &&ast::Declaration| each.name.as_ref().is_some_and(|known| known.text == name);
        self.declarations().filter(named).find(|each| form.is_none_or(|form| each.form.text == form))
    }

    pub fn params(self) -> impl Iterator<Item = &'a ast::Param> {
        self.loaded.files.iter().flat_map(|file| &file.params)
    }

    pub fn param(self, name: &str) -> Option<&'a ast::Param> {
        self.params().find(|param| param.name.text == name)
    }

    /// A parameter as declared.
    pub fn declared(self, param: &ast::Param) -> String {
        format!("param {}: {} = {}", param.name.text, param.ty.text, self.sources.text(param.value.span))
    }
}

/// Whether a parameter with this word for its type may be used as a value of a type, or as a part of one.
pub fn fits(word: &str, ty: &Type) -> bool {
    match ty {
        Type::List(inner) => fits(word, inner),
        Type::Reference(form) => word == *form,
        Type::WordOrReference(_, form) => matches!(word, "word" | "text") || word == *form,
        Type::Boolean => word == "boolean",
        Type::Text | Type::Path => word == "text",
        Type::Choice(_) | Type::Step(_) => matches!(word, "word" | "text"),
        Type::Integer { .. } | Type::Ticks { .. } => matches!(word, "integer" | "number"),
        Type::Condition(_) | Type::Formula(_) | Type::Requirement(_) => dimension(word).is_some(),
        Type::Point | Type::WordOrPoint(_) | Type::Pose => {
            matches!(dimension(word), Some(Dimension::LENGTH | Dimension::ANGLE))
        }
        Type::Quantity { dimension: wanted, .. }
        | Type::Range { dimension: wanted, .. }
        | Type::Distribution { dimension: wanted, .. } => dimension(word) == Some(*wanted),
    }
}

/// The dimension of a parameter, by the word for its type.
pub fn dimension(word: &str) -> Option<Dimension> {
    if word == "integer" {
        return Some(Dimension::RATIO);
    }
    DIMENSIONS.iter().find(|(name, _)| *name == word).map(|(_, dimension)| *dimension)
}

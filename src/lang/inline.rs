//! Kinds with their keys in place of a name: `drivers: [idm(time_headway: 1 s)]`, also as values of a `matrix`.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use super::ast::{Declaration, Entry, Expression, ExpressionKind, File, Name, Property};
use super::{Loaded, Matrix};
use base::diagnostic::{Sources, Span};
use base::signature::{Form, Signature, Type};
use base::suggest::nearest;

/// Maximum length of a derived name (bytes) that is made of the keys and values themselves.
const MAX_PLAIN_NAME: usize = 40;

/// Makes a declaration of each kind that is written where the name of a declaration is expected. It is appended to its file, and its name is
/// derived from its text: `idm(time_headway: 1 s)` is `idm_time_headway_1_s`. Equal texts of a file are one declaration.
///
/// A call again finds only what has been written since, such as settings from outside.
pub fn declare_inline(loaded: &mut Loaded, forms: &[Form], sources: &Sources) {
    let mut inline = Inline::new(loaded, forms, sources);
    for file in &mut loaded.files {
        inline.begin(file);
        for declaration in &mut file.declarations {
            if mentions_kinds(&declaration.entries) {
                inline.declaration(Arc::make_mut(declaration));
            }
        }
        for param in &mut file.params {
            if let Some(form) = forms.iter().find(|form| form.name == param.ty.text) {
                inline.value(&mut param.value, &Type::Reference(form.name));
            }
        }
        file.declarations.extend(inline.made.drain(..).map(Arc::new));
    }
}

/// Makes a declaration of each kind that is a value of a matrix, as [`declare_inline`]. It is appended to the file of the matrix. All combinations have all
/// of them, so what is checked of one combination is true of the others.
pub fn declare_inline_axes(matrices: &mut [Matrix], loaded: &mut Loaded, forms: &[Form], sources: &Sources) {
    let params = loaded.files.iter().flat_map(|file| &file.params);
    let form = |ty: &str| forms.iter().find(|form| form.name == ty).map(|form| form.name);
    let types: BTreeMap<String, Type> =
        params.filter_map(|param| Some((param.name.text.clone(), Type::Reference(form(&param.ty.text)?)))).collect();
    let mut inline = Inline::new(loaded, forms, sources);
    for matrix in matrices {
        let place = loaded.files.binary_search_by_key(&matrix.declaration.0, |file| file.source);
        let file = &mut loaded.files[place.expect("the file of the matrix is loaded")];
        inline.begin(file);
        for setting in matrix.combinations.iter_mut().flatten() {
            if let Some(ty) = types.get(&setting.path[0].text) {
                inline.value(&mut setting.value, ty);
            }
        }
        file.declarations.extend(inline.made.drain(..).map(Arc::new));
    }
}

/// Whether a value may be a kind: it is a call, or a list with calls.
fn mentions_kinds(entries: &[Entry]) -> bool {
    let may_be = |value: &Expression| match &value.kind {
        ExpressionKind::List(members) => {
            members.iter().any(|member| matches!(member.kind, ExpressionKind::Call { .. }))
        }
        kind => matches!(kind, ExpressionKind::Call { .. }),
    };
    entries.iter().any(|entry| match entry {
        Entry::Property(property) => may_be(&property.value),
        Entry::Child(child) => mentions_kinds(&child.entries),
        _ => false,
    })
}

struct Inline<'a> {
    forms: &'a [Form],
    sources: &'a Sources,
    /// All forms and names of declarations.
    taken: BTreeSet<(String, String)>,
    /// The declarations of this file by form and text, with their places in it.
    known: BTreeMap<(&'static str, String), usize>,
    /// Those of this file.
    made: Vec<Declaration>,
    /// The place of the first of them.
    first: usize,
}

impl<'a> Inline<'a> {
    fn new(loaded: &Loaded, forms: &'a [Form], sources: &'a Sources) -> Self {
        let declared = |each: &Arc<Declaration>| Some((each.form.text.clone(), each.name.as_ref()?.text.clone()));
        let taken = loaded.files.iter().flat_map(|file| &file.declarations).filter_map(declared).collect();
        Self { forms, sources, taken, known: BTreeMap::new(), made: Vec::new(), first: 0 }
    }

    /// Turns to a file, whose declarations in place of names are known.
    fn begin(&mut self, file: &File) {
        self.first = file.declarations.len();
        let known = file.declarations.iter().enumerate().filter(|(_, each)| each.is_inline);
        self.known = known.filter_map(|(place, each)| Some((self.key(each)?, place))).collect();
    }

    fn declaration(&mut self, declaration: &mut Declaration) {
        let Some(form) = self.forms.iter().find(|form| form.name == declaration.form.text) else { return };
        let kind = declaration.kind.as_ref();
        let signature = match kind {
            Some(kind) => form.kinds.iter().find(|known| known.name == kind.text),
            None => form.plain.as_ref(),
        };
        if let Some(signature) = signature {
            self.entries(&mut declaration.entries, signature);
        }
    }

    fn entries(&mut self, entries: &mut [Entry], signature: &Signature) {
        for entry in entries {
            match entry {
                Entry::Property(Property { key, value }) => {
                    if let Some(param) = signature.params.iter().find(|param| param.name == key.text) {
                        self.value(value, &param.ty);
                    }
                }
                Entry::Child(child) => {
                    let named = signature.params.iter().find(|param| param.name == child.form.text);
                    if let Some(list) = named.and_then(|param| self.named(child, &param.ty)) {
                        *entry = Entry::Property(list);
                    } else if let Some(inner) = signature.children.iter().find(|inner| inner.name == child.form.text) {
                        self.entries(&mut child.entries, inner);
                    }
                }
                Entry::Clause(_) | Entry::Bare(_) | Entry::Unread => {}
            }
        }
    }

    /// The list of the declarations that a block with the name of a list of names holds, each as `name: kind(…)`; `None` for another block.
    fn named(&mut self, block: &Declaration, ty: &Type) -> Option<Property> {
        let Type::List(item) = ty else { return None };
        let Type::Reference(form) = **item else { return None };
        let form = self.forms.iter().find(|known| known.name == form)?;
        let all = block.entries.iter().map(|entry| match entry {
            Entry::Property(property) if names_kind(form, &property.value.kind) => Some(property),
            _ => None,
        });
        let mut members = Vec::new();
        for Property { key, value } in all.collect::<Option<Vec<_>>>().filter(|_| block.name.is_none())? {
            let mut declaration = of_call(form, value)?;
            declaration.name = Some(key.clone());
            declaration.head = key.span;
            self.declaration(&mut declaration);
            self.made.push(declaration);
            // A second declaration of a name is reported where it stands.
            let member = ExpressionKind::Name(key.text.clone());
            if members.iter().all(|other: &Expression| other.kind != member) {
                members.push(Expression { kind: member, span: key.span });
            }
        }
        let value = Expression { kind: ExpressionKind::List(members), span: block.head };
        Some(Property { key: block.form.clone(), value })
    }

    fn value(&mut self, value: &mut Expression, ty: &Type) {
        match (ty, &mut value.kind) {
            (Type::List(item), ExpressionKind::List(members)) => {
                members.iter_mut().for_each(|member| self.value(member, item));
            }
            (Type::List(item), _) => self.value(value, item),
            (Type::Reference(form), ExpressionKind::Call { .. }) => {
                let form = self.forms.iter().find(|known| known.name == *form);
                if let Some(form) = form.filter(|form| names_kind(form, &value.kind)) {
                    let place = self.declare(form, value);
                    value.kind = ExpressionKind::Inline { form: form.name, place };
                }
            }
            _ => {}
        }
    }

    /// A text without comments, and with blanks between words only.
    fn text(&self, span: Span) -> String {
        let is_of_word = |letter: char| letter.is_alphanumeric() || letter == '_';
        let mut text = String::new();
        for word in self.sources.plain_text(span).split_whitespace() {
            if text.ends_with(is_of_word) && word.starts_with(is_of_word) {
                text.push(' ');
            }
            text.push_str(word);
        }
        text
    }

    /// The form and the text of a declaration in place of a name.
    fn key(&self, declaration: &Declaration) -> Option<(&'static str, String)> {
        let form = self.forms.iter().find(|form| form.name == declaration.form.text)?;
        Some((form.name, self.text(declaration.span)))
    }

    /// The place of the declaration that a call stands for.
    fn declare(&mut self, form: &Form, value: &Expression) -> usize {
        let (Some(mut declaration), ExpressionKind::Call { function, .. }) = (of_call(form, value), &value.kind) else {
            unreachable!("a kind with keys is a call")
        };
        let text = self.text(value.span);
        if let Some(known) = self.known.get(&(form.name, text.clone())) {
            return *known;
        }
        declaration.name = Some(Name { text: self.name(form.name, &function.text, &text), span: function.span });
        declaration.is_inline = true;
        // A kind may be in place of a name inside, such as `sensors: interfuser_suite()`.
        self.declaration(&mut declaration);
        let place = self.first + self.made.len();
        self.known.insert((form.name, text), place);
        self.made.push(declaration);
        place
    }

    /// A name that no other declaration of the form has: the words and numbers of the text, or the kind and a digest of the text.
    fn name(&mut self, form: &str, kind: &str, text: &str) -> String {
        let words: Vec<&str> = text.split(|letter: char| !letter.is_ascii_alphanumeric() && letter != '_').collect();
        let words: Vec<&str> = words.into_iter().filter(|word| !word.is_empty()).collect();
        let plain = words.join("_");
        let digest = || format!("{kind}_{}", &blake3::hash(text.as_bytes()).to_hex()[..8]);
        let key = |name: &str| (form.to_string(), name.to_string());
        let name = if plain.len() <= MAX_PLAIN_NAME && !self.taken.contains(&key(&plain)) { plain } else { digest() };
        self.taken.insert(key(&name));
        name
    }
}

/// The declaration of a form that a call stands for, without a name; `None` for another value.
fn of_call(form: &Form, value: &Expression) -> Option<Declaration> {
    let ExpressionKind::Call { function, arguments, keys } = &value.kind else { return None };
    let entry = |(key, value): (&Option<Name>, &Expression)| match key {
        Some(key) => Entry::Property(Property { key: key.clone(), value: value.clone() }),
        None => Entry::Bare(value.clone()),
    };
    Some(Declaration {
        docs: Vec::new(),
        form: Name { text: form.name.to_string(), span: function.span },
        name: None,
        kind: Some(function.clone()),
        entries: keys.iter().zip(arguments).map(entry).collect(),
        is_inline: false,
        head: value.span,
        span: value.span,
    })
}

/// Whether a call is of a kind of this form, or nearly.
fn names_kind(form: &Form, call: &ExpressionKind) -> bool {
    let ExpressionKind::Call { function, .. } = call else { return false };
    let mut kinds = form.kinds.iter().map(|kind| kind.name);
    kinds.any(|kind| kind == function.text)
        || nearest(&function.text, form.kinds.iter().map(|kind| kind.name)).is_some()
}

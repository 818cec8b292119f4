//! AST → HIR: forms, kinds, keys, references, defaults.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use super::ast::{self, Entry, ExpressionKind, Name};
use super::defaults::Defaults;
use super::formula::{Scope, named};
use super::hir::ParamId;
use super::hir::{Block, Clause, Declaration, Program};
use super::names::names_of_all;
use super::params::Params;
use super::value::{Context, plain_number, value};
use super::{Loaded, diagnostics};
use base::diagnostic::{Diagnostic, SourceId, Sources, Span};
use base::signature::{Arguments, DeclarationId, Form, Param, Signature, Type, Value, Vocabulary};

/// The results of checking, reused for further variants of the same files, which differ only in their settings.
#[derive(Debug)]
pub struct Checked<'f> {
    defaults: Defaults<'f>,
    /// Declarations without errors.
    faultless: BTreeMap<DeclarationId, Faultless>,
}

/// Maximum length of the name of a declaration (bytes): files are named after several of them.
const MAX_NAME: usize = 50;

/// A declaration without errors, and its result.
#[derive(Debug)]
struct Faultless {
    written: Arc<ast::Declaration>,
    /// The parameters that it names, with their values.
    params: Vec<(ParamId, Option<ExpressionKind>)>,
    checked: Arc<Declaration>,
}

impl<'f> Checked<'f> {
    /// Starts with none.
    pub fn new(vocabulary: &'f Vocabulary) -> Self {
        Self { defaults: Defaults::new(vocabulary), faultless: BTreeMap::new() }
    }

    /// The declarations that had no errors, nor any in their parameters.
    pub fn faultless(&self) -> impl Iterator<Item = DeclarationId> {
        self.faultless.keys().copied()
    }

    /// The earlier result of the same declaration, if its parameters had the same values.
    fn find(&self, id: DeclarationId, written: &Arc<ast::Declaration>, now: &mut Params) -> Option<Arc<Declaration>> {
        let before = self.faultless.get(&id).filter(|before| Arc::ptr_eq(&before.written, written))?;
        now.are_still(&before.params).then(|| Arc::clone(&before.checked))
    }
}

/// Maximum number of diagnostics, after which checking ends, so that a file in which all is wrong fits into the memory.
const MAX_DIAGNOSTICS: usize = 20_000;

/// Checks all files against what the language offers.
///
/// Returns the program and all diagnostics; the program may only be compiled when no diagnostic is an
/// error. After 20,000 diagnostics the declarations that follow are not checked.
pub fn check<'f>(
    loaded: &Loaded,
    sources: &Sources,
    forms: &'f [Form],
    checked: &mut Checked<'f>,
) -> (Program, Vec<Diagnostic>) {
    let vocabulary = checked.defaults.vocabulary();
    let mut diagnostics = Vec::new();
    let ids = number_declarations(&loaded.files);
    let mut declarations = Vec::new();
    let form_names: Vec<&str> = forms.iter().map(|form| form.name).collect();
    let names = names_of_all(&loaded.files, &ids, forms, &mut diagnostics);
    let mut params = Params::resolve(loaded, &names, forms, vocabulary, sources, &mut diagnostics);
    for (place, file) in loaded.files.iter().enumerate() {
        let context = Context { vocabulary, forms, names: &names[place], sources };
        for (written, id) in file.declarations.iter().zip(&ids[&file.source]) {
            if diagnostics.len() > MAX_DIAGNOSTICS {
                break;
            }
            if let Some(known) = checked.find(*id, written, &mut params) {
                declarations.push(known);
                continue;
            }
            let mentioned = params.mentioned(written, place);
            let replaced = (!mentioned.is_empty()).then(|| params.replace(written, place));
            let as_meant = replaced.as_ref().unwrap_or(written);
            let before = diagnostics.len();
            let defaults = &mut checked.defaults;
            let mut checker = Checker { whole: true, context: &context, defaults, diagnostics: &mut diagnostics };
            let mut declaration = checker.declaration(as_meant, *id, file.source, forms, &form_names);
            let whole = checker.whole;
            declaration.params = params.behind(&mentioned);
            let declaration = Arc::new(declaration);
            params.explain(&mut diagnostics[before..]);
            let understood = mentioned.iter().all(|(_, value)| value.is_some());
            if diagnostics.len() == before && understood && whole {
                checked.faultless.entry(*id).or_insert_with(|| Faultless {
                    written: Arc::clone(written),
                    params: mentioned,
                    checked: Arc::clone(&declaration),
                });
            }
            declarations.push(declaration);
        }
    }
    let program = Program { declarations, roots: loaded.roots.clone(), params: params.finish() };
    // A clash inside an imported file is found again by every file that imports it.
    once(&mut diagnostics);
    diagnostics::explain_foreign(&mut diagnostics, sources);
    (program, diagnostics)
}

/// Drops repeated diagnostics.
pub fn once(diagnostics: &mut Vec<Diagnostic>) {
    let mut said = BTreeSet::new();
    diagnostics.retain(|each| said.insert((each.primary.span, each.code, each.message.clone())));
}

fn number_declarations(files: &[ast::File]) -> BTreeMap<SourceId, Vec<DeclarationId>> {
    let mut next = 0;
    let mut number = |file: &ast::File| {
        let first = next;
        next += file.declarations.len();
        (file.source, (first..next).map(DeclarationId).collect())
    };
    files.iter().map(&mut number).collect()
}

/// A key that a block gives.
struct Given {
    key: &'static str,
    /// The place of the key.
    span: Span,
    place: Span,
    /// `None` if it is wrong.
    value: Option<Value>,
}

struct Checker<'a, 'b, 'f> {
    /// Whether every value up to now was understood; one that was not need not have been reported.
    whole: bool,
    context: &'a Context<'a>,
    defaults: &'b mut Defaults<'f>,
    diagnostics: &'b mut Vec<Diagnostic>,
}

impl<'f> Checker<'_, '_, 'f> {
    fn declaration(
        &mut self,
        written: &ast::Declaration,
        id: DeclarationId,
        source: SourceId,
        forms: &'f [Form],
        form_names: &[&str],
    ) -> Declaration {
        let empty = |word| Block {
            word,
            name: None,
            arguments: Arguments::default(),
            places: Vec::new(),
            members: Vec::new(),
            children: Vec::new(),
            clauses: Vec::new(),
            head: written.head,
        };
        let (form, block) = match forms.iter().find(|form| form.name == written.form.text) {
            None => {
                let Name { text, span } = &written.form;
                self.diagnostics.push(diagnostics::unknown_form(*span, text, form_names));
                ("", empty(""))
            }
            Some(form) => {
                if written.name.is_none() {
                    self.diagnostics.push(diagnostics::missing_name(written.head, form.name));
                }
                match self.signature(written, form) {
                    Some(signature) => (form.name, self.block(written, signature)),
                    None => (form.name, empty(form.name)),
                }
            }
        };
        let name = written.name.as_ref().map_or_else(String::new, |name| name.text.clone());
        if let Some(long) = written.name.as_ref().filter(|name| name.text.len() > MAX_NAME) {
            self.diagnostics.push(diagnostics::long_name(long.span, MAX_NAME));
        }
        let docs = written.docs.clone();
        let is_inline = written.is_inline;
        Declaration { id, source, form, kind: block.word, name, docs, is_inline, params: Vec::new(), block }
    }

    fn signature(&mut self, written: &ast::Declaration, form: &'f Form) -> Option<&'f Signature> {
        let kinds: Vec<&str> = form.kinds.iter().map(|kind| kind.name).collect();
        match &written.kind {
            None => {
                if form.plain.is_none() {
                    self.diagnostics.push(diagnostics::missing_kind(written.head, form.name, &kinds));
                }
                form.plain.as_ref()
            }
            Some(kind) => {
                let found = form.kinds.iter().find(|candidate| candidate.name == kind.text);
                if found.is_none() {
                    self.diagnostics.push(diagnostics::unknown_kind(kind.span, form.name, &kind.text, &kinds));
                }
                found
            }
        }
    }

    fn block(&mut self, written: &ast::Declaration, signature: &'f Signature) -> Block {
        let mut given: Vec<Given> = Vec::new();
        let (mut members, mut children, mut clauses) = (Vec::new(), Vec::new(), Vec::new());
        let mut before = BTreeMap::new();
        // Keys that a typo or something unreadable probably gives: their absence is not reported.
        let (mut misspelt, mut unread) = (BTreeSet::new(), false);
        for entry in &written.entries {
            match entry {
                Entry::Property(property) => match signature.params.iter().find(|p| p.name == property.key.text) {
                    Some(param) => self.property(property, param, &mut given, &mut members),
                    None => self.unknown_key(&property.key, written, signature, &mut misspelt),
                },
                Entry::Child(child) => children.extend(self.child(child, signature, &mut before)),
                Entry::Clause(clause) if signature.clauses => {
                    let clause = self.clause(clause, &clauses);
                    self.whole &= clause.is_some();
                    clauses.extend(clause);
                }
                Entry::Clause(clause) => {
                    self.diagnostics.push(diagnostics::unexpected_clause(clause.event.span, signature.name));
                }
                Entry::Bare(expression) => {
                    unread = true;
                    let keys: Vec<&str> = signature.params.iter().map(|param| param.name).collect();
                    let text = self.context.sources.text(expression.span);
                    self.diagnostics.push(diagnostics::bare_argument(expression.span, text, &keys));
                }
                Entry::Unread => (unread, self.whole) = (true, false),
            }
        }
        let mut arguments = Arguments::default();
        let mut missing = Vec::new();
        for param in &signature.params {
            let value = match (given.iter().find(|given| given.key == param.name), param.default) {
                (Some(given), _) => given.value.clone(),
                (None, Some("")) => None,
                (None, Some(text)) => Some(self.defaults.value(param, text, self.context.names, self.context.sources)),
                (None, None) => {
                    missing.extend((!unread && !misspelt.contains(param.name)).then_some(param));
                    None
                }
            };
            arguments.push(param.name, value.unwrap_or(Value::Absent));
        }
        if !missing.is_empty() {
            self.diagnostics.push(diagnostics::missing_keys(written.head, signature.name, &missing));
        }
        let places: Vec<(&str, Span)> = given.iter().map(|given| (given.key, given.place)).collect();
        let name = written.name.as_ref().map(|name| name.text.clone());
        let block =
            Block { word: signature.name, name, arguments, places, members, children, clauses, head: written.head };
        self.rising(&block, signature);
        block
    }

    /// Reports a key that the block does not have, and notes which one it probably means.
    fn unknown_key(
        &mut self,
        key: &Name,
        written: &ast::Declaration,
        signature: &Signature,
        misspelt: &mut BTreeSet<String>,
    ) {
        // What is given elsewhere in the block, or is meant by another typo, is not what this one means. A setting from outside may.
        let source = key.span.source;
        let is_given = |known: &str| {
            let is_it = |other: &Name| other.text == known && other.span.source == source;
            let mut others = written.entries.iter();
            others.any(|other| matches!(other, Entry::Property(other) if is_it(&other.key)))
        };
        let is_left = |known: &&str| !is_given(known) && !misspelt.contains(*known);
        let left: Vec<&str> = signature.params.iter().map(|p| p.name).filter(is_left).collect();
        let mut unknown = diagnostics::unknown_key(key.span, signature.name, &key.text, &left);
        if let Some(ours) = diagnostics::ours(&key.text).filter(|ours| is_given(ours)) {
            unknown.help.clear();
            unknown = unknown.here(format!("`{ours}` says it already"));
        }
        misspelt.extend(unknown.fixes.iter().map(|fix| fix.text.clone()));
        self.diagnostics.push(unknown);
    }

    /// Checks the value of a key.
    fn property(
        &mut self,
        property: &ast::Property,
        param: &'f Param,
        given: &mut Vec<Given>,
        members: &mut Vec<(&'static str, Vec<Span>)>,
    ) {
        let (key, written) = (property.key.span, &property.value);
        if let Some(first) = given.iter().find(|given| given.key == param.name) {
            return self.diagnostics.push(diagnostics::duplicate_key(key, param.name, first.span));
        }
        let before = self.diagnostics.len();
        let value = value(written, &param.ty, self.context, self.diagnostics);
        for said in &mut self.diagnostics[before..] {
            diagnostics::show_key(said, key, param);
        }
        self.whole &= value.is_some();
        given.push(Given { key: param.name, span: key, place: written.span, value });
        if matches!(param.ty, Type::List(_)) {
            let spans = match &written.kind {
                ast::ExpressionKind::List(members) => members.iter().map(|member| member.span).collect(),
                _ => vec![written.span],
            };
            members.push((param.name, spans));
        }
    }

    /// Checks a block inside another one, which has these others before it.
    fn child<'w>(
        &mut self,
        child: &'w ast::Declaration,
        signature: &'f Signature,
        before: &mut BTreeMap<(&'f str, Option<&'w str>), Span>,
    ) -> Option<Block> {
        let Name { text: word, span } = &child.form;
        let Some(inner) = signature.children.iter().find(|inner| inner.name == *word) else {
            let words: Vec<&str> = signature.children.iter().map(|child| child.name).collect();
            self.diagnostics.push(diagnostics::unknown_block(*span, signature.name, word, &words));
            return None;
        };
        if let Some(first) = before.insert((inner.name, None), child.head).filter(|_| inner.once) {
            self.diagnostics.push(diagnostics::repeated_block(*span, signature.name, word, first));
        }
        if let Some(name) = &child.name
            && let Some(first) = before.insert((inner.name, Some(&name.text)), name.span)
        {
            self.diagnostics.push(diagnostics::duplicate_declaration(name.span, inner.name, &name.text, first));
        }
        Some(self.block(child, inner))
    }

    /// Reports keys whose values must not lie above those of others.
    fn rising(&mut self, block: &Block, signature: &Signature) {
        for [low, high] in &signature.rising {
            let place = |key: &str| block.places.iter().find(|(name, _)| *name == key).map(|(_, span)| *span);
            if let (Value::Number(a), Value::Number(b)) = (block.arguments.value(low), block.arguments.value(high))
                && a > b
            {
                let (first, second) = (place(low), place(high));
                let span = second.or(first).unwrap_or(block.head);
                let other = first.filter(|_| second.is_some());
                self.diagnostics.push(diagnostics::not_rising(span, low, high, other));
            }
        }
    }

    fn clause(&mut self, written: &ast::Clause, earlier: &[Clause]) -> Option<Clause> {
        let events = || self.context.vocabulary.events.iter().filter(|event| event.answered);
        let known: Vec<&str> = events().map(|event| event.name).collect();
        let name = &written.event;
        let Some(event) = events().find(|event| event.name == name.text) else {
            self.diagnostics.push(diagnostics::unknown_event(name.span, &name.text, &known));
            return None;
        };
        let mut subject = None;
        let word = match (&written.word, event.declared) {
            (None, Some(form)) => {
                let known = self.context.names.of_form(form);
                self.diagnostics.push(diagnostics::nameless_event(name.span, event.name, form, known));
                return None;
            }
            (Some(word), Some(form)) => {
                subject = Some(named(&word.text, word.span, form, self.context.names, self.diagnostics)?);
                None
            }
            (None, None) => None,
            (Some(word), None) => match event.words.iter().find(|known| **known == word.text) {
                Some(known) => Some(*known),
                None => {
                    let unknown = diagnostics::unknown_event_word(word.span, event.name, &word.text, event.words);
                    self.diagnostics.push(unknown);
                    return None;
                }
            },
        };
        if let Some(first) =
            earlier.iter().find(|clause| (clause.event, clause.word, clause.subject) == (event.name, word, subject))
        {
            self.diagnostics.push(diagnostics::duplicate_clause(name.span, first.span));
        }
        let Context { vocabulary, names, .. } = *self.context;
        let scope = Scope { vocabulary, available: &event.variables, event: event.name, names, whole: true };
        let formula = plain_number(&written.formula, &scope, self.diagnostics)?;
        Some(Clause { event: event.name, word, subject, formula, span: name.span })
    }
}

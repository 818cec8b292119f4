//! AST → HIR: forms, kinds, keys, references, defaults.

use std::cell::LazyCell;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use super::ast::{self, Entry, ExpressionKind, Name};
use super::defaults::Defaults;
use super::diagnostics::KeyOf;
use super::formula::{Scope, named};
use super::hir::ParamId;
use super::hir::{Block, Clause, Declaration, Program};
use super::names::names_of_all;
use super::params::{DIMENSIONS, Params, type_of};
use super::value::{Context, plain_number, value};
use super::{Loaded, diagnostics};
use base::diagnostic::{Diagnostic, SourceId, Sources, Span};
use base::signature::{Arguments, DeclarationId, Form, Param, Signature, Type, Value, Vocabulary};
use base::units::{Dimension, parse_unit};

/// The results of checking, reused for further variants of the same files, which differ only in their settings.
#[derive(Debug)]
pub struct Checked<'f> {
    defaults: Defaults<'f>,
    /// Declarations without errors.
    faultless: BTreeMap<DeclarationId, Faultless>,
}

/// The longest name of a declaration (bytes): files are named after several of them.
const LONGEST_NAME: usize = 50;

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

/// The number of diagnostics after which checking ends, so that a file in which all is wrong fits into the memory.
const MOST: usize = 20_000;

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
    let names = names_of_all(&loaded.files, &ids, &mut diagnostics);
    let mut params = Params::resolve(loaded, &names, forms, vocabulary, sources, &mut diagnostics);
    for (place, file) in loaded.files.iter().enumerate() {
        let context = Context { vocabulary, forms, names: &names[place], sources };
        for (written, id) in file.declarations.iter().zip(&ids[&file.source]) {
            if diagnostics.len() > MOST {
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
    (program, diagnostics)
}

/// Drops repeated diagnostics.
pub fn once(diagnostics: &mut Vec<Diagnostic>) {
    let mut said = BTreeSet::new();
    diagnostics.retain(|each| said.insert((each.primary.span, each.code, each.message.clone())));
}

/// Where a key belongs that a signature does not have: in one of its blocks, or else in another form.
fn key_of<'f>(word: &str, signature: &'f Signature, forms: &'f [Form]) -> Option<KeyOf<'f>> {
    let has = |signature: &Signature| signature.params.iter().any(|param| param.name == word);
    if let Some(block) = signature.children.iter().find(|child| has(child)) {
        return Some(KeyOf::Block(block.name));
    }
    let of = |form: &&Form| form.kinds.iter().chain(&form.plain).any(has);
    let within =
        |form: &'f Form| form.kinds.iter().chain(&form.plain).flat_map(|each| &each.children).find(|each| has(each));
    let form = forms.iter().find(of).map(|form| form.name);
    form.or_else(|| forms.iter().find_map(within).map(|child| child.name)).map(KeyOf::Form)
}

/// Whether numbers of a type may be of this dimension.
fn measures(ty: &Type, dimension: Dimension) -> bool {
    ty.dimension() == Some(dimension)
        || matches!(ty, Type::Integer { .. } | Type::Ticks { .. }) && dimension == Dimension::RATIO
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
                let kind = written.kind.as_ref().filter(|_| written.name.is_none());
                let has =
                    |form: &&Form| kind.is_some_and(|kind| form.kinds.iter().any(|known| known.name == kind.text));
                self.diagnostics.push(match forms.iter().find(has) {
                    Some(form) => diagnostics::missing_form(*span, text, form.name),
                    None => diagnostics::unknown_form(*span, text, form_names),
                });
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
        if let Some(long) = written.name.as_ref().filter(|name| name.text.len() > LONGEST_NAME) {
            self.diagnostics.push(diagnostics::long_name(long.span, LONGEST_NAME));
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
        let keys: Vec<&str> = signature.params.iter().map(|param| param.name).collect();
        let words: Vec<&str> = signature.children.iter().map(|child| child.name).collect();
        let mut given: Vec<(&Name, &'static str, Span, Option<Value>)> = Vec::new();
        let mut members = Vec::new();
        let mut children = Vec::new();
        let mut clauses: Vec<Clause> = Vec::new();
        let mut named: BTreeMap<(&str, &str), Span> = BTreeMap::new();
        // Keys with a reported suggestion: their absence is not reported again.
        let mut meant: BTreeSet<String> = BTreeSet::new();
        // Keys that are not given, for suggestions.
        let left = LazyCell::new(|| {
            let key = |entry: &Entry| match entry {
                Entry::Property(property) => keys.iter().find(|key| **key == property.key.text).copied(),
                _ => None,
            };
            let given: BTreeSet<&str> = written.entries.iter().filter_map(key).collect();
            keys.iter().copied().filter(|key| !given.contains(key)).collect::<Vec<&str>>()
        });
        // The ends of values that have been reported as one.
        let mut told = 0;
        for (place, entry) in written.entries.iter().enumerate() {
            match entry {
                Entry::Property(property) => match signature.params.iter().find(|p| p.name == property.key.text) {
                    None => {
                        let Name { text, span } = &property.key;
                        let elsewhere = key_of(text, signature, self.context.forms);
                        let is_event =
                            signature.clauses && self.context.vocabulary.events.iter().any(|event| event.name == text);
                        let unknown = match is_event {
                            true => diagnostics::event_for_key(*span, signature.name, text),
                            false => diagnostics::unknown_key(*span, signature.name, text, &left, &words, elsewhere),
                        };
                        meant.extend(unknown.fixes.iter().map(|fix| fix.text.clone()));
                        self.diagnostics.push(unknown);
                    }
                    Some(param) => {
                        if let Some((first, ..)) = given.iter().find(|(_, name, ..)| *name == param.name) {
                            self.diagnostics.push(diagnostics::duplicate_key(
                                property.key.span,
                                param.name,
                                first.span,
                            ));
                            continue;
                        }
                        let bare = written.entries[place + 1..].iter().map_while(|entry| match entry {
                            Entry::Bare(value) => Some(value.span),
                            _ => None,
                        });
                        if let Some(end) = self.torn(property.value.span, bare, param) {
                            self.whole = false;
                            given.push((&property.key, param.name, property.value.span, None));
                            told = end;
                            continue;
                        }
                        if let Some(said) = counted_in_ticks(&property.value, param, signature, &written.entries) {
                            self.whole = false;
                            given.push((&property.key, param.name, property.value.span, None));
                            self.diagnostics.push(said);
                            continue;
                        }
                        let before = self.diagnostics.len();
                        let checked = value(&property.value, &param.ty, self.context, self.diagnostics);
                        for said in &mut self.diagnostics[before..] {
                            diagnostics::show_key(said, property.key.span, param);
                        }
                        self.whole &= checked.is_some();
                        given.push((&property.key, param.name, property.value.span, checked));
                        if matches!(param.ty, Type::List(_)) {
                            let spans = match &property.value.kind {
                                ast::ExpressionKind::List(members) => {
                                    members.iter().map(|member| member.span).collect()
                                }
                                _ => vec![property.value.span],
                            };
                            members.push((param.name, spans));
                        }
                    }
                },
                Entry::Bare(expression) if expression.span.start < told => {}
                Entry::Bare(expression) => {
                    // It may be the value of any missing key.
                    meant.extend(keys.iter().map(|key| (*key).to_string()));
                    let text = self.context.sources.text(expression.span);
                    let of_kind = type_of(text)
                        .and_then(|word| DIMENSIONS.iter().find(|(name, _)| *name == word))
                        .map(|(_, dimension)| *dimension);
                    let is_text = matches!(expression.kind, ExpressionKind::Text(_));
                    let fits = |param: &&Param| match is_text {
                        true => matches!(param.ty, Type::Text | Type::Path),
                        false => of_kind.is_none_or(|kind| measures(&param.ty, kind)),
                    };
                    // Keys that must be given come before those with a default.
                    let fitting = || signature.params.iter().filter(fits);
                    let needed: Vec<&str> =
                        fitting().filter(|param| param.default.is_none()).map(|param| param.name).collect();
                    let fitting = if needed.is_empty() { fitting().map(|param| param.name).collect() } else { needed };
                    self.diagnostics.push(diagnostics::bare_argument(expression.span, text, &fitting));
                }
                Entry::Unread(words) => {
                    self.whole = false;
                    meant.extend(words.iter().cloned());
                }
                Entry::Child(child) => match signature.children.iter().find(|c| c.name == child.form.text) {
                    None => {
                        let Name { text: word, span } = &child.form;
                        if keys.contains(&word.as_str()) {
                            meant.insert(word.clone());
                        }
                        self.diagnostics.push(match (&child.kind, child.entries.as_slice()) {
                            (Some(kind), []) if keys.contains(&word.as_str()) && child.name.is_none() => {
                                let meant = format!("{word}: {}", kind.text);
                                diagnostics::mistake(span.to(kind.span), "a key is followed by `:`", Some(&meant))
                            }
                            _ => diagnostics::unknown_block(*span, signature.name, word, &words, &keys),
                        });
                    }
                    Some(inner) => {
                        if let Some(kind) = &child.kind {
                            let place = child.form.span.to(kind.span);
                            let meant = child.name.is_none().then(|| format!("{} {}", child.form.text, kind.text));
                            let said = "a block follows its name directly";
                            let said = diagnostics::mistake(place, said, meant.as_deref());
                            // `search meet = intercept()`
                            let own =
                                self.context.forms.iter().find(|form| form.kinds.iter().any(|k| k.name == kind.text));
                            self.diagnostics.push(match (own, &child.name) {
                                (Some(form), Some(name)) => said.help(format!(
                                    "declare it outside, `{} {} = {}(…)`, and name it in a key",
                                    form.name, name.text, kind.text
                                )),
                                _ => said,
                            });
                        }
                        if let Some(name) = &child.name {
                            let before = named.insert((&child.form.text, &name.text), name.span);
                            let again =
                                |first| diagnostics::duplicate_declaration(name.span, inner.name, &name.text, first);
                            self.diagnostics.extend(before.map(again));
                        }
                        children.push(self.block(child, inner));
                    }
                },
                Entry::Clause(clause) if signature.clauses => {
                    let clause = self.clause(clause, &clauses);
                    self.whole &= clause.is_some();
                    clauses.extend(clause);
                }
                Entry::Clause(clause) => {
                    self.diagnostics.push(diagnostics::unexpected_clause(clause.event.span, signature.name));
                }
            }
        }
        let mut arguments = Arguments::default();
        let mut missing = Vec::new();
        for param in &signature.params {
            let value = match given.iter().find(|(_, name, ..)| *name == param.name) {
                Some((_, _, _, checked)) => checked.clone(),
                None => match param.default {
                    Some("") => Some(Value::Absent),
                    Some(text) => Some(self.defaults.value(param, text, self.context.names, self.context.sources)),
                    None if meant.contains(param.name) => None,
                    None => {
                        missing.push(param);
                        None
                    }
                },
            };
            arguments.push(param.name, value.unwrap_or(Value::Absent));
        }
        if !missing.is_empty() {
            self.diagnostics.push(diagnostics::missing_keys(written.head, signature.name, &missing));
        }
        let places: Vec<(&str, Span)> = given.iter().map(|(_, name, span, _)| (*name, *span)).collect();
        for [low, high] in &signature.rising {
            let place = |key: &str| places.iter().find(|(name, _)| *name == key).map(|(_, span)| *span);
            if let (Value::Number(a), Value::Number(b)) = (arguments.value(low), arguments.value(high))
                && a > b
            {
                let (first, second) = (place(low), place(high));
                let span = second.or(first).unwrap_or(written.head);
                let other = first.filter(|_| second.is_some());
                self.diagnostics.push(diagnostics::not_rising(span, low, high, other));
            }
        }
        let name = written.name.as_ref().map(|name| name.text.clone());
        Block { word: signature.name, name, arguments, places, members, children, clauses, head: written.head }
    }

    /// Reports a value that continues in the values after it, which have no key: a number with commas, or a list without brackets.
    /// Returns where it ends.
    fn torn(&mut self, value: Span, mut bare: impl Iterator<Item = Span>, param: &Param) -> Option<usize> {
        let text = &self.context.sources.get(value.source).text;
        let first = bare.next()?;
        let comma = decimal_comma(&text[..first.start], &text[first.start..]);
        let listed = matches!(param.ty, Type::List(_));
        let (start, end, diagnostic) = match comma {
            Some((whole, part)) if !listed => {
                let (start, end) = (first.start - whole, first.start + part);
                (start, end, diagnostics::decimal_comma(Span { start, end, ..first }, &text[start..end]))
            }
            _ if listed => {
                let span = value.to(bare.last().unwrap_or(first));
                (span.start, span.end, diagnostics::unbracketed_list(span, self.context.sources.text(span)))
            }
            _ => return None,
        };
        if start < value.start {
            return None;
        }
        self.diagnostics.push(diagnostic);
        Some(end)
    }

    fn clause(&mut self, written: &ast::Clause, earlier: &[Clause]) -> Option<Clause> {
        let events = || self.context.vocabulary.events.iter().filter(|event| event.answered);
        let known: Vec<&str> = events().map(|event| event.name).collect();
        let name = &written.event;
        let Some(event) = events().find(|event| event.name == name.text) else {
            self.diagnostics.push(diagnostics::unknown_event(
                name.span,
                &name.text,
                &known,
                events().find(|event| event.words.contains(&name.text.as_str())).map(|event| event.name),
            ));
            // What is paid is looked at all the same.
            let Context { vocabulary, names, .. } = *self.context;
            let every: Vec<&'static str> = vocabulary.variables.iter().map(|variable| variable.name).collect();
            let scope = Scope { vocabulary, available: &every, event: "this event", names, whole: true };
            plain_number(&written.formula, &scope, self.diagnostics);
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

/// A number written with commas; `text` starts with the digits after the first comma. Returns its bytes before and after it.
fn decimal_comma(before: &str, text: &str) -> Option<(usize, usize)> {
    let digits = |text: &mut dyn Iterator<Item = u8>| text.take_while(u8::is_ascii_digit).count();
    let whole = digits(&mut before.strip_suffix(',')?.bytes().rev());
    let mut part = digits(&mut text.bytes());
    if whole == 0 || part == 0 {
        return None;
    }
    while text[part..].starts_with(',') {
        match digits(&mut text[part + 1..].bytes()) {
            0 => break,
            more => part += 1 + more,
        }
    }
    Some((whole + 1, part))
}

/// A time where a number of ticks is expected, with that number; none where the value is something else.
fn counted_in_ticks(
    value: &ast::Expression,
    param: &Param,
    signature: &Signature,
    entries: &[Entry],
) -> Option<Diagnostic> {
    let time = seconds(value).filter(|_| matches!(param.ty, Type::Ticks { .. }))?;
    let Some(ticks) = signature.params.iter().find(|param| param.name == "tick") else {
        return Some(diagnostics::time_for_budget(value.span, param.name));
    };
    let default = ticks.default?;
    let written = entries.iter().find_map(|entry| match entry {
        Entry::Property(property) if property.key.text == "tick" => Some(&property.value),
        _ => None,
    });
    let tick = match written {
        Some(tick) => seconds(tick)?,
        None => default.strip_suffix(" s")?.parse().ok()?,
    };
    Some(diagnostics::time_for_ticks(value.span, param.name, time, tick))
}

/// A number with a unit of time, in s.
fn seconds(value: &ast::Expression) -> Option<f64> {
    let ExpressionKind::Number { value, unit: Some(unit) } = &value.kind else { return None };
    let unit = parse_unit(&unit.text).ok().filter(|unit| unit.dimension == Dimension::TIME)?;
    Some(value * unit.factor)
}

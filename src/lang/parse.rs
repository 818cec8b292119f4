//! Text → AST. Only this module and `format::marks` know pest.

mod expression;
mod junk;

use pest::Parser;
use pest::iterators::Pair;
use std::sync::Arc;

use super::ast::{Clause, Declaration, Entry, Expression, ExpressionKind, File, Import, Known, Name, Param, Property};
use super::{brackets, codes, repair};
use crate::diagnostic::{Diagnostic, SourceId, Span};

#[allow(missing_docs, reason = "the derive writes the enum; the grammar documents the rules")]
pub(super) mod rules {
    /// The parser made from the grammar files.
    #[derive(pest_derive::Parser)]
    #[grammar = "../grammar/lexical.pest"]
    #[grammar = "../grammar/scenario.pest"]
    pub(in crate::internal::lang) struct ScenarioParser;
}
use rules::{Rule, ScenarioParser};

/// The longest file that is read (bytes).
const MAX_BYTES: usize = 4 << 20;

/// Reads a file's text into a tree, with everything that could be read and one diagnostic for each statement that
/// could not.
pub fn parse(source: SourceId, text: &str) -> (File, Vec<Diagnostic>) {
    if text.len() > MAX_BYTES {
        let span = Span { source, start: 0, end: 0 };
        return (File { torn: true, ..empty(source) }, vec![codes::too_large(span, text.len(), MAX_BYTES)]);
    }
    match brackets::scan(source, text) {
        Ok(()) => read(source, text),
        Err(diagnostic) => {
            let balanced = brackets::balance(source, text, *diagnostic);
            let (mut file, diagnostics) = match balanced.text {
                Some(text) => read(source, &text),
                None => (File { torn: true, ..empty(source) }, Vec::new()),
            };
            file.unread.splice(0..0, balanced.left_out.iter().flat_map(|part| names_of(&text[part.clone()])));
            (file, [balanced.diagnostics, diagnostics].concat())
        }
    }
}

/// Reads a text whose brackets are balanced.
fn read(source: SourceId, text: &str) -> (File, Vec<Diagnostic>) {
    let mut reader = Reader { source, headless: false, diagnostics: Vec::new() };
    let mut file = empty(source);
    match ScenarioParser::parse(Rule::file, text) {
        Ok(mut pairs) => {
            for pair in pairs.next().expect("a parse gives its rule").into_inner() {
                reader.item(pair, &mut file);
            }
        }
        Err(error) => {
            file.torn = true;
            reader.diagnostics.push(reader.syntax_error(&error, 0, 0));
        }
    }
    (file, reader.diagnostics)
}

fn empty(source: SourceId) -> File {
    let (imports, params, declarations) = (Vec::new(), Vec::new(), Vec::new());
    File { source, edition: None, imports, params, unread: Vec::new(), torn: false, declarations }
}

/// The words of what may be left over from a declaration: parentheses that could not be read.
fn unread_arguments(junk: &Pair<Rule>) -> Option<Entry> {
    junk.as_str().starts_with('(').then(|| Entry::Unread(words_of(junk.as_str())))
}

/// The words of a text, some of them if there are many.
fn words_of(text: &str) -> Vec<String> {
    const MOST: usize = 64;
    let part = |c: char| c == '_' || c.is_ascii_alphanumeric();
    let words =
        text.split(|c: char| !part(c)).filter(|word| word.starts_with(|first: char| first.is_ascii_lowercase()));
    words.take(MOST).map(str::to_string).collect()
}

/// The words among which the name is that a statement declares: those before its first `=`, `{` or `(`.
fn names_of(statement: &str) -> impl Iterator<Item = String> {
    /// Form, name, type, and one that does not belong there.
    const MOST: usize = 4;
    let lines = statement.lines().map(str::trim_start).filter(|line| !line.starts_with("//"));
    let first = lines.into_iter().find(|line| !line.is_empty()).unwrap_or_default();
    let head = first.split(['=', '{', '(']).next().unwrap_or_default();
    let words = head.split(|c: char| c != '_' && !c.is_ascii_alphanumeric()).filter(|word| !word.is_empty());
    let words: Vec<String> = words.take(MOST).map(str::to_string).collect();
    words.into_iter()
}

/// Reads a value that stands alone, such as a default in a signature.
pub(super) fn parse_value(source: SourceId, text: &str) -> Result<Expression, Box<Diagnostic>> {
    let mut reader = Reader { source, headless: false, diagnostics: Vec::new() };
    brackets::scan(source, text)?;
    match ScenarioParser::parse(Rule::whole_value, text) {
        Ok(mut pairs) => {
            let value = pairs.next().and_then(|whole| whole.into_inner().next()).expect("whole_value holds a value");
            Ok(reader.value(value))
        }
        Err(error) => Err(Box::new(reader.syntax_error(&error, 0, 0))),
    }
}

struct Reader {
    source: SourceId,
    /// Whether the last statement is the head of a declaration without braces: indented lines are what it was to hold.
    headless: bool,
    diagnostics: Vec<Diagnostic>,
}

impl Reader {
    fn span(&self, pair: &Pair<Rule>) -> Span {
        let span = pair.as_span();
        // Trailing blanks belong to no node.
        let end = span.start() + span.as_str().trim_end().len();
        Span { source: self.source, start: span.start(), end: end }
    }

    fn name(&self, pair: Pair<Rule>) -> Name {
        Name { text: pair.as_str().to_string(), span: self.span(&pair) }
    }

    fn item(&mut self, pair: Pair<Rule>, file: &mut File) {
        let before = &pair.get_input()[..pair.as_span().start()];
        let indented = before.ends_with([' ', '\t']) && before.trim_end_matches([' ', '\t']).ends_with('\n');
        if self.headless && indented && matches!(pair.as_rule(), Rule::junk_item | Rule::declaration) {
            file.unread.extend(names_of(pair.as_str()));
            return;
        }
        self.headless &= pair.as_rule() == Rule::doc;
        match pair.as_rule() {
            Rule::edition => {
                let mut inner = pair.into_inner().skip_while(|part| part.as_rule() == Rule::doc);
                let word = inner.next().expect("edition has a word");
                let number = inner.next().expect("edition has a number");
                let span = self.span(&word).to(self.span(&number));
                let before = file.edition.map(|(_, span)| span);
                if before.is_some()
                    || !(file.imports.is_empty() && file.params.is_empty() && file.declarations.is_empty())
                {
                    self.diagnostics.push(codes::misplaced_edition(span, before));
                    if before.is_some() {
                        return;
                    }
                }
                file.edition = Some((read_number(number.as_str()), self.span(&number)));
            }
            Rule::import => {
                let mut names = Vec::new();
                for part in pair.into_inner() {
                    match part.as_rule() {
                        Rule::imported => names.extend(part.into_inner().map(|name| self.name(name))),
                        Rule::text => {
                            let (path, span) = (inner_text(&part), self.span(&part));
                            file.imports.push(Import { names: std::mem::take(&mut names), path, span, source: None });
                        }
                        _ => {}
                    }
                }
            }
            Rule::param => {
                let param = self.param(pair);
                file.params.push(param);
            }
            Rule::declaration => {
                let declaration = self.declaration(pair);
                file.declarations.push(declaration.into());
            }
            Rule::junk_item => {
                if let Some(param) = file.params.last_mut().filter(|param| self.goes_on(&param.value, &pair)) {
                    param.value.kind = ExpressionKind::Known(Known::Wrong);
                }
                if let Some(declaration) = file.declarations.last_mut().and_then(Arc::get_mut) {
                    declaration.entries.extend(unread_arguments(&pair));
                }
                file.unread.extend(names_of(pair.as_str()));
                // What it would have brought is not known.
                file.torn |= repair::imports(pair.as_str());
                let start = pair.as_span().start();
                let behind = &pair.get_input()[pair.as_span().end()..];
                match repair::headless(pair.as_str(), behind).filter(|_| !indented) {
                    Some(colon) => {
                        self.headless = true;
                        self.diagnostics
                            .push(codes::missing_braces(self.place(start + colon.start, start + colon.end)));
                    }
                    None => self.junk(&pair, Rule::whole_item),
                }
            }
            Rule::doc | Rule::EOI => {}
            other => unreachable!("file holds no {other:?}"),
        }
    }

    fn param(&mut self, pair: Pair<Rule>) -> Param {
        let span = self.span(&pair);
        let mut docs = Vec::new();
        let mut names = Vec::new();
        let mut value = None;
        for part in pair.into_inner() {
            match part.as_rule() {
                Rule::doc => docs.push(part.as_str()[3..].trim().to_string()),
                Rule::name => names.push(self.name(part)),
                Rule::value => value = Some(self.value(part)),
                _ => {}
            }
        }
        let mut names = names.into_iter();
        let mut name = || names.next().expect("a parameter has a name and a type");
        Param { docs, name: name(), ty: name(), value: value.expect("a parameter has a value"), setting: None, span }
    }

    fn declaration(&mut self, pair: Pair<Rule>) -> Declaration {
        let span = self.span(&pair);
        let mut docs = Vec::new();
        let mut names = Vec::new();
        let mut kind = None;
        let mut entries = Vec::new();
        for part in pair.into_inner() {
            match part.as_rule() {
                Rule::doc => docs.push(part.as_str()[3..].trim().to_string()),
                Rule::name => names.push(self.name(part)),
                Rule::kind => {
                    let mut inner = part.into_inner();
                    kind = inner.next().map(|word| self.name(word));
                    for argument in inner.flat_map(Pair::into_inner) {
                        let entry = self.argument(argument);
                        entries.push(entry);
                    }
                }
                Rule::block => self.block(part, &mut entries),
                other => unreachable!("declaration holds no {other:?}"),
            }
        }
        let mut names = names.into_iter();
        let form = names.next().expect("a declaration begins with a name");
        let name = names.next();
        let last = kind.as_ref().or(name.as_ref()).unwrap_or(&form);
        Declaration { docs, head: form.span.to(last.span), span, form, name, kind, entries }
    }

    fn argument(&mut self, pair: Pair<Rule>) -> Entry {
        let mut inner = pair.into_inner();
        let first = inner.next().expect("an argument has a value");
        match inner.next() {
            Some(value) => Entry::Property(Property { key: self.name(first), value: self.value(value) }),
            None => Entry::Bare(self.value(first)),
        }
    }

    fn block(&mut self, pair: Pair<Rule>, entries: &mut Vec<Entry>) {
        for part in pair.into_inner() {
            match part.as_rule() {
                Rule::property => {
                    let mut inner = part.into_inner().filter(|p| p.as_rule() != Rule::doc);
                    let key = self.name(inner.next().expect("a property has a key"));
                    let value = self.value(inner.next().expect("a property has a value"));
                    entries.push(Entry::Property(Property { key, value }));
                }
                Rule::clause => {
                    let mut inner = part.into_inner().filter(|p| !matches!(p.as_rule(), Rule::doc | Rule::on_word));
                    let mut event = inner.next().expect("a clause has an event").into_inner();
                    let name = self.name(event.next().expect("an event has a name"));
                    let word = event.next().map(|word| self.name(word));
                    let formula = self.value(inner.next().expect("a clause has a formula"));
                    entries.push(Entry::Clause(Clause { event: name, word, formula }));
                }
                Rule::declaration => {
                    let child = self.declaration(part);
                    entries.push(Entry::Child(child));
                }
                Rule::junk_entry => {
                    // What it goes on from is no more than a part of what was meant.
                    if let Some(Entry::Property(Property { value, .. }) | Entry::Clause(Clause { formula: value, .. })) =
                        entries.last_mut()
                        && self.goes_on(value, &part)
                    {
                        value.kind = ExpressionKind::Known(Known::Wrong);
                    }
                    if let Some(Entry::Child(child)) = entries.last_mut() {
                        child.entries.extend(unread_arguments(&part));
                    }
                    entries.push(Entry::Unread(words_of(part.as_str())));
                    self.junk(&part, Rule::whole_entry);
                }
                Rule::doc => {}
                other => unreachable!("block holds no {other:?}"),
            }
        }
    }

    /// A part of the text that is being parsed, as a place of the source.
    fn place(&self, start: usize, end: usize) -> Span {
        Span { source: self.source, start: start, end: end }
    }
}

fn read_number(text: &str) -> f64 {
    let number = if text.contains('_') { text.replace('_', "").parse() } else { text.parse() };
    number.expect("the grammar admits only numbers")
}

fn inner_text(pair: &Pair<Rule>) -> String {
    pair.clone().into_inner().next().map_or_else(String::new, |inner| inner.as_str().to_string())
}

#[cfg(test)]
mod tests;

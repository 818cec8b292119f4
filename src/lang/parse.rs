//! Text → AST. Only this module and `format::marks` know pest.

mod expression;
mod mistakes;
mod recovery;
mod statements;

use pest::Parser;
use pest::iterators::Pair;

use super::ast::{Entry, Expression, File, Name};
use super::{brackets, diagnostics};
use base::diagnostic::{Diagnostic, SourceId, Span};

#[allow(missing_docs, reason = "the derive writes the enum; the grammar documents the rules")]
pub(super) mod rules {
    /// The parser made from the grammar files.
    #[derive(pest_derive::Parser)]
    #[grammar = "grammar/lexical.pest"]
    #[grammar = "grammar/scenario.pest"]
    #[grammar = "grammar/mistakes.pest"]
    pub(crate) struct ScenarioParser;
}
use rules::{Rule, ScenarioParser};

/// The longest file that is read (bytes).
const MAX_BYTES: usize = 4 << 20;

/// Reads a file's text into a tree of everything that could be read, with one diagnostic for each statement that
/// could not.
pub fn parse(source: SourceId, text: &str) -> (File, Vec<Diagnostic>) {
    if text.len() > MAX_BYTES {
        let span = Span { source, start: 0, end: 0 };
        return (File { torn: true, ..empty(source) }, vec![diagnostics::too_large(span, text.len(), MAX_BYTES)]);
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
    let mut reader = Reader { source, headless: false, mistakes: 0, diagnostics: Vec::new() };
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
fn unread_arguments(node: &Pair<Rule>) -> Option<Entry> {
    node.as_str().starts_with('(').then(|| Entry::Unread(words_of(node.as_str())))
}

/// The words of a text; only some of them if there are many.
fn words_of(text: &str) -> Vec<String> {
    const MOST: usize = 64;
    let part = |c: char| c == '_' || c.is_ascii_alphanumeric();
    let words =
        text.split(|c: char| !part(c)).filter(|word| word.starts_with(|first: char| first.is_ascii_lowercase()));
    words.take(MOST).map(str::to_string).collect()
}

/// The words that may be the name that a statement declares: those before its first `=`, `{` or `(`.
fn names_of(statement: &str) -> impl Iterator<Item = String> {
    /// Form, name, type, and one word too many.
    const MOST: usize = 4;
    let lines = statement.lines().map(str::trim_start).filter(|line| !line.starts_with("//"));
    let first = lines.into_iter().find(|line| !line.is_empty()).unwrap_or_default();
    let head = first.split(['=', '{', '(']).next().unwrap_or_default();
    let words = head.split(|c: char| c != '_' && !c.is_ascii_alphanumeric()).filter(|word| !word.is_empty());
    let words: Vec<String> = words.take(MOST).map(str::to_string).collect();
    words.into_iter()
}

/// Reads a single value, such as a default in a signature.
pub(super) fn parse_value(source: SourceId, text: &str) -> Result<Expression, Box<Diagnostic>> {
    let mut reader = Reader { source, headless: false, mistakes: 0, diagnostics: Vec::new() };
    brackets::scan(source, text)?;
    match ScenarioParser::parse(Rule::whole_value, text) {
        Ok(mut pairs) => {
            let value = pairs.next().and_then(|whole| whole.into_inner().next()).expect("whole_value holds a value");
            let value = reader.value(value);
            match reader.diagnostics.into_iter().next().filter(|_| reader.mistakes > 0) {
                Some(mistake) => Err(Box::new(mistake)),
                None => Ok(value),
            }
        }
        Err(error) => Err(Box::new(reader.syntax_error(&error, 0, 0))),
    }
}

struct Reader {
    source: SourceId,
    /// Whether the last statement is the head of a declaration without braces; indented lines are then its intended contents.
    headless: bool,
    /// The number of reported mistakes.
    mistakes: usize,
    diagnostics: Vec<Diagnostic>,
}

impl Reader {
    fn span(&self, pair: &Pair<Rule>) -> Span {
        let span = pair.as_span();
        // Trailing blanks belong to no node.
        let end = span.start() + span.as_str().trim_end().len();
        Span { source: self.source, start: span.start(), end }
    }

    fn name(&self, pair: Pair<Rule>) -> Name {
        Name { text: pair.as_str().to_string(), span: self.span(&pair) }
    }

    /// A part of the text that is being parsed, as a place of the source.
    fn place(&self, start: usize, end: usize) -> Span {
        Span { source: self.source, start, end }
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

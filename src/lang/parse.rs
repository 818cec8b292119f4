//! Text → AST. Only this module and `format::marks` know pest.

mod expression;
mod statements;
mod unreadable;

use pest::Parser;
use pest::iterators::Pair;

use super::ast::{Expression, File, Name};
use super::{brackets, diagnostics};
use base::diagnostic::{Diagnostic, SourceId, Span};

#[allow(missing_docs, reason = "the derive writes the enum; the grammar documents the rules")]
pub(super) mod rules {
    /// The parser made from the grammar files.
    #[derive(pest_derive::Parser)]
    #[grammar = "grammar/lexical.pest"]
    #[grammar = "grammar/scenario.pest"]
    pub(crate) struct ScenarioParser;
}
use rules::{Rule, ScenarioParser};

/// Maximum length of a file (bytes).
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
            let (file, diagnostics) = match balanced.text {
                Some(text) => read(source, &text),
                None => (empty(source), Vec::new()),
            };
            (File { torn: true, ..file }, [balanced.diagnostics, diagnostics].concat())
        }
    }
}

/// Reads a text whose brackets are balanced.
fn read(source: SourceId, text: &str) -> (File, Vec<Diagnostic>) {
    let mut reader = Reader { source, diagnostics: Vec::new() };
    let mut file = empty(source);
    match ScenarioParser::parse(Rule::file, text) {
        Ok(mut pairs) => {
            for pair in pairs.next().expect("a parse gives its rule").into_inner() {
                reader.item(pair, &mut file);
            }
        }
        Err(error) => {
            file.torn = true;
            reader.diagnostics.push(reader.syntax_error(&error, text, 0));
        }
    }
    (file, reader.diagnostics)
}

fn empty(source: SourceId) -> File {
    let (imports, params, declarations) = (Vec::new(), Vec::new(), Vec::new());
    File { source, edition: None, imports, params, torn: false, declarations }
}

/// Reads a single value, such as a default in a signature.
pub(super) fn parse_value(source: SourceId, text: &str) -> Result<Expression, Box<Diagnostic>> {
    let mut reader = Reader { source, diagnostics: Vec::new() };
    brackets::scan(source, text)?;
    match ScenarioParser::parse(Rule::whole_value, text) {
        Ok(mut pairs) => {
            let value = pairs.next().and_then(|whole| whole.into_inner().next()).expect("whole_value holds a value");
            let value = reader.value(value);
            reader.diagnostics.into_iter().next().map_or(Ok(value), |said| Err(Box::new(said)))
        }
        Err(error) => Err(Box::new(reader.syntax_error(&error, text, 0))),
    }
}

struct Reader {
    source: SourceId,
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

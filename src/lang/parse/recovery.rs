//! Error nodes: reports on statements that neither the grammar nor its error productions match.

use std::ops::Range;
use std::sync::Arc;

use pest::Parser;
use pest::error::{ErrorVariant, InputLocation};
use pest::iterators::Pair;

use super::mistakes::{NO_IF, RANGE};
use super::rules::{Rule, ScenarioParser};
use super::{Reader, names_of, unread_arguments};
use crate::ast::{Expression, ExpressionKind, File, Known};
use crate::brackets::unbraced;
use crate::diagnostics;
use crate::tokens::{Token, TokenKind, words};
use base::diagnostic::{Diagnostic, Span};

/// The greatest number of error nodes that are parsed again for the place of the error; a file with more is not a scenario.
const MOST_REREAD: usize = 1000;

impl Reader {
    /// Whether an error node follows a value on its line.
    pub(super) fn goes_on(&self, value: &Expression, node: &Pair<Rule>) -> bool {
        let between = node.get_input().get(value.span.end..node.as_span().start());
        between.is_some_and(|text| text.trim_matches([' ', '\t', ',']).is_empty())
    }

    /// Takes the names that an error node may declare, and reports it.
    pub(super) fn junk_item(&mut self, pair: &Pair<Rule>, indented: bool, file: &mut File) {
        if let Some(param) = file.params.last_mut().filter(|param| self.goes_on(&param.value, pair)) {
            param.value.kind = ExpressionKind::Known(Known::Wrong);
        }
        if let Some(declaration) = file.declarations.last_mut().and_then(Arc::get_mut) {
            declaration.entries.extend(unread_arguments(pair));
        }
        file.unread.extend(names_of(pair.as_str()));
        // The names that it would have imported are not known.
        file.torn |= imports(pair.as_str());
        let start = pair.as_span().start();
        let after = &pair.get_input()[pair.as_span().end()..];
        match headless(pair.as_str(), after).filter(|_| !indented) {
            Some(colon) => {
                self.headless = true;
                self.diagnostics.push(diagnostics::missing_braces(self.place(start + colon.start, start + colon.end)));
            }
            None => self.error_node(pair, Rule::whole_item),
        }
    }

    /// Reports an error node: characters that the language does not have, a value that is cut off, or where the parser fails.
    pub(super) fn error_node(&mut self, pair: &Pair<Rule>, rule: Rule) {
        if self.diagnostics.len() >= MOST_REREAD {
            return self.diagnostics.push(diagnostics::syntax(self.span(pair), String::new()));
        }
        let start = pair.as_span().start();
        let text = pair.as_str().trim_end();
        let source = pair.get_input();
        if self.foreign(text, start, source) {
            return;
        }
        if let Some(sign) = open_end(source, start, text) {
            return self.diagnostics.push(diagnostics::open_end(self.place(sign.start, sign.end)));
        }
        let line = source[..start].rfind(['\n', '\r']).map_or(0, |end| end + 1);
        if let Some(clause) = source[line..start].trim_end().strip_suffix("return") {
            let place = self.place(line + clause.len(), line + clause.len() + "return".len());
            return self.diagnostics.push(diagnostics::mistake(place, "a formula needs no `return`", Some("")));
        }
        let before = source[line..start].trim();
        let whole = self.place(start, start + text.len());
        // What was read as a name or a unit before it, and is a word of another language.
        let last = before.rsplit([' ', '\t']).next().unwrap_or_default();
        let last_at = line + source[line..start].trim_end().len() - last.len();
        let replaced = match last {
            "if" => Some((NO_IF, None)),
            "to" if text.starts_with(|c: char| c.is_ascii_digit() || c == '-') => Some((RANGE, Some(".."))),
            _ => None,
        };
        if let Some((said, instead)) = replaced {
            return self.report(self.place(last_at, last_at + last.len()), said, instead);
        }
        let is_word = text.chars().all(|c| c == '_' || c.is_ascii_alphanumeric());
        let said = match rule {
            Rule::whole_item if before.starts_with("import ") && before.ends_with('"') => {
                "an import ends with its path; names come before it: `import a, b from \"path\"`"
            }
            Rule::whole_item if before.contains('=') && key_first(text) => "the keys of a kind need parentheses",
            Rule::whole_item if first_word(text) == "matrix" => {
                "a `matrix { name: [value, …] }` belongs inside a `campaign`"
            }
            Rule::whole_item if matches!(first_word(text), "for" | "foreach" | "while") => {
                "there are no loops: `matrix { name: [value, …] }` inside a `campaign` runs it for each value"
            }
            Rule::whole_item if before.is_empty() && key_first(text) => {
                "a key belongs inside a declaration: `form name { key: value }`"
            }
            Rule::whole_item if imports(text) => "write `import \"path\"`, or `import a, b from \"path\"`",
            Rule::whole_item if first_word(text) == "version" => "write `edition 1`",
            Rule::whole_entry if text.starts_with('?') => NO_IF,
            Rule::whole_entry if compares(text, 1) => {
                "a condition is the value of a key, such as `require: …` or `end_when: …`"
            }
            Rule::whole_entry if key_first(text) && compares(text, 2) => RANGE,
            Rule::whole_entry if text.contains("=>") && first_word(text) == "on" => {
                "an event takes one word in parentheses, no condition: `on hit(front) => …`"
            }
            Rule::whole_entry if is_word && !before.is_empty() => "this does not belong to the value before it",
            _ => return self.unreadable(text, start, rule),
        };
        self.diagnostics.push(diagnostics::mistake(whole, said, None));
    }

    /// Reports the place where the parser fails.
    fn unreadable(&mut self, text: &str, start: usize, rule: Rule) {
        // Parentheses of a declaration that does not need them.
        let head = if text.starts_with('(') { "form name = kind" } else { "" };
        let said = match ScenarioParser::parse(rule, &format!("{head}{text}")) {
            Err(error) => self.syntax_error(&error, head.len(), start),
            Ok(_) => diagnostics::syntax(self.place(start, start + text.len()), "this cannot stand here".into()),
        };
        self.diagnostics.push(said);
    }

    /// The error of pest for a text from a place of the source on, after a number of bytes that were added before it.
    pub(super) fn syntax_error(&self, error: &pest::error::Error<Rule>, added: usize, start: usize) -> Diagnostic {
        let (from, to) = match error.location {
            InputLocation::Pos(at) => (at, at),
            InputLocation::Span((from, to)) => (from, to),
        };
        let (from, to) = (from.saturating_sub(added), to.saturating_sub(added));
        let span = Span { source: self.source, start: start + from, end: start + to };
        let expected = match &error.variant {
            ErrorVariant::ParsingError { positives, .. } => {
                let mut words: Vec<&str> = positives.iter().filter_map(|rule| describe(*rule)).collect();
                words.sort_unstable();
                words.dedup();
                words.join(", ")
            }
            ErrorVariant::CustomError { message } => message.clone(),
        };
        let text = if expected.is_empty() { "not understood from here".into() } else { format!("expected {expected}") };
        diagnostics::syntax(span, text)
    }

    /// Reports that a comma is missing after a value, or that another sign is in its place.
    pub(super) fn missing_comma(&mut self, gap: &Pair<Rule>, end: usize) {
        self.mistakes += 1;
        let start = gap.as_span().start();
        self.diagnostics.push(match gap.as_str() {
            ";" => diagnostics::mistake(self.place(start, start + 1), "commas separate values", Some(",")),
            _ => diagnostics::missing_comma(self.place(end, end)),
        });
    }
}

/// Whether a text starts with a key.
fn key_first(text: &str) -> bool {
    let mut found = words(text);
    found.next().is_some_and(|token| token.kind == TokenKind::Name) && found.next().is_some_and(|t| t.text(text) == ":")
}

/// Whether the word at this place of a statement is a sign of comparison.
fn compares(statement: &str, place: usize) -> bool {
    words(statement).nth(place).is_some_and(|token| matches!(token.text(statement), "<" | ">" | "<=" | ">="))
}

/// The first word of a statement, or "".
fn first_word(statement: &str) -> &str {
    let first = words(statement).find(|token| token.kind != TokenKind::Doc);
    first.map_or("", |token| token.text(statement))
}

/// Whether a statement was probably meant as an import.
fn imports(statement: &str) -> bool {
    ["import", "include", "from", "using"].contains(&first_word(statement).to_lowercase().as_str())
}

/// The end of a declaration's head without any brace, when `after` continues with an indented line.
fn headless(statement: &str, after: &str) -> Option<Range<usize>> {
    let start = words(statement).find(|token| token.kind != TokenKind::Doc)?.start;
    let line = statement[start..].trim_end();
    let next = after
        .split(['\n', '\r'])
        .map(|line| line.split("//").next().unwrap_or_default())
        .find(|line| !line.trim().is_empty())?;
    let holds = next.starts_with([' ', '\t']) && next.contains([':', '{', '=']);
    let place = unbraced(line).filter(|_| holds && !line.contains('\n'))?;
    Some(start + place.start..start + place.end)
}

/// The operator that a value ends with: at the end of an error node, or before a key that was read as the rest of the value.
fn open_end(source: &str, start: usize, text: &str) -> Option<Range<usize>> {
    /// The number of bytes that are read for the operator.
    const MOST: usize = 4096;
    let open = |token: &Token, text: &str| match token.kind {
        TokenKind::Sign => !matches!(token.text(text), "," | ";" | "="),
        TokenKind::Keyword => matches!(token.text(text), "and" | "or" | "not" | "implies"),
        _ => false,
    };
    if text.starts_with(':') {
        let from = source[..start].floor_char_boundary(start.saturating_sub(MOST));
        let from = from + source[from..start].find('\n').filter(|_| from > 0).unwrap_or(0);
        let before = &source[from..start];
        let mut found: Vec<Token> = words(before).collect();
        let (key, sign) = (found.pop()?, found.pop()?);
        let apart = before[sign.end..key.start].contains('\n');
        return (apart && open(&sign, before)).then_some(from + sign.start..from + sign.end);
    }
    let last = words(text).last().filter(|token| open(token, text))?;
    Some(start + last.start..start + last.end)
}

/// The user's name of a rule; `None` for rules that mean nothing to a user. Exhaustive, so that a new rule gets a name.
fn describe(rule: Rule) -> Option<&'static str> {
    Some(match rule {
        Rule::name => "a name",
        Rule::number | Rule::quantity => "a number",
        Rule::unit => "a unit",
        Rule::text => "a text in quotes",
        Rule::block => "`{`",
        Rule::kind => "`=`",
        Rule::arguments | Rule::group => "`(`",
        Rule::list => "`[`",
        Rule::edition | Rule::edition_word => "`edition`",
        Rule::import | Rule::import_word => "`import`",
        Rule::imported => "names",
        Rule::from_word => "`from`",
        Rule::param | Rule::param_word => "`param name: type = value`",
        Rule::declaration => "a declaration",
        Rule::property => "`key: value`",
        Rule::clause | Rule::on_word => "`on event => formula`",
        Rule::event => "an event",
        Rule::value | Rule::expression | Rule::term | Rule::primary => "a value",
        Rule::call => "a call",
        Rule::argument => "an argument",
        Rule::infix => "an operator",
        Rule::conversion => "`in`",
        Rule::EOI | Rule::whole_item | Rule::whole_entry | Rule::whole_value => "the end of the statement",
        Rule::b
        | Rule::stated
        | Rule::before_block
        | Rule::requirement_word
        | Rule::COMMENT
        | Rule::doc
        | Rule::docs
        | Rule::name_char
        | Rule::keyword
        | Rule::digits
        | Rule::free
        | Rule::unit_part
        | Rule::power
        | Rule::blank
        | Rule::text_inner
        | Rule::file
        | Rule::junk_item
        | Rule::junk_entry
        | Rule::balanced
        | Rule::within
        | Rule::piece
        | Rule::dark
        | Rule::plain
        | Rule::line
        | Rule::remark
        | Rule::prefix
        | Rule::range_sign
        | Rule::gap
        | Rule::group_gap
        | Rule::unlisted
        | Rule::head_rest
        | Rule::wrong_infix
        | Rule::foreign_word
        | Rule::wrong_prefix
        | Rule::range_from
        | Rule::odd_number
        | Rule::odd_power
        | Rule::stray_unit
        | Rule::measure
        | Rule::wrong_entry
        | Rule::wrong_property
        | Rule::odd_key
        | Rule::split_key
        | Rule::no_colon
        | Rule::wrong_clause
        | Rule::several
        | Rule::odd_event
        | Rule::odd_word
        | Rule::braced
        | Rule::unmarked
        | Rule::on_like
        | Rule::wrong_item
        | Rule::hash
        | Rule::wrong_edition
        | Rule::edition_like
        | Rule::wrong_import
        | Rule::import_like
        | Rule::bare_path
        | Rule::wrong_declaration
        | Rule::odd_name
        | Rule::stray_colon
        | Rule::stray_equals
        | Rule::colon_kind
        | Rule::wrong_param
        | Rule::param_head
        | Rule::bare_head
        | Rule::param_like
        | Rule::arrow_sign
        | Rule::colon_sign => return None,
    })
}

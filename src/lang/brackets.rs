//! Finds unbalanced brackets before parsing; the parser could only report them far from the cause.

use std::ops::Range;

use super::diagnostics;
use super::tokens::{TokenKind, tokens};
use base::diagnostic::{Diagnostic, SourceId, Span};

/// Maximum depth of nested brackets.
pub const MAX_DEPTH: usize = 64;

/// Maximum number of statements that are left out because of their brackets; a file with more of them is not a scenario.
const MAX_UNBALANCED: usize = 16;

/// A text whose brackets are balanced.
pub struct Balanced {
    /// The text, of the same length, with blanks for the statements that were left out. `None` if there are too many.
    pub text: Option<String>,
    /// What is wrong with it.
    pub diagnostics: Vec<Diagnostic>,
}

/// Leaves out the statements of a text whose brackets are not balanced.
pub fn balance(source: SourceId, text: &str, first: Diagnostic) -> Balanced {
    let mut balanced = Balanced { text: None, diagnostics: Vec::new() };
    let mut rest = text.to_string();
    let mut found = first;
    for _ in 0..MAX_UNBALANCED {
        let closing = found.primary.span;
        let opening = found.labels.first().filter(|label| label.text == diagnostics::OPENED);
        let part = match found.code {
            // A closing bracket without a partner affects nothing else, so only it is left out.
            "stray-bracket" => closing.start..closing.end,
            "unclosed-comment" => statement(text, closing.start).start..text.len(),
            _ => {
                let start = opening.map_or(closing, |label| label.span).start;
                statement(text, start).start..statement(text, closing.start).end
            }
        };
        let blank = |letter: char| if matches!(letter, '\n' | '\r') { letter } else { ' ' };
        let blanks: String =
            rest[part.clone()].chars().flat_map(|c| std::iter::repeat_n(blank(c), c.len_utf8())).collect();
        rest.replace_range(part, &blanks);
        balanced.diagnostics.push(found);
        match scan(source, &rest) {
            Ok(()) => {
                balanced.text = Some(rest);
                break;
            }
            Err(next) => found = *next,
        }
    }
    balanced
}

/// The statement of a byte: from the last line that starts with a letter to the next one or its documentation.
fn statement(text: &str, byte: usize) -> Range<usize> {
    let starts = |line: &str| line.starts_with(|first: char| first.is_ascii_alphabetic()) || line.starts_with("///");
    let begins = |at: &usize| starts(&text[*at..]);
    let mut before = text[..byte].match_indices('\n').map(|(at, _)| at + 1);
    let start = before.rfind(|at| begins(at) && !text[*at..].starts_with("///")).unwrap_or(0);
    let mut after = text[byte..].match_indices('\n').map(|(at, _)| byte + at + 1);
    start..after.find(begins).unwrap_or(text.len())
}

/// Finds the first bracket without its partner.
///
/// # Errors
/// That bracket, a comment that is never closed, or nesting beyond [`MAX_DEPTH`].
pub fn scan(source: SourceId, text: &str) -> Result<(), Box<Diagnostic>> {
    let at = |start: usize| Span { source, start, end: start + 1 };
    let mut open: Vec<(char, usize)> = Vec::new();
    // The last text that does not end on its line; it may have swallowed a bracket.
    let mut unended = None;
    for token in tokens(text) {
        match token.kind {
            TokenKind::OpenComment => return Err(Box::new(diagnostics::unclosed_comment(at(token.start)))),
            TokenKind::OpenText => unended = Some(at(token.start)),
            TokenKind::Open => {
                open.extend(token.text(text).chars().map(|bracket| (bracket, token.start)));
                if open.len() > MAX_DEPTH {
                    return Err(Box::new(diagnostics::too_deep(at(token.start), MAX_DEPTH)));
                }
            }
            TokenKind::Close => match open.pop() {
                Some((opening, _)) if closes(opening, token.text(text)) => {}
                Some((opening, place)) => {
                    return Err(Box::new(diagnostics::mismatched_bracket(at(token.start), at(place), opening)));
                }
                None => return Err(Box::new(diagnostics::stray_bracket(at(token.start)))),
            },
            _ => {}
        }
    }
    let Some((opening, place)) = open.pop() else { return Ok(()) };
    let unended = unended.filter(|text| text.start > place);
    Err(Box::new(diagnostics::unclosed_bracket(at(place), opening, unended)))
}

fn closes(opening: char, closing: &str) -> bool {
    matches!((opening, closing), ('{', "}") | ('(', ")") | ('[', "]"))
}

//! Finds unbalanced brackets before parsing; the parser could only report them far from the cause.

use std::ops::Range;

use super::diagnostics;
use super::tokens::{TokenKind, tokens};
use base::diagnostic::{Diagnostic, SourceId, Span};

/// How deep brackets may nest.
pub const MAX_DEPTH: usize = 64;

/// The greatest number of statements that are left out because of their brackets; a file with more of them is not a scenario.
const MOST_UNBALANCED: usize = 16;

/// A text whose brackets are balanced, and the parts that were left out.
pub struct Balanced {
    /// The text, of the same length, with blanks for the parts that were left out. None when too much would be left out.
    pub text: Option<String>,
    /// What is wrong with it.
    pub diagnostics: Vec<Diagnostic>,
    /// The parts that were left out.
    pub left_out: Vec<Range<usize>>,
}

/// Leaves out the statements of a text whose brackets are not balanced.
pub fn balance(source: SourceId, text: &str, first: Diagnostic) -> Balanced {
    let mut balanced = Balanced { text: None, diagnostics: Vec::new(), left_out: Vec::new() };
    let mut rest = text.as_bytes().to_vec();
    let mut found = first;
    for _ in 0..MOST_UNBALANCED {
        let place = found
            .labels
            .first()
            .filter(|label| label.text == diagnostics::OPENED)
            .map_or(found.primary.span, |label| label.span);
        let part = match found.code {
            "stray-bracket" => match unopened(text, place.start) {
                Some((part, head)) => {
                    found = diagnostics::missing_brace(Span { start: head.start, end: head.end, ..place });
                    part
                }
                // A closing bracket without a partner affects nothing else, so only it is left out.
                None => place.start..place.end,
            },
            "unclosed-comment" => statement(text, place.start).start..text.len(),
            _ => statement(text, place.start).start..statement(text, found.primary.span.start).end,
        };
        rest[part.clone()].iter_mut().filter(|byte| !matches!(byte, b'\n' | b'\r')).for_each(|byte| *byte = b' ');
        balanced.diagnostics.push(found);
        balanced.left_out.push(part);
        let left = String::from_utf8(rest).expect("whole statements are left out");
        match scan(source, &left) {
            Ok(()) => {
                balanced.text = Some(left);
                break;
            }
            Err(next) => found = *next,
        }
        rest = left.into_bytes();
    }
    balanced
}

/// A statement without the opening brace that the brace at this byte would close, and the range after the last word of its
/// first line: a colon or nothing.
fn unopened(text: &str, byte: usize) -> Option<(Range<usize>, Range<usize>)> {
    if text.as_bytes()[byte] != b'}' {
        return None;
    }
    let whole = statement(text, byte);
    let line = text[whole.start..byte].lines().next()?;
    let place = unbraced(line).filter(|_| whole.start + line.len() < byte)?;
    let head = whole.start + place.start..whole.start + place.end;
    Some((whole.start..byte + 1, head))
}

/// The range at the end of a declaration's head without its brace, after the last word: a colon or nothing.
pub(super) fn unbraced(line: &str) -> Option<Range<usize>> {
    let head = line.split("//").next()?.trim_end();
    let named = head.strip_suffix(':').map_or(head, str::trim_end);
    let fine = (2..=4).contains(&named.split_whitespace().count()) && !named.contains(['{', '}', '"', ':']);
    let declares = !["edition", "import", "param", "on"].contains(&named.split_whitespace().next()?);
    (fine && declares).then_some(named.len()..head.len())
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
    // The last comment that contains a closing bracket.
    let mut commented: Option<Span> = None;
    for token in tokens(text) {
        match token.kind {
            TokenKind::LineComment | TokenKind::Doc if token.text(text).contains(['}', ')', ']']) => {
                commented = Some(at(token.start));
            }
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
    let line = text[place..].find(['\n', '\r']).map_or(text.len(), |end| place + end);
    let commented = commented.filter(|comment| (place..line).contains(&comment.start));
    Err(Box::new(diagnostics::unclosed_bracket(at(place), opening, unended, commented)))
}

fn closes(opening: char, closing: &str) -> bool {
    matches!((opening, closing), ('{', "}") | ('(', ")") | ('[', "]"))
}

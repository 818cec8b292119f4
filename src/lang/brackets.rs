//! Finds unbalanced brackets before parsing: the parser could only complain far from the cause.

use std::ops::Range;

use super::codes;
use super::repair::unbraced;
use crate::diagnostic::{Diagnostic, SourceId, Span};

/// How deep brackets may nest.
pub const MAX_DEPTH: usize = 64;

/// Most statements that are left out of a file because of their brackets; a file with more of them is no scenario.
const MOST_UNBALANCED: usize = 16;

/// A text whose brackets are balanced, and what was left out of it.
pub struct Balanced {
    /// The text, of the same length: what was left out is blank. None when too much would be.
    pub text: Option<String>,
    /// What is wrong with it.
    pub diagnostics: Vec<Diagnostic>,
    /// The parts that were left out.
    pub left_out: Vec<Range<usize>>,
}

/// Leaves out of a text the statements whose brackets are not balanced.
pub fn balance(source: SourceId, text: &str, first: Diagnostic) -> Balanced {
    let mut balanced = Balanced { text: None, diagnostics: Vec::new(), left_out: Vec::new() };
    let mut rest = text.as_bytes().to_vec();
    let mut found = first;
    for _ in 0..MOST_UNBALANCED {
        let place = found
            .labels
            .first()
            .filter(|label| label.text == codes::OPENED)
            .map_or(found.primary.span, |label| label.span);
        let part = match found.code {
            "stray-bracket" => match unopened(text, place.start) {
                Some((part, head)) => {
                    found = codes::missing_brace(Span { start: head.start, end: head.end, ..place });
                    part
                }
                // What closes nothing else does no harm but for itself.
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
            Ok(_) => {
                balanced.text = Some(left);
                break;
            }
            Err(next) => found = *next,
        }
        rest = left.into_bytes();
    }
    balanced
}

/// A statement without the brace that one at this byte would close, and the end of its first line behind the last word: a colon,
/// perhaps, or nothing.
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

/// The statement of a byte: from the last line that begins with a letter to the next one or its documentation.
fn statement(text: &str, byte: usize) -> Range<usize> {
    let starts = |line: &str| line.starts_with(|first: char| first.is_ascii_alphabetic()) || line.starts_with("///");
    let begins = |at: &usize| starts(&text[*at..]);
    let mut before = text[..byte].match_indices('\n').map(|(at, _)| at + 1);
    let start = before.rfind(|at| begins(at) && !text[*at..].starts_with("///")).unwrap_or(0);
    let mut after = text[byte..].match_indices('\n').map(|(at, _)| byte + at + 1);
    start..after.find(begins).unwrap_or(text.len())
}

/// Gives the places outside of brackets where a line begins as statements do: with a letter, or with the documentation of what
/// comes next.
///
/// # Errors
/// The first bracket without its partner, or nesting beyond [`MAX_DEPTH`].
pub fn scan(source: SourceId, text: &str) -> Result<Vec<usize>, Box<Diagnostic>> {
    let bytes = text.as_bytes();
    let at = |start: usize| Span { source, start, end: start + 1 };
    let mut open: Vec<(u8, usize)> = Vec::new();
    let mut starts = Vec::new();
    let begins = |index: usize, open: &[(u8, usize)]| open.is_empty() && (index == 0 || bytes[index - 1] == b'\n');
    // Whether documentation stands before what comes next.
    let mut documented = false;
    // The last text that does not end on its line, which may have swallowed a bracket.
    let mut unended = None;
    // The last comment that holds a closing bracket.
    let mut commented: Option<Span> = None;
    let mut index = 0;
    while index < bytes.len() {
        match bytes[index] {
            b'/' if bytes.get(index + 1) == Some(&b'/') => {
                let begun = index;
                if bytes.get(index + 2) == Some(&b'/') {
                    if begins(index, &open) && !documented {
                        starts.push(index);
                    }
                    documented = true;
                }
                index =
                    bytes[index..].iter().position(|b| matches!(b, b'\n' | b'\r')).map_or(bytes.len(), |n| index + n);
                if bytes[begun..index].iter().any(|byte| matches!(byte, b'}' | b')' | b']')) {
                    commented = Some(at(begun));
                }
            }
            b'/' if bytes.get(index + 1) == Some(&b'*') => {
                let opened = index;
                index = end_of(bytes, index + 2, b"*/");
                if index >= bytes.len() {
                    return Err(Box::new(codes::unclosed_comment(at(opened))));
                }
            }
            b'"' => {
                let opened = index;
                let end = bytes[index + 1..].iter().position(|b| matches!(b, b'"' | b'\n' | b'\r'));
                index = end.map_or(bytes.len(), |n| index + 1 + n);
                if bytes.get(index) != Some(&b'"') {
                    unended = Some(at(opened));
                }
            }
            byte @ (b'{' | b'(' | b'[') => {
                open.push((byte, index));
                if open.len() > MAX_DEPTH {
                    return Err(Box::new(codes::too_deep(at(index), MAX_DEPTH)));
                }
            }
            byte @ (b'}' | b')' | b']') => match open.pop() {
                Some((opening, _)) if closes(opening, byte) => {}
                Some((opening, place)) => {
                    return Err(Box::new(codes::mismatched_bracket(at(index), at(place), opening as char)));
                }
                None => return Err(Box::new(codes::stray_bracket(at(index)))),
            },
            byte if !byte.is_ascii_whitespace() => {
                if byte.is_ascii_alphabetic() && begins(index, &open) && !documented {
                    starts.push(index);
                }
                documented = false;
            }
            _ => {}
        }
        index += 1;
    }
    match open.pop() {
        Some((opening, place)) => {
            let unended = unended.filter(|text| text.start > place);
            let line = text[place..].find(['\n', '\r']).map_or(text.len(), |end| place + end);
            let commented = commented.filter(|comment| (place..line).contains(&comment.start));
            Err(Box::new(codes::unclosed_bracket(at(place), opening as char, unended, commented)))
        }
        None => Ok(starts),
    }
}

fn closes(opening: u8, closing: u8) -> bool {
    matches!((opening, closing), (b'{', b'}') | (b'(', b')') | (b'[', b']'))
}

fn end_of(bytes: &[u8], from: usize, mark: &[u8]) -> usize {
    let found = bytes.get(from..).and_then(|rest| rest.windows(mark.len()).position(|window| window == mark));
    found.map_or(bytes.len(), |n| from + n + mark.len() - 1)
}

//! Finds unbalanced brackets before parsing: the parser could only complain far from the cause.

use super::codes;
use crate::diagnostic::{Diagnostic, SourceId, Span};

/// How deep brackets may nest.
pub const MAX_DEPTH: usize = 64;

/// Looks for the first bracket without its partner, and for nesting beyond [`MAX_DEPTH`].
pub fn scan(source: SourceId, text: &str) -> Result<(), Box<Diagnostic>> {
    let bytes = text.as_bytes();
    let at = |start: usize| Span { source, start, end: start + 1 };
    let mut open: Vec<(u8, usize)> = Vec::new();
    let mut index = 0;
    while index < bytes.len() {
        match bytes[index] {
            b'/' if bytes.get(index + 1) == Some(&b'/') => {
                index =
                    bytes[index..].iter().position(|b| matches!(b, b'\n' | b'\r')).map_or(bytes.len(), |n| index + n);
            }
            b'/' if bytes.get(index + 1) == Some(&b'*') => {
                let opened = index;
                index = end_of(bytes, index + 2, b"*/");
                if index >= bytes.len() {
                    return Err(Box::new(codes::unclosed_comment(at(opened))));
                }
            }
            b'"' => {
                index = bytes[index + 1..]
                    .iter()
                    .position(|b| matches!(b, b'"' | b'\n' | b'\r'))
                    .map_or(bytes.len(), |n| index + 1 + n)
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
            _ => {}
        }
        index += 1;
    }
    match open.pop() {
        Some((opening, place)) => Err(Box::new(codes::unclosed_bracket(at(place), opening as char))),
        None => Ok(()),
    }
}

fn closes(opening: u8, closing: u8) -> bool {
    matches!((opening, closing), (b'{', b'}') | (b'(', b')') | (b'[', b']'))
}

fn end_of(bytes: &[u8], from: usize, mark: &[u8]) -> usize {
    let found = bytes.get(from..).and_then(|rest| rest.windows(mark.len()).position(|window| window == mark));
    found.map_or(bytes.len(), |n| from + n + mark.len() - 1)
}

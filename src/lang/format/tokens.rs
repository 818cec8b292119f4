//! A text as a row of tokens, comments included.

use super::marks::{Leaf, Marks};

/// What a token is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// What the parser has a name for.
    Leaf(Leaf),
    /// A word of the language: `edition`, `on`, `and`.
    Word,
    /// A sign, a bracket.
    Sign,
    /// `// to the end of the line`
    LineComment,
    /// `/* between */`
    BlockComment,
}

/// A piece of the text.
#[derive(Debug, Clone, Copy)]
pub struct Token<'a> {
    /// Its text.
    pub text: &'a str,
    /// What it is.
    pub kind: Kind,
    /// Line ends between the token before and this one.
    pub lines_before: usize,
    /// Whether the line ends after it.
    pub ends_line: bool,
    /// Whether a statement begins here, and whether that is a pair.
    pub statement: Option<bool>,
    /// Whether it opens a block.
    pub opens_block: bool,
}

impl Token<'_> {
    /// Whether it is a comment.
    pub fn is_comment(&self) -> bool {
        matches!(self.kind, Kind::LineComment | Kind::BlockComment)
    }

    /// Whether it stands on the line of the token before it.
    pub fn trails(&self) -> bool {
        self.lines_before == 0
    }
}

/// Cuts a text at the parser's marks, and what lies between them at words, signs and comments.
pub fn tokens<'a>(text: &'a str, marks: &Marks) -> Vec<Token<'a>> {
    let bytes = text.as_bytes();
    let mut all: Vec<Token> = Vec::new();
    let mut at = 0;
    // Before the first token a line has just begun.
    let mut lines_before = 1;
    while at < bytes.len() {
        let rest = &text[at..];
        if bytes[at].is_ascii_whitespace() {
            lines_before += line_ends(bytes, at);
            at += 1;
            continue;
        }
        let (end, kind) = match marks.leaves.get(&at) {
            Some((end, leaf)) => (*end, Kind::Leaf(*leaf)),
            None if rest.starts_with("//") => (at + rest.find(['\n', '\r']).unwrap_or(rest.len()), Kind::LineComment),
            None if rest.starts_with("/*") => {
                (at + rest[2..].find("*/").map_or(rest.len(), |n| n + 4), Kind::BlockComment)
            }
            None if is_word(bytes[at]) => {
                (at + bytes[at..].iter().take_while(|byte| is_word(**byte)).count(), Kind::Word)
            }
            None => (at + sign(rest), Kind::Sign),
        };
        all.push(Token {
            text: text[at..end].trim_end(),
            kind,
            lines_before,
            ends_line: false,
            statement: marks.statements.get(&at).copied(),
            opens_block: marks.blocks.contains_key(&at),
        });
        lines_before = 0;
        at = end;
    }
    for index in 0..all.len() {
        all[index].ends_line = all.get(index + 1).is_none_or(|next| next.lines_before > 0);
    }
    all
}

/// 1 at the last byte of a line end.
fn line_ends(bytes: &[u8], at: usize) -> usize {
    usize::from(bytes[at] == b'\n' || (bytes[at] == b'\r' && bytes.get(at + 1) != Some(&b'\n')))
}

fn is_word(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || byte == b'_'
}

/// Length of the sign that a text begins with.
fn sign(text: &str) -> usize {
    const LONG: [&str; 8] = ["..", "=>", "->", "<=", ">=", "==", "!=", "::"];
    match LONG.iter().find(|long| text.starts_with(**long)) {
        Some(long) => long.len(),
        None => text.chars().next().map_or(1, char::len_utf8),
    }
}

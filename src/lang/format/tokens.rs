//! Tokens with the properties that a layout needs: line ends, and the statements and blocks that the parser found.

use super::marks::Marks;
use crate::tokens::{self, TokenKind};

/// A token that is not a blank.
#[derive(Debug, Clone, Copy)]
pub struct Token<'a> {
    pub text: &'a str,
    pub kind: TokenKind,
    /// Whether it is a sign before a value, as in `-3 m`.
    pub prefix: bool,
    /// Line ends between the token before and this one.
    pub lines_before: usize,
    /// Whether the line ends after it.
    pub ends_line: bool,
    /// Whether a statement starts here, and whether that is a property or a clause.
    pub statement: Option<bool>,
    pub opens_block: bool,
}

impl Token<'_> {
    pub fn is_comment(&self) -> bool {
        self.kind.is_comment()
    }

    /// Whether it is on the line of the token before it.
    pub fn trails(&self) -> bool {
        self.lines_before == 0
    }

    /// Whether it ends a value, so that a `-` after it subtracts.
    fn ends_value(&self) -> bool {
        use TokenKind::{Close, Name, Number, Text, Unit};
        matches!(self.kind, Name | Number | Text | Unit | Close)
    }
}

/// The tokens of a text that parses, with the parser's marks.
pub fn tokens<'a>(text: &'a str, marks: &Marks) -> Vec<Token<'a>> {
    let mut all: Vec<Token> = Vec::new();
    // The text starts on a new line.
    let mut lines_before = 1;
    let mut after_value = false;
    for token in tokens::tokens(text) {
        if token.kind == TokenKind::Blank {
            lines_before += line_ends(token.text(text));
            if let Some(last) = all.last_mut() {
                last.ends_line = lines_before > 0;
            }
            continue;
        }
        let next = Token {
            text: token.text(text).trim_end(),
            kind: token.kind,
            prefix: token.text(text) == "-" && !after_value,
            lines_before,
            ends_line: false,
            statement: marks.statements.get(&token.start).copied(),
            opens_block: marks.blocks.contains(&token.start),
        };
        if !next.is_comment() {
            after_value = next.ends_value();
        }
        all.push(next);
        lines_before = 0;
    }
    if let Some(last) = all.last_mut() {
        last.ends_line = true;
    }
    all
}

/// Line ends of any system: `\n`, `\r\n` and `\r`.
fn line_ends(blank: &str) -> usize {
    blank.matches(['\n', '\r']).count() - blank.matches("\r\n").count()
}

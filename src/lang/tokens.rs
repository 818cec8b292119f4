//! A text as a sequence of tokens, without loss: their texts in order are the whole text.
//!
//! pest parses (`grammar/*.pest`). All code that reads a text which need not parse uses these tokens: the brackets before
//! parsing, recovery after it, the layout and the editor. They agree with the leaves of the grammar in every text that parses
//! (a test below), and with the colours of editors (`tests/compile/editors.rs`).

use std::ops::Range;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TokenKind {
    /// Blanks and line ends.
    Blank,
    /// `// to the end of the line`
    LineComment,
    /// `/// to the end of the line`
    Doc,
    /// `/* between */`
    BlockComment,
    /// A block comment that is not closed before the end of the text.
    OpenComment,
    /// `"between quotes"`
    Text,
    /// A text that is not closed before the end of its line.
    OpenText,
    /// A number without its unit.
    Number,
    /// The unit of the number before it, or the one that follows `in`.
    Unit,
    /// One of [`KEYWORDS`].
    Keyword,
    /// Any other word, and a signal of a role: `child.gap`.
    Name,
    /// `(`, `[` or `{`
    Open,
    /// `)`, `]` or `}`
    Close,
    /// An operator or a separator.
    Sign,
    /// A character that starts no token of the language.
    Foreign,
}

impl TokenKind {
    /// Whether the parser skips it.
    pub fn is_trivia(self) -> bool {
        self == TokenKind::Blank || self.is_comment()
    }

    /// Whether it is a comment without documentation.
    pub fn is_comment(self) -> bool {
        matches!(self, TokenKind::LineComment | TokenKind::BlockComment | TokenKind::OpenComment)
    }
}

/// A piece of a text.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Token {
    pub kind: TokenKind,
    /// Its first byte.
    pub start: usize,
    /// One past its last byte.
    pub end: usize,
}

impl Token {
    /// Its place in the text.
    pub fn range(self) -> Range<usize> {
        self.start..self.end
    }

    pub fn text(self, text: &str) -> &str {
        &text[self.range()]
    }
}

/// The words that are not names.
pub const KEYWORDS: [&str; 8] = ["on", "in", "and", "or", "not", "implies", "edition", "import"];

/// Operators and separators, the longer ones first.
const SIGNS: [&str; 14] = ["=>", "..", "<=", ">=", "<", ">", "+", "-", "*", "/", "=", ":", ",", ";"];

pub fn tokens(text: &str) -> Tokens<'_> {
    Tokens { text, at: 0, before: Before::Other }
}

/// The tokens of a text without blanks and comments.
pub fn words(text: &str) -> impl Iterator<Item = Token> {
    tokens(text).filter(|token| !token.kind.is_trivia())
}

/// The state that decides whether a word is a unit.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Before {
    /// A number on the same line.
    Number,
    /// The keyword `in`.
    In,
    /// The keyword `edition`, whose number has no unit.
    Edition,
    Other,
}

/// The tokens of a text in their order.
#[derive(Debug, Clone)]
pub struct Tokens<'a> {
    text: &'a str,
    at: usize,
    before: Before,
}

impl Iterator for Tokens<'_> {
    type Item = Token;

    fn next(&mut self) -> Option<Token> {
        let rest = &self.text[self.at..];
        let (kind, length) = next(rest, self.before)?;
        let start = self.at;
        self.at += length;
        self.before = match (kind, self.before) {
            (TokenKind::Blank, Before::Number) if rest[..length].contains(['\n', '\r']) => Before::Other,
            (TokenKind::Blank, before) => before,
            (kind, Before::Number) if kind.is_comment() => Before::Other,
            (kind, before) if kind.is_comment() => before,
            (TokenKind::Number, Before::Edition) => Before::Other,
            (TokenKind::Number, _) => Before::Number,
            (TokenKind::Keyword, _) if &rest[..length] == "in" => Before::In,
            (TokenKind::Keyword, _) if &rest[..length] == "edition" => Before::Edition,
            _ => Before::Other,
        };
        Some(Token { kind, start, end: self.at })
    }
}

/// The first token of a text, and its length.
fn next(text: &str, before: Before) -> Option<(TokenKind, usize)> {
    let bytes = text.as_bytes();
    let line = || text.find(['\n', '\r']).unwrap_or(text.len());
    Some(match *bytes.first()? {
        first if is_blank(first) => (TokenKind::Blank, count(bytes, is_blank)),
        b'/' if text.starts_with("///") => (TokenKind::Doc, line()),
        b'/' if text.starts_with("//") => (TokenKind::LineComment, line()),
        b'/' if text.starts_with("/*") => match text[2..].find("*/") {
            Some(end) => (TokenKind::BlockComment, end + 4),
            None => (TokenKind::OpenComment, text.len()),
        },
        b'"' => match text[1..].find(['"', '\n', '\r']) {
            Some(end) if bytes[end + 1] == b'"' => (TokenKind::Text, end + 2),
            Some(end) => (TokenKind::OpenText, end + 1),
            None => (TokenKind::OpenText, text.len()),
        },
        first if first.is_ascii_digit() => (TokenKind::Number, number(bytes)),
        first if is_word(first) => match unit(bytes).filter(|_| first != b'_' && before != Before::Other) {
            Some(length) if before == Before::In || !names_what_follows(text, length) => (TokenKind::Unit, length),
            _ => word(text),
        },
        b'(' | b'[' | b'{' => (TokenKind::Open, 1),
        b')' | b']' | b'}' => (TokenKind::Close, 1),
        _ => match SIGNS.into_iter().find(|sign| text.starts_with(sign)) {
            Some(sign) => (TokenKind::Sign, sign.len()),
            None => (TokenKind::Foreign, text.chars().next().map_or(1, char::len_utf8)),
        },
    })
}

/// A keyword, a name, or a signal of a role.
fn word(text: &str) -> (TokenKind, usize) {
    let bytes = text.as_bytes();
    let length = count(bytes, is_word);
    let (own, after) = (&text[..length], bytes.get(length + 1).copied());
    let has_signal =
        bytes.get(length) == Some(&b'.') && after.is_some_and(|byte| is_word(byte) && !byte.is_ascii_digit());
    if has_signal
        && !KEYWORDS.contains(&own)
        && !KEYWORDS.contains(&&text[length + 1..][..count(&bytes[length + 1..], is_word)])
    {
        return (TokenKind::Name, length + 1 + count(&bytes[length + 1..], is_word));
    }
    let kind = if KEYWORDS.contains(&&text[..length]) { TokenKind::Keyword } else { TokenKind::Name };
    (kind, length)
}

/// Length of the number at the start of a text: `1_000.5e-3`.
fn number(bytes: &[u8]) -> usize {
    let is_digit = |byte: u8| byte.is_ascii_digit();
    let in_number = |byte: u8| byte.is_ascii_digit() || byte == b'_';
    let mut length = count(bytes, in_number);
    if bytes.get(length) == Some(&b'.') && bytes.get(length + 1).is_some_and(u8::is_ascii_digit) {
        length += 1 + count(&bytes[length + 1..], in_number);
    }
    if matches!(bytes.get(length), Some(b'e' | b'E')) {
        let sign = usize::from(matches!(bytes.get(length + 1), Some(b'+' | b'-')));
        let digits = bytes.get(length + 1 + sign..).map_or(0, |rest| count(rest, is_digit));
        length += if digits > 0 { 1 + sign + digits } else { 0 };
    }
    length
}

/// Length of the unit at the start of a text: `m`, `km/h`, `m/s^2`; `None` if its first word is a keyword.
fn unit(bytes: &[u8]) -> Option<usize> {
    let part = |bytes: &[u8]| {
        let name = count(bytes, is_word);
        let minus = usize::from(bytes.get(name + 1) == Some(&b'-'));
        let digits = bytes.get(name + 1 + minus..).map_or(0, |rest| count(rest, |byte| byte.is_ascii_digit()));
        if bytes.get(name) == Some(&b'^') && digits > 0 { name + 1 + minus + digits } else { name }
    };
    let mut length = part(bytes);
    let first = &bytes[..count(bytes, is_word)];
    if KEYWORDS.iter().any(|keyword| keyword.as_bytes() == first) {
        return None;
    }
    while matches!(bytes.get(length), Some(b'/' | b'*')) && bytes.get(length + 1).is_some_and(u8::is_ascii_alphabetic) {
        length += 1 + part(&bytes[length + 1..]);
    }
    Some(length)
}

/// Units that may come before the block of a requirement; no block has the name of one.
const BEFORE_BLOCK: [&str; 12] = ["m/s^3", "m/s^2", "m/s", "km/h", "mph", "km", "cm", "ms", "m", "s", "deg", "rad"];

/// Whether the word of this length at the start of a text is a key or block that the rest belongs to.
fn names_what_follows(text: &str, length: usize) -> bool {
    let (word, rest) = text.split_at(length);
    let rest = rest.trim_start_matches([' ', '\t']);
    rest.starts_with(':') || rest.starts_with('{') && !BEFORE_BLOCK.contains(&word)
}

fn count(bytes: &[u8], such: impl Fn(u8) -> bool) -> usize {
    bytes.iter().take_while(|byte| such(**byte)).count()
}

fn is_blank(byte: u8) -> bool {
    matches!(byte, b' ' | b'\t' | b'\n' | b'\r')
}

/// Whether a byte is a part of a name.
pub fn is_word(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || byte == b'_'
}

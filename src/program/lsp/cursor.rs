//! The context of the cursor, read from the text before it, which need not be a complete file.

use std::ops::Range;

use super::visible::{dimension as measured, referred};
use base::signature::{Param, Signature, Type};
use base::units::Dimension;
use compile::Catalog;
use lang::tokens::{self, TokenKind, is_word, tokens};

/// The cursor's context, as the text before it determines it.
#[derive(Debug)]
pub struct Cursor<'a> {
    /// The whole word at the cursor; may be empty.
    pub word: &'a str,
    /// The role of the word.
    pub place: Place<'a>,
    /// The owner of the innermost braces or parentheses.
    pub signature: Option<&'a Signature>,
}

/// The role of a word.
#[derive(Debug, Clone, Copy)]
pub enum Place<'a> {
    /// The first word of a declaration.
    Form,
    /// The kind of this form.
    Kind(&'a str),
    /// A key, a block or `on`.
    Key,
    /// A value of this key.
    Value(&'a Param),
    /// A unit, of this dimension if it is known.
    Unit(Option<Dimension>),
    Formula,
    Event,
    /// The word in the parentheses of this event.
    EventWord(&'a str),
    /// The path of an import, up to the cursor.
    Import(&'a str),
    /// A name that is imported from this path.
    Imported(&'a str),
    /// The name of a parameter, where it is declared.
    Param,
    /// The type of a parameter.
    Type,
    ParamValue {
        /// Its name, which is excluded from the values.
        name: &'a str,
        /// The word for its type.
        ty: &'a str,
    },
    /// A parameter that a matrix varies.
    Axis,
    /// A value of this parameter in a matrix.
    AxisValue(&'a str),
    /// In a comment, or in no known context.
    Nothing,
}

#[derive(Debug, Clone, Copy)]
struct Token<'a> {
    text: &'a str,
    kind: TokenKind,
    end: usize,
    /// Whether it is the first on its line.
    first: bool,
    /// Whether it starts its line, without a blank before it.
    at_margin: bool,
}

impl Token<'_> {
    /// Whether a value must follow it.
    fn is_open(&self) -> bool {
        matches!(self.kind, TokenKind::Sign | TokenKind::Open | TokenKind::Foreign)
    }

    fn is_word(&self) -> bool {
        matches!(self.kind, TokenKind::Name | TokenKind::Keyword | TokenKind::Unit)
    }
}

/// An open bracket, or the file.
#[derive(Debug, Default)]
struct Frame<'a> {
    signature: Option<&'a Signature>,
    /// Whether keys are expected here, as in braces and after kinds.
    keys: bool,
    param: Option<&'a Param>,
    formula: bool,
    event: Option<&'a str>,
    /// Whether it is a `matrix`, and the parameter whose values are written here.
    matrix: bool,
    axis: Option<&'a str>,
    tokens: Vec<Token<'a>>,
    /// The kind whose parentheses have just closed.
    closed: Option<&'a Signature>,
}

/// What has been read of a text.
struct Reading<'a> {
    frames: Vec<Frame<'a>>,
    /// Whether the next token is the first on its line.
    first: bool,
}

impl<'a> Reading<'a> {
    fn new() -> Self {
        Self { frames: vec![Frame { keys: true, ..Frame::default() }], first: true }
    }

    /// Reads one more token of the text.
    fn read(&mut self, text: &'a str, token: tokens::Token, catalog: &'a Catalog) {
        if token.kind == TokenKind::Blank {
            self.first |= token.text(text).contains('\n');
        } else if !token.kind.is_trivia() && token.kind != TokenKind::Doc {
            let at_margin = is_at_margin(text, token.start);
            let (text, kind, end) = (token.text(text), token.kind, token.end);
            take(&mut self.frames, Token { text, kind, end, first: self.first, at_margin }, catalog);
            self.first = false;
        }
    }
}

/// Finds the context of a byte of a text.
pub fn cursor<'a>(text: &'a str, byte: usize, catalog: &'a Catalog) -> Cursor<'a> {
    let byte = text.floor_char_boundary(byte);
    let mut start = byte - text[..byte].bytes().rev().take_while(|b| is_word(*b)).count();
    let end = byte + text[byte..].bytes().take_while(|b| is_word(*b)).count();
    let mut reading = Reading::new();
    for token in tokens(text).take_while(|token| token.start < byte) {
        let inside = match token.kind {
            TokenKind::Text | TokenKind::BlockComment => start < token.end,
            TokenKind::OpenText | TokenKind::LineComment | TokenKind::Doc | TokenKind::OpenComment => {
                start <= token.end
            }
            _ => false,
        };
        if inside {
            let last = reading.frames.last().and_then(|frame| frame.tokens.last());
            let is_text = matches!(token.kind, TokenKind::Text | TokenKind::OpenText);
            let import = is_text && last.is_some_and(|last| matches!(last.text, "import" | "from"));
            let place = if import { Place::Import(&text[(token.start + 1).min(byte)..byte]) } else { Place::Nothing };
            return Cursor { word: &text[start..end], place, signature: None };
        }
        if token.end > start && !token.kind.is_trivia() && token.kind != TokenKind::Doc {
            // A unit has several words: `m/s^2`.
            start = if token.kind == TokenKind::Unit { token.start } else { start };
            break;
        }
        reading.read(text, token, catalog);
    }
    let place = role(&reading.frames, text, start..end, catalog);
    let frame = reading.frames.last().expect("the file is never closed");
    // A unit may continue after its first word: `m/s^2`.
    let rest = match place {
        Place::Unit(_) => text[end..].bytes().take_while(|b| is_word(*b) || matches!(b, b'/' | b'*' | b'^')).count(),
        _ => 0,
    };
    Cursor { word: &text[start..end + rest], place, signature: frame.signature }
}

/// The words of a text that are not in a comment or in quotes, each with its role.
pub fn places<'a>(text: &'a str, catalog: &'a Catalog) -> Vec<(Range<usize>, Place<'a>)> {
    let (mut all, mut reading) = (Vec::new(), Reading::new());
    for token in tokens(text) {
        if matches!(token.kind, TokenKind::Name | TokenKind::Keyword) {
            all.push((token.range(), role(&reading.frames, text, token.range(), catalog)));
        }
        reading.read(text, token, catalog);
    }
    all
}

fn is_at_margin(text: &str, byte: usize) -> bool {
    text[..byte].bytes().next_back().is_none_or(|before| matches!(before, b'\n' | b'\r'))
}

/// The role of a word that follows what has been read.
fn role<'a>(frames: &[Frame<'a>], text: &'a str, word: Range<usize>, catalog: &Catalog) -> Place<'a> {
    let top = frames.len() == 1;
    let frame = frames.last().expect("the file is never closed");
    let (before, behind) = (&text[..word.start], &text[word.end..]);
    let is_key = behind.trim_start_matches([' ', '\t']).starts_with(':');
    match statement(frame, before, behind).filter(|_| top) {
        Some(place) => place,
        None => place(frame, top, is_key, before, catalog),
    }
}

/// The role of a word of an `import` or a `param`; `None` in other statements.
fn statement<'a>(frame: &Frame<'a>, before: &str, behind: &'a str) -> Option<Place<'a>> {
    let words: Vec<&str> = frame.tokens.iter().map(|token| token.text).collect();
    let last = frame.tokens.last()?;
    // On the next line another statement starts, unless this one is still open.
    let open = last.is_open() || matches!(last.text, "import" | "param");
    let next_line = before[last.end.min(before.len())..].contains('\n');
    match words.as_slice() {
        ["import" | "param", ..] | ["edition", _] if next_line && !open => Some(Place::Form),
        ["import", ..] if last.text == "import" || last.text == "," => {
            let path = behind.lines().next()?.split_once("from")?.1.split('"').nth(1)?;
            Some(Place::Imported(path))
        }
        ["import", ..] => Some(Place::Nothing),
        ["param"] => Some(Place::Param),
        ["param", _, ":"] => Some(Place::Type),
        ["param", _, ":", ty, "=", ..] if last.kind == TokenKind::Number => Some(Place::Unit(measured(ty))),
        ["param", name, ":", ty, "=", ..] => Some(Place::ParamValue { name, ty }),
        ["param", ..] => Some(Place::Nothing),
        _ => None,
    }
}

fn place<'a>(frame: &Frame<'a>, top: bool, is_key: bool, before: &str, catalog: &Catalog) -> Place<'a> {
    let behind = |n: usize| frame.tokens.len().checked_sub(n).map(|at| frame.tokens[at]);
    let last = behind(1);
    // The word before an `in`, if it is a variable.
    let counted = behind(2).and_then(|token| catalog.vocabulary.variables.iter().find(|each| each.name == token.text));
    let counted = counted.map(|variable| variable.dimension);
    if let Some(event) = frame.event {
        return Place::EventWord(event);
    }
    if is_key && frame.keys && !top {
        return if frame.matrix { Place::Axis } else { Place::Key };
    }
    match last {
        Some(last) if last.kind == TokenKind::Number && before[last.end..].chars().all(|c| matches!(c, ' ' | '\t')) => {
            return Place::Unit(frame.param.and_then(|param| param.ty.dimension()));
        }
        Some(last) if last.text == "in" => return Place::Unit(counted),
        Some(last) if last.text == "on" && frame.keys => return Place::Event,
        Some(last) if last.text == "=" && frame.param.is_none() => {
            return behind(3).map_or(Place::Nothing, |form| Place::Kind(form.text));
        }
        _ => {}
    }
    let open = last.is_none_or(|last| last.is_open() || matches!(last.text, "and" | "or" | "not" | "implies"));
    if frame.formula && (open || !frame.keys) {
        return Place::Formula;
    }
    match frame.axis {
        Some(axis) if open || !frame.keys => return Place::AxisValue(axis),
        _ if frame.matrix && frame.keys => return Place::Axis,
        _ => {}
    }
    match frame.param {
        Some(param) if open || !frame.keys => Place::Value(param),
        _ if !frame.keys => Place::Formula,
        _ if !top => Place::Key,
        // At the top level a form, unless one has just been written.
        _ if last.is_none_or(|last| !last.is_word() || last.text == "import") => Place::Form,
        _ => Place::Nothing,
    }
}

/// Reads one more token.
fn take<'a>(frames: &mut Vec<Frame<'a>>, token: Token<'a>, catalog: &'a Catalog) {
    let opens = |form: &base::signature::Form| form.name == token.text;
    let starts = || matches!(token.text, "edition" | "import" | "param") || catalog.forms.iter().any(opens);
    // A bracket that is still open ends where the next statement starts at the margin: it is being typed, and what follows is not inside.
    if token.at_margin && frames.len() > 1 && token.is_word() && starts() {
        frames.truncate(1);
    }
    let top = frames.len() == 1;
    let frame = frames.last_mut().expect("the file is never closed");
    if token.text != "{" {
        frame.closed = None;
    }
    if top && token.first && starts() {
        *frame = Frame { keys: true, ..Frame::default() };
    }
    match token.text {
        "{" => {
            let signature = opened(frame, top, catalog);
            let multiplies =
                |signature: &Signature| catalog.forms.iter().any(|form| form.multiplies && form.name == signature.name);
            let matrix = frame.tokens.last().is_some_and(|last| last.text == "matrix")
                && frame.signature.is_some_and(multiplies);
            frames.push(Frame { signature, keys: true, matrix, ..Frame::default() });
            return;
        }
        "(" | "[" => {
            let inner = bracket(frame, token, catalog);
            frames.push(inner);
            return;
        }
        ")" | "]" | "}" => {
            let closed = if frames.len() > 1 { frames.pop() } else { None };
            let frame = frames.last_mut().expect("the file is never closed");
            if token.text == "}" {
                *frame =
                    Frame { signature: frame.signature, keys: frame.keys, matrix: frame.matrix, ..Frame::default() };
            } else {
                frame.closed = closed.filter(|closed| closed.keys).and_then(|closed| closed.signature);
                frame.tokens.push(token);
            }
            return;
        }
        ":" => {
            let key = frame.tokens.last().map_or("", |last| last.text);
            frame.param = frame.signature.and_then(|s| s.params.iter().find(|param| param.name == key));
            frame.formula = false;
            frame.axis = Some(key).filter(|_| frame.matrix);
        }
        "=" if top => {
            let form = frame.tokens.len().checked_sub(2).map_or("", |at| frame.tokens[at].text);
            let written = written(form, catalog);
            (frame.signature, frame.param) = (written.map(|(form, _)| form), written.map(|(_, param)| param));
        }
        "=>" => {
            frame.param = None;
            frame.formula = true;
        }
        "," | ";" if frame.keys => {
            frame.param = None;
            frame.axis = None;
            frame.formula = false;
            if !top {
                frame.tokens.clear();
                return;
            }
        }
        _ => {}
    }
    frame.tokens.push(token);
}

/// The owner of a block whose brace comes next.
fn opened<'a>(frame: &Frame<'a>, top: bool, catalog: &'a Catalog) -> Option<&'a Signature> {
    if let Some(closed) = frame.closed {
        return Some(closed);
    }
    if top && frame.param.is_some() {
        return frame.signature;
    }
    let behind = |n: usize| frame.tokens.len().checked_sub(n).map(|at| frame.tokens[at].text);
    if behind(2) == Some("=") {
        return kind(behind(4)?, behind(1)?, catalog);
    }
    let find = |word: &str| {
        if top {
            catalog.forms.iter().find(|form| form.name == word).and_then(|form| form.plain.as_ref())
        } else {
            frame.signature.and_then(|signature| signature.children.iter().find(|child| child.name == word))
        }
    };
    let (name, word) = (behind(1), behind(2));
    // `word name {` or `word {`.
    word.and_then(find).or_else(|| name.and_then(find))
}

/// The keys of a form whose value is written after its name, as in `requirement name = always(…)`, and the key of this value.
fn written<'a>(form: &str, catalog: &'a Catalog) -> Option<(&'a Signature, &'a Param)> {
    let signature = catalog.forms.iter().find(|each| each.name == form)?.plain.as_ref()?;
    let param = signature.params.iter().find(|param| matches!(param.ty, Type::Requirement(_)))?;
    Some((signature, param))
}

fn kind<'a>(form: &str, kind: &str, catalog: &'a Catalog) -> Option<&'a Signature> {
    let form = catalog.forms.iter().find(|each| each.name == form)?;
    form.kinds.iter().find(|each| each.name == kind)
}

fn bracket<'a>(frame: &Frame<'a>, token: Token<'a>, catalog: &'a Catalog) -> Frame<'a> {
    let behind = |n: usize| frame.tokens.len().checked_sub(n).map(|at| frame.tokens[at].text);
    let has_kind = frame.param.is_none();
    if token.text == "(" && behind(2) == Some("=") && has_kind {
        let signature = behind(4).zip(behind(1)).and_then(|(form, word)| kind(form, word, catalog));
        return Frame { signature, keys: true, ..Frame::default() };
    }
    // A kind in place of a name: `methods: [archive(`.
    let inline = || kind(referred(&frame.param?.ty)?, behind(1)?, catalog);
    if token.text == "("
        && let Some(signature) = inline()
    {
        return Frame { signature: Some(signature), keys: true, ..Frame::default() };
    }
    let event = if token.text == "(" && behind(2) == Some("on") { behind(1) } else { None };
    let Frame { signature, param, formula, matrix, axis, .. } = *frame;
    Frame { signature, param, formula, matrix, axis, event, ..Frame::default() }
}

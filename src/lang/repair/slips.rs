//! Signs and words of other languages and of print.

use std::ops::Range;

use crate::units::parse_unit;

/// A sign or word that people bring along from other languages or from print.
pub(in crate::internal::lang) struct Slip {
    /// Where it stands.
    pub place: Range<usize>,
    /// What would be read there.
    pub instead: String,
    /// Whether that is what was meant; else it takes a decision.
    pub meant: bool,
    /// What is to be said.
    pub said: &'static str,
    /// Whether nothing that can be read holds such a sign, so that it is wrong whatever else is.
    pub foreign: bool,
}

/// Most slips of a statement that are told; what holds more is no statement.
const MOST_SLIPS: usize = 100;

/// What is said of conditionals.
const NO_IF: &str = "there is no `if`: what is asked goes into a condition, what is weighed into `min` and `max`";
/// What is said of several events side by side.
const ONE_EVENT: &str = "every event has an `on event => formula` of its own";
/// What is said of tolerances.
const BOTH: &str = "write both ends: `-60 deg .. 60 deg`";
/// What is said of signs around a value.
const SIZE: &str = "the size of a number is `abs(…)`";

/// The slips in a statement; `key_first` when it may be `key: value`.
pub(in crate::internal::lang) fn slips(text: &str, key_first: bool) -> Vec<Slip> {
    let mut scan = Scan { text, at: 0, open: Vec::new(), tokens: Vec::new(), found: Vec::new(), key_first };
    while scan.at < text.len() && scan.found.len() < MOST_SLIPS {
        scan.step();
    }
    scan.found
}

/// What a token is, as far as the next one hangs on it.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Token {
    Number,
    /// The word behind a number, and what it is joined with by signs without blanks.
    Unit,
    Word,
    Closing,
    Sign,
}

struct Scan<'a> {
    text: &'a str,
    at: usize,
    open: Vec<u8>,
    tokens: Vec<(Token, Range<usize>)>,
    found: Vec<Slip>,
    key_first: bool,
}

impl Scan<'_> {
    fn rest(&self) -> &str {
        &self.text[self.at..]
    }

    fn last(&self) -> Option<Token> {
        self.tokens.last().map(|(token, _)| *token)
    }

    /// A token of the statement by its number; empty where there is none.
    fn word(&self, number: usize) -> &str {
        self.tokens.get(number).map_or("", |(_, place)| &self.text[place.clone()])
    }

    fn push(&mut self, token: Token, length: usize) {
        self.tokens.push((token, self.at..self.at + length));
        self.at += length;
    }

    fn slip(&mut self, length: usize, instead: impl Into<String>, meant: bool, said: &'static str) {
        let foreign = [NO_IF, ONE_EVENT].contains(&said)
            || self.rest().starts_with(|first: char| {
                !first.is_ascii() || matches!(first, '#' | '%' | '\'' | '!' | '&' | '|' | '"' | '?' | '$')
            });
        let place = self.at..self.at + length;
        self.found.push(Slip { place, instead: instead.into(), meant, said, foreign });
        self.push(Token::Sign, length);
    }

    /// Whether all before is `on event` or `on event(word)`.
    fn after_event(&self) -> bool {
        self.word(0) == "on"
            && (self.tokens.len() == 2 || self.tokens.len() == 5 && self.word(2) == "(")
            && self.open.is_empty()
    }

    /// Whether what was read last may be a key: the first word, or one behind a value.
    fn behind_key(&self) -> bool {
        self.open.is_empty()
            && match self.tokens.as_slice() {
                [(Token::Word, _)] => true,
                [.., (before, _), (Token::Word, _)] => matches!(before, Token::Number | Token::Unit | Token::Closing),
                _ => false,
            }
    }

    /// Whether what was read last may be the end of a value.
    fn behind_value(&self) -> bool {
        matches!(self.last(), Some(Token::Number | Token::Unit | Token::Word | Token::Closing))
            || self.tokens.is_empty()
    }

    /// Whether what comes next is the name of a declaration.
    fn is_name_next(&self) -> bool {
        let importing = ["import", "from", "edition"].contains(&self.word(0));
        !self.key_first && self.tokens.len() == 1 && self.last() == Some(Token::Word) && !importing
    }

    fn step(&mut self) {
        let rest = self.rest();
        let first = rest.chars().next().expect("there is more to read");
        let starts = |sign: &str| rest.starts_with(sign);
        let line = || rest.find(['\n', '\r']).unwrap_or(rest.len());
        // The sign of a unit touches what stands before it.
        let joined = self.tokens.last().is_some_and(|(_, place)| place.end == self.at);
        let blank = if joined { " " } else { "" };
        match first {
            _ if first.is_whitespace() && first.is_ascii() => self.at += first.len_utf8(),
            _ if starts("//") => self.at += line(),
            _ if starts("/*") => self.at += rest.find("*/").map_or(rest.len(), |end| end + 2),
            '"' => match rest[1..].find(['"', '\n', '\r']).filter(|end| rest[1 + end..].starts_with('"')) {
                Some(end) if self.word(0) == "edition" && self.tokens.len() == 1 => {
                    let number = rest[1..end + 1].to_string();
                    self.slip(end + 2, number, true, "a number has no quotes");
                }
                Some(end) if self.is_name_next() => {
                    let name = rest[1..end + 1].to_string();
                    self.slip(end + 2, name, true, "names have no quotes");
                }
                Some(end) => self.push(Token::Closing, end + 2),
                None => {
                    let line = line();
                    let instead = format!("{}\"", rest[..line].trim_end());
                    self.slip(line, instead, true, "this text is not closed on its line");
                }
            },
            '\'' => match rest[1..].find(['\'', '\n', '\r']).filter(|end| rest[1 + end..].starts_with('\'')) {
                Some(end) => {
                    let instead = format!("\"{}\"", &rest[1..end + 1]);
                    self.slip(end + 2, instead, true, "a text needs double quotes");
                }
                None => self.push(Token::Sign, 1),
            },
            '#' => {
                let line = line();
                self.slip(1, "//", true, "a comment starts with `//`");
                self.at += line - 1;
            }
            '–' | '—' if matches!(self.last(), None | Some(Token::Number | Token::Unit)) => {
                self.slip(first.len_utf8(), "..", true, "a range is written `low .. high`");
            }
            '−' | '–' | '—' => self.slip(first.len_utf8(), "-", true, "the sign for minus is `-`"),
            '°' => {
                let instead = format!("{blank}deg");
                self.slip(first.len_utf8(), instead, true, "degrees are written `deg`");
            }
            '%' => self.slip(1, format!("{blank}percent"), true, "write `percent`, or the plain number"),
            '“' | '”' | '„' | '«' | '»' => {
                let inside = &rest[first.len_utf8()..line()];
                let closing = inside.find(['“', '”', '«', '»', '"']).filter(|end| *end > 0);
                let (length, instead) = match closing.and_then(|end| Some((end, inside[end..].chars().next()?))) {
                    Some((end, last)) => (first.len_utf8() + end + last.len_utf8(), format!("\"{}\"", &inside[..end])),
                    None => (first.len_utf8(), "\"".to_string()),
                };
                self.slip(length, instead, true, "a text needs straight quotes");
            }
            '\u{a0}' | '\u{2009}' | '\u{202f}' | '\u{200b}' | '\u{feff}' => {
                self.slip(first.len_utf8(), " ", true, "this is no ordinary blank");
            }
            '²' | '³' => {
                let power = if first == '²' { "^2" } else { "^3" };
                self.slip(first.len_utf8(), power, true, "powers of units are written `^2`");
            }
            '±' => self.slip(first.len_utf8(), "", false, BOTH),
            '：' => self.slip(first.len_utf8(), ":", true, "this is no ordinary colon"),
            '，' => self.slip(first.len_utf8(), ",", true, "this is no ordinary comma"),
            _ if !self.behind_value() && (starts("+-") || starts("+/-")) => {
                self.slip(if starts("+-") { 2 } else { 3 }, "-", false, BOTH);
            }
            '×' | '·' => self.slip(first.len_utf8(), "*", true, "the sign for times is `*`"),
            '≤' => self.slip(first.len_utf8(), "<=", true, "at most is written `<=`"),
            '≥' => self.slip(first.len_utf8(), ">=", true, "at least is written `>=`"),
            '…' => self.slip(first.len_utf8(), "..", true, "a range is written `low .. high`"),
            _ if starts("==>") || starts(">=") && self.after_event() => {
                let length = if starts("==>") { 3 } else { 2 };
                self.slip(length, "=>", true, "an event is followed by `=>`");
            }
            '[' if self.word(0) == "on" && self.tokens.len() == 2 && rest.contains(']') => {
                let end = rest.find(']').unwrap_or(0);
                let instead = format!("({})", rest[1..end].trim());
                self.slip(end + 1, instead, true, "what an event is narrowed to stands in parentheses");
            }
            '{' if self.after_event() && rest.contains('}') => {
                let end = rest.find('}').unwrap_or(0);
                let instead = format!("=> {}", rest[1..end].trim());
                self.slip(end + 1, instead, true, "an event is followed by `=>`");
            }
            ',' if self.after_event() => self.slip(1, "", false, ONE_EVENT),
            ':' if self.tokens.len() == 4 && self.word(0) == "param" && self.open.is_empty() => {
                self.slip(1, format!("{blank}="), true, "the value of a parameter stands behind `=`");
            }
            _ if starts("=>") => {
                let named = self.tokens.len() == 1 || self.tokens.len() == 4 && self.word(1) == "(";
                let word = self.word(0).starts_with(|first: char| first.is_ascii_alphabetic());
                if named && word && self.found.is_empty() && self.open.is_empty() && self.word(0) != "on" {
                    let place = self.tokens[0].1.clone();
                    let event = self.word(0).trim_start_matches("on").trim_start_matches('_');
                    let instead = format!("on {}", if event.is_empty() { self.word(0) } else { event });
                    let said = "what an event is worth begins with `on`";
                    self.found.push(Slip { place, instead, meant: true, said, foreign: false });
                }
                self.push(Token::Sign, 2);
            }
            _ if starts("==") || starts("!=") => {
                let key = self.key_first && self.tokens.len() == 1;
                if key && first == '=' {
                    self.slip(2, ":", true, "a key is followed by `:`");
                } else {
                    self.slip(
                        2,
                        "<=",
                        false,
                        "no two measured quantities are just equal: ask with `<=` and `>=`, or give a range",
                    );
                }
            }
            _ if starts("<=") || starts(">=") => self.push(Token::Sign, 2),
            _ if starts("->") && self.after_event() => self.slip(2, "=>", true, "an event is followed by `=>`"),
            '=' | ':' if self.after_event() => {
                self.slip(1, format!("{blank}=>"), true, "an event is followed by `=>`");
            }
            '=' | ':' if self.tokens.len() == 1 && self.word(0) == "edition" => {
                self.slip(1, "", true, "the number stands right behind the word");
            }
            '=' if self.tokens.len() == 2 && rest[1..].trim_start().starts_with('{') => {
                self.slip(1, "", true, "a block stands right behind the name");
            }
            ':' if self.is_name_next() => self.slip(1, "", true, "the name stands right behind the word"),
            ':' if !self.key_first && self.tokens.len() == 2 && self.open.is_empty() && self.word(0) != "param" => {
                self.slip(1, format!("{blank}="), true, "a kind stands behind `=`");
            }
            '-' if !self.key_first && joined && self.tokens.len() == 2 && self.last() == Some(Token::Word) => {
                self.slip(1, "_", true, "names are letters, digits and `_`");
                // What follows belongs to the name.
                self.at += self.rest().bytes().take_while(|byte| *byte == b'_' || byte.is_ascii_alphanumeric()).count();
                self.tokens.pop();
            }
            '=' if self.key_first && self.behind_key()
                || self.open.last() == Some(&b'(') && self.last() == Some(Token::Word) =>
            {
                self.slip(1, ":", true, "a key is followed by `:`");
            }
            '{' | '(' | '[' => {
                self.open.push(first as u8);
                self.push(Token::Sign, 1);
            }
            '}' | ')' | ']' => {
                self.open.pop();
                self.push(Token::Closing, 1);
            }
            _ if starts("&&") => self.slip(2, "and", true, "write `and`"),
            _ if starts("||") => self.slip(2, "or", true, "write `or`"),
            '|' => {
                let open = self.found.iter().filter(|slip| slip.said == SIZE).count() % 2 == 1;
                if self.behind_value() && !open {
                    self.slip(1, format!("{blank}or"), true, "write `or`");
                } else {
                    self.slip(1, "", false, SIZE);
                }
            }
            '?' if self.behind_value() && rest.contains(':') => self.slip(1, "", false, NO_IF),
            '$' => self.slip(1, "", true, "a parameter is named without a sign"),
            '+' if !self.behind_value() => self.slip(1, "", true, "a number needs no `+`"),
            ';' if matches!(self.open.last(), Some(b'(' | b'[')) => {
                self.slip(1, ",", true, "commas separate values");
            }
            _ if starts("=<") => self.slip(2, "<=", true, "at most is written `<=`"),
            ':' | '='
                if self.key_first
                    && self.tokens.len() == 1
                    && self.last() == Some(Token::Word)
                    && opens_block(&rest[1..]) =>
            {
                self.slip(
                    1,
                    "",
                    false,
                    "a block has its brace right behind its name; a range is written `low .. high`, a list `[a, b]`",
                );
            }
            '!' => self.slip(1, "not ", true, "write `not`"),
            '^' if self.last() == Some(Token::Unit) => {
                let digits = rest[1..].trim_start_matches('-').trim_start_matches(|c: char| c.is_ascii_digit());
                self.push(Token::Unit, rest.len() - digits.len());
            }
            _ if starts("**") && self.last() == Some(Token::Unit) => {
                self.slip(2, "^", true, "powers of units are written `^2`");
            }
            '^' | '*'
                if self.last() == Some(Token::Number) && (first == '^' || starts("**")) && self.ends_with("10") =>
            {
                self.slip(
                    if first == '^' { 1 } else { 2 },
                    "",
                    false,
                    "there are no powers: write `1e-4` for 10 to the power of -4",
                );
            }
            '^' | '*' if (first == '^' && self.last() != Some(Token::Unit)) || starts("**") => {
                let sign = if first == '^' { 1 } else { 2 };
                let digits =
                    rest[sign..].trim_start_matches([' ', '-']).trim_start_matches(|c: char| c.is_ascii_digit());
                self.slip(rest.len() - digits.len(), "", false, "there are no powers: multiply, as in `v_c * v_c`");
            }
            _ if starts("..=") || starts("..<") => self.slip(3, "..", true, "a range is written `low .. high`"),
            _ if starts("...") => self.slip(3, "..", true, "a range is written `low .. high`"),
            _ if starts("..") => self.push(Token::Sign, 2),
            '.' if rest[1..].starts_with(|next: char| next.is_ascii_digit()) => {
                self.slip(1, "0.", true, "a number starts with a digit");
                self.tokens.pop();
            }
            _ if first.is_ascii_digit() => self.step_number(),
            _ if first.is_ascii_alphabetic() || first == '_' => self.step_word(joined),
            _ => self.push(Token::Sign, first.len_utf8()),
        }
    }

    /// Whether what was read last is this word.
    fn ends_with(&self, word: &str) -> bool {
        self.tokens.last().is_some_and(|(_, place)| self.text[place.clone()] == *word)
    }

    fn step_number(&mut self) {
        let rest = self.rest();
        if let Some((length, whole)) = grouped(rest) {
            return self.slip(length, whole, true, "digits are grouped by `_`");
        }
        let digits = |text: &str| text.bytes().take_while(|byte| byte.is_ascii_digit() || *byte == b'_').count();
        if let Some(length) = path(rest) {
            let quoted = format!("\"{}\"", &rest[..length]);
            return self.slip(length, quoted, true, "a text needs quotes");
        }
        let mut length = digits(rest);
        if rest[length..].starts_with('.') && rest[length + 1..].starts_with(|next: char| next.is_ascii_digit()) {
            length += 1 + digits(&rest[length + 1..]);
        }
        self.push(Token::Number, length);
    }

    /// Reads a word; `joined` when nothing stands between it and what is before.
    fn step_word(&mut self, joined: bool) {
        let rest = self.rest();
        if let Some(length) = path(rest) {
            let quoted = format!("\"{}\"", &rest[..length]);
            return self.slip(length, quoted, true, "a text needs quotes");
        }
        if let Some((length, last)) = dotted(rest) {
            let parts: Vec<&str> = rest[..length].split('.').collect();
            return match parts.as_slice() {
                _ if rest[length..].starts_with('(') => {
                    let function = last.to_string();
                    self.slip(length, function, true, "functions are named alone");
                }
                [event, word] if self.word(0) == "on" && self.tokens.len() == 1 => {
                    let instead = format!("{event}({word})");
                    self.slip(length, instead, true, "what an event is narrowed to stands in parentheses");
                }
                parts => self.slip(length, parts.join("_"), true, "names hold no points"),
            };
        }
        let length = rest.bytes().take_while(|byte| byte.is_ascii_alphanumeric() || *byte == b'_').count();
        let word = &rest[..length];
        let first_word = self.tokens.is_empty() && !self.key_first;
        if let Some(own) = first_word.then(|| own_statement(word)).flatten() {
            return self.slip(length, own, true, "this statement begins with another word");
        }
        let is_key = rest[length..].trim_start().starts_with(':');
        let in_unit = joined && self.last() == Some(Token::Sign) && {
            let before = self.tokens.len().checked_sub(2).map(|place| self.tokens[place].0);
            before == Some(Token::Unit)
        };
        let behind = rest[length..].trim_start();
        // The first word of a clause.
        let clause = self.key_first && self.tokens.is_empty();
        let unit = behind.split(|c: char| !(c.is_ascii_alphanumeric() || "/^".contains(c))).next().unwrap_or_default();
        match word {
            "On" | "ON" | "when" | "When" | "upon" if clause && !is_key && behind.contains("=>") => {
                self.slip(length, "on", true, "what an event is worth begins with `on`");
            }
            _ if self.after_event() && self.tokens.len() == 2 && behind.starts_with("=>") => {
                let instead = format!("({word})");
                self.slip(length, instead, true, "what an event is narrowed to stands in parentheses");
            }
            "as" | "to"
                if self.last() == Some(Token::Word) && !is_key && parse_unit(unit).is_ok() && !unit.is_empty() =>
            {
                self.slip(length, "in", true, "write `in` before the unit");
            }
            "from"
                if self.key_first
                    && self.tokens.len() == 2
                    && behind.starts_with(|next: char| next.is_ascii_digit() || next == '-')
                    && behind.contains(" to ") =>
            {
                self.slip(length, "", true, "a range is written `low .. high`");
            }
            _ if self.behind_value() && !is_key && !self.tokens.is_empty() && compares(word).is_some() => {
                let sign = compares(word).unwrap_or_default();
                self.slip(length, sign, true, "quantities are compared by signs");
            }
            "to" if self.behind_value()
                && !is_key
                && rest[length..]
                    .trim_start()
                    .starts_with(|next: char| next.is_ascii_digit() || matches!(next, '-' | '('))
                && self.tokens.last().is_none_or(|(_, place)| !self.text[place.clone()].eq("from")) =>
            {
                self.slip(length, "..", true, "a range is written `low .. high`");
            }
            "if" | "elif" | "else" | "then" if !is_key => match self.found.iter().any(|slip| slip.said == NO_IF) {
                true => self.push(Token::Word, length),
                false => self.slip(length, "", false, NO_IF),
            },
            "return" if !is_key => self.slip(length, "", true, "a formula stands alone"),
            _ if matches!(self.word(self.tokens.len().wrapping_sub(1)), ")" | "]")
                && !is_key
                && parse_unit(word).is_ok() =>
            {
                self.slip(length, "", false, "the unit stands behind every number");
            }
            "AND" | "OR" | "NOT" => {
                self.slip(length, word.to_lowercase(), true, "the words of logic are `and`, `or`, `not`");
            }
            _ if self.last() == Some(Token::Number) || in_unit => self.push(Token::Unit, length),
            _ => self.push(Token::Word, length),
        }
    }
}

/// The length of a path or a release that stands where a text does begin, with a point within but no number and no range.
fn path(text: &str) -> Option<usize> {
    let whole = run(text, |byte| byte.is_ascii_alphanumeric() || b"_./-".contains(&byte))?;
    let points = whole.matches('.').count();
    let number = whole.parse::<f64>().is_ok() || whole.starts_with(|c: char| c.is_ascii_digit()) && points < 2;
    let plain = whole.contains("..") || whole.ends_with(['.', '/', '-']) || whole.contains("//");
    // Words with points between them are a path when they end as the names of files do.
    let ending = whole.rsplit('.').next().unwrap_or_default();
    let file =
        whole.contains('/') || FILES.contains(&ending) || whole.starts_with(|first: char| first.is_ascii_digit());
    (points > 0 && !number && !plain && file).then_some(whole.len())
}

/// The bytes that a text begins with, as long as they are such; none when they are more than anybody would write.
fn run(text: &str, such: impl Fn(u8) -> bool) -> Option<&str> {
    const MOST: usize = 256;
    let length = text.bytes().take(MOST).take_while(|byte| such(*byte)).count();
    (length < MOST).then(|| &text[..length])
}

/// How the names of files end that scenarios speak of.
const FILES: &[&str] = &["scn", "xodr", "onnx", "json", "toml", "py", "exe", "sh", "csv", "parquet", "xml"];

/// The length of words with points between them, as other languages reach into things, and the last of them.
fn dotted(text: &str) -> Option<(usize, &str)> {
    let whole = run(text, |byte| byte.is_ascii_alphanumeric() || matches!(byte, b'_' | b'.'))?;
    let named = |word: &str| word.starts_with(|first: char| first.is_ascii_alphabetic() || first == '_');
    let last = whole.split('.').next_back().filter(|_| whole.contains('.') && whole.split('.').all(named))?;
    Some((whole.len(), last))
}

/// A number whose digits are grouped by blanks or apostrophes: its length, and how it is written here.
fn grouped(text: &str) -> Option<(usize, String)> {
    let digits = |text: &str| text.bytes().take_while(u8::is_ascii_digit).count();
    let first = digits(text);
    let (mut length, mut groups) = (first, vec![&text[..first]]);
    while text[length..].starts_with([' ', '\'']) && digits(&text[length + 1..]) == 3 {
        groups.push(&text[length + 1..length + 4]);
        length += 4;
    }
    let whole = (1..=3).contains(&first) && groups.len() > 1;
    let ends = !text[length..].starts_with(|next: char| next.is_ascii_alphanumeric() || next == '.');
    (whole && ends).then(|| (length, groups.join("_")))
}

/// The sign that a word of other languages stands for.
pub(super) fn compares(word: &str) -> Option<&'static str> {
    Some(match word {
        "gt" | "above" | "exceeds" => ">",
        "lt" | "below" => "<",
        "ge" | "gte" => ">=",
        "le" | "lte" => "<=",
        _ => return None,
    })
}

/// What a statement begins with here that begins with this word elsewhere.
fn own_statement(word: &str) -> Option<&'static str> {
    Some(match word {
        "Edition" | "EDITION" => "edition",
        "Import" | "IMPORT" | "include" | "using" => "import",
        "Param" | "PARAM" | "parameter" | "var" | "let" | "const" => "param",
        _ => return None,
    })
}

/// Whether a text begins with a brace that a block may have, and not a list of values.
fn opens_block(text: &str) -> bool {
    let inside = text.trim_start_matches([' ', '\t']).strip_prefix('{').map(str::trim_start);
    inside.is_some_and(|inside| {
        inside.starts_with(|first: char| first.is_ascii_alphabetic() || matches!(first, '/' | '}'))
    })
}

/// The text with what was meant in place of its slips.
pub(in crate::internal::lang) fn without(text: &str, slips: &[Slip]) -> String {
    let (mut repaired, mut last) = (String::new(), 0);
    for slip in slips {
        repaired.extend([&text[last..slip.place.start], &slip.instead]);
        last = slip.place.end;
    }
    repaired.push_str(&text[last..]);
    repaired
}

/// A slip of its own: a key without the colon before its value.
pub(in crate::internal::lang) fn missing_colon(text: &str) -> Option<Vec<Slip>> {
    let word = |text: &str| text.bytes().take_while(|byte| *byte == b'_' || byte.is_ascii_alphanumeric()).count();
    let key = word(text);
    // What opens a block is no value.
    if text.split(['\n', '"', '(', '[', ':']).next().is_some_and(|head| head.contains('{')) {
        return None;
    }
    let value = text[key..].trim_start();
    let follows = text[key..].starts_with([' ', '\t']) && !value.is_empty() && !value.starts_with(['{', '=', ':', '(']);
    // Words that join things are no keys.
    const JOINING: &[&str] = &[
        "on", "as", "between", "and", "or", "in", "is", "if", "else", "per", "with", "for", "from", "at", "of", "to",
        "not",
    ];
    if key == 0 || !follows || JOINING.contains(&&text[..key]) {
        return None;
    }
    let (place, instead) = (0..key, format!("{}:", &text[..key]));
    let mut all = vec![Slip { place, instead, meant: true, said: "a key is followed by `:`", foreign: false }];
    all.extend(slips(text, true).into_iter().filter(|slip| slip.place.start >= key));
    Some(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slips_are_found_where_they_are_slips() {
        for (text, meant) in [
            ("ticks = 600", "ticks : 600"),
            ("ticks == 600", "ticks : 600"),
            ("on hit: 1", "on hit => 1"),
            ("on hit(front) -> 1", "on hit(front) => 1"),
            ("on hit = 1", "on hit => 1"),
            ("hit(front) => 1", "on hit(front) => 1"),
            ("(gamma=0.9, steps = 3)", "(gamma:0.9, steps : 3)"),
            ("bearing: −60° .. 60 °", "bearing: -60 deg .. 60 deg"),
            ("distance: 7 m to 30 m", "distance: 7 m .. 30 m"),
            ("distance: 7 m ... 30 m", "distance: 7 m .. 30 m"),
            ("file: 'a # b'", "file: \"a # b\""),
            ("import \"std/paper.scn", "import \"std/paper.scn\""),
            ("# a \"comment", "// a \"comment"),
            ("miss: 50%", "miss: 50 percent"),
            ("require: a && !b || c", "require: a and not b or c"),
            ("on hit => v_c^2 * .5", "on hit => v_c * 0.5"),
            ("require: a | b", "require: a or b"),
            ("on hit => max(3; +4)", "on hit => max(3, 4)"),
            ("on hit.front => math.max(1, ego.speed)", "on hit(front) => max(1, ego_speed)"),
            ("on_hit(front) => 1", "on hit(front) => 1"),
            ("on step => return $far", "on step =>  far"),
            ("onhit => 1", "on hit => 1"),
            ("on lost { -1 }", "on lost => -1"),
            ("on hit >= 1", "on hit => 1"),
            ("on hit ==> 1", "on hit => 1"),
            ("on hit[ front ] => 1", "on hit(front) => 1"),
            ("on hit front => 1", "on hit (front) => 1"),
            ("when hit => v_c as m/s", "on hit => v_c in m/s"),
            ("acceleration: 6 m/s**2", "acceleration: 6 m/s^2"),
            ("steps: 100 000", "steps: 100_000"),
            ("steps: 1'500'000", "steps: 1_500_000"),
            ("distance: from 8 m to 25 m", "distance:  8 m .. 25 m"),
            ("distance: 8 m ..= 25 m", "distance: 8 m .. 25 m"),
            ("require: distance gt 80 m", "require: distance > 80 m"),
            ("file: “a b”", "file: \"a b\""),
        ] {
            assert_eq!(without(text, &slips(text, true)), meant);
        }
        for fine in [
            "wall { from: (1 m, 2 m) to: (3 m, 4 m) }",
            "// 50% of # 'these' are fine",
            "a: \"60° == −60\"",
            "b: 2 m/s^2 .. 3 m/s^2*kg^-1",
            "on hit => max(1, 2)",
            "spawn s = kind(a: 1 <= 2)",
        ] {
            assert!(slips(fine, true).is_empty(), "{fine}: {}", without(fine, &slips(fine, true)));
        }
    }

    #[test]
    fn slips_stand_one_behind_the_other() {
        for text in
            ["°=> 1", "..==> 30 m", "a.scn=> min(1)", "，=> 2", "onhit front => 1", "$x ==> [1] ±3° ** 10^2 +- “a"]
        {
            for key_first in [true, false] {
                let found = slips(text, key_first);
                assert!(found.windows(2).all(|pair| pair[0].place.end <= pair[1].place.start), "{text}");
                without(text, &found);
            }
        }
    }
}

//! Guesses at what is missing in a statement of no known shape, or foreign to it: a repair is believed when the statement can be read
//! with it.

use std::ops::Range;

use super::params::DIMENSIONS;
use crate::units::parse_unit;

/// Where commas may be missing: the ends of values inside parentheses and brackets that another value follows.
pub(super) fn missing_commas(text: &str) -> Vec<usize> {
    let bytes = text.as_bytes();
    let mut open: Vec<u8> = Vec::new();
    // Whether parentheses hold values alone, and no arguments.
    let mut groups: Vec<bool> = Vec::new();
    let mut found = Vec::new();
    // The end of the last token, when it may end a value, and whether it is a number.
    let mut value: Option<(usize, bool)> = None;
    // Whether the last token is a name, which parentheses may follow.
    let mut called = false;
    let mut at = 0;
    while at < bytes.len() {
        let rest = &text[at..];
        let word = rest.bytes().take_while(|byte| byte.is_ascii_alphanumeric() || matches!(byte, b'_' | b'.')).count();
        let length = match bytes[at] {
            byte if byte.is_ascii_whitespace() => {
                at += 1;
                continue;
            }
            b'/' if rest.starts_with("//") => {
                at += rest.find('\n').unwrap_or(rest.len());
                continue;
            }
            b'"' => rest[1..].find('"').map_or(rest.len(), |end| end + 2),
            _ if word > 0 => rest[..word].find("..").filter(|range| *range > 0).unwrap_or(word),
            _ => rest.chars().next().map_or(1, char::len_utf8),
        };
        let token = &rest[..length];
        let starts = word > 0 && !token.starts_with('.') || matches!(bytes[at], b'"' | b'[');
        let operator = matches!(token, "and" | "or" | "not" | "in");
        let grouped = groups.last() == Some(&true);
        if let Some((end, number)) = value
            && (starts || bytes[at] == b'(' && !called)
            && !operator
            && matches!(open.last(), Some(b'(' | b'['))
        {
            // The word after a number is its unit, unless it is a key.
            let is_key = rest[length..].trim_start().starts_with(':');
            let is_unit = number && token.starts_with(|first: char| first.is_ascii_alphabetic()) && !is_key;
            if grouped && !number && !is_key && token.starts_with(|first: char| first.is_ascii_alphabetic()) {
                // Words side by side within plain parentheses are a sentence.
                return Vec::new();
            }
            if !is_unit {
                found.push(end);
            }
        }
        match bytes[at] {
            bracket @ (b'(' | b'[' | b'{') => {
                open.push(bracket);
                groups.push(bracket == b'(' && !called);
            }
            b')' | b']' | b'}' => {
                open.pop();
                groups.pop();
            }
            _ => {}
        }
        let ends = starts && !operator && bytes[at] != b'[' || matches!(bytes[at], b')' | b']');
        called = token.starts_with(|first: char| first.is_ascii_alphabetic() || first == '_');
        value = ends.then_some((at + length, bytes[at].is_ascii_digit()));
        at += length;
    }
    found
}

/// A sign or word that people bring along from other languages or from print.
pub(super) struct Slip {
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

/// The slips in a statement; `key_first` when it may be `key: value`.
pub(super) fn slips(text: &str, key_first: bool) -> Vec<Slip> {
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
        let foreign = self
            .rest()
            .starts_with(|first: char| !first.is_ascii() || matches!(first, '#' | '%' | '\'' | '!' | '&' | '|' | '"'));
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
                    self.slip(end + 2, instead, true, "a text stands in double quotes");
                }
                None => self.push(Token::Sign, 1),
            },
            '#' => {
                let line = line();
                self.slip(1, "//", true, "a comment begins with `//`");
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
                self.slip(first.len_utf8(), "\"", true, "a text stands in straight quotes")
            }
            '\u{a0}' | '\u{2009}' | '\u{202f}' | '\u{200b}' | '\u{feff}' => {
                self.slip(first.len_utf8(), " ", true, "this is no ordinary blank");
            }
            '²' | '³' => {
                let power = if first == '²' { "^2" } else { "^3" };
                self.slip(first.len_utf8(), power, true, "powers of units are written `^2`");
            }
            '±' => self.slip(first.len_utf8(), "", false, "write both ends: `-60 deg .. 60 deg`"),
            '×' | '·' => self.slip(first.len_utf8(), "*", true, "the sign for times is `*`"),
            '≤' => self.slip(first.len_utf8(), "<=", true, "at most is written `<=`"),
            '≥' => self.slip(first.len_utf8(), ">=", true, "at least is written `>=`"),
            '…' => self.slip(first.len_utf8(), "..", true, "a range is written `low .. high`"),
            '{' | '(' | '[' => {
                self.open.push(first as u8);
                self.push(Token::Sign, 1);
            }
            '}' | ')' | ']' => {
                self.open.pop();
                self.push(Token::Closing, 1);
            }
            _ if starts("=>") => {
                let named = self.tokens.len() == 1 || self.tokens.len() == 4 && self.word(1) == "(";
                if named && self.open.is_empty() && self.word(0) != "on" {
                    let place = self.tokens[0].1.clone();
                    let instead = format!("on {}", self.word(0));
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
            _ if starts("&&") => self.slip(2, "and", true, "write `and`"),
            _ if starts("||") => self.slip(2, "or", true, "write `or`"),
            '|' => self.slip(1, "", false, "the size of a number is `abs(…)`"),
            '!' => self.slip(1, "not ", true, "write `not`"),
            '^' if self.last() == Some(Token::Unit) => {
                let digits = rest[1..].trim_start_matches('-').trim_start_matches(|c: char| c.is_ascii_digit());
                self.push(Token::Unit, rest.len() - digits.len());
            }
            '^' | '*' if (first == '^' && self.last() != Some(Token::Unit)) || starts("**") => {
                let sign = if first == '^' { 1 } else { 2 };
                let digits =
                    rest[sign..].trim_start_matches([' ', '-']).trim_start_matches(|c: char| c.is_ascii_digit());
                self.slip(rest.len() - digits.len(), "", false, "there are no powers: multiply, as in `v_c * v_c`");
            }
            _ if starts("...") => self.slip(3, "..", true, "a range is written `low .. high`"),
            _ if starts("..") => self.push(Token::Sign, 2),
            '.' if rest[1..].starts_with(|next: char| next.is_ascii_digit()) => {
                self.slip(1, "0.", true, "a number begins with a digit");
                self.tokens.pop();
            }
            _ if first.is_ascii_digit() => {
                let digits =
                    |text: &str| text.bytes().take_while(|byte| byte.is_ascii_digit() || *byte == b'_').count();
                if let Some(length) = path(rest) {
                    let quoted = format!("\"{}\"", &rest[..length]);
                    return self.slip(length, quoted, true, "a text stands in quotes");
                }
                let mut length = digits(rest);
                if rest[length..].starts_with('.') && rest[length + 1..].starts_with(|next: char| next.is_ascii_digit())
                {
                    length += 1 + digits(&rest[length + 1..]);
                }
                self.push(Token::Number, length);
            }
            _ if first.is_ascii_alphabetic() || first == '_' => {
                if let Some(length) = path(rest) {
                    let quoted = format!("\"{}\"", &rest[..length]);
                    return self.slip(length, quoted, true, "a text stands in quotes");
                }
                let length = rest.bytes().take_while(|byte| byte.is_ascii_alphanumeric() || *byte == b'_').count();
                let word = &rest[..length];
                let is_key = rest[length..].trim_start().starts_with(':');
                let in_unit = joined && self.last() == Some(Token::Sign) && {
                    let before = self.tokens.len().checked_sub(2).map(|place| self.tokens[place].0);
                    before == Some(Token::Unit)
                };
                match word {
                    "to" if self.behind_value()
                        && !is_key
                        && rest[length..]
                            .trim_start()
                            .starts_with(|next: char| next.is_ascii_digit() || matches!(next, '-' | '('))
                        && self.tokens.last().is_none_or(|(_, place)| !self.text[place.clone()].eq("from")) =>
                    {
                        self.slip(length, "..", true, "a range is written `low .. high`");
                    }
                    "AND" | "OR" | "NOT" => {
                        self.slip(length, word.to_lowercase(), true, "the words of logic are `and`, `or`, `not`")
                    }
                    _ if self.last() == Some(Token::Number) || in_unit => self.push(Token::Unit, length),
                    _ => self.push(Token::Word, length),
                }
            }
            _ => self.push(Token::Sign, first.len_utf8()),
        }
    }
}

/// The length of a path or a release that stands where a text does begin, with a point within but no number and no range.
fn path(text: &str) -> Option<usize> {
    let part = |c: char| c.is_ascii_alphanumeric() || "_./-".contains(c);
    let whole = &text[..text.find(|c: char| !part(c)).unwrap_or(text.len())];
    let points = whole.matches('.').count();
    let number = whole.parse::<f64>().is_ok() || whole.starts_with(|c: char| c.is_ascii_digit()) && points < 2;
    let plain = whole.contains("..") || whole.ends_with(['.', '/', '-']) || whole.contains("//");
    (points > 0 && !number && !plain).then_some(whole.len())
}

/// The text with what was meant in place of its slips.
pub(super) fn without(text: &str, slips: &[Slip]) -> String {
    let (mut repaired, mut last) = (String::new(), 0);
    for slip in slips {
        repaired.extend([&text[last..slip.place.start], &slip.instead]);
        last = slip.place.end;
    }
    repaired.push_str(&text[last..]);
    repaired
}

/// A slip of its own: a key without the colon before its value.
pub(super) fn missing_colon(text: &str) -> Option<Vec<Slip>> {
    let word = |text: &str| text.bytes().take_while(|byte| *byte == b'_' || byte.is_ascii_alphanumeric()).count();
    let key = word(text);
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

/// Values side by side, of which `text` begins with one behind a comma: how many bytes stand before and behind.
pub(super) fn unbracketed(before: &str, text: &str) -> Option<(usize, usize)> {
    let listed = before.trim_end().strip_suffix(',')?;
    // Between the colon of the key and the comma stands one value, without a bracket.
    let first = listed.rfind(':').map(|colon| &listed[colon + 1..])?;
    let fine = |value: &str| !value.trim().is_empty() && !value.contains(['{', '}', '(', ')', '[', ']', ',', ';', '"']);
    let part = |byte: &u8| *byte == b'_' || byte.is_ascii_alphanumeric();
    let is_key = |behind: &str| behind.trim_start().starts_with([':', '=', '{']);
    // A word, or a number with its unit.
    let value = |text: &str| {
        let word = text.bytes().take_while(|byte| part(byte) || *byte == b'.').count();
        let unit = text[word..].trim_start_matches(' ');
        let length = unit.bytes().take_while(|byte| part(byte) || matches!(byte, b'/' | b'^')).count();
        let with_unit =
            text.starts_with(|first: char| first.is_ascii_digit()) && length > 0 && !is_key(&unit[length..]);
        if with_unit { text.len() - unit.len() + length } else { word }
    };
    let mut end = value(text);
    if end == 0 || !fine(first) || is_key(&text[end..]) {
        return None;
    }
    while let Some(next) = text[end..].trim_start_matches(' ').strip_prefix(',') {
        let next = next.trim_start_matches(' ');
        let length = value(next);
        if length == 0 || is_key(&next[length..]) {
            break;
        }
        end = text.len() - next.len() + length;
    }
    let start = before.len() - (listed.len() - first.len()) - (first.len() - first.trim_start().len());
    Some((start, end))
}

/// The name of a parameter without a type, and the word for the type that its value has.
pub(super) fn untyped_param(text: &str) -> Option<(Range<usize>, Option<&'static str>)> {
    let rest = text.strip_prefix("param")?;
    let name = rest.trim_start();
    let start = text.len() - name.len();
    let length = name.bytes().take_while(|byte| *byte == b'_' || byte.is_ascii_alphanumeric()).count();
    let value = name[length..].trim_start().strip_prefix('=')?.trim();
    if length == 0 || start == text.len() - rest.len() || value.starts_with('=') {
        return None;
    }
    let number =
        value.trim_start_matches('-').bytes().take_while(|byte| byte.is_ascii_digit() || *byte == b'.').count();
    let unit = value.trim_start_matches('-')[number..].split_whitespace().next();
    let ty = match unit {
        _ if value == "true" || value == "false" => Some("boolean"),
        _ if value.starts_with('"') => Some("text"),
        _ if number == 0 => None,
        None => Some("number"),
        Some(unit) => parse_unit(unit).ok().and_then(|unit| {
            DIMENSIONS.iter().find(|(_, dimension)| *dimension == unit.dimension).map(|(name, _)| *name)
        }),
    };
    Some((start..start + length, ty))
}

/// The words with points between them before a colon: no key, but what leads to one from outside.
pub(super) fn dotted_key(text: &str) -> Option<&str> {
    let is_part = |c: char| c == '_' || c.is_ascii_alphanumeric();
    let path = &text[..text.find(|c: char| !is_part(c) && c != '.').unwrap_or(text.len())];
    let words = path.split('.').filter(|word| word.starts_with(|c: char| c.is_ascii_alphabetic())).count();
    let named = words > 1 && words == path.split('.').count();
    (named && text[path.len()..].trim_start().starts_with(':')).then_some(path)
}

/// A number written with commas, of which `text` begins with the digits behind the first: how many bytes stand before and behind.
pub(super) fn decimal_comma(before: &str, text: &str) -> Option<(usize, usize)> {
    let digits = |text: &mut dyn Iterator<Item = u8>| text.take_while(u8::is_ascii_digit).count();
    let whole = digits(&mut before.strip_suffix(',')?.bytes().rev());
    let mut part = digits(&mut text.bytes());
    if whole == 0 || part == 0 {
        return None;
    }
    while text[part..].starts_with(',') {
        match digits(&mut text[part + 1..].bytes()) {
            0 => break,
            more => part += 1 + more,
        }
    }
    Some((whole + 1, part))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commas_are_missed_between_values() {
        let marked = |text: &str| {
            let mut repaired = text.to_string();
            missing_commas(text).iter().rev().for_each(|at| repaired.insert(*at, ','));
            repaired
        };
        assert_eq!(marked("policy p = idm(limit_share: 1 margin: 1 m)"), "policy p = idm(limit_share: 1, margin: 1 m)");
        assert_eq!(marked("towns: [a b \"c\"]"), "towns: [a, b, \"c\"]");
        assert_eq!(marked("at: (1 m 2 m, 3 deg)"), "at: (1 m, 2 m, 3 deg)");
        assert_eq!(marked("at: [(1 m, 2 m) (3 m, 4 m)]"), "at: [(1 m, 2 m), (3 m, 4 m)]");
        for fine in
            ["x: max(1 m, f(2) * 3 .. 4) and b in m/s", "a: [7..30, 1 m .. 2 m]", "{ a: 1 b: 2 }", "f(not a or b)"]
        {
            assert_eq!(marked(fine), fine);
        }
    }

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
    fn a_comma_may_stand_in_a_number() {
        assert_eq!(decimal_comma("gamma: 0,", "95, steps"), Some((2, 2)));
        assert_eq!(decimal_comma("gamma: 0, ", "95"), None);
        assert_eq!(decimal_comma("(a, ", "b"), None);
    }
}

//! The words of the grammar's error productions (`grammar/mistakes.pest`).

use pest::iterators::Pair;

use super::Reader;
use super::rules::Rule;
use crate::ast::{Expression, ExpressionKind, Known};
use crate::diagnostics;
use crate::tokens::{TokenKind, tokens};
use base::diagnostic::Span;

const COLON: &str = "a key is followed by `:`";
const ARROW: &str = "an event is followed by `=>`";
pub(super) const RANGE: &str = "a range is written `low .. high`";
const CLAUSE: &str = "a clause starts with `on`";
const EVENT_WORD: &str = "the word of an event needs parentheses";
const NAME: &str = "the name follows the form directly";
const UNCLOSED: &str = "this text is not closed on its line";
/// The message for a conditional, once per value.
pub(super) const NO_IF: &str =
    "there is no `if`: use `min` and `max` in a formula, and `and`, `or`, `not` in a condition";

/// The message, and the text to write instead if one meaning is likely.
type Words = (&'static str, Option<String>);

/// The words of an error production that replaces one text by another.
fn words(rule: Rule, text: &str) -> Words {
    let instead = |said, text: &str| (said, Some(text.to_string()));
    match (rule, text) {
        (Rule::colon_sign, _) => instead(COLON, ":"),
        (Rule::arrow_sign, _) => instead(ARROW, "=>"),
        (Rule::braced, _) => (ARROW, None),
        (Rule::range_sign, _) => instead(RANGE, ".."),
        (Rule::wrong_infix, "AND" | "OR") => ("operators are lower case", Some(text.to_lowercase())),
        (Rule::wrong_infix, "gt" | "above" | "exceeds") => instead("write `>`", ">"),
        (Rule::wrong_infix, "lt" | "below") => instead("write `<`", "<"),
        (Rule::wrong_infix, "ge" | "gte") => instead("write `>=`", ">="),
        (Rule::wrong_infix, "le" | "lte" | "=<") => instead("write `<=`", "<="),
        (Rule::wrong_infix, "==") => {
            ("measured quantities are never exactly equal: use `<=` and `>=`, or give a range", None)
        }
        (Rule::wrong_infix, "**" | "^") => ("there are no powers: multiply, as in `v_c * v_c`", None),
        (Rule::wrong_infix, "->") => instead("write `implies`", "implies"),
        (Rule::wrong_infix, _) => (NO_IF, None),
        (Rule::wrong_prefix, "+") => instead("a number needs no `+`", ""),
        (Rule::wrong_prefix, _) => ("write both ends: `-60 deg .. 60 deg`", None),
        (Rule::odd_power, _) => ("powers of units are written `^2`", Some(text.replace("**", "^"))),
        (Rule::hash, _) => instead("a comment starts with `//`", "//"),
        (Rule::split_key, _) if text.starts_with("matrix ") => ("write `matrix { name: [value, …] }`", None),
        (Rule::split_key, _) => {
            let parts: Vec<&str> = text.split([' ', '-']).filter(|part| !part.is_empty()).collect();
            ("a key is one word", Some(parts.join("_")))
        }
        (Rule::odd_word, _) => {
            let word = text.trim_matches(|c: char| !c.is_ascii_alphanumeric() && c != '_');
            (EVENT_WORD, Some(format!("({word})")))
        }
        (Rule::on_like, _) => instead(CLAUSE, "on"),
        (Rule::several, _) => ("every event has an `on event => formula` of its own", None),
        (Rule::import_like, _) => instead("write `import \"path\"`", "import"),
        (Rule::bare_path, text) if is_unclosed(text) => (UNCLOSED, text.ends_with(".scn").then(|| format!("{text}\""))),
        (Rule::bare_path, _) => {
            ("a text needs quotes", Some(format!("\"{}\"", text.trim_matches(['"', '\'', '“', '”']))))
        }
        (Rule::odd_name, _) if text.starts_with('"') => ("names have no quotes", Some(text.replace('"', ""))),
        (Rule::odd_name, _) if text.starts_with(|first: char| first.is_ascii_digit()) => {
            ("a name starts with a letter", None)
        }
        (Rule::odd_name, _) if text.contains('-') => {
            ("names are letters, digits and `_`", Some(text.replace('-', "_")))
        }
        (Rule::odd_name, _) => {
            ("a name is one word", Some(text.split(' ').filter(|part| !part.is_empty()).collect::<Vec<_>>().join("_")))
        }
        (Rule::stray_colon, _) => instead(NAME, ""),
        (Rule::colon_kind, _) => instead("a kind follows `=`", "="),
        (Rule::stray_equals, _) => instead("a block follows the name directly", ""),
        (other, _) => unreachable!("{other:?} is no error production"),
    }
}

/// Whether the path of an import has its opening quote and no closing one.
pub(super) fn is_unclosed(path: &str) -> bool {
    path.starts_with('"') && !path.ends_with(['"', '”', '\''])
}

/// Characters that the language does not have: the message, and the text to write instead.
const CONFUSABLES: &[(&str, &str, Option<&str>)] = &[
    ("#", "a comment starts with `//`", Some("//")),
    ("%", "write `percent`, or the plain number", Some("percent")),
    ("°", "degrees are written `deg`", Some("deg")),
    ("²", "powers of units are written `^2`", Some("^2")),
    ("³", "powers of units are written `^3`", Some("^3")),
    ("±", "write both ends: `-60 deg .. 60 deg`", None),
    ("−", "the sign for minus is `-`", Some("-")),
    ("×", "the sign for times is `*`", Some("*")),
    ("·", "the sign for times is `*`", Some("*")),
    ("≤", "write `<=`", Some("<=")),
    ("≥", "write `>=`", Some(">=")),
    ("…", RANGE, Some("..")),
    ("：", "this is not an ordinary colon", Some(":")),
    ("，", "this is not an ordinary comma", Some(",")),
    ("&&", "write `and`", Some("and")),
    ("&", "write `and`", Some("and")),
    ("||", "write `or`", Some("or")),
    ("|", "write `or`", Some("or")),
    ("!=", "measured quantities always differ: use `<` or `>`", None),
    ("!", "write `not`", Some("not ")),
    ("$", "a parameter is named without a sign", Some("")),
    ("\u{a0}", "this is not an ordinary blank", Some(" ")),
    ("\u{2009}", "this is not an ordinary blank", Some(" ")),
    ("\u{202f}", "this is not an ordinary blank", Some(" ")),
    ("\u{200b}", "this is not an ordinary blank", Some(" ")),
    ("\u{feff}", "this is not an ordinary blank", Some(" ")),
];

/// The greatest number of reported characters of a statement.
const MOST_FOREIGN: usize = 100;

impl Reader {
    /// Reports an error production.
    pub(super) fn mistake(&mut self, pair: &Pair<Rule>) {
        let text = pair.as_str().trim_end();
        let (said, instead) = words(pair.as_rule(), text);
        let start = pair.as_span().start();
        let end = match pair.as_rule() {
            Rule::hash | Rule::colon_kind => start + 1,
            _ => start + text.len(),
        };
        // A sign without a blank before it becomes a word of its own.
        let joined = matches!(pair.as_rule(), Rule::arrow_sign | Rule::colon_kind)
            && !pair.get_input()[..start].ends_with([' ', '\t']);
        let instead = instead.map(|instead| if joined { format!(" {instead}") } else { instead });
        self.report(self.place(start, end), said, instead.as_deref());
    }

    /// Reports a mistake in the words of a table.
    pub(super) fn report(&mut self, place: Span, said: &'static str, instead: Option<&str>) {
        self.mistakes += 1;
        let again = said == NO_IF && self.diagnostics.last().is_some_and(|last| last.primary.text == NO_IF);
        if !again {
            self.diagnostics.push(diagnostics::mistake(place, said, instead));
        }
    }

    /// Reads a value whose mistakes have been reported, without further reports.
    pub(super) fn whole_value(&mut self, pair: Pair<Rule>) -> Expression {
        let before = self.mistakes;
        let mut value = self.value(pair);
        if self.mistakes > before {
            value.kind = ExpressionKind::Known(Known::Wrong);
        }
        value
    }

    /// Reports several values without brackets; `first` is the one before the first comma.
    pub(super) fn unlisted(&mut self, first: &Expression, rest: &[Expression], source: &str, in_matrix: bool) {
        let Some(last) = rest.last() else { return };
        self.mistakes += 1;
        let place = first.span.to(last.span);
        let text = &source[place.start..place.end];
        let digits = text.find(|c: char| !(c.is_ascii_digit() || c == ',')).unwrap_or(text.len());
        let quantity = |value: &Expression| matches!(&value.kind, ExpressionKind::Number { unit: Some(_), .. });
        let said = match rest {
            // `1,5`, `1,000,000`
            _ if text[..digits].contains(',') && rest.iter().all(|value| plain_digits(source, value)) => {
                diagnostics::decimal_comma(
                    self.place(place.start, place.start + digits),
                    text[..digits].trim_end_matches(','),
                )
            }
            [high] if quantity(first) && quantity(high) && !in_matrix => {
                let part = |value: &Expression| &source[value.span.start..value.span.end];
                diagnostics::unbracketed_pair(place, (part(first), part(high)))
            }
            _ => diagnostics::unbracketed_list(place, text),
        };
        self.diagnostics.push(said);
    }

    /// Reports characters that the language does not have; false if the table lists none of them.
    pub(super) fn foreign(&mut self, text: &str, start: usize, source: &str) -> bool {
        let before = self.diagnostics.len();
        let mut done = 0;
        let mut last = None;
        for token in tokens(text) {
            if self.diagnostics.len() - before >= MOST_FOREIGN {
                break;
            }
            if token.start < done {
                continue;
            }
            let rest = &text[token.start..];
            let source_id = self.source;
            let place = |length: usize| {
                let start = start + token.start;
                Span { source: source_id, start, end: start + length }
            };
            let line = || rest.find(['\n', '\r']).unwrap_or(rest.len());
            if token.kind == TokenKind::OpenText {
                let instead = format!("{}\"", rest[..line()].trim_end());
                self.report(place(line()), UNCLOSED, Some(&instead));
            }
            if token.kind == TokenKind::Foreign {
                let first = rest.chars().next().unwrap_or_default();
                let found = match first {
                    '\'' | '“' | '”' | '„' | '«' | '»' => quoted(&rest[..line()]),
                    '–' | '—' => {
                        let range = matches!(last, None | Some(TokenKind::Number | TokenKind::Unit));
                        let (said, sign) = if range { (RANGE, "..") } else { ("the sign for minus is `-`", "-") };
                        Some((first.len_utf8(), said, Some(sign.to_string())))
                    }
                    '.' => return self.point(start + token.start, source) || self.diagnostics.len() > before,
                    _ => CONFUSABLES.iter().find(|(sign, ..)| rest.starts_with(sign)).map(|(sign, said, instead)| {
                        let joined = instead.is_some_and(|instead| instead.starts_with(char::is_alphabetic))
                            && !source[..start + token.start].ends_with([' ', '\t']);
                        let blank = if joined { " " } else { "" };
                        (sign.len(), *said, instead.map(|instead| format!("{blank}{instead}")))
                    }),
                };
                let found = found.or_else(|| unknown_characters(rest));
                if let Some((length, said, instead)) = found {
                    self.report(place(length), said, instead.as_deref());
                    done = token.start + length;
                    if first == '#' {
                        done = token.start + line();
                    }
                }
            }
            if token.kind != TokenKind::Blank {
                last = Some(token.kind);
            }
        }
        self.diagnostics.len() > before
    }

    /// Reports a point that belongs to no number and no range: `.5`, `maps/Town01.xodr`, `ego.speed`.
    fn point(&mut self, at: usize, source: &str) -> bool {
        let run = |such: fn(char) -> bool| -> (usize, usize) {
            let start = source[..at].trim_end_matches(such).len();
            (start, source[at..].find(|c| !such(c)).map_or(source.len(), |end| at + end))
        };
        let word: fn(char) -> bool = |c| c.is_ascii_alphanumeric() || matches!(c, '_' | '.');
        let path: fn(char) -> bool = |c| c.is_ascii_alphanumeric() || matches!(c, '_' | '.' | '/' | '-');
        let (start, end) = run(path);
        let file = ["scn", "xodr", "onnx", "json", "toml", "py", "sh", "csv"];
        if source[start..end].rsplit('.').next().is_some_and(|ending| file.contains(&ending)) {
            let instead = format!("\"{}\"", &source[start..end]);
            self.report(self.place(start, end), "a text needs quotes", Some(&instead));
            return true;
        }
        let (start, end) = run(word);
        let written = &source[start..end];
        if written.starts_with('.') && written[1..].starts_with(|next: char| next.is_ascii_digit()) {
            self.report(self.place(at, at + 1), "a number starts with a digit", Some("0."));
        } else if source[end..].trim_start().starts_with(':') && written.split('.').all(starts_with_letter) {
            self.mistakes += 1;
            self.diagnostics.push(diagnostics::dotted_key(self.place(start, end), written));
        } else if written.split('.').all(starts_with_letter) {
            let last = written.rsplit('.').next().unwrap_or_default();
            let call = source[end..].starts_with('(');
            let instead = if call { last.to_string() } else { written.replace('.', "_") };
            self.report(self.place(start, end), "names contain no points", Some(&instead));
        } else {
            return false;
        }
        true
    }
}

fn starts_with_letter(word: &str) -> bool {
    word.starts_with(|first: char| first.is_ascii_alphabetic())
}

/// Whether a value is written only in digits, perhaps with a unit.
fn plain_digits(source: &str, value: &Expression) -> bool {
    matches!(value.kind, ExpressionKind::Number { .. })
        && source[..value.span.start].ends_with(',')
        && source[value.span.start..].starts_with(|first: char| first.is_ascii_digit())
}

/// Characters beyond ASCII that no table lists, such as an emoji: their length, and the message.
fn unknown_characters(rest: &str) -> Option<(usize, &'static str, Option<String>)> {
    let length = rest.find(|c: char| c.is_ascii()).unwrap_or(rest.len());
    let said = match rest.chars().next()? {
        first if first.is_ascii() => return None,
        first if first.is_alphabetic() => "names are letters of a to z and A to Z, digits and `_`",
        _ => "the language does not have this character; only comments and texts can hold it",
    };
    Some((length, said, None))
}

/// A text in other quotes: its length, the message, and the text in the quotes of the language.
fn quoted(line: &str) -> Option<(usize, &'static str, Option<String>)> {
    let first = line.chars().next()?;
    let said = if first == '\'' { "a text needs double quotes" } else { "a text needs straight quotes" };
    let inside = &line[first.len_utf8()..];
    let is_closing = |c: char| if first == '\'' { c == '\'' } else { matches!(c, '“' | '”' | '«' | '»' | '"') };
    let end = inside.find(is_closing)?;
    let length = first.len_utf8() + end + inside[end..].chars().next()?.len_utf8();
    Some((length, said, Some(format!("\"{}\"", &inside[..end]))))
}

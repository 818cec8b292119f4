//! Text of others on a terminal: names of files, of roads, of a report from elsewhere may hold characters that command the terminal.

use std::borrow::Cow;
use std::fmt::Write;

/// Whether a character commands a terminal instead of being seen: C0, DEL, C1, and those that turn the direction of the text. Line ends and
/// tabs are seen.
pub fn is_command(character: char) -> bool {
    let turns =
        matches!(character, '\u{061c}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    turns || (character.is_control() && !matches!(character, '\n' | '\t'))
}

/// A text whose commands to a terminal are written out, as `\u{1b}`. Colours and bold print stay.
pub fn printable(text: &str) -> Cow<'_, str> {
    if !text.chars().any(is_command) {
        return text.into();
    }
    let mut safe = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(place) = rest.find(is_command) {
        safe.push_str(&rest[..place]);
        rest = &rest[place..];
        let style = style_length(rest);
        if style > 0 {
            safe.push_str(&rest[..style]);
            rest = &rest[style..];
        } else if let Some(command) = rest.chars().next() {
            let _ = write!(safe, "{}", command.escape_unicode());
            rest = &rest[command.len_utf8()..];
        }
    }
    safe.push_str(rest);
    safe.into()
}

/// The length of the escape sequence at the start of a text if it sets a colour, bold print, a line below, or none of them; else 0.
fn style_length(text: &str) -> usize {
    let Some(inner) = text.strip_prefix("\u{1b}[") else { return 0 };
    let Some(end) = inner.find(|letter: char| !letter.is_ascii_digit() && letter != ';') else { return 0 };
    let is_style = |code: &str| matches!(code.parse::<u8>().unwrap_or(0), 0..=4 | 22..=24 | 30..=37 | 39 | 90..=97);
    if inner[end..].starts_with('m') && inner[..end].split(';').all(is_style) { end + 3 } else { 0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_are_written_out_and_styles_stay() {
        for (text, wanted) in [
            ("a plain line\n\twith a tab, ü and 行", "a plain line\n\twith a tab, ü and 行"),
            ("\u{1b}[1m\u{1b}[31merror\u{1b}[0m: no", "\u{1b}[1m\u{1b}[31merror\u{1b}[0m: no"),
            ("x\u{1b}]0;title\u{7}y", "x\\u{1b}]0;title\\u{7}y"),
            ("\u{9b}31m", "\\u{9b}31m"),
            ("\u{1b}[2J\u{1b}[8mhidden\u{1b}[", "\\u{1b}[2J\\u{1b}[8mhidden\\u{1b}["),
            ("a\u{202e}b\u{2066}c\rd\u{7f}", "a\\u{202e}b\\u{2066}c\\u{d}d\\u{7f}"),
        ] {
            assert_eq!(printable(text), wanted);
        }
    }
}

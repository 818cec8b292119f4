//! Advice on characters of word processors and other languages: curly quotes, dashes, decimal commas.

use base::diagnostic::{Diagnostic, Sources};

/// The codes of messages about a place with such a character.
const CODES: [&str; 4] = ["syntax", "missing-unit", "bare-argument", "wrong-type"];

/// Adds advice to messages whose place has such a character.
pub fn explain_foreign(diagnostics: &mut [Diagnostic], sources: &Sources) {
    for said in diagnostics.iter_mut().filter(|said| CODES.contains(&said.code)) {
        let span = said.primary.span;
        let advice = advice(&sources.get(span.source).text, span.start, span.end);
        // The keys of a block do not help with half a number.
        if advice.is_some() && said.code == "bare-argument" {
            said.help.clear();
        }
        said.help.extend(advice);
    }
}

fn advice(text: &str, start: usize, end: usize) -> Option<String> {
    if text[..start].ends_with("\\\"") {
        return Some("a text has no escapes; single quotes are letters of it: \"python3 'my av.py'\"".into());
    }
    let sign = match text.get(start..)?.chars().next()? {
        '“' | '”' | '„' | '‟' | '«' | '»' | '‘' | '’' | '‚' => {
            "texts stand in straight double quotes: `\"`"
        }
        '−' | '–' | '—' => "a minus sign is the hyphen `-`",
        '…' => "a range is written with two points: `7 m .. 40 m`",
        '×' | '·' => "a product is written with `*`",
        _ => return with_comma(text, [start, start.wrapping_sub(1), end]),
    };
    Some(sign.into())
}

/// Advice on a number whose decimal comma is at one of these bytes.
fn with_comma(text: &str, places: [usize; 3]) -> Option<String> {
    let is_digit = |at: usize| text.as_bytes().get(at).is_some_and(u8::is_ascii_digit);
    let is_comma =
        |at: &usize| text.as_bytes().get(*at) == Some(&b',') && is_digit(at.wrapping_sub(1)) && is_digit(*at + 1);
    let comma = places.into_iter().find(is_comma)?;
    let digits = |byte: &u8| byte.is_ascii_digit();
    let first = comma - text.as_bytes()[..comma].iter().rev().take_while(|byte| digits(byte)).count();
    let last = comma + 1 + text.as_bytes()[comma + 1..].iter().take_while(|byte| digits(byte)).count();
    let number = &text[first..last];
    let decimal = number.replace(',', ".");
    let (whole, rest) = number.split_once(',')?;
    if rest.len() == 3 && whole.len() <= 3 && !whole.starts_with('0') {
        let thousands = number.replace(',', "_");
        return Some(format!(
            "if `{number}` is one number, write `{thousands}` for thousands, or `{decimal}` for a decimal"
        ));
    }
    Some(format!("a decimal needs a point: if `{number}` is one number, write `{decimal}`"))
}

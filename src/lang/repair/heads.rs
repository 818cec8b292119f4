//! What stands before a value: names of parameters and keys.

use std::ops::Range;

use crate::lang::params::DIMENSIONS;
use crate::units::parse_unit;

/// The end of a line that is the head of a declaration without its brace, behind the last word: a colon, perhaps, or nothing.
pub(in crate::lang) fn unbraced(line: &str) -> Option<Range<usize>> {
    let head = line.split("//").next()?.trim_end();
    let named = head.strip_suffix(':').map_or(head, str::trim_end);
    let fine = (2..=4).contains(&named.split_whitespace().count()) && !named.contains(['{', '}', '"', ':']);
    let declares = !["edition", "import", "param", "on"].contains(&named.split_whitespace().next()?);
    (fine && declares).then_some(named.len()..head.len())
}

/// The same of a statement without any brace, when `behind` goes on with an indented line.
pub(in crate::lang) fn headless(statement: &str, behind: &str) -> Option<Range<usize>> {
    let skipped = statement.len() - statement.trim_start().len();
    let documented: usize =
        statement.split_inclusive('\n').take_while(|line| line.trim_start().starts_with("//")).map(str::len).sum();
    let start = skipped.max(documented);
    let line = statement[start..].trim_end();
    let next = behind
        .split(['\n', '\r'])
        .map(|line| line.split("//").next().unwrap_or_default())
        .find(|line| !line.trim().is_empty())?;
    let holds = next.starts_with([' ', '\t']) && next.contains([':', '{', '=']);
    let place = unbraced(line).filter(|_| holds && !line.contains('\n'))?;
    Some(start + place.start..start + place.end)
}

/// Whether a statement was meant to import something.
pub(in crate::lang) fn imports(statement: &str) -> bool {
    let mut lines = statement.lines().map(str::trim_start).filter(|line| !line.is_empty() && !line.starts_with("//"));
    let word = lines.next().and_then(|line| line.split(|c: char| !c.is_ascii_alphabetic()).next()).unwrap_or_default();
    ["import", "include", "from", "using"].contains(&word.to_lowercase().as_str())
}

/// A parameter without a type: where its name stands, or what stands in place of `param` as well, what would be written there,
/// and the word for the type that its value has.
pub(in crate::lang) fn untyped_param(text: &str) -> Option<(Range<usize>, String, Option<&'static str>)> {
    let (word, rest) = text.split_at(text.find(|c: char| !c.is_ascii_alphabetic())?);
    let own = ["param", "parameter", "let", "var", "const"].contains(&word);
    let name = rest.trim_start();
    let start = text.len() - name.len();
    let length = name.bytes().take_while(|byte| *byte == b'_' || byte.is_ascii_alphanumeric()).count();
    let value = name[length..].trim_start().strip_prefix('=')?.trim();
    if !own || length == 0 || start == word.len() || value.starts_with('=') {
        return None;
    }
    let name = &name[..length];
    let place = if word == "param" { start..start + length } else { 0..start + length };
    let instead = if word == "param" { name.to_string() } else { format!("param {name}") };
    Some((place, instead, type_of(value)))
}

/// The word for the type of a value, as far as one look at its text tells.
pub(in crate::lang) fn type_of(value: &str) -> Option<&'static str> {
    let number =
        value.trim_start_matches('-').bytes().take_while(|byte| byte.is_ascii_digit() || *byte == b'.').count();
    let unit = value.trim_start_matches('-')[number..].split_whitespace().next();
    match unit {
        _ if value == "true" || value == "false" => Some("boolean"),
        _ if value.starts_with('"') => Some("text"),
        _ if number == 0 => None,
        None => Some("number"),
        Some(unit) => parse_unit(unit).ok().and_then(|unit| {
            DIMENSIONS.iter().find(|(_, dimension)| *dimension == unit.dimension).map(|(name, _)| *name)
        }),
    }
}

/// The words with points between them before a colon: no key, but what leads to one from outside.
pub(in crate::lang) fn dotted_key(text: &str) -> Option<&str> {
    let is_part = |c: char| c == '_' || c.is_ascii_alphanumeric();
    let path = &text[..text.find(|c: char| !is_part(c) && c != '.').unwrap_or(text.len())];
    let words = path.split('.').filter(|word| word.starts_with(|c: char| c.is_ascii_alphabetic())).count();
    let named = words > 1 && words == path.split('.').count();
    (named && text[path.len()..].trim_start().starts_with(':')).then_some(path)
}

/// The sign with which the value of the line above ends, when the key of this line was taken for what it lacks: `before` ends with
/// that key, and `text` goes on with the colon behind it.
pub(in crate::lang) fn open_end(before: &str, text: &str) -> Option<Range<usize>> {
    let (above, key) = before.rsplit_once('\n')?;
    let is_part = |c: char| c == '_' || c.is_ascii_alphanumeric();
    let value = above.lines().next_back()?.split("//").next()?.trim_end();
    let line = above.len() - above.lines().next_back()?.len();
    let sign = ["..", "+", "-", "*", "/", "<=", ">=", "<", ">"].into_iter().find(|sign| value.ends_with(sign))?;
    let alone = !key.trim().is_empty() && key.trim().chars().all(is_part) && text.starts_with(':');
    let end = line + value.len();
    alone.then_some(end - sign.len()..end)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_without_its_end_is_told_of_on_its_line() {
        for (before, sign) in [("a: 1 m..\n  b", ".."), ("a: 1\na: 2 * // twice\n b ", "*")] {
            let place = open_end(before, ": 3").expect("the line above goes on");
            assert_eq!(&before[place], sign);
        }
        assert_eq!(open_end("a: 1 m\n  b", ": 3"), None);
        assert_eq!(open_end("a: 1 m ..\n  b", " 3"), None);
        assert_eq!(open_end("a: 1 m .. b", ": 3"), None);
    }
}

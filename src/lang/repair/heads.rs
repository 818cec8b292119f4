//! What stands before a value: names of parameters and keys.

use std::ops::Range;

use crate::lang::params::{DIMENSIONS, OTHER_TYPES};
use crate::units::parse_unit;

/// The end of a line that is the head of a declaration without its brace, behind the last word: a colon, perhaps, or nothing.
pub(in crate::internal::lang) fn unbraced(line: &str) -> Option<Range<usize>> {
    let head = line.split("//").next()?.trim_end();
    let named = head.strip_suffix(':').map_or(head, str::trim_end);
    let fine = (2..=4).contains(&named.split_whitespace().count()) && !named.contains(['{', '}', '"', ':']);
    let declares = !["edition", "import", "param", "on"].contains(&named.split_whitespace().next()?);
    (fine && declares).then_some(named.len()..head.len())
}

/// The same of a statement without any brace, when `behind` goes on with an indented line.
pub(in crate::internal::lang) fn headless(statement: &str, behind: &str) -> Option<Range<usize>> {
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
pub(in crate::internal::lang) fn imports(statement: &str) -> bool {
    let mut lines = statement.lines().map(str::trim_start).filter(|line| !line.is_empty() && !line.starts_with("//"));
    let word = lines.next().and_then(|line| line.split(|c: char| !c.is_ascii_alphabetic()).next()).unwrap_or_default();
    ["import", "include", "from", "using"].contains(&word.to_lowercase().as_str())
}

/// A parameter without a type: where its name stands, or what stands in place of `param` as well, what would be written there,
/// and the word for the type that its value has.
pub(in crate::internal::lang) fn untyped_param(text: &str) -> Option<(Range<usize>, String, Option<&'static str>)> {
    let (word, rest) = text.split_at(text.find(|c: char| !c.is_ascii_alphabetic())?);
    if let Some(found) = typed_first(text) {
        return Some(found);
    }
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

/// A parameter whose type stands before its name, or that has no word before it at all.
fn typed_first(text: &str) -> Option<(Range<usize>, String, Option<&'static str>)> {
    let (head, value) = text.split_once('=')?;
    let words: Vec<&str> = head.split_whitespace().collect();
    let of = |word: &str| {
        let known = DIMENSIONS.iter().map(|(name, _)| *name).chain(OTHER_TYPES.iter().copied());
        known.into_iter().find(|name| *name == word)
    };
    let (name, ty) = match words.as_slice() {
        [name] => (*name, type_of(value.trim())?),
        ["param", ty, name] | [ty, name] => (*name, of(ty)?),
        _ => return None,
    };
    let named = name.starts_with(|first: char| first.is_ascii_alphabetic())
        && name.bytes().all(|byte| byte == b'_' || byte.is_ascii_alphanumeric());
    (named && !value.starts_with(['=', '>'])).then(|| (0..head.trim_end().len(), format!("param {name}"), Some(ty)))
}

/// What is wrong with the words before a brace or a colon that are no head and, in a block, no key: their place, what to say,
/// and what would be written there.
pub(in crate::internal::lang) fn split_words(
    text: &str,
    in_block: bool,
) -> Option<(Range<usize>, &'static str, Option<String>)> {
    let end = text.find(|c: char| !(c == '_' || c == '-' || c == ' ' || c.is_ascii_alphanumeric()))?;
    let head = text[..end].trim_end();
    let words: Vec<&str> = head.split(' ').filter(|word| !word.is_empty()).collect();
    let at = |word: &str| word.as_ptr() as usize - text.as_ptr() as usize;
    match (text[end..].chars().next()?, words.as_slice()) {
        ('{', [_, name]) if name.starts_with(|first: char| first.is_ascii_digit()) => {
            Some((at(name)..at(name) + name.len(), "a name starts with a letter", None))
        }
        ('{', [_, first, .., last]) => {
            let place = at(first)..at(last) + last.len();
            let one = text[place.clone()].split(' ').filter(|part| !part.is_empty()).collect::<Vec<_>>().join("_");
            Some((place, "a name is one word", Some(one)))
        }
        (':', ["param", _]) if !in_block => {
            // The head of a parameter: `param name: type: value`, or without a value.
            let rest = &text[end + 1..];
            let second = rest.find([':', '=', '\n']).filter(|at| rest[*at..].starts_with(':'));
            let (place, meant) = match second {
                Some(at) => (end + 1 + at..end + 2 + at, Some(" =".to_string())),
                None => (text.trim_end().len()..text.trim_end().len(), None),
            };
            Some((place, "the value of a parameter stands behind `=`", meant))
        }
        (':', words) if in_block && (words.len() == 2 || head.contains('-')) => {
            let joins = |word: &&str| ["on", "as", "and", "or", "in", "is", "if", "for", "to", "not"].contains(word);
            let named = head.starts_with(|first: char| first.is_ascii_alphabetic());
            (named && !words.iter().any(joins))
                .then(|| (0..head.len(), "a key is one word", Some(head.replace([' ', '-'], "_"))))
        }
        _ => None,
    }
}

/// The sign or word at the end of a statement behind which something is missing.
pub(in crate::internal::lang) fn ends_open(text: &str) -> Option<Range<usize>> {
    let value = text.trim_end();
    let signs = ["..", "+", "-", "*", "/", "<=", ">=", "<", ">", " and", " or", " not", "=>", ":"];
    let sign = signs.into_iter().find(|sign| value.ends_with(sign))?.trim_start();
    (value.len() > sign.len()).then(|| value.len() - sign.len()..value.len())
}

/// The word for the type of a value, as far as one look at its text tells.
pub(in crate::internal::lang) fn type_of(value: &str) -> Option<&'static str> {
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
pub(in crate::internal::lang) fn dotted_key(text: &str) -> Option<&str> {
    let is_part = |c: char| c == '_' || c.is_ascii_alphanumeric();
    let path = &text[..text.find(|c: char| !is_part(c) && c != '.').unwrap_or(text.len())];
    let words = path.split('.').filter(|word| word.starts_with(|c: char| c.is_ascii_alphabetic())).count();
    let named = words > 1 && words == path.split('.').count();
    (named && text[path.len()..].trim_start().starts_with(':')).then_some(path)
}

/// The sign with which the value of the line above ends, when the key of this line was taken for what it lacks: `before` ends with
/// that key, and `text` goes on with the colon behind it.
pub(in crate::internal::lang) fn open_end(before: &str, text: &str) -> Option<Range<usize>> {
    /// Most blank lines and comments between.
    const MOST: usize = 100;
    let (above, key) = before.rsplit_once('\n').filter(|_| text.starts_with(':'))?;
    let is_part = |c: char| c == '_' || c.is_ascii_alphanumeric();
    let code = |line: &'_ str| line.split("//").next().unwrap_or_default().trim_end().len();
    let line = above.rsplit('\n').take(MOST).find(|line| code(line) > 0)?;
    let start = line.as_ptr() as usize - before.as_ptr() as usize;
    let value = &line[..code(line)];
    let signs = ["..", "+", "-", "*", "/", "<=", ">=", "<", ">", " and", " or", " not"];
    let sign = signs.into_iter().find(|sign| value.ends_with(sign))?.trim_start();
    let alone = !key.trim().is_empty() && key.trim().chars().all(is_part);
    let end = start + value.len();
    alone.then_some(end - sign.len()..end)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_without_its_end_is_told_of_on_its_line() {
        for (before, sign) in [
            ("a: 1 m..\n  b", ".."),
            ("a: 1\na: 2 * // twice\n b ", "*"),
            ("a: 1 m ..\r\n\r\n  // next\n\n  b", ".."),
            ("a: 1 m < c and\n  b", "and"),
        ] {
            let place = open_end(before, ": 3").expect("the line above goes on");
            assert_eq!(&before[place], sign);
        }
        assert_eq!(open_end("a: 1 m\n  b", ": 3"), None);
        assert_eq!(open_end("a: 1 m ..\n  b", " 3"), None);
        assert_eq!(open_end("a: 1 m .. b", ": 3"), None);
    }
}

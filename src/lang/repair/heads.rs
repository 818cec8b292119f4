//! What stands before a value: names of parameters and keys.

use std::ops::Range;

use crate::lang::params::DIMENSIONS;
use crate::units::parse_unit;

/// The name of a parameter without a type, and the word for the type that its value has.
pub(in crate::lang) fn untyped_param(text: &str) -> Option<(Range<usize>, Option<&'static str>)> {
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
pub(in crate::lang) fn dotted_key(text: &str) -> Option<&str> {
    let is_part = |c: char| c == '_' || c.is_ascii_alphanumeric();
    let path = &text[..text.find(|c: char| !is_part(c) && c != '.').unwrap_or(text.len())];
    let words = path.split('.').filter(|word| word.starts_with(|c: char| c.is_ascii_alphabetic())).count();
    let named = words > 1 && words == path.split('.').count();
    (named && text[path.len()..].trim_start().starts_with(':')).then_some(path)
}

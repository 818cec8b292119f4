//! Guesses at what is missing in a statement of no known shape: a repair is believed when the statement can be read with it.

/// Where commas may be missing: the ends of values inside parentheses and brackets that another value follows.
pub(super) fn missing_commas(text: &str) -> Vec<usize> {
    let bytes = text.as_bytes();
    let mut open: Vec<u8> = Vec::new();
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
        if let Some((end, number)) = value
            && (starts || bytes[at] == b'(' && !called)
            && !operator
            && matches!(open.last(), Some(b'(' | b'['))
        {
            // The word after a number is its unit, unless it is a key.
            let is_key = rest[length..].trim_start().starts_with(':');
            let is_unit = number && token.starts_with(|first: char| first.is_ascii_alphabetic()) && !is_key;
            if !is_unit {
                found.push(end);
            }
        }
        match bytes[at] {
            bracket @ (b'(' | b'[' | b'{') => open.push(bracket),
            b')' | b']' | b'}' => drop(open.pop()),
            _ => {}
        }
        let ends = starts && !operator && bytes[at] != b'[' || matches!(bytes[at], b')' | b']');
        called = token.starts_with(|first: char| first.is_ascii_alphabetic() || first == '_');
        value = ends.then_some((at + length, bytes[at].is_ascii_digit()));
        at += length;
    }
    found
}

/// Where the sign stands in `key = value`, which is written `key: value` inside braces.
pub(super) fn equals_sign(text: &str) -> Option<usize> {
    let name = text.bytes().take_while(|byte| byte.is_ascii_alphanumeric() || *byte == b'_').count();
    let sign = name + (text[name..].len() - text[name..].trim_start().len());
    (name > 0 && text[sign..].starts_with('=') && !text[sign..].starts_with("=>")).then_some(sign)
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
    fn a_sign_of_equality_stands_behind_a_key() {
        assert_eq!(equals_sign("ticks = 600"), Some(6));
        assert_eq!(equals_sign("on hit => 1"), None);
        assert_eq!(equals_sign("= 1"), None);
    }
}

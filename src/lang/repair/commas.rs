//! Commas that are missing, and such as stand where other languages have them.

/// Words that join others: beside them nothing is told of a list.
const JOINING: &[&str] =
    &["between", "if", "else", "then", "is", "when", "where", "as", "at", "of", "with", "for", "than"];

/// Where commas may be missing: the ends of values inside parentheses and brackets that another value follows.
pub(in crate::internal::lang) fn missing_commas(text: &str) -> Vec<usize> {
    let bytes = text.as_bytes();
    let mut open: Vec<u8> = Vec::new();
    // Whether parentheses hold values alone, and no arguments.
    let mut groups: Vec<bool> = Vec::new();
    let mut found = Vec::new();
    // The end of the last token, when it may end a value, and whether it is a number.
    let mut value: Option<(usize, bool)> = None;
    // Whether the last token is a name, which parentheses may follow.
    let mut called = false;
    // The first byte of the last token; whether that is a word in the place of a key, which may be a part of one.
    let (mut last, mut alone) = (None, false);
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
        let is_key = rest[length..].trim_start().starts_with(':');
        if JOINING.contains(&token) && !is_key && !open.is_empty() || is_key && alone {
            // A sentence, or a key of two words.
            return Vec::new();
        }
        let grouped = groups.last() == Some(&true);
        if let Some((end, number)) = value
            && (starts || bytes[at] == b'(' && !called)
            && !operator
            && matches!(open.last(), Some(b'(' | b'['))
        {
            // The word after a number is its unit, unless it is a key.
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
        let begins = matches!(last, Some(b'(' | b',')) && open.last() == Some(&b'(') && groups.last() == Some(&false);
        alone = begins && word > 0 && !is_key && !token.starts_with(|first: char| first.is_ascii_digit());
        last = Some(bytes[at]);
        called = token.starts_with(|first: char| first.is_ascii_alphabetic() || first == '_');
        value = ends.then_some((at + length, bytes[at].is_ascii_digit()));
        at += length;
    }
    found
}

/// Values side by side, of which `text` begins with one behind a comma: how many bytes stand before and behind.
pub(in crate::internal::lang) fn unbracketed(before: &str, text: &str) -> Option<(usize, usize)> {
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
    // Comparisons and sums of such.
    let value = |text: &str| {
        let mut end = value(text);
        loop {
            let rest = text[end..].trim_start_matches(' ');
            let sign =
                rest.bytes().take_while(|byte| matches!(byte, b'<' | b'>' | b'=' | b'+' | b'-' | b'*' | b'/')).count();
            let word = ["and ", "or ", "in "].into_iter().find(|word| rest.starts_with(word)).map_or(sign, str::len);
            let next = rest[word..].trim_start_matches(' ');
            let more = value(next);
            if end == 0 || word == 0 || more == 0 || rest.starts_with("=") {
                return end;
            }
            end = text.len() - next.len() + more;
        }
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

/// A number written with commas, of which `text` begins with the digits behind the first: how many bytes stand before and behind.
pub(in crate::internal::lang) fn decimal_comma(before: &str, text: &str) -> Option<(usize, usize)> {
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
    fn a_comma_may_stand_in_a_number() {
        assert_eq!(decimal_comma("gamma: 0,", "95, steps"), Some((2, 2)));
        assert_eq!(decimal_comma("gamma: 0, ", "95"), None);
        assert_eq!(decimal_comma("(a, ", "b"), None);
    }

    #[test]
    fn what_stands_side_by_side_ends_where_its_values_do() {
        let listed = |before: &str, text: &str| {
            unbracketed(before, text).map(|(back, on)| format!("{}{}", &before[before.len() - back..], &text[..on]))
        };
        assert_eq!(listed("hidden: 64, ", "64 steps: 3").as_deref(), Some("64, 64"));
        assert_eq!(
            listed("require: aside < 5 m, ", "distance > 8 m\n}").as_deref(),
            Some("aside < 5 m, distance > 8 m")
        );
        assert_eq!(listed("towns: a, ", "b: 3"), None);
    }
}

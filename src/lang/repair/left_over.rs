//! What stands behind a value on its line and cannot be read with it.

use super::slips::{Slip, compares};
use crate::units::parse_unit;

/// What is wrong with a text behind a value: `before` is the line up to it, and places count from the beginning of the line.
pub(in crate::internal::lang) fn left_over(before: &str, text: &str, in_block: bool) -> Option<Slip> {
    let start = before.len();
    let value = before.trim_end();
    let part = |c: char| c == '_' || c.is_ascii_alphanumeric();
    let (word, behind) = text.split_at(text.find(|c: char| !part(c)).unwrap_or(text.len()));
    let last = value.rsplit(|c: char| !part(c)).next().unwrap_or_default();
    let named = last.starts_with(|c: char| c.is_ascii_alphabetic());
    let blank = behind.trim().is_empty();
    let is_unit = |text: &str| !text.is_empty() && parse_unit(text).is_ok();
    let slip = |place, instead: String, meant, said| Some(Slip { place, instead, meant, said, foreign: true });
    let (at_word, all) = (start..start + word.len(), start..start + text.len());
    if matches!(word, "as" | "to") && is_unit(behind.trim()) {
        return slip(at_word, "in".into(), true, "write `in` before the unit");
    }
    if matches!(word, "and" | "or" | "not") && blank {
        return slip(at_word, String::new(), false, "a value is missing after this");
    }
    if let Some(sign) = compares(word).filter(|_| !blank) {
        return slip(at_word, sign.into(), true, "quantities are compared by signs");
    }
    if in_block && named && is_unit(text.trim_matches([' ', '\t', '\r', '\n'])) {
        let said = "a unit follows a number; write `in` to convert a quantity";
        return slip(all, format!("in {}", text.trim()), value.contains("=>"), said);
    }
    if let Some((low, high)) = text.split_once(" to ").filter(|_| last == "from") {
        let from = value.len() - last.len()..start + text.len();
        return slip(from, format!("{low} .. {high}"), true, "a range is written `low .. high`");
    }
    if value.trim_start().starts_with("import ") && value.ends_with('"') {
        let said = "an import ends with its path; names stand before it: `import a, b from \"path\"`";
        return slip(all, String::new(), false, said);
    }
    if value.ends_with(',') && text.starts_with('(') {
        let comma = value.len() - 1..value.len();
        return slip(comma, String::new(), false, "several values need brackets: `[(…), (…)]`");
    }
    let keyed = text.find(':').is_some_and(|colon| text[..colon].trim_end().chars().all(part));
    if !in_block && keyed && value.contains('=') && !last.is_empty() {
        let kind = value.len() - last.len()..start + text.len();
        let call = format!("{last}({})", text.trim_end_matches(','));
        return slip(kind, call, true, "what a kind takes stands in parentheses");
    }
    if last == "return" {
        return slip(value.len() - last.len()..start, String::new(), true, "a formula stands alone");
    }
    let unit = text.find(|c: char| !(c.is_ascii_alphanumeric() || "/^*".contains(c))).unwrap_or(text.len());
    if value.ends_with([')', ']']) && parse_unit(&text[..unit]).is_ok() {
        return slip(start..start + unit, String::new(), false, "the unit stands behind every number");
    }
    let stray = in_block && !last.is_empty() && blank && !word.is_empty();
    stray.then(|| slip(at_word, String::new(), false, "this does not belong to the value before it")).flatten()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_stands_behind_a_value_is_taken_for_what_was_meant() {
        for (before, text, meant) in [
            ("on hit => v_c ", "as m/s", "on hit => v_c in m/s"),
            ("on hit => v_c ", "m/s", "on hit => v_c in m/s"),
            ("require: distance ", "gt 8 m", "require: distance > 8 m"),
            ("distance: from ", "8 m to 25 m", "distance: 8 m .. 25 m"),
            ("vehicle v = generic ", "length: 4.9 m", "vehicle v = generic(length: 4.9 m)"),
            ("on hit => return ", "1", "on hit => 1"),
        ] {
            let slip = left_over(before, text, !before.starts_with("vehicle")).expect(text);
            let mut line = format!("{before}{text}");
            line.replace_range(slip.place, &slip.instead);
            assert!(slip.meant);
            assert_eq!(line, meant);
        }
        for (before, text, place) in [
            ("sight: visible ", "hidden", 15..21),
            ("require: a > b ", "and", 15..18),
            ("import \"a.scn\" ", "as b", 15..19),
            ("at: (1 m, 2 m), ", "(3 m, 4 m)", 14..15),
            ("at: (1, 2) ", "m", 11..12),
        ] {
            let slip = left_over(before, text, true).expect(text);
            assert!(!slip.meant);
            assert_eq!(slip.place, place, "{text}");
        }
        assert!(left_over("gamma: 0.9 ", "+ 1", true).is_none());
    }
}

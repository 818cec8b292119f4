use serde::Serialize;

/// Text between tags or within a quoted attribute of HTML or SVG: whatever a name holds, it stays text.
pub fn escape(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => safe.push_str("&amp;"),
            '<' => safe.push_str("&lt;"),
            '>' => safe.push_str("&gt;"),
            '"' => safe.push_str("&quot;"),
            '\'' => safe.push_str("&#39;"),
            // No document may hold these, not even by their numbers.
            c if c.is_control() && !matches!(c, '\n' | '\t') => safe.push('\u{fffd}'),
            c => safe.push(c),
        }
    }
    safe
}

/// JSON that may stand within `<script type="application/json">`: no text of it ends the element or begins a comment.
pub fn json(value: &impl Serialize) -> String {
    let text = serde_json::to_string(value).expect("structs of strings and numbers have a form in JSON");
    text.replace('<', "\\u003c").replace('>', "\\u003e").replace('&', "\\u0026")
}

/// A name that can be a part of an `id` or a file's name: letters and digits stay, all else is a dash and a number.
pub fn slug(text: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    text.chars().map(|c| if plain(c) { c.to_string() } else { format!("-{:x}", u32::from(c)) }).collect()
}

/// A share as a percentage: whole, but for small ones.
pub fn percent(share: f64) -> String {
    let hundred = share * 100.0;
    if hundred > 0.0 && hundred < 9.95 { format!("{hundred:.1}\u{a0}%") } else { format!("{hundred:.0}\u{a0}%") }
}

/// A whole number with thin spaces between the thousands.
pub fn count(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            text.push('\u{202f}');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_breaks_out_of_its_place() {
        let evil = "</script><img src=x onerror='alert(1)'>\"&\u{8}";
        let safe = escape(evil);
        assert!(!safe.contains(['<', '>', '"', '\'', '\u{8}']), "{safe}");
        let safe = json(&[evil]);
        assert!(!safe.contains(['<', '>', '&']), "{safe}");
        let back: Vec<String> = serde_json::from_str(&safe).unwrap();
        assert_eq!(back, [evil]);
        assert_eq!(slug("a b/ü"), "a-20b-2f-fc");
    }

    #[test]
    fn numbers_are_for_people() {
        assert_eq!(
            [0.0, 0.004, 0.0994, 0.0996, 0.844, 1.0].map(percent),
            ["0", "0.4", "9.9", "10", "84", "100"].map(|number| format!("{number}\u{a0}%"))
        );
        assert_eq!([7, 1234, 1_000_000].map(count), ["7", "1\u{202f}234", "1\u{202f}000\u{202f}000"]);
    }
}

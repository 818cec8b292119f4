use maud::{Markup, html};
use serde::Serialize;

/// JSON for the content of `<script type="application/json">`: no text in it ends the element or starts a comment.
pub fn json(value: &impl Serialize) -> String {
    let text = serde_json::to_string(value).expect("structs of strings and numbers have a form in JSON");
    text.replace('<', "\\u003c").replace('>', "\\u003e").replace('&', "\\u0026")
}

/// A paragraph or a list in the program's Markdown, with code, stress and emphasis.
pub fn paragraph(text: &str) -> Markup {
    html! {
        @if text.starts_with("- ") {
            ul { @for line in text.lines() { li { (prose(line.trim_start_matches("- "))) } } }
        } @else {
            p { (prose(text)) }
        }
    }
}

/// A text with inline Markdown: `` `code` ``, `**stress**`, `*emphasis*`. Marks that are not closed stay as they are.
pub fn prose(text: &str) -> Markup {
    let marked = [("`", 0), ("**", 1), ("*", 2)].into_iter().filter_map(|(mark, kind)| {
        let from = text.find(mark)?;
        let inner = from + mark.len();
        let length = text[inner..].find(mark).filter(|length| *length > 0)?;
        let spaced = text[inner..].starts_with(' ') && mark != "`";
        (!spaced).then_some((from, mark.len(), inner, inner + length, kind))
    });
    let Some((from, mark, inner, end, kind)) = marked.min_by_key(|found| (found.0, found.4)) else {
        return html! { (text) };
    };
    html! {
        (text[..from])
        @match kind {
            0 => code { (text[inner..end]) },
            1 => strong { (prose(&text[inner..end])) },
            _ => em { (prose(&text[inner..end])) },
        }
        (prose(&text[end + mark..]))
    }
}

/// A share as a percentage: a whole number, except for small shares.
pub fn percent(share: f64) -> String {
    let hundred = share * 100.0;
    let digits = match hundred {
        0.0 => 0,
        _ if hundred < 0.095 => 3,
        _ if hundred < 9.95 => 1,
        _ => 0,
    };
    format!("{hundred:.digits$}\u{a0}%")
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
        let safe = prose(evil).into_string();
        assert!(!safe.contains(['<', '>', '"']), "{safe}");
        let safe = html! { p title=(evil) {} }.into_string();
        assert_eq!(safe.matches(['<', '>']).count(), 4, "{safe}");
        let safe = json(&[evil]);
        assert!(!safe.contains(['<', '>', '&']), "{safe}");
        let back: Vec<String> = serde_json::from_str(&safe).unwrap();
        assert_eq!(back, [evil]);
    }

    #[test]
    fn marks_within_a_line_become_elements() {
        let html = |text: &str| prose(text).into_string();
        assert_eq!(html("**a `b*`** *c*"), "<strong>a <code>b*</code></strong> <em>c</em>");
        assert_eq!(html("2 * 3 and 4 ** 5, `open"), "2 * 3 and 4 ** 5, `open");
        assert_eq!(paragraph("- a\n- *b*").into_string(), "<ul><li>a</li><li><em>b</em></li></ul>");
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

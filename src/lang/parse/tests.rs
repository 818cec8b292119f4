use super::*;
use crate::diagnostic::Sources;
use proptest::prelude::*;

/// Lines of which scenarios are made, and some that make one statement of two or none of one.
const LINES: &[&str] = &[
    "",
    "  ",
    "/// Far.",
    "/// Near.  ",
    "// No.",
    "/* so",
    "and so */ param d: length = 3 m",
    "edition 1",
    "import \"a.scn\"",
    "import b,",
    "import c",
    "from \"b.scn\"",
    "param a: length = 3 m",
    "param b: length =",
    "param c: boolean = x",
    "3 m",
    "+ 4 m",
    "and y",
    "or not",
    "z",
    "in m/s",
    ".. 5 m",
    "policy p = idm()",
    "policy q",
    "= idm",
    "(gap: 1 m)",
    "policy",
    "r = idm() // So.",
    "spawn s {",
    "spawn t {}",
    "bearing: 3 deg",
    "require: [a,",
    "b]",
    "}",
    "  /// In.",
    "on hit => 1",
    "u: 1  spawn v {} /// Late.",
    "{ }",
    "param e: text = \"f",
    "\"",
    "param",
    "on",
    "\r",
];

/// Lines that are whole by themselves.
const WHOLE: &[&str] =
    &["", "/// Far.", "// No.", "import \"a.scn\"", "param a: length = 3 m", "policy p = idm()", "spawn t {}"];

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    /// However a text is laid out: where nothing is wrong with its parts, they are what the whole is.
    #[test]
    fn parts_without_mistakes_make_the_whole(lines in prop::collection::vec(prop_oneof![3 => prop::sample::select(WHOLE), 1 => prop::sample::select(LINES)], 1..9)) {
        let text = lines.join("\n");
        let source = Sources::default().add("", text.as_str());
        if let Ok(starts) = brackets::scan(source, &text) {
            let (in_parts, said) = read_parts(source, &text, parts(&starts, text.len(), 0));
            if said.is_empty() {
                prop_assert_eq!((in_parts, said), read_parts(source, &text, std::iter::once(0..text.len())), "{}", text);
            }
        }
    }
}

#[test]
fn a_long_text_is_read_in_parts_that_begin_with_statements() {
    let statement = "/// A driver.\n// Brakes.\n\npolicy p = idm()\n";
    let text = format!("edition 1\n{}", statement.repeat(100));
    let starts = brackets::scan(Sources::default().add("", ""), &text).unwrap();
    let parts = parts(&starts, text.len(), LEAST_PART);
    assert!(parts.len() > 3 && parts.iter().skip(1).all(|part| text[part.clone()].starts_with("/// A driver.")));
    assert!(parts.windows(2).all(|pair| pair[0].end == pair[1].start && pair[0].len() >= LEAST_PART));
}

#[test]
fn plain_quantities_are_what_the_grammar_makes_of_them() {
    let read = |text: &str| {
        let source = Sources::default().add("", text);
        let plain = plain_quantity(source, text).is_some();
        (plain, parse_value(source, text).ok(), parse_any_value(source, text).ok())
    };
    for text in ["5", "0.98", "3 m", "0.25 deg", "600", "12.5 kg"] {
        let (plain, value, any) = read(text);
        assert!(plain && value.is_some() && value == any, "{text}: {value:?}, {any:?}");
    }
    for text in
        ["", "-5 m", "5.", ".5", "5 and", "5  m", "5 m ", "2 m/s^2", "1_000", "1e3", "5 parsecs", "5 m^+2", "true"]
    {
        let (plain, value, any) = read(text);
        assert!(!plain && value == any, "{text}: {value:?}, {any:?}");
    }
}

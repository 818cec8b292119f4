use super::*;
use crate::tokens::{self, TokenKind};
use base::diagnostic::Sources;
use proptest::prelude::*;

/// Lines of scenarios, and some that join two statements or split one.
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
    "driver p = idm()",
    "driver q",
    "= idm",
    "(gap: 1 m)",
    "driver",
    "r = idm() // So.",
    "spawn s {",
    "spawn t {}",
    "bearing: 3 deg",
    "require: [a,",
    "b]",
    "}",
    "  /// In.",
    "on touch => 1",
    "u: 1  spawn v {} /// Late.",
    "{ }",
    "param e: text = \"f",
    "\"",
    "param",
    "on",
    "\r",
    "requirement r = always(a.gap > 1 m or not gap(a, b) < b.c)",
    "reward r { on touch => -a in m/s^2 / 2e-3 + 7..30 }",
    "town t { a: 7m b: 2 kg*m^-2/s c { x: 1_0.5 e: 3e } } // no",
    "requirement r = always(gap > 1 m) implies a < 3 m/s { priority: 1 }\nrequirement { a: 7 m { } }",
    "vehicle v = kind(a: not (b) and -1 /* so */ m, c: 3 /* x */)",
];

/// The leaves of a parse that are tokens, with their kinds; `None` if the text holds a syntax error.
fn leaves(text: &str) -> Option<Vec<(TokenKind, usize, usize)>> {
    let (_, said) = read(Sources::default().add("", text), text);
    if said.iter().any(|each| each.code == "syntax") {
        return None;
    }
    let mut found = Vec::new();
    for pair in ScenarioParser::parse(Rule::file, text).ok()?.flatten() {
        let kind = match pair.as_rule() {
            Rule::junk_item | Rule::junk_entry => return None,
            Rule::name | Rule::signal | Rule::from_word | Rule::param_word | Rule::requirement_word => TokenKind::Name,
            Rule::number => TokenKind::Number,
            Rule::unit => TokenKind::Unit,
            Rule::text => TokenKind::Text,
            Rule::doc => TokenKind::Doc,
            Rule::edition_word | Rule::import_word | Rule::on_word => TokenKind::Keyword,
            _ => continue,
        };
        found.push((kind, pair.as_span().start(), pair.as_span().end()));
    }
    Some(found)
}

/// The same from the tokens. Words between the leaves are keywords of expressions.
fn as_leaves(text: &str) -> Vec<(TokenKind, usize, usize)> {
    use TokenKind::{Doc, Keyword, Name, Number, Text, Unit};
    let is_leaf = |token: &tokens::Token| match token.kind {
        Keyword => !["in", "and", "or", "not", "implies"].contains(&token.text(text)),
        kind => matches!(kind, Doc | Name | Number | Text | Unit),
    };
    tokens::tokens(text).filter(is_leaf).map(|token| (token.kind, token.start, token.end)).collect()
}

fn joined(text: &str) -> String {
    tokens::tokens(text).map(|token| token.text(text)).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    /// The tokens of any text cover all of it.
    #[test]
    fn tokens_give_the_text_back(text in "[ \\t\\r\\na-eimnos0-9_./*\"{}()\\[\\]=<>+:,;^°“#-]{0,60}") {
        prop_assert_eq!(joined(&text), text);
    }

    /// In any layout: if the text parses, its tokens are the leaves of the grammar.
    #[test]
    fn tokens_are_the_leaves_of_the_grammar(lines in prop::collection::vec(prop::sample::select(LINES), 1..6)) {
        let text = lines.join("\n");
        prop_assert_eq!(joined(&text), text.as_str());
        if let Some(leaves) = leaves(&text) {
            prop_assert_eq!(as_leaves(&text), leaves, "{}", text);
        }
    }
}

#[test]
fn tokens_are_the_leaves_of_every_scenario_and_section() {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let mut read = 0;
    for folder in ["scenarios", "scenarios/lib", "tests/suite", "tests/bench"] {
        for entry in std::fs::read_dir(root.join(folder)).unwrap() {
            let path = entry.unwrap().path();
            if path.extension().is_none_or(|end| end != "scn") {
                continue;
            }
            let text = std::fs::read_to_string(&path).unwrap();
            for section in text.split("//# ") {
                // The name of a section is its first line.
                let section = format!("//# {section}");
                assert_eq!(joined(&section), section, "{}", path.display());
                if let Some(leaves) = leaves(&section) {
                    assert_eq!(as_leaves(&section), leaves, "{}", path.display());
                    read += 1;
                }
            }
        }
    }
    assert!(read > 100, "only {read} sections were compared");
}

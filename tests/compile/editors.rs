//! The syntax colouring of editors knows the words of the language.

use base::units::UNIT_NAMES;
use compile::Catalog;
use lang::tokens::{KEYWORDS, TokenKind, tokens};
use lang::{functions, temporal_operators};
use regex::Regex;
use serde_json::Value;

fn grammar() -> Value {
    let path = crate::repository().join("grammar/falsify.tmLanguage.json");
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

/// The words between the parentheses of a rule of the form `\\b(a|b|c)\\b`.
fn words(rule: &str) -> Vec<String> {
    let grammar = grammar();
    let pattern = grammar["repository"][rule]["match"].as_str().unwrap_or_else(|| panic!("no rule {rule}")).to_string();
    let inner = pattern.split_once("(?:").unwrap().1.split_once(')').unwrap().0.to_string();
    let mut words: Vec<String> = inner.split('|').map(str::to_string).collect();
    words.sort();
    words
}

fn sorted<'a>(words: impl Iterator<Item = &'a str>) -> Vec<String> {
    let mut words: Vec<String> = words.map(str::to_string).collect();
    words.sort();
    words.dedup();
    words
}

#[test]
fn the_words_are_the_languages() {
    let catalog = Catalog::builtin();
    assert_eq!(words("form"), sorted(catalog.forms.iter().map(|form| form.name)));
    assert_eq!(words("kind"), sorted(catalog.forms.iter().flat_map(|form| &form.kinds).map(|kind| kind.name)));
    assert_eq!(words("function"), sorted(functions().chain(temporal_operators()).map(|(name, _)| name)));
    assert_eq!(words("variable"), sorted(catalog.vocabulary.variables.iter().map(|variable| variable.name)));
    assert_eq!(words("event"), sorted(catalog.vocabulary.events.iter().map(|event| event.name)));
    let units = words("unit");
    for (name, _) in UNIT_NAMES {
        assert!(units.iter().any(|unit| unit == name), "{name}");
    }
    assert_eq!(units.len(), UNIT_NAMES.len());
    let source = std::fs::read_to_string(crate::repository().join("grammar/lexical.pest")).unwrap();
    let keywords = source.lines().find(|line| line.starts_with("keyword ")).unwrap();
    assert_eq!(words("keyword"), sorted(keywords.split('"').skip(1).step_by(2)));
    assert_eq!(words("keyword"), sorted(KEYWORDS.into_iter()));
}

/// The pattern of a rule, or of one of its groups, for a whole token. Look-aheads at the text after the token are removed.
fn pattern(rule: &str, group: usize) -> Regex {
    let grammar = grammar();
    let mut pattern =
        grammar["repository"][rule]["match"].as_str().unwrap_or_else(|| panic!("no rule {rule}")).to_string();
    while let Some(start) = ["(?=", "(?!"].into_iter().filter_map(|ahead| pattern.find(ahead)).min() {
        let mut depth = 0;
        let end = pattern[start..].find(|c: char| {
            depth += i32::from(c == '(') - i32::from(c == ')');
            depth == 0
        });
        pattern.replace_range(start..=start + end.unwrap(), "");
    }
    let whole = Regex::new(&format!("^(?:{pattern})$")).unwrap();
    assert!(group < whole.captures_len(), "{rule} has no group {group}");
    whole
}

#[test]
fn colours_and_tokens_agree_on_every_file() {
    let root = crate::repository();
    let (quantity, conversion) = (pattern("quantity", 2), pattern("unit_conversion", 2));
    let rules = [
        (TokenKind::Doc, pattern("documentation", 0)),
        (TokenKind::LineComment, pattern("comment", 0)),
        (TokenKind::Text, pattern("text", 0)),
        (TokenKind::OpenText, pattern("text", 0)),
        (TokenKind::Keyword, pattern("keyword", 0)),
        (TokenKind::Name, pattern("key", 0)),
    ];
    let operator = pattern("operator", 0);
    let group = |pattern: &Regex, text: &str, group| {
        pattern.captures(text).and_then(|found| found.get(group)).map(|found| found.as_str().to_string())
    };
    let mut compared = 0;
    for folder in ["scenarios", "scenarios/lib", "tests/suite", "tests/bench"] {
        for entry in std::fs::read_dir(root.join(folder)).unwrap() {
            let path = entry.unwrap().path();
            if path.extension().is_none_or(|end| end != "scn") {
                continue;
            }
            let text = std::fs::read_to_string(&path).unwrap();
            for token in tokens(&text) {
                let written = token.text(&text);
                let coloured = match token.kind {
                    TokenKind::Number => group(&quantity, written, 1).as_deref() == Some(written),
                    TokenKind::Unit => {
                        group(&quantity, &format!("1 {written}"), 2).as_deref() == Some(written)
                            && group(&conversion, &format!("in {written}"), 2).as_deref() == Some(written)
                    }
                    // Separators have no colour.
                    TokenKind::Sign if !matches!(written, "," | ";" | ":") => operator.is_match(written),
                    kind => rules.iter().filter(|(of, _)| *of == kind).all(|(_, rule)| rule.is_match(written)),
                };
                assert!(coloured, "{}: {:?} `{written}`", path.display(), token.kind);
                // No token has the colour of another kind of token.
                let others = [TokenKind::Keyword, TokenKind::Text].into_iter().filter(|kind| *kind != token.kind);
                for (kind, rule) in others.flat_map(|other| rules.iter().filter(move |(kind, _)| *kind == other)) {
                    let open = token.kind == TokenKind::OpenText && *kind == TokenKind::Text;
                    assert!(open || !rule.is_match(written), "{}: `{written}` as {kind:?}", path.display());
                }
                compared += 1;
            }
        }
    }
    assert!(compared > 10_000, "only {compared} tokens were compared");
}

#[test]
fn every_rule_that_is_named_is_there() {
    fn named<'a>(value: &'a Value, found: &mut Vec<&'a str>) {
        match value {
            Value::Object(map) => map.iter().for_each(|(key, inner)| match (key.as_str(), inner.as_str()) {
                ("include", Some(name)) => found.push(name),
                _ => named(inner, found),
            }),
            Value::Array(all) => all.iter().for_each(|inner| named(inner, found)),
            _ => {}
        }
    }
    let grammar = grammar();
    let mut found = Vec::new();
    named(&grammar, &mut found);
    assert!(found.len() > 5);
    for name in found {
        assert!(grammar["repository"].get(name.trim_start_matches('#')).is_some(), "{name}");
    }
}

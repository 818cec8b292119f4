//! The syntax colouring of editors knows the words of the language.

use base::units::UNIT_NAMES;
use compile::Catalog;
use lang::tokens::KEYWORDS;
use lang::{functions, temporal_operators};
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

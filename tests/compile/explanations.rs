//! Every code, form, kind and key can be explained, and each example shows what it claims.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use base::diagnostic::Sources;
use compile::{Catalog, compile, key};
use lang::Reader;
use lang::error_index::mistakes;
use lang::keywords::WORDS;

/// Reads an example instead of a file, and also the files of the suite.
struct Example {
    text: String,
}

const ROOT: &str = "mistake.scn";

impl Example {
    fn beside(path: &Path) -> PathBuf {
        crate::repository().join("tests/suite/files").join(path)
    }
}

impl Reader for Example {
    fn text(&self, path: &Path) -> std::io::Result<String> {
        if path == Path::new(ROOT) { Ok(self.text.clone()) } else { std::fs::read_to_string(Self::beside(path)) }
    }

    fn bytes(&self, path: &Path) -> std::io::Result<Vec<u8>> {
        std::fs::read(Self::beside(path))
    }
}

/// The codes that an example raises.
fn raised(text: &str) -> BTreeSet<&'static str> {
    let text = text.replace("+ 1 …", &"+ 1 ".repeat(600)).replace('…', &"and so on ".repeat(500_000));
    let mut sources = Sources::default();
    let compiled = compile(&[PathBuf::from(ROOT)], &Catalog::builtin(), &Example { text }, &mut sources).unwrap();
    compiled.diagnostics.iter().map(|each| each.code).collect()
}

#[test]
fn the_bad_example_raises_its_code_alone_and_the_good_one_nothing() {
    let mut wrong = Vec::new();
    // Settings are given on the command line, so their examples are commands.
    for mistake in mistakes().into_iter().filter(|mistake| !mistake.bad.starts_with("falsify ")) {
        let (bad, good) = (raised(mistake.bad), raised(mistake.good));
        if bad != BTreeSet::from([mistake.code]) || !good.is_empty() {
            wrong.push(format!("{}: bad raises {bad:?}, good raises {good:?}", mistake.code));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn every_code_is_explained_once() {
    let folder = std::fs::read_dir(crate::repository().join("src/lang/diagnostics")).unwrap();
    let source: String = folder.map(|file| std::fs::read_to_string(file.unwrap().path()).unwrap()).collect();
    let mut known = BTreeSet::new();
    for call in ["Diagnostic::error(", "Diagnostic::warning(", " = error(", " = warning(", "unknown("] {
        for rest in source.split(call).skip(1) {
            let code = rest.trim_start().strip_prefix('"').and_then(|rest| rest.split('"').next());
            known.extend(code);
        }
    }
    let explained: Vec<&str> = mistakes().iter().map(|mistake| mistake.code).collect();
    let explained_set: BTreeSet<&str> = explained.iter().copied().collect();
    assert!(known.len() > 40);
    assert_eq!(explained_set, known, "src/lang/mistakes.md and src/lang/diagnostics do not agree");
    assert_eq!(explained.len(), explained_set.len(), "a code is explained twice");
}

#[test]
fn every_form_kind_block_and_key_is_explained() {
    let catalog = Catalog::builtin();
    let explain = |words: &[&str]| {
        let words: Vec<String> = words.iter().map(|word| (*word).to_string()).collect();
        catalog.explain(&words).unwrap_or_else(|error| panic!("{error}"))
    };
    let everything = explain(&[]);
    for form in &catalog.forms {
        assert!(everything.contains(form.name));
        assert!(explain(&[form.name]).contains(form.doc));
        for kind in &form.kinds {
            assert!(explain(&[form.name, kind.name]).contains(kind.doc));
            for param in &kind.params {
                assert!(explain(&[form.name, kind.name, param.name]).contains(&key(param)));
            }
        }
        for child in form.plain.iter().flat_map(|plain| &plain.children) {
            assert!(explain(&[form.name, child.name]).contains(child.doc));
            for param in &child.params {
                assert!(explain(&[form.name, child.name, param.name]).contains(&key(param)));
            }
        }
    }
    for mistake in mistakes() {
        assert!(everything.contains(mistake.code), "{}", mistake.code);
        assert!(explain(&[mistake.code]).contains(mistake.good.lines().last().unwrap()));
    }
    for (topic, part) in [("units", "km"), ("events", "on touch"), ("variables", "v_c")] {
        assert!(explain(&[topic]).contains(part), "{topic}");
    }
}

#[test]
fn words_events_and_variables_are_explained_and_the_examples_are_right() {
    let catalog = Catalog::builtin();
    let explain = |words: &[&str]| {
        let words: Vec<String> = words.iter().map(|word| (*word).to_string()).collect();
        catalog.explain(&words).unwrap_or_else(|error| panic!("{error}"))
    };
    for word in WORDS {
        assert!(explain(&[word.name]).contains(word.text), "{}", word.name);
        assert_eq!(raised(word.example), BTreeSet::new(), "{}", word.name);
    }
    let known: BTreeSet<&str> = WORDS.iter().map(|word| word.name).collect();
    assert!(lang::distributions().all(|name| known.contains(name)));
    for event in &catalog.vocabulary.events {
        assert!(explain(&[event.name]).contains(event.doc) && explain(&["on", event.name]).contains(event.doc));
    }
    for variable in &catalog.vocabulary.variables {
        assert!(explain(&[variable.name]).contains(variable.doc));
    }
    assert!(explain(&["distance"]).contains("spawn name"), "a key of that name is shown as well");
    let protocol = explain(&["fmvss127"]);
    assert!(protocol.contains("49 CFR 571.127") && protocol.contains("`crossing_right`"), "{protocol}");
    assert!(!catalog.forms.iter().any(|form| catalog.vocabulary.events.iter().any(|event| event.name == form.name)));
}

#[test]
fn what_is_not_known_is_answered_with_the_nearest_that_is() {
    let catalog = Catalog::builtin();
    for (words, near) in [
        (vec!["drivr"], "did you mean `driver`?"),
        (vec!["driver", "idn"], "did you mean `driver idm`?"),
        (vec!["missing-untis"], "did you mean `missing-unit`?"),
        (vec!["zebra crossing"], "lists what there is"),
    ] {
        let words: Vec<String> = words.into_iter().map(str::to_string).collect();
        let error = catalog.explain(&words).unwrap_err();
        assert!(error.contains(near), "{error}");
    }
}

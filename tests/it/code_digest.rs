//! The digest of the code that makes numbers (`build.rs`): a change of wording keeps it, a change of a number changes it.

use std::path::Path;

use build::{digest, sources, without_wording};

#[path = "../../build.rs"]
#[expect(dead_code, clippy::print_stdout, reason = "the parts that talk to cargo")]
mod build;

#[test]
fn wording_is_left_out_and_code_is_kept() {
    for (text, kept) in [
        ("/// A sum.\nfn f() -> u8 { 1 /* one /* nested */ */ + 2 } // three", "fn f()->u8{1+2}"),
        ("a(\"two words\", \"A sentence of plain words.\")", "a(\"two words\",\"\")"),
        ("b(\"https://x\", \"one \\\" two // three four\", 1)", "b(\"https://x\",\"\",1)"),
        ("let c = ['\"', '\\'', '/', '/'];", "let c=['\"','\\'','/','/'];"),
        ("fn f<'a>(x: &'a str) -> &'a str { x }", "fn f<'a>(x:&'a str)->&'a str{x}"),
        ("(r#\"some raw \"quoted text\" // here\"#, br\"// no\", r\"\\\", 2)", "(\"\",br\"// no\",r\"\\\",2)"),
        (
            "stream(\"falsify 2026 random streams\", \"7 m .. 30 m\")",
            "stream(\"falsify 2026 random streams\",\"7 m .. 30 m\")",
        ),
        ("name(\"{} in {} against {}\")", "name(\"{} in {} against {}\")"),
        ("for r in \"x\".bytes() {}", "for r in\"x\".bytes(){}"),
        ("x - 1;\n\n#[cfg(test)]\nmod tests {\n 2\n}", "x-1;"),
        ("a\n    .b( 1,\n 2 )", "a.b(1,2)"),
    ] {
        assert_eq!(without_wording(text), kept, "{text}");
    }
}

#[test]
fn a_number_of_the_simulator_changes_the_digest_and_a_comment_does_not() {
    let all = sources(Path::new(env!("CARGO_MANIFEST_DIR")));
    for folder in ["sim", "av", "env", "judge", "falsifier", "rl", "road", "compile"] {
        assert!(all.iter().any(|(name, _)| name.starts_with(&format!("src/{folder}/"))), "{folder} makes numbers");
    }
    assert!(!all.iter().any(|(name, _)| name.starts_with("src/lang/") || name.starts_with("src/report/")));
    // The other files would only cost time.
    let simulator: Vec<_> = all.into_iter().filter(|(name, _)| name.starts_with("src/sim/")).collect();
    let same = digest(&simulator);
    let with = |place: usize, text: String| {
        let mut changed = simulator.clone();
        changed[place].1 = text;
        digest(&changed)
    };
    for (place, (name, text)) in simulator.iter().enumerate() {
        assert_eq!(with(place, format!("// Another comment.\n{text}")), same, "{name}");
        let message = |words: &str| with(place, format!("const TEXT: &str = \"{words}\";\n{text}"));
        assert_eq!(message("the car is fast"), message("the vehicle has a high speed"), "{name}");
        // Change the last digit in the code.
        let code = without_wording(text);
        assert_eq!(with(place, code.clone()), same, "{name}");
        if let Some(at) = code.rfind(|c: char| c.is_ascii_digit()) {
            let other = if &code[at..=at] == "9" { "8" } else { "9" };
            assert_ne!(with(place, format!("{}{other}{}", &code[..at], &code[at + 1..])), same, "{name}");
        }
    }
    assert!(simulator.iter().any(|(_, text)| text.contains("f64 = ")));
    assert_ne!(digest(&simulator[1..]), same, "{}", simulator[0].0);
}

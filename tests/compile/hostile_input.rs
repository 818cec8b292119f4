//! No text makes the front end panic or hang: any bytes get an answer in bounded time.

use std::path::Path;
use std::sync::mpsc;
use std::time::Duration;

use base::diagnostic::{Colour, Sources, records, render};
use compile::{Catalog, compile};
use proptest::prelude::*;

/// Checks a text, renders its diagnostics, lays it out, and returns the first code.
fn survive(text: &str) -> Option<&'static str> {
    let root = Path::new("hostile.scn");
    let none = || std::io::Error::from(std::io::ErrorKind::NotFound);
    let read = |path: &Path| if path == root { Ok(text.to_string()) } else { Err(none()) };
    let mut sources = Sources::default();
    let compiled = compile(&[root.to_path_buf()], &Catalog::builtin(), &read, &mut sources).unwrap();
    for each in compiled.diagnostics.iter().take(20) {
        let _ = render(each, &sources, Colour::Never);
    }
    let _ = records(&compiled.diagnostics, &sources);
    let _ = lang::format(sources.add("", text), text);
    compiled.diagnostics.first().map(|each| each.code)
}

/// Calls [`survive`] and fails after a long time without an answer. The bound is generous: it separates bounded time from a hang.
fn survive_in_time(name: &str, text: String) -> Option<&'static str> {
    let (sender, receiver) = mpsc::channel();
    std::thread::spawn(move || sender.send(survive(&text)));
    receiver.recv_timeout(Duration::from_secs(100)).unwrap_or_else(|_| panic!("{name}: no answer"))
}

fn shipped() -> Vec<String> {
    [
        "scenarios/first_look.scn",
        "scenarios/lib/paper.scn",
        "scenarios/lib/drivers.scn",
        "src/program/commands/templates/crossing.scn",
    ]
    .map(|path| std::fs::read_to_string(crate::repository().join(path)).unwrap())
    .to_vec()
}

#[test]
fn huge_and_deep_files_get_an_answer() {
    let edition = "edition 1\n";
    for (name, text, code) in [
        ("junk beyond reason", "§$%&? \n".repeat(50 << 17), Some("too-large")),
        ("junk", "§$%&? \n".repeat((4 << 20) / 8), Some("syntax")),
        ("a name without end", format!("{edition}{0} a {{}}\n{0} b {{}}", "a".repeat(1 << 20)), Some("unknown-form")),
        ("brackets", format!("{edition}reward r {{ on touch => {}", "(".repeat(10_000)), Some("too-deep")),
        (
            "pairs of brackets",
            format!("{edition}reward r {{ on touch => {}1{} }}", "[".repeat(10_000), "]".repeat(10_000)),
            Some("too-deep"),
        ),
        ("blocks", format!("{edition}{}{}", "a { ".repeat(10_000), "}".repeat(10_000)), Some("too-deep")),
        ("terms", format!("{edition}reward r {{ on touch => 1{} }}", " + 1".repeat(20_000)), Some("too-long")),
        ("signs", format!("{edition}reward r {{ on touch => {}1 }}", "-".repeat(20_000)), Some("too-long")),
        ("documentation", "///\n".repeat(1 << 14), Some("missing-edition")),
        ("documentation in a block", format!("{edition}reward r {{\n{}}}", "///\n".repeat(1 << 14)), None),
        ("comments", format!("{edition}{}", "// a\n/* b */".repeat(1 << 13)), None),
        ("junk with braces in texts", format!("{edition}? {}\n", "\"{\" ".repeat(1000)), Some("syntax")),
        ("junk with braces in comments", format!("{edition}? {}\n", "/* { */ ".repeat(1000)), Some("syntax")),
        ("junk with braces behind quotes", format!("{edition}{}", "? \" {\n".repeat(1000)), Some("syntax")),
        ("nested junk", format!("{edition}{}{}", "? { ".repeat(60), "}".repeat(60)), Some("syntax")),
        (
            "nested calls",
            format!("{edition}reward r {{ on touch => {}!{} }}", "max(a: ".repeat(60), ")".repeat(60)),
            Some("syntax"),
        ),
        ("no line ends", "a".repeat(1 << 18), Some("syntax")),
        ("words without end", format!("{edition}? {}", "a b' 1 = ".repeat(1 << 18)), Some("syntax")),
        ("foreign signs without end", format!("{edition}? {}", "% ° ".repeat(1 << 18)), Some("syntax")),
        (
            "brackets that never match",
            format!("{edition}{}", "reward r { (}\n".repeat(1 << 15)),
            Some("mismatched-bracket"),
        ),
        (
            "lists without brackets",
            format!("{edition}campaign c {{ {} }}", "a: b, c ".repeat(1 << 15)),
            Some("unknown-key"),
        ),
    ] {
        assert_eq!(survive_in_time(name, text), code, "{name}");
    }
}

/// The requested number of lines, each with its number instead of `#`.
#[test]
fn a_chain_of_imports_ends_in_an_error() {
    let read = |path: &Path| {
        let number: u32 = path.file_stem().unwrap().to_string_lossy().parse().unwrap();
        Ok(format!("edition 1\nimport \"{}.scn\"\n", number + 1))
    };
    let mut sources = Sources::default();
    let compiled = compile(&["0.scn".into()], &Catalog::builtin(), &read, &mut sources).unwrap();
    let codes: Vec<&str> = compiled.diagnostics.iter().map(|each| each.code).collect();
    assert_eq!(codes, ["import-not-found"]);
    assert!(
        compiled.diagnostics[0].message.contains("import each other in a row"),
        "{}",
        compiled.diagnostics[0].message
    );
}

fn lines(count: usize, line: &str) -> String {
    (0..count).map(|number| line.replace('#', &number.to_string()) + "\n").collect()
}

#[test]
fn streets_that_all_cross_each_other_are_told_in_time() {
    let street = |number: i32, along: bool| {
        let (a, b) = (number * 40 - 4000, 9000);
        let ends = if along { [(-b, a), (b, a)] } else { [(a, -b), (a, b)] };
        format!("street {{ through: [({} m, {} m), ({} m, {} m)] }}\n", ends[0].0, ends[0].1, ends[1].0, ends[1].1)
    };
    let streets: String = (0..400).map(|number| street(number / 2, number % 2 == 0)).collect();
    let text = format!("edition 1\ntown t {{\n{streets}}}\n");
    assert_eq!(survive_in_time("crossings", text), Some("unbuildable-town"));
}

#[test]
fn a_hundred_thousand_declarations_are_checked() {
    let text = format!("edition 1\n{}", lines(100_000, "reward r# { on touch => # }"));
    let (sender, receiver) = mpsc::channel();
    std::thread::spawn(move || {
        let root = Path::new("hostile.scn");
        let read = |_: &Path| Ok(text.clone());
        let compiled = compile(&[root.to_path_buf()], &Catalog::builtin(), &read, &mut Sources::default()).unwrap();
        sender.send((compiled.plan.is_some(), compiled.diagnostics.len()))
    });
    assert_eq!(receiver.recv_timeout(Duration::from_secs(100)), Ok((true, 0)));
}

#[test]
fn as_many_mistakes_as_there_are_lines_are_found() {
    let edition = "edition 1\n";
    let names = lines(10_000, "s#, ");
    for (name, text, code) in [
        ("forms", format!("{edition}{}", lines(5_000, "rewrd r# {}")), "unknown-form"),
        ("statements", format!("{edition}{}", lines(5_000, "? x = # m m")), "syntax"),
        ("equal names", format!("{edition}{}", lines(5_000, "reward r {}")), "duplicate-declaration"),
        ("imported names", format!("{edition}import {names}s from \"std/paper.scn\"\n"), "unknown-import"),
        ("missing commas", format!("{edition}driver p = idm({})\n", lines(5_000, "margin: #")), "syntax"),
        (
            "names that lead nowhere, among many that do",
            format!(
                "{edition}{}campaign c {{ train {{ rewards: [{names}] }} }}\n",
                lines(10_000, "reward r# { on touch => 1 }")
            ),
            "missing-key",
        ),
        (
            "parameters in the wrong place",
            format!(
                "{edition}{}{}",
                lines(10_000, "param p#: length = # m"),
                lines(10_000, "spawn s# { distance: p# .. 7 s }")
            ),
            "wrong-unit",
        ),
    ] {
        assert_eq!(survive_in_time(name, text), Some(code), "{name}");
    }
}

#[test]
fn what_multiplies_is_bounded() {
    let params = lines(5_000, "param p#: length = # m");
    let axes = lines(5_000, "p#: # m");
    let pieces = "import \"std/paper.scn\"\nimport \"std/drivers.scn\"\n";
    let one_row = format!("edition 1\n{pieces}{params}campaign c {{ matrix {{ {axes} }} }}\n");
    assert_eq!(survive_in_time("a row of many values", one_row), Some("missing-key"));
    let ten = "[0, 1, 2, 3, 4, 5, 6, 7, 8, 9]";
    let many = format!("edition 1\n{params}campaign c {{ matrix {{ p0: {ten} p1: {ten} p2: {ten} }} }}\n");
    assert_eq!(survive_in_time("many rows of much", many), Some("too-many-combinations"));
    // Parameters that name each other double the parts of a distribution.
    for (name, part, twice) in
        [("choice", "choice(1, 2)", "choice(#, #)"), ("weighted", "weighted((1, 1))", "weighted((1, #), (1, #))")]
    {
        let twice =
            |number: u32| format!("param p{}: number = {}\n", number + 1, twice.replace('#', &format!("p{number}")));
        let text = format!("edition 1\nparam p0: number = {part}\n{}", (0..200).map(twice).collect::<String>());
        assert_eq!(survive_in_time(name, text), Some("too-many-parts"), "{name}");
    }
    // Each of many keys may have as many parts as are allowed.
    let large = format!("edition 1\nparam far: length = choice({})\n", vec!["7 m"; 4_096].join(", "));
    assert_eq!(survive_in_time("many large ones", large + &lines(2_000, "spawn s# { distance: far }")), None);
    let runs = "train { towns: [harbour, village] drivers: [behavior, idm, blind] rewards: [r1, r2] runs: 10_000 }";
    let keys = "vehicle: model3 body: suicidal spawn: ahead episode: thirty_seconds training: ppo_paper";
    let text = format!("edition 1\n{pieces}import \"std/towns.scn\"\n{params}campaign c {{ {keys} {runs} {runs} }}\n");
    assert!(survive_in_time("many trainings", text).is_some());
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn no_bytes_panic(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        survive(&String::from_utf8_lossy(&bytes));
    }

    #[test]
    fn no_soup_of_tokens_panics(tokens in prop::collection::vec(prop::sample::select(vec![
        "edition", "1", "import", "\"a\"", "reward", "r", "{", "}", "(", ")", "[", "]", "on", "touch", "=>", ":", ",", ";", "=",
        "..", "7", "7 m", "60 deg", "-", "+", "*", "/", "<", "<=", "and", "or", "not", "in", "m/s", "///d\n", "//c\n", "/*b*/",
        "\"", "{\"", "\n", "\r", "\u{feff}", "é", "🚗", "max(", "spawn s {", "town t = opendrive(", "bearing:", "1e999", "m^99",
    ]), 0..60), spaced in any::<bool>()) {
        survive(&tokens.join(if spaced { " " } else { "" }));
    }

    #[test]
    fn no_mutation_of_a_shipped_file_panics(
        file in 0..4_usize,
        cuts in prop::collection::vec((any::<prop::sample::Index>(), 0..30_usize, "[ -~\n🚗]{0,6}"), 1..6),
    ) {
        let mut text: Vec<char> = shipped()[file].chars().collect();
        for (place, length, put) in cuts {
            let at = place.index(text.len().max(1)).min(text.len());
            let end = (at + length).min(text.len());
            text.splice(at..end, put.chars());
        }
        survive(&text.into_iter().collect::<String>());
    }
}

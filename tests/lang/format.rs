//! The layout of files: it keeps the meaning and the comments, and a second pass changes nothing.

use std::fmt::Debug;

use base::diagnostic::{Severity, Sources};
use lang::{format, parse};
use proptest::prelude::*;

use crate::samples::samples;
use crate::shipped::shipped;

/// The fields that an outline omits: places in files.
const PLACES: [&str; 8] = ["span", "head", "source", "places", "roots", "setting", "unread", "torn"];

/// Any tree as indented lines, without places in files: two files with the same meaning
/// have the same outline.
///
/// It is made from the debug form, so new kinds of nodes need no change here.
fn outline(tree: &impl Debug) -> String {
    let text = format!("{tree:#?}");
    let mut result = String::new();
    let mut skipped_at: Option<usize> = None;
    for line in text.lines() {
        let indent = line.len() - line.trim_start().len();
        let content = line.trim();
        let closes = matches!(content.chars().next(), Some('}' | ')' | ']'));
        if let Some(at) = skipped_at {
            if indent == at && closes {
                skipped_at = None;
            }
            continue;
        }
        let field = content.split_once(": ").map_or("", |(field, _)| field);
        if PLACES.contains(&field) || content == "Span {" {
            if content.ends_with(['{', '(', '[']) {
                skipped_at = Some(indent);
            }
            continue;
        }
        let content = content.trim_end_matches(',').trim_end_matches(['{', '(', '[']).trim_end();
        if closes || content.is_empty() {
            continue;
        }
        result.extend(std::iter::repeat_n(' ', indent / 2));
        result.push_str(content);
        result.push('\n');
    }
    result
}

/// The meaning of a text without its positions; none when the text cannot be parsed.
fn meaning(text: &str) -> Option<String> {
    let (file, said) = parse(Sources::default().add("", text), text);
    said.iter().all(|each| each.severity == Severity::Warning).then(|| outline(&file))
}

/// Lays a text out and checks every property that the layout promises; false when the text cannot be parsed.
fn holds(text: &str) -> bool {
    let source = Sources::default().add("", text);
    let Some(before) = meaning(text) else {
        assert!(format(source, text).is_err(), "{text}");
        return false;
    };
    let once = format(source, text).unwrap();
    assert_eq!(meaning(&once).as_ref(), Some(&before), "{text}\n---\n{once}");
    assert_eq!(format(source, &once).unwrap(), once, "{text}");
    assert!(once.is_empty() || once.ends_with('\n') && !once.ends_with("\n\n"), "{once:?}");
    // Comments belong to the author, including their trailing blanks, so lines of block comments are left out of this check.
    let ours = once.lines().filter(|line| !line.contains("/*") && !line.contains("*/"));
    assert!(!ours.clone().any(|line| line.ends_with(' ')), "{once:?}");
    true
}

#[test]
fn every_shipped_file_is_laid_out() {
    for file in shipped("scenarios").into_iter().chain(shipped("src/program/commands/templates")) {
        let text = std::fs::read_to_string(&file).unwrap();
        let laid_out = format(Sources::default().add(&file, text.as_str()), &text).unwrap();
        assert!(laid_out == text, "run `falsify fmt {}`", file.display());
    }
}

#[test]
fn every_file_and_every_readable_section_of_the_suite_keeps_its_meaning() {
    let mut read = 0;
    for file in shipped("scenarios").into_iter().chain(shipped("tests/suite")) {
        let text = std::fs::read_to_string(&file).unwrap();
        for section in text.split("//# ") {
            // The first line of a section is its name.
            let body = if section.starts_with("edition") || section.starts_with('/') {
                section
            } else {
                section.split_once('\n').map_or("", |(_, body)| body)
            };
            read += usize::from(holds(body));
        }
    }
    assert!(read > 60, "{read}");
}

#[test]
fn the_layout_is_what_it_is() {
    let text = std::fs::read_to_string(crate::repository().join("tests/suite/layout/before.txt")).unwrap();
    let wanted = crate::repository().join("tests/suite/layout/after.txt");
    assert!(holds(&text));
    let found = format(Sources::default().add("", text.as_str()), &text).unwrap();
    if std::env::var_os("UPDATE_REFERENCE").is_some() {
        std::fs::write(&wanted, &found).unwrap();
    }
    assert_eq!(found, std::fs::read_to_string(wanted).unwrap());
}

#[test]
fn a_comment_counts_alike_before_and_after_a_comma_that_goes() {
    let list = "[ not ready /* between */ , not ready , v_c in m/s , -60deg , v_c in m/s , /* between */ v_c in m/s , not ready ]";
    for end in ["// aside\n,)", ", // aside\n)", "// aside\n)"] {
        assert!(holds(&std::format!("edition 1 town t {{ part a {{ key: 7 m .. ( {list} {end} }} }}")));
    }
}

/// Expressions, statements and blocks with arbitrary spacing and line breaks.
fn untidy() -> impl Strategy<Value = String> {
    let gap = || {
        prop_oneof![
            6 => Just(" ".to_string()),
            2 => Just("\n".to_string()),
            1 => Just("\n\n\n".to_string()),
            1 => Just("\r\n\t".to_string()),
            1 => Just(" // aside\n".to_string()),
            1 => Just("\n  // apart\n".to_string()),
            1 => Just(" /* between */ ".to_string()),
            1 => Just("\n/* two\n   lines */\n".to_string()),
        ]
    };
    let atom = prop_oneof![
        Just("7 m".to_string()),
        Just("-60deg".to_string()),
        Just("1_000".to_string()),
        Just("v_c in m/s".to_string()),
        Just("\"a // b\"".to_string()),
        Just("not ready".to_string()),
        "[a-z_]{1,40}x",
    ];
    let value = atom.prop_recursive(4, 40, 8, move |inner| {
        let list = prop::collection::vec((inner.clone(), gap(), gap()), 1..9);
        prop_oneof![
            list.clone().prop_map(|all| {
                format!("[{}]", all.iter().map(|(v, a, b)| format!("{a}{v}{b}")).collect::<Vec<_>>().join(","))
            }),
            list.clone().prop_map(|all| {
                format!("({},)", all.iter().map(|(v, a, b)| format!("{a}{v}{b}")).collect::<Vec<_>>().join(","))
            }),
            list.prop_map(|all| {
                format!("max({})", all.iter().map(|(v, a, b)| format!("{a}{v}{b}")).collect::<Vec<_>>().join(","))
            }),
            (inner.clone(), prop::sample::select(vec!["+", "-", "*", "/", "<=", "and"]), inner.clone(), gap(), gap())
                .prop_map(|(a, sign, b, one, two)| format!("({a}{one} {sign} {two}{b})")),
        ]
    });
    let range = (value.clone(), value.clone(), gap()).prop_map(|(a, b, gap)| format!("{a}{gap}..{gap}{b}"));
    let value = prop_oneof![3 => value.clone(), 1 => range];
    let pair = (gap(), value.clone(), gap(), prop::sample::select(vec!["", ",", ";", "\n"]))
        .prop_map(|(a, v, b, end)| format!("key:{b}{v}{end}{a}"));
    let clause = (gap(), value).prop_map(|(gap, v)| format!("on{gap} touch(front) =>{gap}{v}{gap}"));
    let entry = prop_oneof![4 => pair, 1 => clause, 1 => Just("\n/// said\nkey: 1 ".to_string())];
    let block = (prop::collection::vec(entry, 0..6), gap(), gap())
        .prop_map(|(entries, a, b)| format!("{{{a}{}{b}}}", entries.join(" ")));
    let block = block.prop_recursive(3, 12, 3, move |inner| {
        prop::collection::vec((inner, gap()), 1..4).prop_map(|blocks| {
            format!("{{\n{}}}", blocks.iter().map(|(b, g)| format!("part a{g}{b}{g}")).collect::<String>())
        })
    });
    let declaration = (block, gap(), any::<bool>()).prop_map(|(block, gap, kind)| {
        if kind {
            format!("town t{gap}= made(a: 1,{gap}b: [2 m, 3 m]){gap}{block}")
        } else {
            format!("town t{gap}{block}")
        }
    });
    prop::collection::vec((gap(), declaration), 0..4).prop_map(|all| {
        let body: String = all.into_iter().map(|(gap, declaration)| format!("{gap}{declaration}")).collect();
        format!("edition 1{}", if body.is_empty() { "\n".to_string() } else { format!(" {body}") })
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: samples(50, 400) as u32, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn untidy_files_keep_their_meaning(text in untidy()) {
        prop_assert!(holds(&text), "{text}");
    }
}

//! Files of the standard library that are read only as far as somebody names what they hold.
//!
//! The library grows, and a scenario wants little of it. Its files are laid out so that their statements can be told apart without
//! being read: of the lines of a statement only the first begins with a letter, and `///` lines belong to the next one.

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::LazyLock;

use super::ast::File;
use super::library;
use super::parse::parse_part;
use crate::diagnostic::Sources;

/// The part of a text before its first statement that has a name: the edition and the imports.
pub(super) fn heading(text: &str) -> &str {
    named_statements(text).first().map_or(text, |first| &text[..first.whole.start])
}

/// Completes files of the library of which only the [`heading`] was read, by the statements that the other files name, or
/// these words, or a statement that is read itself.
///
/// A word anywhere in a text counts: a statement that is read for nothing does no harm.
pub(super) fn read_named(files: &mut [File], words: &[&str], sources: &Sources) {
    let mut shelved: BTreeMap<&[u8], Vec<(usize, Statement)>> = BTreeMap::new();
    // The lengths of the names with each first byte: what has no such length need not be looked for.
    let mut lengths = [0_u64; 256];
    let length = |word: &[u8]| 1 << word.len().min(63);
    let mut texts = words.to_vec();
    for (place, file) in files.iter().enumerate() {
        let source = sources.get(file.source);
        if library::holds(&source.path) {
            for statement in named_statements(&source.text) {
                let name = source.text[statement.name.clone()].as_bytes();
                lengths[usize::from(name[0])] |= length(name);
                shelved.entry(name).or_default().push((place, statement));
            }
        } else {
            texts.push(&source.text);
        }
    }
    let mut wanted: Vec<(usize, Range<usize>)> = Vec::new();
    while let Some(text) = texts.pop() {
        for word in words_of(text).filter(|word| lengths[usize::from(word[0])] & length(word) != 0) {
            for (place, statement) in shelved.remove(word).into_iter().flatten() {
                let text = &sources.get(files[place].source).text;
                texts.push(&text[statement.name.end..statement.whole.end]);
                wanted.push((place, statement.whole));
            }
        }
    }
    wanted.sort_by_key(|(place, part)| (*place, part.start));
    for (place, part) in wanted {
        let file = &mut files[place];
        let read = parse_part(file.source, &sources.get(file.source).text, part);
        file.params.extend(read.params);
        file.declarations.extend(read.declarations);
    }
}

/// The file of the library that declares something.
pub(super) fn home(form: &str, name: &str) -> Option<&'static str> {
    /// By form and name. A file may have as many mistakes as lines, so the library is looked through once.
    static HOMES: LazyLock<BTreeMap<(&str, &str), &str>> = LazyLock::new(|| {
        let declared = library::files().flat_map(|(file, text)| {
            named_statements(text).into_iter().map(move |statement| {
                let before = text[..statement.name.start].trim_end();
                let form = before.rsplit(|c: char| c.is_whitespace()).next().unwrap_or_default();
                ((form, &text[statement.name]), file)
            })
        });
        declared.collect()
    });
    HOMES.get(&(form, name)).copied()
}

/// The statements of the library that declare something of this name, each with its file.
pub fn library_statements(name: &str) -> Vec<(&'static str, &'static str)> {
    let mut found = Vec::new();
    for (file, text) in library::files() {
        let statements = named_statements(text).into_iter().filter(|statement| &text[statement.name.clone()] == name);
        found.extend(statements.map(|statement| (file, &text[statement.whole])));
    }
    found
}

/// The words of a text without lines that are comments. In such a line, `*/` may end one that began before.
fn words_of(text: &str) -> impl Iterator<Item = &[u8]> {
    let lines = text.split(['\n', '\r']).filter(|line| !line.trim_start().starts_with("//") || line.contains("*/"));
    lines.flat_map(|line| line.as_bytes().split(|byte| !is_part_of_name(*byte))).filter(|word| !word.is_empty())
}

/// A statement with a name.
struct Statement {
    /// It, with its documentation.
    whole: Range<usize>,
    /// The second word of its first line.
    name: Range<usize>,
}

/// The statements of a file of the library that have a name, in their order.
fn named_statements(text: &str) -> Vec<Statement> {
    let mut statements: Vec<Statement> = Vec::new();
    let (mut at, mut documented) = (0, None);
    for line in text.split_inclusive('\n') {
        let start = at;
        at += line.len();
        if line.starts_with("///") {
            documented.get_or_insert(start);
        } else if line.starts_with(|first: char| first.is_ascii_alphabetic()) {
            let begin = documented.take().unwrap_or(start);
            if let Some(before) = statements.last_mut() {
                before.whole.end = before.whole.end.min(begin);
            }
            let first = word(line, 0);
            if let "edition" | "import" = &line[first.clone()] {
                continue;
            }
            let blank = line[first.end..].len() - line[first.end..].trim_start().len();
            let name = word(line, first.end + blank);
            statements.push(Statement { whole: begin..text.len(), name: start + name.start..start + name.end });
        }
    }
    statements
}

/// The word that begins at this byte of a line.
fn word(line: &str, start: usize) -> Range<usize> {
    let length = line.bytes().skip(start).take_while(|byte| is_part_of_name(*byte)).count();
    start..start + length
}

fn is_part_of_name(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || byte == b'_'
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::lang::{Loaded, load, load_named, parse};

    fn scenario(text: &str) -> String {
        let imports: String = library::names().map(|name| format!("import \"std/{name}\"\n")).collect();
        format!("edition 1\n{imports}{text}")
    }

    /// A disk with one file.
    fn disk(text: String) -> impl Fn(&Path) -> std::io::Result<String> {
        move |path| if path == Path::new("s.scn") { Ok(text.clone()) } else { Err(std::io::ErrorKind::NotFound.into()) }
    }

    /// What is read of the library for a scenario that imports all of it.
    fn read_for(text: &str, words: &[&str]) -> Vec<String> {
        let read = disk(scenario(text));
        let loaded = load_named(&["s.scn".into()], words, &read, &mut Sources::default()).unwrap();
        let names = |file: &File| -> Vec<String> {
            let declared = file.declarations.iter().filter_map(|each| each.name.as_ref());
            file.params.iter().map(|param| &param.name).chain(declared).map(|name| name.text.clone()).collect()
        };
        loaded.files[1..].iter().flat_map(names).collect()
    }

    #[test]
    fn the_statements_of_every_file_of_the_library_are_told_apart() {
        for name in library::names() {
            let text = library::read(&library::place(&format!("std/{name}")).unwrap()).unwrap();
            let source = Sources::default().add(name, text);
            let (whole, diagnostics) = parse(source, text);
            assert!(diagnostics.is_empty(), "{name}: {diagnostics:?}");
            let mut found = parse(source, heading(text)).0;
            for statement in named_statements(text) {
                let part = parse_part(source, text, statement.whole);
                let read = part.params.iter().map(|param| &param.name);
                let read: Vec<_> = read.chain(part.declarations.iter().flat_map(|each| &each.name)).collect();
                let [only] = read.as_slice() else { panic!("{name}: not one statement: {read:?}") };
                assert_eq!((only.span.start, only.span.end), (statement.name.start, statement.name.end), "{name}");
                found.params.extend(part.params);
                found.declarations.extend(part.declarations);
            }
            assert_eq!(found, whole, "{name}");
        }
    }

    #[test]
    fn what_nobody_names_is_not_read() {
        assert_eq!(read_for("", &[]), Vec::<String>::new());
        assert_eq!(read_for("policy mine = idm()", &["village.lane_width = 3 m"]), ["village"]);
        assert_eq!(read_for("// aeb\n/* village\n// */ rss\n// nobody\r  poor", &[]), ["rss", "poor", "village"]);
    }

    #[test]
    fn what_a_statement_names_is_read_with_it() {
        let read = read_for("campaign c { policies: interfuser }", &[]);
        assert!(read.contains(&"interfuser".to_string()) && read.contains(&"interfuser_eyes".to_string()), "{read:?}");
        assert!(!read.contains(&"lav".to_string()), "{read:?}");
    }

    #[test]
    fn completed_the_library_is_whole() {
        let read = disk(scenario("campaign c { towns: village }"));
        let mut sources = Sources::default();
        let mut named = load_named(&["s.scn".into()], &[], &read, &mut sources).unwrap();
        named.complete(&sources);
        let Loaded { files, .. } = load(&["s.scn".into()], &read, &mut Sources::default()).unwrap();
        assert_eq!(named.files, files);
    }
}

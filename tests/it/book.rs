//! Documents: links and headings exist. The book in `docs`: examples check, commands parse, and the page of options is that of the program.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use base::diagnostic::Sources;
use clap::{Command, CommandFactory};
use compile::{Catalog, compile};
use program::commands::Arguments;

/// The documents of the repository with their texts, sorted by path.
fn documents() -> Vec<(PathBuf, String)> {
    let folders =
        ["docs", "reports", "grammar", "python", "scenarios", "src"].map(|name| crate::repository().join(name));
    let mut open = folders.to_vec();
    let mut paths = ["README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "CHANGELOG.md", "SECURITY.md"]
        .map(|name| crate::repository().join(name))
        .to_vec();
    while let Some(folder) = open.pop() {
        for path in std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
            let is_hidden = path.file_name().is_some_and(|name| name.to_string_lossy().starts_with('.'));
            if path.is_dir() && !path.is_symlink() && !is_hidden {
                open.push(path);
            } else if path.extension().is_some_and(|extension| extension == "md") {
                paths.push(path);
            }
        }
    }
    paths.sort();
    let with_text = |path: PathBuf| {
        let text = std::fs::read_to_string(&path).unwrap();
        (path, text)
    };
    paths.into_iter().map(with_text).collect()
}

/// What the program prints (`explain`) is below `src`, and no document; nor is a report of somebody's own run.
#[test]
fn the_first_page_has_at_most_950_words() {
    let words = std::fs::read_to_string(crate::repository().join("README.md")).unwrap().split_whitespace().count();
    assert!(words <= 950, "{words} words: shorten a part before another grows");
}

#[test]
fn all_documents_have_at_most_64_000_words() {
    let top = crate::repository();
    let (src, reports) = (top.join("src"), top.join("reports"));
    let kept = ["reference", "stack_faults", "metadrive_faults"].map(|name| reports.join(name));
    let is_own = |path: &Path| {
        let is_inside = path.starts_with(&reports) && path.parent() != Some(&reports);
        is_inside && kept.iter().all(|folder| !path.starts_with(folder))
    };
    let read = documents().into_iter().filter(|(path, _)| !path.starts_with(&src) && !is_own(path));
    let words: usize = read.map(|(_, text)| text.split_whitespace().count()).sum();
    assert!((30_000..=64_000).contains(&words), "{words} words: shorten a page before another grows");
}

/// The pages of the book with their texts.
fn pages() -> Vec<(PathBuf, String)> {
    let book = crate::repository().join("docs/src");
    documents().into_iter().filter(|(path, _)| path.starts_with(&book)).collect()
}

/// The text outside of blocks of code.
fn prose(text: &str) -> String {
    text.split("```").step_by(2).collect()
}

/// The blocks of code in a language.
fn blocks<'a>(text: &'a str, language: &str) -> Vec<&'a str> {
    let fence = format!("```{language}\n");
    text.split(fence.as_str()).skip(1).filter_map(|rest| rest.split("```").next()).collect()
}

/// The targets of the links of a page, without those to other hosts.
fn links(text: &str) -> Vec<String> {
    let prose = prose(text);
    let targets = prose.split("](").skip(1).filter_map(|rest| rest.split(')').next());
    targets.filter(|target| !target.contains("://")).map(str::to_string).collect()
}

/// The anchors of the headings of a page, as mdBook and GitHub make them.
fn anchors(text: &str) -> BTreeSet<String> {
    let headings = text.lines().filter(|line| line.starts_with('#'));
    let anchor = |heading: &str| {
        let lower = heading.trim_start_matches('#').trim().to_lowercase();
        let kept = lower.chars().filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'));
        kept.map(|c| if c == ' ' { '-' } else { c }).collect()
    };
    headings.map(anchor).collect()
}

#[test]
fn links_and_included_files_exist() {
    let (mut count, mut broken) = (0, Vec::new());
    for (path, text) in documents() {
        let folder = path.parent().unwrap();
        let included = text.split("{{#include ").skip(1).map(|rest| rest.split("}}").next().unwrap().to_string());
        for target in links(&text).into_iter().chain(included) {
            count += 1;
            let (file, heading) = target.split_once('#').unwrap_or((&target, ""));
            let file = if file.is_empty() { path.clone() } else { folder.join(file) };
            let exists = file.exists()
                && (heading.is_empty() || anchors(&std::fs::read_to_string(&file).unwrap()).contains(heading));
            if !exists {
                broken.push(format!("{}: {target}", path.display()));
            }
        }
    }
    assert!(count > 90 && broken.is_empty(), "{count} links, broken: {broken:#?}");
}

#[test]
fn the_examples_of_the_book_check() {
    let mut count = 0;
    for (path, text) in pages() {
        for block in blocks(&text, "scn") {
            let root = crate::repository().join("scenarios/example.scn");
            let read = |path: &Path| if path == root { Ok(block.to_string()) } else { std::fs::read_to_string(path) };
            let compiled =
                compile(std::slice::from_ref(&root), &Catalog::builtin(), &read, &mut Sources::default()).unwrap();
            let errors: Vec<_> = compiled
                .diagnostics
                .iter()
                .filter(|each| !["unused", "external-not-allowed"].contains(&each.code))
                .collect();
            assert!(errors.is_empty(), "{}: {errors:?}", path.display());
            count += 1;
        }
    }
    assert!(count >= 6, "{count}");
}

/// The words of a command line of a shell: quotes are removed, a comment ends it.
fn words(line: &str) -> Vec<String> {
    let (mut words, mut word, mut quote) = (Vec::new(), String::new(), None);
    for c in line.chars() {
        match (quote, c) {
            (Some(open), c) if c == open => quote = None,
            (None, '\'' | '"') => quote = Some(c),
            (None, '#') if word.is_empty() => break,
            (None, ' ') => words.extend((!word.is_empty()).then(|| std::mem::take(&mut word))),
            (_, c) => word.push(c),
        }
    }
    words.extend((!word.is_empty()).then_some(word));
    words
}

#[test]
fn the_commands_of_the_book_parse() {
    let mut count = 0;
    for (path, text) in pages() {
        let lines = blocks(&text, "sh").into_iter().flat_map(str::lines);
        for line in lines.flat_map(|line| line.split(" && ")).flat_map(|line| line.split(" | ")) {
            let words = words(&line.replace("RUN:EPISODE", "1a2b3c4d:17"));
            if words.first().is_some_and(|first| first == "falsify") {
                let parsed = Arguments::command().try_get_matches_from(&words);
                assert!(parsed.is_ok(), "{}: `{line}`: {}", path.display(), parsed.unwrap_err());
                count += 1;
            }
        }
        // A command within a sentence may be a part of one: the command and its options exist.
        for code in prose(&text).split('`').skip(1).step_by(2).filter(|code| code.starts_with("falsify ")) {
            let known = Arguments::command();
            let mut rest = words(code).into_iter().skip(1);
            let first = rest.next().unwrap();
            let command = known.find_subcommand(&first);
            if first.starts_with(|c: char| c.is_lowercase()) {
                let command = command.unwrap_or_else(|| panic!("{}: there is no `{code}`", path.display()));
                let own = rest.take_while(|word| word != "--").filter(|word| word.starts_with("--"));
                for option in own.map(|word| word.trim_start_matches('-').to_string()) {
                    let mut options =
                        command.get_subcommands().flat_map(Command::get_arguments).chain(command.get_arguments());
                    let there = option == "help" || options.any(|arg| arg.get_long() == Some(&option));
                    assert!(there, "{}: `{code}` has no --{option}", path.display());
                }
                count += 1;
            }
        }
    }
    assert!(count > 45, "{count}");
}

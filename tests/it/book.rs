//! The book in `docs`: every page is listed, links and headings exist, examples check, commands parse, and the page of commands has them all.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use base::diagnostic::Sources;
use clap::{Command, CommandFactory};
use compile::{Catalog, compile};
use program::cli::{ExitCode, settings};
use program::commands::Arguments;

fn source() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/src")
}

/// The pages of the book with their texts, sorted by path.
fn pages() -> Vec<(PathBuf, String)> {
    let (mut open, mut pages) = (vec![source()], Vec::new());
    while let Some(folder) = open.pop() {
        for path in std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
            if path.is_dir() {
                open.push(path);
            } else if path.extension().is_some_and(|extension| extension == "md") {
                let text = std::fs::read_to_string(&path).unwrap();
                pages.push((path, text));
            }
        }
    }
    pages.sort();
    pages
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
fn the_summary_lists_every_page_once() {
    let summary = std::fs::read_to_string(source().join("SUMMARY.md")).unwrap();
    // A heading in the list of chapters has no page.
    let chapters = links(&summary).into_iter().filter(|link| !link.is_empty());
    let mut listed: Vec<PathBuf> = chapters.map(|link| source().join(link)).collect();
    listed.sort();
    let written: Vec<PathBuf> =
        pages().into_iter().map(|(path, _)| path).filter(|path| !path.ends_with("SUMMARY.md")).collect();
    assert_eq!(listed, written);
}

#[test]
fn links_and_included_files_of_the_book_exist() {
    let (mut count, mut broken) = (0, Vec::new());
    for (path, text) in pages() {
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
    assert!(count > 60 && broken.is_empty(), "{count} links, broken: {broken:#?}");
}

#[test]
fn the_examples_of_the_book_check() {
    let mut count = 0;
    for (path, text) in pages() {
        for block in blocks(&text, "scn") {
            let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/example.scn");
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

#[test]
fn the_page_of_commands_has_every_command() {
    let page = std::fs::read_to_string(source().join("reference/commands.md")).unwrap();
    for command in Arguments::command().get_subcommands() {
        let name = format!("| `falsify {}", command.get_name());
        assert!(page.lines().any(|line| line.starts_with(&name)), "docs/src/reference/commands.md has no row `{name}`");
    }
}

/// The page of options: every command with its arguments, as `--help` has them.
fn options_page() -> String {
    let mut page = String::from(
        "# Options of all commands\n\nThe options of each command, generated from the program. `falsify COMMAND --help` has the same with examples.\n",
    );
    let mut program = Arguments::command();
    program.build();
    for command in program.get_subcommands().filter(|command| command.get_name() != "help") {
        let inner: Vec<&Command> = command.get_subcommands().filter(|each| each.get_name() != "help").collect();
        let named = if inner.is_empty() { vec![(String::new(), command)] } else { Vec::new() };
        let named = inner.into_iter().map(|each| (format!(" {}", each.get_name()), each)).chain(named);
        for (suffix, each) in named {
            let about = each.get_about().map(ToString::to_string).unwrap_or_default();
            page += &format!("\n## falsify {}{suffix}\n\n{about}.\n", command.get_name());
            let shown = |arg: &&clap::Arg| !arg.is_hide_set() && !["help", "color"].contains(&arg.get_id().as_str());
            let arguments: Vec<&clap::Arg> = each.get_arguments().filter(shown).collect();
            if !arguments.is_empty() {
                page += "\n| option | meaning | default |\n|---|---|---|\n";
            }
            for arg in arguments {
                let help = arg.get_help().map(ToString::to_string).unwrap_or_default();
                let help =
                    help.split_whitespace().collect::<Vec<_>>().join(" ").replace('|', "\\|").replace('<', "&lt;");
                let defaults = if arg.get_action().takes_values() { arg.get_default_values() } else { &[] };
                let values: Vec<String> =
                    defaults.iter().map(|value| format!("`{}`", value.to_string_lossy())).collect();
                let name = arg.to_string().replace('|', "\\|");
                page += &format!("| `{name}` | {help} | {} |\n", values.join(", "));
            }
        }
    }
    page
}

#[test]
fn the_page_of_options_is_that_of_the_program() {
    let place = source().join("reference/options.md");
    let page = options_page();
    if std::env::var_os("UPDATE_REFERENCE").is_some() {
        std::fs::write(&place, &page).unwrap();
    }
    let written = std::fs::read_to_string(&place).unwrap_or_default();
    assert!(written == page, "docs/src/reference/options.md is outdated; run this test with UPDATE_REFERENCE=1");
}

/// Compares the table of a page that starts with this line with that of the program. The text around it is written by hand.
#[track_caller]
fn table_is_that_of_the_program(page: &str, head: &str, rows: &[String]) {
    let place = source().join(page);
    let text = std::fs::read_to_string(&place).unwrap();
    let start = text.find(head).unwrap_or_else(|| panic!("{page} has no table `{head}`"));
    let length: usize =
        text[start..].split_inclusive('\n').take_while(|line| line.starts_with('|')).map(str::len).sum();
    let columns = head.matches('|').count() - 1;
    let table = format!("{head}\n|{}\n{}\n", "---|".repeat(columns), rows.join("\n"));
    if std::env::var_os("UPDATE_REFERENCE").is_some() {
        std::fs::write(&place, format!("{}{table}{}", &text[..start], &text[start + length..])).unwrap();
    } else {
        assert!(text[start..start + length] == table, "{page} is outdated; run this test with UPDATE_REFERENCE=1");
    }
}

#[test]
fn the_page_of_exit_codes_is_that_of_the_program() {
    let row = |code: &ExitCode| format!("| {} | {} |", *code as u8, code.meaning());
    let rows: Vec<String> = ExitCode::ALL.iter().map(row).collect();
    table_is_that_of_the_program("reference/exit-codes.md", "| code | meaning |", &rows);
    // The help has the same codes.
    let help = Arguments::command().get_after_help().unwrap().to_string();
    let (_, listed) = help.split_once("Exit codes:").unwrap();
    let numbers: Vec<u8> = listed.split_whitespace().filter_map(|word| word.parse().ok()).collect();
    assert_eq!(numbers, ExitCode::ALL.map(|code| code as u8));
}

#[test]
fn the_page_of_settings_is_that_of_the_program() {
    let row = |(name, variable, option): (&str, Option<&str>, clap::Arg)| {
        let help = option.get_help().map(ToString::to_string).unwrap_or_default();
        let help = help.split_whitespace().collect::<Vec<_>>().join(" ").replace('|', "\\|").replace('<', "&lt;");
        let possible: Vec<String> =
            option.get_possible_values().iter().map(|value| format!("`{}`", value.get_name())).collect();
        let help = if possible.is_empty() { help } else { format!("{help}: {}", possible.join(", ")) };
        let values = option.get_default_values().iter().map(|value| format!("`{}`", value.to_string_lossy()));
        let (variable, values) =
            (variable.map_or(String::new(), |name| format!("`{name}`")), values.collect::<Vec<_>>());
        format!("| `{name}` | {variable} | {help} | {} |", values.join(", "))
    };
    let rows: Vec<String> = settings().into_iter().map(row).collect();
    table_is_that_of_the_program("reference/settings.md", "| setting | variable | meaning | default |", &rows);
}

//! Applies the repairs that diagnostics offer.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use crate::cli::console;
use crate::cli::failure::{failed, unwritten};
use crate::commands::fmt::write;
use crate::exit_code::ExitCode;
use crate::session::{Checked, Input, Session};
use base::diagnostic::{Fix, SourceId};
use lang::library;

/// The greatest number of rounds: a repair can show the next mistake.
const ROUNDS: usize = 20;

/// Repairs files as far as each diagnostic offers exactly one repair, and reports how many were applied to each. A round of repairs that
/// leads to more errors is taken back.
///
/// # Errors
/// The exit code, after the reason has been printed.
pub fn fix(session: &Session, input: &Input) -> Result<Checked, ExitCode> {
    let check = || session.check(input).map_err(failed);
    let mut checked = check()?;
    let mut applied: BTreeMap<PathBuf, usize> = BTreeMap::new();
    for _ in 0..ROUNDS {
        let repairs = repairs(&checked);
        if repairs.is_empty() {
            break;
        }
        let mut before = Vec::new();
        for (path, (old, new, count)) in repairs {
            put(&path, &old, &new)?;
            before.push((path, old, new, count));
        }
        let after = check()?;
        if after.errors() > checked.errors() {
            for (path, old, new, _) in &before {
                put(path, new, old)?;
            }
            break;
        }
        for (path, _, _, count) in before {
            *applied.entry(path).or_default() += count;
        }
        checked = after;
    }
    for (_, source) in checked.sources.iter().filter(|(_, source)| on_disk(&source.path)) {
        if !is_scenario(&source.path, &source.text) {
            let path = source.path.display();
            console::note(&format!(
                "{path} was left alone: its name does not end in .scn, and it does not begin with `edition`"
            ));
        }
    }
    for (_, source) in checked.sources.iter().filter(|(id, _)| is_of_other_edition(&checked, *id)) {
        console::note(&format!("{} was left alone: this program does not know its edition", source.path.display()));
    }
    for (path, count) in applied {
        console::note(&format!("{} repaired in {}", console::count(count, "mistake"), path.display()));
    }
    Ok(checked)
}

fn put(path: &Path, before: &str, text: &str) -> Result<(), ExitCode> {
    write(path, before, text).map_err(|error| unwritten(format!("cannot write `{}`: {error}", path.display())))
}

/// Whether a file is of an edition that this program does not know. What is a mistake in it, is not known either.
fn is_of_other_edition(checked: &Checked, source: SourceId) -> bool {
    let mut said = checked.compiled.diagnostics.iter();
    said.any(|each| each.code == "unknown-edition" && each.primary.span.source == source)
}

/// Whether a source is a file of the user.
fn on_disk(path: &Path) -> bool {
    path.is_file() && !library::holds(path)
}

/// Whether a file says that it is a scenario, by its name or its first word. Others are left alone: a program is not a scenario with mistakes.
fn is_scenario(path: &Path, text: &str) -> bool {
    let first = text.lines().map(str::trim_start).find(|line| !line.is_empty() && !line.starts_with("//"));
    let says = first.and_then(|line| line.get(..7)).is_some_and(|word| word.eq_ignore_ascii_case("edition"));
    says || path.extension().is_some_and(|ending| ending == "scn")
}

/// For each file on the disk with repairs: its text, the repaired text, and the number of repairs.
fn repairs(checked: &Checked) -> BTreeMap<PathBuf, (String, String, usize)> {
    let mut files = BTreeMap::new();
    for (id, source) in checked.sources.iter() {
        if !on_disk(&source.path) || !is_scenario(&source.path, &source.text) || is_of_other_edition(checked, id) {
            continue;
        }
        let only = checked.compiled.diagnostics.iter().filter_map(|each| match each.fixes.as_slice() {
            [fix] if fix.span.source == id => Some(fix),
            _ => None,
        });
        let mut fixes: Vec<&Fix> = only.collect();
        fixes.sort_by_key(|fix| (fix.span.start, fix.span.end));
        let mut text = String::new();
        let mut end = 0;
        let mut count = 0;
        for (place, fix) in fixes.iter().enumerate() {
            // Two repairs of one place contradict each other; the next round has the rest.
            if fix.span.start < end || (place > 0 && fix.span.start == fixes[place - 1].span.start) {
                continue;
            }
            text.push_str(&source.text[end..fix.span.start]);
            text.push_str(&fix.text);
            end = fix.span.end;
            count += 1;
        }
        text.push_str(&source.text[end..]);
        if count > 0 && text != source.text {
            let mark = if source.mark > 0 { "\u{feff}" } else { "" };
            files.insert(source.path.clone(), (format!("{mark}{}", source.text), format!("{mark}{text}"), count));
        }
    }
    files
}

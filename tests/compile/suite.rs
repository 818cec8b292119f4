//! Language tests written in the language.
//!
//! A file of `tests/suite` holds sections. Each starts with a line `//# name`. A line with a mistake states it:
//! `// error: [code] "part of the message"`, or `// warning: …`, once for each diagnostic of the line. All other lines
//! must be silent. Imports are read from the folder `tests/suite`. A line `// set: name=value` gives a setting as `--set` does;
//! diagnostics of the setting are expected on the section's first line.

use std::path::{Path, PathBuf};

use base::diagnostic::{Severity, Sources};
use compile::{Catalog, Overrides, compile_with};
use lang::Reader;

#[derive(Debug, PartialEq, Eq, PartialOrd, Ord, Clone)]
struct Said {
    line: usize,
    severity: String,
    code: String,
}

#[test]
fn every_section_says_what_it_expects() {
    let folder = crate::repository().join("tests/suite");
    let mut files: Vec<PathBuf> = std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.retain(|path| path.extension().is_some_and(|extension| extension == "scn"));
    files.sort();
    let mut failures = Vec::new();
    let mut sections = 0;
    for file in &files {
        let text = std::fs::read_to_string(file).unwrap();
        for (name, body) in split(&text) {
            sections += 1;
            if let Err(why) = section(&folder, &body) {
                failures.push(format!("{} # {name}\n{why}", file.file_name().unwrap().display()));
            }
        }
    }
    assert!(sections > 40, "the suite has shrunk to {sections} sections");
    assert!(failures.is_empty(), "{}", failures.join("\n\n"));
}

fn split(text: &str) -> Vec<(String, String)> {
    let mut sections: Vec<(String, String)> = Vec::new();
    for line in text.lines() {
        match line.strip_prefix("//# ") {
            Some(name) => sections.push((name.to_string(), String::new())),
            None => {
                if let Some((_, body)) = sections.last_mut() {
                    body.push_str(line);
                    body.push('\n');
                }
            }
        }
    }
    sections
}

/// Reads a section instead of a file, and also files.
struct Section<'a> {
    root: PathBuf,
    body: &'a str,
}

impl Reader for Section<'_> {
    fn text(&self, path: &Path) -> std::io::Result<String> {
        if path == self.root { Ok(self.body.to_string()) } else { std::fs::read_to_string(path) }
    }

    fn bytes(&self, path: &Path) -> std::io::Result<Vec<u8>> {
        std::fs::read(path)
    }
}

fn section(folder: &Path, body: &str) -> Result<(), String> {
    let root = folder.join("section.scn");
    let read = Section { root: root.clone(), body };
    let mut sources = Sources::default();
    let settings = body.lines().filter_map(|line| line.strip_prefix("// set: ")).map(str::to_string).collect();
    let overrides = Overrides { settings, ..Overrides::default() };
    let compiled =
        compile_with(std::slice::from_ref(&root), &overrides, &Catalog::builtin(), &read, &mut sources).unwrap();
    let mut found: Vec<(Said, String)> = Vec::new();
    for each in &compiled.diagnostics {
        let span = each.primary.span;
        let (line, _) = sources.line_column(span.source, span.start);
        let severity = if each.severity == Severity::Error { "error" } else { "warning" }.to_string();
        let everything = [&each.message, &each.primary.text, &each.help.join(" "), &each.offer().unwrap_or_default()]
            .map(String::as_str)
            .join(" ");
        found.push((Said { line, severity, code: each.code.to_string() }, everything));
    }
    let mut wanted = expectations(body);
    for (said, text) in &found {
        match wanted.iter().position(|(want, part)| want == said && text.contains(part.as_str())) {
            Some(index) => drop(wanted.remove(index)),
            None => return Err(format!("  unexpected: {said:?}\n    {text}")),
        }
    }
    match wanted.first() {
        None => Ok(()),
        Some((said, part)) => Err(format!("  missing: {said:?} with {part:?}; found {found:?}")),
    }
}

fn expectations(body: &str) -> Vec<(Said, String)> {
    let mut all = Vec::new();
    for (index, line) in body.lines().enumerate() {
        for severity in ["error", "warning"] {
            for mark in line.split(&format!("// {severity}: [")).skip(1) {
                let (code, rest) = mark.split_once(']').expect("an expectation names its code in brackets");
                let text =
                    rest.trim().strip_prefix('"').and_then(|rest| rest.split_once('"')).map_or("", |(text, _)| text);
                let said = Said { line: index + 1, severity: severity.into(), code: code.into() };
                all.push((said, text.to_string()));
            }
        }
    }
    all
}

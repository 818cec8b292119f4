//! What makes code hard to follow: imports that point up, circles of files, long functions. Each has a bound, which is only lowered.
//!
//! This scans plain text as rustfmt lays it out: imports, and paths in code that begin with `crate::`, `super::` or `self::`, without tests.
//! A name that a file has from elsewhere counts as the one of the file that declares it; a public import only passes a name on.

use std::collections::{BTreeMap, BTreeSet};

use crate::house::{rust_files, top};

/// The pairs of files of a package whose import points up: to a module that `lib.rs` declares later, or to `lib.rs` itself. A module is
/// here a file beside `lib.rs`, or a folder with all in it. The goal of each is 0.
const UPWARD: &[(&str, usize)] = &[
    ("base", 0),
    ("compile", 2),
    ("episode", 4),
    ("export", 0),
    ("lang", 1),
    ("learn", 0),
    ("ported", 0),
    ("process", 0),
    ("program", 2),
    ("results", 31),
    ("road", 0),
    ("search", 0),
    ("verdict", 0),
    ("world", 0),
];

/// The files that import each other in circles. The number of circles is no measure: a large one that falls in two is a step. The goal is 0.
const IN_CIRCLES: usize = 76;

/// The functions of more than [`LONG`] lines from name to last brace, comments left out. The goal is 0.
const LONG_FUNCTIONS: usize = 25;
const LONG: usize = 60;

/// The files that name a metric, besides the one that declares them all, summed over the metrics. A section may be about one; what is shown, gated and
/// compared of all is not told one by one.
const METRICS_NAMED: usize = 86;

/// The names on the way to a module or an item, the package first.
type Path = Vec<String>;

struct Import {
    path: Path,
    /// The name that the file has from it. Empty for a path in code.
    name: String,
    is_public: bool,
}

struct File {
    /// From `src`.
    path: String,
    /// Without comments and tests.
    text: String,
    imports: Vec<Import>,
}

/// The code of the packages, with their imports.
struct Code {
    files: Vec<File>,
    /// The file of each module.
    modules: BTreeMap<Path, usize>,
}

/// A text without comments and without items of tests.
fn without_tests(text: &str) -> String {
    let indent = |line: &str| line.len() - line.trim_start().len();
    let (mut kept, mut lines) = (String::new(), text.lines());
    while let Some(line) = lines.next() {
        if line.trim() == "#[cfg(test)]" {
            lines.find(|next| indent(next) == indent(line) && next.ends_with([';', '}']));
        } else if !line.trim_start().starts_with("//") {
            kept += &format!("{line}\n");
        }
    }
    kept
}

/// The word that a text begins with, and the rest.
fn word(text: &str) -> (&str, &str) {
    text.split_at(text.find(|c: char| !c.is_alphanumeric() && !"_*".contains(c)).unwrap_or(text.len()))
}

/// Reads paths that branch, `a::{b, c::d as e}`. Each comes with the name that it gives; returns what follows them.
fn branches<'a>(mut rest: &'a str, mut path: Vec<&'a str>, found: &mut Vec<(Path, String)>) -> &'a str {
    loop {
        if let Some(inner) = rest.strip_prefix('{') {
            rest = inner.trim_start();
            while rest.starts_with(|c: char| c.is_alphabetic() || "_*".contains(c)) {
                rest = branches(rest, path.clone(), found).trim_start_matches(',').trim_start();
            }
            return rest.strip_prefix('}').unwrap_or(rest).trim_start();
        }
        let (name, after) = word(rest);
        path.push(name);
        rest = after;
        let Some(next) = rest.strip_prefix("::") else { break };
        rest = next;
    }
    if path.last() == Some(&"self") {
        path.pop();
    }
    let mut name = *path.last().unwrap_or(&"");
    if let Some(renamed) = rest.strip_prefix(" as ") {
        (name, rest) = word(renamed);
    }
    found.push((path.iter().map(ToString::to_string).collect(), name.to_string()));
    rest.trim_start()
}

/// The imports of a text, and the paths in its code.
fn imports(text: &str) -> Vec<Import> {
    let mut all = Vec::new();
    let mut add = |at: usize, is_public: bool, is_import: bool| {
        let mut found = Vec::new();
        branches(&text[at..], Vec::new(), &mut found);
        let named = |(path, name)| Import { path, name: if is_import { name } else { String::new() }, is_public };
        all.extend(found.into_iter().map(named));
    };
    let line = |at: usize| text[..at].rsplit('\n').next().unwrap();
    for (at, import) in text.match_indices("use ") {
        let before = line(at);
        if before.is_empty() || before.starts_with("pub") {
            add(at + import.len(), !before.is_empty(), true);
        }
    }
    for start in ["crate::", "super::", "self::"] {
        for (at, _) in text.match_indices(start) {
            let (before, is_inner) = (line(at), start == "super::" && line(at).starts_with(' '));
            let follows = before.ends_with(|c: char| c.is_alphanumeric() || "_:$".contains(c));
            let is_import = before.ends_with("use ") && (!before.starts_with(' ') || is_inner);
            if !follows && !is_import && !before.ends_with("(in ") {
                add(at, false, false);
            }
        }
    }
    all
}

impl Code {
    fn read() -> Self {
        let src = top().join("src");
        let mut texts: Vec<(String, String)> = rust_files(&src)
            .into_iter()
            .map(|(path, text)| (path.strip_prefix(&src).unwrap().to_string_lossy().into_owned(), without_tests(&text)))
            .filter(|(path, _)| path.contains('/') && !path.ends_with("/tests.rs") && !path.ends_with("/build.rs"))
            .collect();
        texts.sort();
        let modules: BTreeMap<Path, usize> =
            texts.iter().enumerate().map(|(at, (path, _))| (module(path), at)).collect();
        let files = texts.into_iter().map(|(path, text)| {
            let imports = imports(&text).into_iter().filter_map(|import| {
                Some(Import { path: from_package(&modules, &module(&path), &import.path)?, ..import })
            });
            File { imports: imports.collect(), path, text }
        });
        Self { files: files.collect(), modules }
    }

    /// The file that declares what a path from the package on leads to, through so many files that import it from another one.
    fn declared(&self, path: &[String], through: usize) -> usize {
        let long = (1..=path.len()).rev().find(|long| self.modules.contains_key(&path[..*long])).unwrap();
        let at = self.modules[&path[..long]];
        let file = &self.files[at];
        let Some(name) = path.get(long).filter(|name| through > 0 && !declares(&file.text, name)) else { return at };
        if let Some(import) = file.imports.iter().find(|import| import.name == *name) {
            return self.declared(&import.path, through - 1);
        }
        let globs = file.imports.iter().filter(|import| import.name == "*");
        let mut inner = globs.map(|glob| {
            let folder = &glob.path[..glob.path.len() - 1];
            self.declared(&[folder, &path[long..=long]].concat(), through - 1)
        });
        inner.find(|inner| declares(&self.files[*inner].text, name)).unwrap_or(at)
    }

    /// The files that each file imports from.
    fn arrows(&self) -> Vec<BTreeSet<usize>> {
        let of = |(at, file): (usize, &File)| {
            let used = file.imports.iter().filter(|import| !import.is_public);
            used.map(|import| self.declared(&import.path, 4)).filter(|to| *to != at).collect()
        };
        self.files.iter().enumerate().map(of).collect()
    }
}

/// The names that lead to the module of a file.
fn module(path: &str) -> Path {
    let names = path.trim_end_matches(".rs").split('/').filter(|name| !["mod", "lib"].contains(name));
    names.map(ToString::to_string).collect()
}

/// A path in a module, from the package on. None if it leads out of the package.
fn from_package(modules: &BTreeMap<Path, usize>, home: &[String], path: &[String]) -> Option<Path> {
    let begins = |name: &&String| ["crate", "self", "super"].contains(&name.as_str());
    let start = match path[0].as_str() {
        "crate" => 1,
        _ => home.len() - path.iter().filter(|name| *name == "super").count(),
    };
    let whole: Path = home[..start].iter().chain(path.iter().skip_while(begins)).cloned().collect();
    (begins(&&path[0]) || modules.contains_key(&whole[..=start])).then_some(whole)
}

fn declares(text: &str, name: &str) -> bool {
    ["fn", "struct", "enum", "trait", "type", "const", "static", "mod"].iter().any(|kind| {
        let form = format!("{kind} {name}");
        text.match_indices(&form).any(|(at, _)| word(&text[at + form.len()..]).0.is_empty())
    })
}

#[test]
fn imports_point_down() {
    let code = Code::read();
    let mut upward: BTreeMap<&str, Vec<String>> = BTreeMap::new();
    let package = |at: usize| code.files[at].path.split('/').next().unwrap();
    let rank = |at: usize| {
        let lib = &code.files[code.modules[&[package(at).to_string()][..]]].text;
        let mut modules = lib.lines().filter_map(|line| line.strip_suffix(';')?.split("mod ").nth(1));
        let own = module(&code.files[at].path).get(1).cloned();
        modules.position(|name| Some(name) == own.as_deref()).unwrap_or(usize::MAX)
    };
    for (from, arrows) in code.arrows().iter().enumerate() {
        let up = arrows.iter().filter(|to| rank(**to) > rank(from));
        let shown = up.map(|to| format!("{} imports from {}", code.files[from].path, code.files[*to].path));
        upward.entry(package(from)).or_default().extend(shown);
    }
    for (package, places) in upward {
        let bound = UPWARD.iter().find(|(name, _)| *name == package).expect("each package has a bound").1;
        loud!("{package}: {} imports point up, at most {bound}", places.len());
        assert!(places.len() <= bound, "{package}: more than {bound} imports point up: {places:#?}");
    }
}

#[test]
fn few_files_are_in_circles() {
    let code = Code::read();
    let arrows = code.arrows();
    let reached = |from: usize| {
        let (mut open, mut reached) = (vec![from], BTreeSet::new());
        while let Some(at) = open.pop() {
            open.extend(arrows[at].iter().filter(|to| reached.insert(**to)));
        }
        reached
    };
    let reached: Vec<BTreeSet<usize>> = (0..arrows.len()).map(reached).collect();
    let circle = |at: usize| reached[at].iter().copied().filter(|to| reached[*to].contains(&at)).collect::<Vec<_>>();
    let circles: BTreeSet<Vec<usize>> = (0..arrows.len()).map(circle).filter(|circle| circle.len() > 1).collect();
    let files: usize = circles.iter().map(Vec::len).sum();
    let name = |at: &usize| code.files[*at].path.as_str();
    let shown: Vec<String> =
        circles.iter().map(|circle| circle.iter().map(name).collect::<Vec<_>>().join(", ")).collect();
    loud!("{files} files in {} circles, at most {IN_CIRCLES}", circles.len());
    assert!(files <= IN_CIRCLES, "{files} files in {} circles, at most {IN_CIRCLES}: {shown:#?}", circles.len());
}

#[test]
fn few_functions_are_long() {
    let code = Code::read();
    let mut long = Vec::new();
    for File { path, text, .. } in &code.files {
        let lines: Vec<&str> = text.lines().collect();
        for (at, line) in lines.iter().enumerate() {
            let Some((before, name)) = line.split_once("fn ") else { continue };
            let is_modifier =
                |word: &str| word.starts_with("pub") || word.ends_with(')') || ["const", "unsafe"].contains(&word);
            if line.ends_with(';') || !before.split_whitespace().all(is_modifier) {
                continue;
            }
            let end = format!("{}}}", &line[..line.len() - line.trim_start().len()]);
            let number = lines[at..].iter().position(|line| line.starts_with(&end)).map_or(0, |last| last + 1);
            if number > LONG {
                long.push(format!("{path}: {} has {number} lines", word(name).0));
            }
        }
    }
    loud!("{} functions of more than {LONG} lines, at most {LONG_FUNCTIONS}", long.len());
    assert!(long.len() <= LONG_FUNCTIONS, "more than {LONG_FUNCTIONS} functions of more than {LONG} lines: {long:#?}");
}

#[test]
fn a_metric_is_one_entry() {
    let files = rust_files(&top().join("src"));
    let (_, declared) = files.iter().find(|(path, _)| path.ends_with("results/tables/metrics.rs")).unwrap();
    let is_made = |how: &str| ["count(", "share(", "mean("].iter().any(|kind| how.starts_with(kind));
    let names = declared.lines().filter_map(|line| {
        let (name, how) = line.trim_start().strip_prefix("pub ")?.split_once(" = ")?;
        is_made(how).then_some(name)
    });
    let mut named: BTreeMap<&str, Vec<String>> = BTreeMap::new();
    for name in names {
        let is_word = |text: &str| {
            text.split(|letter: char| !(letter.is_ascii_alphanumeric() || letter == '_')).any(|word| word == name)
        };
        let elsewhere = files.iter().filter(|(path, _)| {
            let path = path.to_string_lossy();
            path.contains("src/results") && !path.ends_with("tables/metrics.rs") && !path.contains("record/")
        });
        let of = elsewhere.filter(|(_, text)| is_word(&without_tests(text)));
        named.insert(name, of.map(|(path, _)| path.to_string_lossy().into_owned()).collect());
    }
    let lone = named.values().filter(|files| files.is_empty()).count();
    let sum: usize = named.values().map(Vec::len).sum();
    println!("{} metrics, {lone} of them in one file; {sum} files name one besides", named.len());
    assert!(named.len() > 30 && sum <= METRICS_NAMED, "{sum} of at most {METRICS_NAMED}: {named:#?}");
}

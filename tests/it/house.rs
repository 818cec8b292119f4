//! The packages of `ARCHITECTURE.md`: the compiler holds their borders, and this holds their doors.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Crates that only some places may name.
const DOORS: &[(&str, &[&str])] = &[
    ("pest", &["lang"]),
    ("pest_derive", &["lang"]),
    ("annotate_snippets", &["base/diagnostic"]),
    ("parry2d", &["road/geometry"]),
    ("roxmltree", &["road"]),
    ("rstar", &["road"]),
    ("rten", &["world/av"]),
    ("rten_tensor", &["world/av"]),
    ("safetensors", &["learn"]),
    ("prost", &["learn", "export"]),
    ("gif", &["export"]),
    ("font8x8", &["export"]),
    ("nix", &["process"]),
    ("polars", &["results/record", "results/tables", "results/report"]),
    ("polars_io", &["results/record", "results/report"]),
    ("polars_parquet_format", &["results/record"]),
    ("maud", &["results/report", "results/jobs"]),
    ("comfy_table", &["results/report"]),
    ("mcap", &["export"]),
    ("tiny_skia", &["export"]),
    ("toml", &["results/report", "program/cli", "program/commands"]),
    ("lsp_server", &["program/lsp"]),
    ("lsp_types", &["program/lsp"]),
    ("clap", &["program/cli", "program/commands", "program/session"]),
    ("indicatif", &["program/cli", "program/commands"]),
    ("ctrlc", &["program/cli", "program/commands"]),
];

pub fn top() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The Rust files below a folder, with their texts.
pub fn rust_files(folder: &Path) -> Vec<(PathBuf, String)> {
    let (mut open, mut all) = (vec![folder.to_path_buf()], Vec::new());
    while let Some(folder) = open.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() && !path.is_symlink() {
                open.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                let text = std::fs::read_to_string(&path).unwrap();
                all.push((path, text));
            }
        }
    }
    all
}

/// The code of `src` without comments and tests, by its path from there.
fn code() -> Vec<(String, String)> {
    let src = top().join("src");
    let without = |text: &str| {
        let text = text.split("#[cfg(test)]").next().unwrap_or_default();
        text.lines().filter(|line| !line.trim_start().starts_with("//")).collect::<Vec<_>>().join("\n")
    };
    let files = rust_files(&src).into_iter().filter(|(path, _)| !path.ends_with("tests.rs"));
    let named =
        files.map(|(path, text)| (path.strip_prefix(&src).unwrap().to_string_lossy().into_owned(), without(&text)));
    named.collect()
}

#[test]
fn some_crates_have_one_door() {
    let mut broken = BTreeSet::new();
    for (path, text) in code() {
        for (name, doors) in DOORS {
            let named = [format!("use {name}::"), format!(" {name}::"), format!("({name}::"), format!("<{name}::")];
            if !doors.iter().any(|door| path.starts_with(door)) && named.iter().any(|form| text.contains(form.as_str()))
            {
                broken.insert(format!("{path}: only {} may name `{name}`", doors.join(" and ")));
            }
        }
    }
    assert!(broken.is_empty(), "{broken:#?}");
}

/// nalgebra 0.35.0 writes out of bounds from safe code when it multiplies small views with a row stride. The learner has such shapes,
/// so it multiplies with its own loops. It uses nalgebra for initialisation only, in matrices that own their numbers.
#[test]
fn the_learner_does_not_multiply_with_nalgebra() {
    let unsound = [
        ".gemm",
        ".gemv",
        ".ger(",
        ".mul_to(",
        "tr_mul",
        "ad_mul",
        "MatrixView",
        "from_slice_with_strides",
        "DMatrixView",
    ];
    let mut broken = BTreeSet::new();
    let learner: Vec<_> = code().into_iter().filter(|(path, _)| path.starts_with("learn/")).collect();
    assert!(learner.len() > 10, "the learner is in src/learn");
    for (path, text) in learner {
        let named = unsound.iter().filter(|call| text.contains(**call));
        broken.extend(named.map(|call| format!("{path}: `{call}`")));
        let matrices = text.contains("nalgebra::") && !text.contains("nalgebra::RealField");
        if matrices && !path.ends_with("init.rs") {
            broken.insert(format!("{path}: matrices of nalgebra"));
        }
    }
    assert!(broken.is_empty(), "{broken:#?}");
}

/// The names of code in `ARCHITECTURE.md` exist: the package, and the last name in it.
#[test]
fn what_the_architecture_names_exists() {
    let page = std::fs::read_to_string(top().join("ARCHITECTURE.md")).unwrap();
    assert!(page.split_whitespace().count() <= 1_300, "the page has at most 1,300 words");
    let code = code();
    let mut missing = BTreeSet::new();
    for name in page.split('`').skip(1).step_by(2).filter(|name| name.contains("::")) {
        let (package, last) = (name.split("::").next().unwrap(), name.rsplit("::").next().unwrap());
        let last = last.split(['(', '.']).next().unwrap();
        let forms = ["pub fn", "pub struct", "pub enum", "pub trait", "pub type", "pub const", "mod"]
            .map(|form| format!("{form} {last}"));
        let is_there = |text: &str| {
            let whole = |at: usize, form: &str| {
                let next = text[at + form.len()..].chars().next();
                next.is_none_or(|c| !c.is_alphanumeric() && c != '_')
            };
            forms.iter().any(|form| text.match_indices(form.as_str()).any(|(at, form)| whole(at, form)))
        };
        let inside = code.iter().filter(|(path, _)| path.starts_with(&format!("{package}/")));
        if !inside.clone().any(|(_, text)| is_there(text)) {
            missing.insert(name.to_string());
        }
    }
    assert!(missing.is_empty(), "{missing:?}");
}

/// What packages embed from other folders of the repository. A copy would go stale, and `cargo publish` follows a link.
#[test]
#[cfg(unix)]
fn what_packages_embed_from_elsewhere_are_links() {
    for path in ["src/lang/grammar", "src/lang/library", "src/program/commands/templates/my_av.py"] {
        let found = std::fs::symlink_metadata(Path::new(env!("CARGO_MANIFEST_DIR")).join(path)).unwrap();
        assert!(found.is_symlink(), "{path} is a copy: make it a link again");
    }
}

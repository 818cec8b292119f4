//! The layers of `src/ARCHITECTURE.md`: a module imports from lower rows only, and some crates are used in one module only.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Each module with the other modules that it may import.
const MAY_IMPORT: &[(&str, &[&str])] = &[
    ("diagnostic", &[]),
    ("contained", &[]),
    ("files", &[]),
    ("units", &[]),
    ("signature", &["units", "statistics"]),
    ("seed", &[]),
    ("statistics", &["seed"]),
    ("geometry", &[]),
    ("lang", &["diagnostic", "units", "signature"]),
    ("road", &["geometry", "seed"]),
    ("sim", &["geometry", "road"]),
    ("rl", &["seed"]),
    ("av", &["contained", "geometry", "road", "sim", "seed", "signature", "units"]),
    ("env", &["geometry", "road", "sim", "rl", "av", "seed", "signature", "units"]),
    ("falsifier", &["signature", "units", "seed", "geometry", "sim", "av", "rl", "env"]),
    (
        "compile",
        &[
            "diagnostic",
            "units",
            "signature",
            "seed",
            "geometry",
            "lang",
            "road",
            "sim",
            "av",
            "rl",
            "env",
            "judge",
            "falsifier",
        ],
    ),
    ("judge", &["statistics", "geometry", "sim", "av", "env"]),
    ("record", &["contained", "statistics", "geometry", "av", "env", "compile", "judge"]),
    ("campaign", &["seed", "statistics", "rl", "env", "compile", "falsifier", "judge", "record"]),
    ("analysis", &["seed", "av", "env", "judge"]),
    (
        "report",
        &[
            "contained",
            "files",
            "seed",
            "statistics",
            "geometry",
            "road",
            "sim",
            "av",
            "rl",
            "env",
            "falsifier",
            "compile",
            "judge",
            "record",
            "campaign",
            "analysis",
        ],
    ),
    ("export", &["geometry", "road", "sim", "env", "judge"]),
    ("store", &["files", "rl", "env", "compile", "falsifier", "judge", "record", "campaign"]),
    ("process", &["av"]),
    ("lsp", &["contained", "files", "diagnostic", "signature", "units", "lang", "compile", "process"]),
    (
        "fuzzing",
        &[
            "cli",
            "report",
            "diagnostic",
            "lang",
            "road",
            "rl",
            "seed",
            "av",
            "env",
            "falsifier",
            "compile",
            "record",
            "store",
        ],
    ),
    (
        "session",
        &[
            "files",
            "diagnostic",
            "seed",
            "lang",
            "road",
            "rl",
            "env",
            "compile",
            "falsifier",
            "judge",
            "record",
            "campaign",
            "report",
            "export",
            "store",
        ],
    ),
    (
        "cli",
        &[
            "contained",
            "files",
            "diagnostic",
            "seed",
            "road",
            "lang",
            "rl",
            "av",
            "env",
            "falsifier",
            "compile",
            "record",
            "campaign",
            "report",
            "export",
            "store",
            "process",
            "session",
            "lsp",
        ],
    ),
];

/// Crates that only one module may name, or only two unrelated modules.
const DOORS: &[(&str, &str)] = &[
    ("pest", "lang"),
    ("lsp_server", "lsp"),
    ("lsp_types", "lsp"),
    ("pest_derive", "lang"),
    ("annotate_snippets", "diagnostic"),
    ("parry2d", "geometry"),
    ("roxmltree", "road"),
    ("rstar", "road"),
    ("safetensors", "rl"),
    ("prost", "rl, export"),
    ("gif", "export"),
    ("font8x8", "export"),
    ("crc32c", "rl"),
    ("polars", "record, report"),
    ("polars_io", "record, report"),
    ("maud", "report"),
    ("comfy_table", "report"),
    ("toml", "report, cli"),
    ("smartcore", "analysis"),
    ("rten", "av"),
    ("rten_tensor", "av"),
    ("nix", "process"),
    ("clap", "cli"),
    ("indicatif", "cli"),
    ("ctrlc", "cli"),
];

fn sources() -> Vec<(String, PathBuf, String)> {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut open = vec![src.clone()];
    let mut all = Vec::new();
    while let Some(folder) = open.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                open.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                let relative = path.strip_prefix(&src).unwrap();
                let first = relative.components().next().unwrap().as_os_str().to_string_lossy();
                let module = first.trim_end_matches(".rs").to_string();
                let text = std::fs::read_to_string(&path).unwrap();
                // Tests may import from more modules, to build what they need.
                let text = text.split("#[cfg(test)]").next().unwrap().to_string();
                if path.file_name().is_some_and(|name| name != "tests.rs") {
                    all.push((module, relative.to_path_buf(), text));
                }
            }
        }
    }
    all
}

fn without_comments(text: &str) -> String {
    text.lines().filter(|line| !line.trim_start().starts_with("//")).collect::<Vec<_>>().join("\n")
}

#[test]
fn modules_import_from_lower_rows_only() {
    let mut broken = BTreeSet::new();
    for (module, path, text) in sources() {
        if module == "lib" || module == "internal" || module == "main" {
            continue;
        }
        let allowed = MAY_IMPORT.iter().find(|(name, _)| *name == module);
        let (_, allowed) = allowed.unwrap_or_else(|| panic!("`{module}` has no row in the layers"));
        for part in without_comments(&text).replace("crate::internal::", "crate::").split("crate::").skip(1) {
            let target: String = part.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
            if !target.is_empty() && target != module && !allowed.contains(&target.as_str()) {
                broken.insert(format!("{}: `{module}` may not import `{target}`", path.display()));
            }
        }
    }
    assert!(broken.is_empty(), "{broken:#?}");
}

#[test]
fn some_crates_have_one_door() {
    let mut broken = BTreeSet::new();
    for (module, path, text) in sources() {
        let text = without_comments(&text);
        for (name, door) in DOORS {
            let named = [format!("use {name}::"), format!(" {name}::"), format!("({name}::"), format!("<{name}::")];
            if door.split(", ").all(|door| module != door) && named.iter().any(|form| text.contains(form.as_str())) {
                broken.insert(format!("{}: only `{door}` may name `{name}`", path.display()));
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
    for (module, path, text) in sources() {
        let text = without_comments(&text);
        if module != "rl" {
            continue;
        }
        let named = unsound.iter().filter(|call| text.contains(**call));
        broken.extend(named.map(|call| format!("{}: `{call}`", path.display())));
        let matrices = text.contains("nalgebra::") && !text.contains("nalgebra::RealField");
        if matrices && path.file_name().is_none_or(|name| name != "init.rs") {
            broken.insert(format!("{}: matrices of nalgebra", path.display()));
        }
    }
    assert!(broken.is_empty(), "{broken:#?}");
}

//! Tells the program which version of its code it is, and links it to a fixed place in memory.
//!
//! `FALSIFY_CODE` is a digest of all sources that make numbers: results are kept from run to run, and those of another version must not be
//! taken for ours. What only shows results has no part in it.
//!
//! The library of tables brings some 400,000 relocations with it; carried out at every start they take longer than checking a
//! scenario. Nothing in the program is to be guarded by a random place: it reads text files of its own user. What unwinds the
//! stack is part of the program for the same reason: every compiler brings it along, and it is one library fewer to look for.

use std::path::{Path, PathBuf};

/// Sources without influence on any number.
const ONLY_SHOWS: [&str; 9] = [
    "src/analysis",
    "src/cli",
    "src/diagnostic",
    "src/lang/format",
    "src/lsp",
    "src/main.rs",
    "src/process",
    "src/report",
    "src/store",
];

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rustc-env=FALSIFY_CODE={}", code());
    let is = |key: &str, value: &str| std::env::var(key).is_ok_and(|found| found == value);
    // A program that holds the C library, too, is told its place by the compiler alone (`-C relocation-model=static`).
    let holds_all =
        std::env::var("CARGO_CFG_TARGET_FEATURE").is_ok_and(|all| all.split(',').any(|one| one == "crt-static"));
    if is("CARGO_CFG_TARGET_OS", "linux") && is("CARGO_CFG_TARGET_ENV", "gnu") && !holds_all {
        println!("cargo::rustc-link-arg-bins=-no-pie");
        println!("cargo::rustc-link-lib=static:-bundle=gcc_eh");
    }
}

/// The digest of the sources.
fn code() -> String {
    let mut files = Vec::new();
    // The rows of an episode are made in a file of the report.
    for place in ["src", "src/report/tables.rs", "grammar", "Cargo.lock"] {
        println!("cargo::rerun-if-changed={place}");
        gather(Path::new(place), &mut files);
    }
    files.sort();
    let mut digest = blake3::Hasher::new();
    for file in &files {
        let bytes = std::fs::read(file).unwrap_or_default();
        digest.update(file.to_string_lossy().replace('\\', "/").as_bytes());
        digest.update(&(bytes.len() as u64).to_le_bytes());
        digest.update(&bytes);
    }
    digest.finalize().to_hex()[..16].to_string()
}

fn gather(place: &Path, files: &mut Vec<PathBuf>) {
    if let Ok(entries) = std::fs::read_dir(place) {
        for path in entries.flatten().map(|entry| entry.path()) {
            if !ONLY_SHOWS.iter().any(|shown| path == Path::new(shown)) {
                gather(&path, files);
            }
        }
    } else if place.extension().is_some_and(|end| end != "md")
        && place.file_name().is_some_and(|name| name != "tests.rs")
    {
        files.push(place.to_path_buf());
    }
}

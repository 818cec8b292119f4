//! Tells the program which version of its code it is, and links it to a fixed place in memory.
//!
//! `FALSIFY_CODE` is a digest of all sources that make numbers: results are kept from run to run, and those of another version must not be
//! taken for ours. What only shows results has no part in it.
//!
//! The library of tables brings some 400,000 relocations with it; carried out at every start they take longer than checking a
//! scenario. Nothing in the program is to be guarded by a random place: it reads text files of its own user. Finding and
//! joining the libraries of the system takes as long again, so the program holds them where the system has them as archives: it
//! then runs on every Linux of its processor, and calculates the same there whatever C library that has.

use std::path::{Path, PathBuf};
use std::process::Command;

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

/// The libraries that Rust's standard library asks for, and the archives that hold the same.
const LIBRARIES: [(&str, &str); 7] =
    [("c", "c"), ("m", "m"), ("dl", "dl"), ("rt", "rt"), ("util", "util"), ("pthread", "pthread"), ("gcc_s", "gcc_eh")];

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rustc-env=FALSIFY_CODE={}", code());
    let target = |key: &str| std::env::var(format!("CARGO_CFG_TARGET_{key}")).unwrap_or_default();
    // A program that is to be static all the same is told its place by the compiler alone (`-C relocation-model=static`).
    let told = target("FEATURE").split(',').any(|one| one == "crt-static");
    if target("OS") == "linux" && target("ENV") == "gnu" && !told {
        println!("cargo::rustc-link-arg-bins=-no-pie");
        // What unwinds the stack comes with every compiler.
        println!("cargo::rustc-link-lib=static:-bundle=gcc_eh");
        // Where it was tried.
        if target("ARCH") == "x86_64" {
            println!("cargo::rerun-if-env-changed=RUSTC_LINKER");
            hold_libraries();
        }
    }
}

/// Links the programs, but no tests, to archives of the system's libraries, if there are such.
fn hold_libraries() {
    let folder = PathBuf::from(std::env::var_os("OUT_DIR").expect("cargo gives a folder")).join("archives");
    if archives(&folder).is_none() {
        return;
    }
    // The folder is searched first, so that what was to be shared is found to be an archive. Archives need each other, and
    // some linkers look through each once.
    println!("cargo::rustc-link-arg-bins=-L{}", folder.display());
    for argument in ["-static", "-Wl,--start-group", "-lgcc_eh", "-lgcc", "-lc", "-Wl,--end-group"] {
        println!("cargo::rustc-link-arg-bins={argument}");
    }
}

/// Fills a folder with linker scripts that lead from the names that the standard library asks for to archives; none when one
/// is missing.
fn archives(folder: &Path) -> Option<()> {
    let compiler = std::env::var_os("RUSTC_LINKER").unwrap_or_else(|| "cc".into());
    let _ = std::fs::remove_dir_all(folder);
    std::fs::create_dir_all(folder).ok()?;
    for (asked, held) in LIBRARIES {
        let answer = Command::new(&compiler).arg(format!("-print-file-name=lib{held}.a")).output().ok()?;
        let archive = PathBuf::from(String::from_utf8(answer.stdout).ok()?.trim());
        // A compiler that has no such file says the bare name again.
        let archive = archive.is_absolute().then_some(archive)?;
        let script = format!("INPUT(\"{}\")\n", archive.display());
        std::fs::write(folder.join(format!("lib{asked}.a")), script).ok()?;
    }
    Some(())
}

/// The digest of the sources.
fn code() -> String {
    let mut files = Vec::new();
    for place in ["src", "grammar", "Cargo.lock"] {
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

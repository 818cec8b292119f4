//! Tells the program which version of its code it is, and links it to a fixed place in memory.
//!
//! `FALSIFY_CODE` is a digest of all sources that make numbers: results are stored, and those of another version must not be taken for ours.
//! Sources that only show results have no part in it, nor has wording: comments, sentences and tests.
//!
//! The library of tables brings some 400,000 relocations with it; carried out at every start they take longer than checking a
//! scenario. Nothing in the program is to be guarded by a random place: it reads text files of its own user. Finding and
//! joining the libraries of the system takes as long again, so the program holds them where the system has them as archives: it
//! then runs on every Linux of its processor, and calculates the same there whatever C library that has.

use std::path::{Path, PathBuf};
use std::process::Command;

/// Sources without influence on any number. What the language makes of a file is digested by itself, in `compile::Recipe`.
const NO_NUMBERS: [&str; 13] = [
    "src/analysis",
    "src/cli",
    "src/diagnostic",
    "src/fuzzing.rs",
    "src/internal.rs",
    "src/lang",
    "src/lib.rs",
    "src/lsp",
    "src/main.rs",
    "src/process",
    "src/report",
    "src/session",
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
    for place in ["src", "Cargo.lock"] {
        println!("cargo::rerun-if-changed={place}");
    }
    digest(&sources(Path::new(".")))
}

/// The sources below a folder that make numbers, by their paths from there, in order.
pub fn sources(root: &Path) -> Vec<(String, String)> {
    let (mut open, mut found) = (vec![PathBuf::from("src"), PathBuf::from("Cargo.lock")], Vec::new());
    while let Some(place) = open.pop() {
        let name = place.to_string_lossy().replace('\\', "/");
        if NO_NUMBERS.contains(&name.as_str()) {
            continue;
        }
        if let Ok(entries) = std::fs::read_dir(root.join(&place)) {
            open.extend(entries.flatten().map(|entry| place.join(entry.file_name())));
        } else if !name.ends_with(".md") && !name.ends_with("/tests.rs") {
            let bytes = std::fs::read(root.join(&place)).unwrap_or_default();
            found.push((name, String::from_utf8_lossy(&bytes).into_owned()));
        }
    }
    found.sort();
    found
}

/// The digest of sources, as 16 hexadecimal digits.
pub fn digest(sources: &[(String, String)]) -> String {
    let mut digest = blake3::Hasher::new();
    for (name, text) in sources {
        let text = if name.ends_with(".rs") { without_wording(text) } else { text.clone() };
        digest.update(name.as_bytes());
        digest.update(&(text.len() as u64).to_le_bytes());
        digest.update(text.as_bytes());
    }
    digest.finalize().to_hex()[..16].to_string()
}

/// Rust without comments, sentences, blanks that part no words, and the module of tests that ends a file.
pub fn without_wording(text: &str) -> String {
    let text = text.split("\n#[cfg(test)]\nmod tests {").next().unwrap_or_default();
    let mut out = String::with_capacity(text.len());
    let mut rest = text;
    let mut blank = false;
    while let Some(first) = rest.chars().next() {
        let length = token(rest, out.chars().next_back());
        let (token, after) = rest.split_at(length);
        rest = after;
        if first.is_whitespace() || token.starts_with("//") || token.starts_with("/*") {
            blank = true;
            continue;
        }
        let word = |c: char| c.is_alphanumeric() || c == '_';
        if std::mem::take(&mut blank) && word(first) && out.ends_with(word) {
            out.push(' ');
        }
        out.push_str(if token.len() > 1 && is_sentence(token) { "\"\"" } else { token });
    }
    out
}

/// Whether a literal is for people: three plain words and no digit. Names of random streams and default values are none.
fn is_sentence(literal: &str) -> bool {
    let plain = |word: &&str| word.len() > 1 && word.bytes().all(|byte| byte.is_ascii_lowercase());
    let words = literal.split([' ', '"', ',', '.', ';', ':', '\n']).filter(plain).count();
    words > 2 && !literal.bytes().any(|byte| byte.is_ascii_digit())
}

/// The length of the comment, literal or character (in bytes) that a text starts with, after this character.
fn token(text: &str, before: Option<char>) -> usize {
    let ended = |from: usize, end: &str| text[from..].find(end).map_or(text.len(), |at| from + at + end.len());
    let one = text.chars().next().map_or(0, char::len_utf8);
    if text.starts_with("//") {
        return text.find('\n').unwrap_or(text.len());
    }
    if text.starts_with("/*") {
        let (mut depth, mut at) = (0, 0);
        while at < text.len() {
            match text.as_bytes()[at..] {
                [b'/', b'*', ..] => (depth, at) = (depth + 1, at + 2),
                [b'*', b'/', ..] => (depth, at) = (depth - 1, at + 2),
                _ => at += 1,
            }
            if depth == 0 {
                break;
            }
        }
        return at;
    }
    if let Some(inner) = text.strip_prefix('\'') {
        // A character, or a lifetime.
        let mut inner = inner.char_indices();
        return match (inner.next(), inner.next()) {
            (Some((_, '\\')), Some((next, c))) => ended(1 + next + c.len_utf8(), "'"),
            (_, Some((next, '\''))) => 1 + next + 1,
            _ => 1,
        };
    }
    if let Some(inner) = text.strip_prefix('"') {
        let mut escaped = false;
        let end = inner.find(|c| {
            let ends = c == '"' && !escaped;
            escaped = c == '\\' && !escaped;
            ends
        });
        return end.map_or(text.len(), |at| at + 2);
    }
    let hashes = text.strip_prefix('r').map(|rest| &rest[..rest.len() - rest.trim_start_matches('#').len()]);
    match hashes {
        // Not the end of a word; `br` and `cr` begin raw literals as well.
        Some(hashes)
            if text[1 + hashes.len()..].starts_with('"')
                && !before.is_some_and(|c| c.is_alphanumeric() && !matches!(c, 'b' | 'c') || c == '_') =>
        {
            ended(2 + hashes.len(), &format!("\"{hashes}"))
        }
        _ => one,
    }
}

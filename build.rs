//! Computes a digest of the program's code.
//!
//! `FALSIFY_CODE` is a digest of all sources that affect numbers. Results are stored; those of another version must not be mistaken for
//! results of this one. Sources that only show results are not part of it. Neither is wording: comments, sentences and tests.

use std::path::{Path, PathBuf};

/// Sources without influence on any number. The compiled scenario has a digest of its own, in `compile::Fingerprint`.
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

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rustc-env=FALSIFY_CODE={}", code());
}

/// The digest of the sources.
fn code() -> String {
    for place in ["src", "Cargo.lock"] {
        println!("cargo::rerun-if-changed={place}");
    }
    digest(&sources(Path::new(".")))
}

/// The sources below a folder that affect numbers, by their paths from there, in order.
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

/// Rust without comments, sentences, unnecessary blanks, and the module of tests that ends a file.
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
        // Not the end of a word; `br` and `cr` start raw literals as well.
        Some(hashes)
            if text[1 + hashes.len()..].starts_with('"')
                && !before.is_some_and(|c| c.is_alphanumeric() && !matches!(c, 'b' | 'c') || c == '_') =>
        {
            ended(2 + hashes.len(), &format!("\"{hashes}"))
        }
        _ => one,
    }
}

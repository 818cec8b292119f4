//! Computes the version of the code that makes numbers.
//!
//! `FALSIFY_CODE` is a digest of all packages that affect numbers. Stored results of another version must not be mistaken for results of this
//! one. What only reads, tabulates or prints is not part of it, and of a scenario its compiled form counts (`compile::Fingerprint`).

use std::path::{Path, PathBuf};

/// What makes numbers, from this package. The other packages are beside it in the repository; in a registry their versions stand for them.
const MAKE_NUMBERS: [&str; 12] = [
    "../base",
    "../learn",
    "../road",
    "../world",
    "../episode",
    "../verdict",
    "../search",
    "../ported",
    "../compile",
    "record",
    "campaign",
    "../../Cargo.lock",
];

fn main() {
    let mut digest = blake3::Hasher::new();
    digest.update(env!("CARGO_PKG_VERSION").as_bytes());
    for place in MAKE_NUMBERS.map(Path::new).into_iter().filter(|place| place.exists()) {
        println!("cargo::rerun-if-changed={}", place.display());
        for file in files(place) {
            let bytes = std::fs::read(&file).unwrap_or_default();
            digest.update(file.to_string_lossy().replace('\\', "/").as_bytes());
            digest.update(&(bytes.len() as u64).to_le_bytes());
            digest.update(&bytes);
        }
    }
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rustc-env=FALSIFY_CODE={}", &digest.finalize().to_hex()[..16]);
}

/// The code below a place, in order.
fn files(place: &Path) -> Vec<PathBuf> {
    let (mut open, mut found) = (vec![place.to_path_buf()], Vec::new());
    while let Some(place) = open.pop() {
        match std::fs::read_dir(&place) {
            Ok(entries) => open.extend(entries.flatten().map(|entry| entry.path())),
            Err(_) => found.push(place),
        }
    }
    found.retain(|file| file.extension().is_none_or(|extension| extension != "md"));
    found.sort();
    found
}

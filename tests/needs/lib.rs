//! `#[needs(python)]` above `#[test]`: where it is missing when the tests are built, the runner reports the test as ignored, with this reason.
//!
//! The harness of Rust cannot skip a test while it runs. The environment variables that decide are read in the expansion, so that a change of
//! one builds these tests again. Something installed in the same folders does not: `touch tests/needs/lib.rs`.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Mutex;

use proc_macro::TokenStream;

/// One of
///
/// | argument | what there must be |
/// |---|---|
/// | `python` | `python3` |
/// | `module = "polars"` | a module of the Python that `FALSIFY_PYTHON` names (default `python3`) |
/// | `program = "node"` | a program that knows `--version` |
/// | `browser` | the browser that `FALSIFY_BROWSER` names, or Chromium or Chrome |
/// | `another_user` | the right to become another user |
/// | `variable = "NAME"` | an environment variable |
/// | `reference = "maps town01"` | a file of the folder of recordings whose path has all these words in lower case |
#[proc_macro_attribute]
pub fn needs(what: TokenStream, test: TokenStream) -> TokenStream {
    let what = what.to_string();
    let (kind, detail) = what.split_once(" = ").unwrap_or((&what, ""));
    let detail = detail.trim_matches('"');
    let (there, named, variables) = match kind {
        "python" => (runs("python3", &["--version"]), "python3".to_owned(), vec!["PATH"]),
        "module" => {
            let python = std::env::var("FALSIFY_PYTHON").unwrap_or_else(|_| "python3".to_owned());
            let find = format!("import importlib.util, sys; sys.exit(importlib.util.find_spec('{detail}') is None)");
            (runs(&python, &["-c", &find]), format!("{detail} in Python"), vec!["PATH", "FALSIFY_PYTHON"])
        }
        "program" => (runs(detail, &["--version"]), detail.to_owned(), vec!["PATH"]),
        "browser" => (browser().is_some(), "Chromium or Chrome".to_owned(), vec!["PATH", "FALSIFY_BROWSER"]),
        "another_user" => {
            let become_one = ["--reuid=3989654", "--clear-groups", "true"];
            (runs("setpriv", &become_one), "the right to become another user".to_owned(), vec!["PATH"])
        }
        "variable" => (std::env::var_os(detail).is_some(), detail.to_owned(), vec![detail]),
        "reference" => {
            let folder = std::env::var_os("FALSIFY_REFERENCE_DIR")
                .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared"), PathBuf::from);
            let words: Vec<&str> = detail.split(' ').collect();
            (holds(&folder, "", &words), format!("{detail} in FALSIFY_REFERENCE_DIR"), vec!["FALSIFY_REFERENCE_DIR"])
        }
        _ => panic!("no test can need {what}"),
    };
    let mark = if there { String::new() } else { format!("#[ignore = \"needs {named}\"]") };
    let read: String = variables.iter().map(|name| format!("const _: Option<&str> = option_env!({name:?});")).collect();
    let mut marked: TokenStream = format!("{read} {mark}").parse().expect("the words above are Rust");
    marked.extend(test);
    marked
}

/// Whether a program ends well. Each is tried once.
fn runs(program: &str, arguments: &[&str]) -> bool {
    static TRIED: Mutex<BTreeMap<String, bool>> = Mutex::new(BTreeMap::new());
    let mut tried = TRIED.lock().expect("no trial panics");
    let try_it = || Command::new(program).args(arguments).output().is_ok_and(|output| output.status.success());
    *tried.entry(format!("{program} {arguments:?}")).or_insert_with(try_it)
}

/// As in `tests/it/page.rs`.
fn browser() -> Option<PathBuf> {
    let names = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome"];
    let path = std::env::var_os("PATH").unwrap_or_default();
    let known = std::env::split_paths(&path).flat_map(|folder| names.map(|name| folder.join(name)));
    std::env::var_os("FALSIFY_BROWSER").map(PathBuf::from).into_iter().chain(known).find(|place| place.is_file())
}

/// Whether a folder holds a file whose path from the top folder, of which `above` is the part so far, has all these words.
fn holds(folder: &Path, above: &str, words: &[&str]) -> bool {
    std::fs::read_dir(folder).into_iter().flatten().flatten().any(|entry| {
        let name = format!("{above}/{}", entry.file_name().to_string_lossy().to_lowercase());
        let path = entry.path();
        if path.is_dir() { holds(&path, &name, words) } else { words.iter().all(|word| name.contains(word)) }
    })
}

use std::collections::BTreeSet;
use std::env;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

use world::av::external::Program;

/// Programs whose first argument is a file to run, unless it is an option; a version may follow the name.
const INTERPRETERS: [&str; 10] = ["python", "pypy", "node", "ruby", "perl", "julia", "bash", "sh", "Rscript", "php"];

/// Looks for a program. If it runs scripts, looks for the script too.
///
/// # Errors
/// What is missing, as a part of a sentence.
pub(super) fn find(program: &Program) -> Result<(), String> {
    let (name, arguments) = program.words.split_first().expect("checked: a command names a program");
    let is_path = name.contains('/');
    let found = match is_path {
        true => program.folder.join(name).is_file(),
        false => env::split_paths(&env::var_os("PATH").unwrap_or_default()).any(|folder| folder.join(name).is_file()),
    };
    if !found {
        let place = if is_path { format!("in {}", shown(&program.folder)) } else { "on the PATH".into() };
        return Err(format!("there is no program `{name}` {place}"));
    }
    if let Some(missing) = program.files.iter().find(|file| !program.folder.join(file).exists()) {
        return Err(format!("there is no file or folder `{missing}` in {}", shown(&program.folder)));
    }
    match arguments.first().filter(|script| interprets(name) && !script.starts_with('-')) {
        Some(script) if !program.folder.join(script).is_file() => {
            Err(format!("there is no file `{script}` in {}", shown(&program.folder)))
        }
        _ => Ok(()),
    }
}

/// Whether a program runs scripts.
fn interprets(name: &str) -> bool {
    let file = Path::new(name).file_name().and_then(|file| file.to_str()).unwrap_or_default();
    INTERPRETERS.contains(&file.trim_end_matches(|end: char| end.is_ascii_digit() || end == '.'))
}

/// Computes a digest of what a program is made of: the files that its command names, those in the folder of its script that end as the script
/// does, and those that the scenario declares. The interpreter on the PATH, a server and an image are not known.
pub(super) fn digest(program: &Program) -> [u8; 32] {
    let mut all = blake3::Hasher::new();
    for path in sources(program) {
        let mut file = blake3::Hasher::new();
        file.update(path.strip_prefix(&program.folder).unwrap_or(&path).as_os_str().as_encoded_bytes());
        // A file that cannot be read is reported when the program is started.
        let _ = std::fs::File::open(&path).and_then(|opened| file.update_reader(opened).map(|_| ()));
        all.update(file.finalize().as_bytes());
    }
    *all.finalize().as_bytes()
}

/// The files that a program is made of.
fn sources(program: &Program) -> BTreeSet<PathBuf> {
    let named = program.words.iter().map(|word| program.folder.join(word)).filter(|path| path.is_file());
    let mut found: BTreeSet<PathBuf> = named.collect();
    if let Some((folder, ending)) = script_folder(program) {
        collect(&folder, &|path| path.extension() == Some(&ending), &mut found);
    }
    for path in program.files.iter().map(|file| program.folder.join(file)) {
        if path.is_dir() {
            collect(&path, &|_| true, &mut found);
        } else {
            found.insert(path);
        }
    }
    found
}

/// The folder of the script that an interpreter runs, and how its sources end; of `python -m MODULE` the folder in which it runs.
fn script_folder(program: &Program) -> Option<(PathBuf, OsString)> {
    let (name, arguments) = program.words.split_first()?;
    if !interprets(name) {
        return None;
    }
    if arguments.iter().any(|word| word == "-m") {
        return Some((program.folder.clone(), "py".into()));
    }
    let script = arguments.iter().map(|word| program.folder.join(word)).find(|path| path.is_file())?;
    Some((script.parent()?.to_path_buf(), script.extension()?.to_os_string()))
}

/// Folders that hold no source of a program.
const NO_SOURCES: [&str; 3] = ["__pycache__", "node_modules", "site-packages"];
/// The most files that are looked at. A folder with more is no folder of a script.
const MOST: usize = 10_000;

/// Adds the files below a folder; those of hidden folders, and of links to folders, are left out.
fn collect(folder: &Path, is_source: &dyn Fn(&Path) -> bool, found: &mut BTreeSet<PathBuf>) {
    let mut entries: Vec<_> = std::fs::read_dir(folder).into_iter().flatten().flatten().collect();
    entries.sort_by_key(std::fs::DirEntry::file_name);
    for entry in entries {
        let name = entry.file_name();
        let name = name.to_string_lossy();
        let Ok(kind) = entry.file_type() else { continue };
        if found.len() >= MOST || name.starts_with('.') || NO_SOURCES.contains(&&*name) {
            continue;
        }
        if kind.is_dir() {
            collect(&entry.path(), is_source, found);
        } else if is_source(&entry.path()) {
            found.insert(entry.path());
        }
    }
}

fn shown(folder: &Path) -> String {
    match folder.as_os_str().is_empty() {
        true => "this folder".into(),
        false => format!("`{}`", folder.display()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn missing(words: &[&str]) -> Option<String> {
        let words = words.iter().map(ToString::to_string).collect();
        find(&Program { words, folder: env!("CARGO_MANIFEST_DIR").into(), files: Vec::new() }).err()
    }

    #[test]
    fn programs_are_looked_for_on_the_path_or_beside_the_file() {
        assert_eq!(missing(&["sh"]), None);
        assert!(missing(&["no-such-driver-anywhere"]).unwrap().contains("on the PATH"));
        assert!(missing(&["./no-such-driver"]).unwrap().contains("no program `./no-such-driver` in `"));
        assert_eq!(missing(&["./Cargo.toml"]), None, "whether it can be run is seen when it is");
    }

    #[test]
    fn scripts_of_interpreters_must_be_there_and_other_arguments_need_not() {
        assert_eq!(missing(&["sh", "Cargo.toml", "no-such-file"]), None);
        assert!(missing(&["sh", "drivr.sh"]).unwrap().contains("no file `drivr.sh`"));
        assert_eq!(missing(&["sh", "-c", "exit"]), None);
        assert_eq!(missing(&["cat", "no-such-file"]), None);
    }

    #[test]
    fn a_program_is_made_of_its_scripts_folder_and_of_what_is_declared() {
        let place = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &str| {
            let path = place.path().join(name);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, text).unwrap();
        };
        for name in ["drv.py", "params.py", "part/deep.py", "__pycache__/old.py", "notes.txt", "gains.json"] {
            write(name, "1");
        }
        let digest_of = |words: &[&str], files: &[&str]| {
            let strings = |all: &[&str]| all.iter().map(ToString::to_string).collect();
            digest(&Program { words: strings(words), folder: place.path().into(), files: strings(files) })
        };
        let script = ["python3", "drv.py"];
        for (changed, words, files, differs) in [
            ("drv.py", &script[..], &[][..], true),
            ("params.py", &script, &[], true),
            ("part/deep.py", &script, &[], true),
            ("__pycache__/old.py", &script, &[], false),
            ("notes.txt", &script, &[], false),
            ("gains.json", &script, &[], false),
            ("gains.json", &script, &["gains.json"], true),
            ("notes.txt", &script, &["."], true),
            ("params.py", &["python3", "-m", "drv"], &[], true),
        ] {
            let before = digest_of(words, files);
            write(changed, "2");
            assert_eq!(digest_of(words, files) != before, differs, "{changed} of {words:?} with {files:?}");
            write(changed, "1");
        }
    }
}

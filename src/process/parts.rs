//! What a program is made of: the files that decide what it does, as far as they can be known.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};

use super::find::interprets;
use world::av::external::{Parts, Program};

/// Endings of files with settings and weights, which a program may read: those in the folder of a script count, too. Tables and texts do not, since a
/// program, or this one, may write them there.
const DATA: [&str; 25] = [
    "json",
    "yaml",
    "yml",
    "toml",
    "ini",
    "cfg",
    "conf",
    "xml",
    "npy",
    "npz",
    "pt",
    "pth",
    "ckpt",
    "onnx",
    "safetensors",
    "pkl",
    "pickle",
    "joblib",
    "h5",
    "hdf5",
    "bin",
    "pb",
    "tflite",
    "engine",
    "mat",
];
/// A folder with one of these holds reports, or installed packages.
const OF_OTHERS: [&str; 3] = [".falsify", "manifest.toml", "pyvenv.cfg"];
/// Endings of files of code: those in the folder of a script count, since one may import or start another.
const CODE: [&str; 14] = ["py", "pyx", "so", "sh", "bash", "js", "mjs", "cjs", "rb", "pl", "jl", "R", "php", "lua"];
/// Programs that run what is elsewhere: an image, or a program of another machine.
const ELSEWHERE: [&str; 13] = [
    "docker",
    "podman",
    "nerdctl",
    "apptainer",
    "singularity",
    "kubectl",
    "nc",
    "ncat",
    "netcat",
    "socat",
    "ssh",
    "telnet",
    "curl",
];
/// Folders that hold no source of a program.
const NO_SOURCES: [&str; 3] = ["__pycache__", "node_modules", "site-packages"];
/// How a script in Python adds folders to where it finds modules, and the longest one that is read (bytes).
const ADDERS: [&str; 4] = ["sys.path.insert", "sys.path.append", "sys.path.extend", "sys.path +="];
const MOST_BYTES: u64 = 1 << 20;
/// The most files and folders that are looked at. A folder with more is no folder of a script.
const MOST: usize = 10_000;

/// Finds what a program is made of: the files that its command names, the code, settings and weights in the folder of its script and below, and what the
/// scenario declares. It is unknown when no file of it is beside the scenario (a server, an image, an installed package), and where a script in Python adds folders
/// to `sys.path` without `files` that name them.
pub(super) fn parts(program: &Program) -> Parts {
    let mut sources = Sources::default();
    let named = program.words.iter().map(|word| program.folder.join(word)).filter(|path| path.is_file());
    sources.files.extend(named.clone());
    let mut folders: BTreeSet<PathBuf> =
        named.filter(|path| is_script(path)).filter_map(|path| path.parent().map(Path::to_path_buf)).collect();
    folders.extend(module(program).and_then(|(_, path)| path).map(|_| program.folder.clone()));
    folders
        .iter()
        .for_each(|folder| sources.collect(folder, &|path| has_ending(path, &CODE) || has_ending(path, &DATA)));
    // Of a declared folder all files count, not the code alone.
    sources.folders.clear();
    for path in program.files.iter().map(|file| program.folder.join(file)) {
        if path.is_dir() {
            sources.collect(&path, &|_| true);
        } else {
            sources.files.insert(path);
        }
    }
    let unknown = unknown(program)
        .or_else(|| {
            (sources.looked > MOST).then(|| format!("the folder of its script has more than {MOST} files and folders"))
        })
        .or_else(|| if program.files.is_empty() { sources.adds_folders(&program.folder) } else { None });
    let name = |path: &Path| path.strip_prefix(&program.folder).unwrap_or(path).to_string_lossy().into_owned();
    // A file that cannot be read is reported when the program is started.
    let files = sources.files.iter().map(|path| (name(path), digest(path).unwrap_or_default()));
    Parts { files: files.collect::<BTreeMap<_, _>>(), unknown }
}

fn digest(path: &Path) -> std::io::Result<String> {
    let mut digest = blake3::Hasher::new();
    digest.update_reader(fs::File::open(path)?)?;
    Ok(digest.finalize().to_hex().to_string())
}

/// Why the files of a program do not decide what it does, as half a sentence.
fn unknown(program: &Program) -> Option<String> {
    let is_file = |word: &String| program.folder.join(word).is_file();
    let name_of = |word: &str| Path::new(word).file_name().unwrap_or_default().to_string_lossy().into_owned();
    let elsewhere = program.words.iter().map(|word| name_of(word)).find(|name| ELSEWHERE.contains(&name.as_str()));
    if let Some(name) = elsewhere {
        return Some(format!("`{name}` runs what is elsewhere"));
    }
    if let Some((module, found)) = module(program) {
        return found.is_none().then(|| format!("the module `{module}` is not beside the scenario"));
    }
    let first = program.words.first()?;
    // An installed command is a few lines that import a package.
    let is_installed = |word: &str| {
        let path = program.folder.join(word);
        path.parent().and_then(Path::parent).is_some_and(|above| above.join("pyvenv.cfg").is_file())
    };
    let runs_itself = first.contains('/') && !interprets(first) && !is_installed(first);
    let names_a_file = runs_itself || program.words[1..].iter().any(is_file);
    (!names_a_file).then(|| format!("no file of `{}` is beside the scenario", name_of(first)))
}

/// The module of `python3 -m MODULE`, and its file or folder if that is beside the scenario.
fn module(program: &Program) -> Option<(&str, Option<PathBuf>)> {
    let interpreter = program.words.iter().position(|word| interprets(word))?;
    let mut words = program.words[interpreter..].iter();
    words.find(|word| *word == "-m")?;
    let module = words.next()?;
    let path = program.folder.join(module.replace('.', "/"));
    let file = path.with_extension("py");
    let found = if file.is_file() { Some(file) } else { Some(path).filter(|path| path.is_dir()) };
    Some((module, found))
}

/// Whether a file is a script: by its ending, or by its first two bytes.
fn is_script(path: &Path) -> bool {
    let mut start = [0; 2];
    has_ending(path, &CODE)
        || fs::File::open(path).and_then(|mut file| file.read_exact(&mut start)).is_ok() && start == *b"#!"
}

fn has_ending(path: &Path, endings: &[&str]) -> bool {
    path.extension().is_some_and(|ending| endings.iter().any(|each| ending == *each))
}

/// The files of a program.
#[derive(Default)]
struct Sources {
    files: BTreeSet<PathBuf>,
    /// The folders that were looked into, without links.
    folders: BTreeSet<PathBuf>,
    /// The number of files and folders that were looked at.
    looked: usize,
}

impl Sources {
    /// The first script in Python that adds folders to where it finds modules, as half a sentence: their code may lie anywhere.
    fn adds_folders(&self, folder: &Path) -> Option<String> {
        let scripts = self.files.iter().filter(|path| path.extension().is_some_and(|ending| ending == "py"));
        let adds =
            |path: &&PathBuf| fs::read_to_string(path).is_ok_and(|text| ADDERS.iter().any(|each| text.contains(each)));
        let found = scripts.filter(|path| path.metadata().is_ok_and(|file| file.len() <= MOST_BYTES)).find(adds)?;
        let name = found.strip_prefix(folder).unwrap_or(found).display();
        Some(format!("`{name}` adds folders to `sys.path`, whose code is not looked at unless `files` names it"))
    }

    /// Adds the files below a folder, also behind links; those of hidden folders are left out.
    fn collect(&mut self, folder: &Path, is_source: &dyn Fn(&Path) -> bool) {
        let here = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        if !here.canonicalize().is_ok_and(|folder| self.folders.insert(folder)) {
            return;
        }
        let mut entries: Vec<_> = fs::read_dir(here).into_iter().flatten().flatten().collect();
        entries.sort_by_key(fs::DirEntry::file_name);
        for entry in entries {
            let (path, name) = (folder.join(entry.file_name()), entry.file_name());
            let name = name.to_string_lossy();
            if name.starts_with('.') || NO_SOURCES.contains(&&*name) {
                continue;
            }
            self.looked += 1;
            if self.looked > MOST {
                return;
            }
            if path.is_dir() {
                if !OF_OTHERS.iter().any(|name| path.join(name).exists()) {
                    self.collect(&path, is_source);
                }
            } else if is_source(&path) {
                self.files.insert(path);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The parts of a program in a folder.
    fn of(folder: &Path, words: &[&str], files: &[&str]) -> Parts {
        let strings = |all: &[&str]| all.iter().map(ToString::to_string).collect();
        parts(&Program { words: strings(words), folder: folder.into(), files: strings(files) })
    }

    fn folder() -> tempfile::TempDir {
        let place = tempfile::tempdir().unwrap();
        for (name, text) in [
            ("drv.py", "1"),
            ("params.py", "1"),
            ("part/deep.py", "1"),
            ("__pycache__/old.py", "1"),
            ("notes.txt", "1"),
            ("gains.json", "1"),
            ("reports/run/manifest.toml", "1"),
            ("reports/run/results.json", "1"),
            ("av", "#!/usr/bin/env python3\n"),
            ("built", "\u{7f}ELF"),
            ("venv/pyvenv.cfg", ""),
            ("venv/bin/av", "#!/usr/bin/env python3\n"),
            ("venv/bin/python3", "\u{7f}ELF"),
        ] {
            let path = place.path().join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, text).unwrap();
        }
        place
    }

    #[test]
    fn a_program_is_made_of_its_scripts_folder_and_of_what_is_declared() {
        let place = folder();
        let script = ["python3", "drv.py"];
        for (changed, words, files, differs) in [
            ("drv.py", &script[..], &[][..], true),
            ("params.py", &script, &[], true),
            ("part/deep.py", &script, &[], true),
            ("__pycache__/old.py", &script, &[], false),
            ("notes.txt", &script, &[], false),
            ("gains.json", &script, &[], true),
            ("gains.json", &script, &["gains.json"], true),
            ("reports/run/results.json", &script, &[], false),
            ("notes.txt", &script, &["."], true),
            ("params.py", &["python3", "-m", "drv"], &[], true),
            ("params.py", &["./av"], &[], true),
            ("params.py", &["nice", "python3", "-u", "drv.py"], &[], true),
            ("params.py", &["./built"], &[], false),
        ] {
            let before = of(place.path(), words, files);
            fs::write(place.path().join(changed), "2").unwrap();
            let after = of(place.path(), words, files);
            assert_eq!(after != before, differs, "{changed} of {words:?} with {files:?}");
            assert_eq!(after.files.keys().any(|name| name == changed), differs, "it is named: {after:?}");
            fs::write(place.path().join(changed), "1").unwrap();
        }
    }

    #[test]
    fn a_program_without_a_file_beside_the_scenario_is_unknown() {
        let place = folder();
        for (words, why) in [
            (&["python3", "drv.py"][..], None),
            (&["python3", "-m", "drv"], None),
            (&["python3", "-m", "part.deep"], None),
            (&["./av"], None),
            (&["./built"], None),
            (&["java", "-jar", "built"], None),
            (&["venv/bin/python3", "drv.py"], None),
            (
                &["python3", "-m", "installed_package"],
                Some("the module `installed_package` is not beside the scenario"),
            ),
            (&["python3", "-c", "print()"], Some("no file of `python3` is beside the scenario")),
            (&["installed-av", "--fast"], Some("no file of `installed-av` is beside the scenario")),
            (&["venv/bin/av"], Some("no file of `av` is beside the scenario")),
            (&["nc", "localhost", "4711"], Some("`nc` runs what is elsewhere")),
            (&["docker", "run", "-i", "image", "drv.py"], Some("`docker` runs what is elsewhere")),
        ] {
            assert_eq!(of(place.path(), words, &[]).unknown.as_deref(), why, "{words:?}");
        }
    }

    #[test]
    fn a_script_that_adds_folders_to_its_path_is_unknown_unless_files_are_named() {
        let place = folder();
        fs::write(place.path().join("part/deep.py"), "import sys\nsys.path.insert(0, '../common')\n").unwrap();
        let why = "`part/deep.py` adds folders to `sys.path`, whose code is not looked at unless `files` names it";
        assert_eq!(of(place.path(), &["python3", "drv.py"], &[]).unknown.as_deref(), Some(why));
        assert_eq!(of(place.path(), &["python3", "drv.py"], &["gains.json"]).unknown, None);
    }

    #[cfg(unix)]
    #[test]
    fn code_behind_a_link_counts_and_a_link_to_a_folder_above_does_not_end_it() {
        let (place, other) = (folder(), tempfile::tempdir().unwrap());
        fs::write(other.path().join("shared.py"), "1").unwrap();
        std::os::unix::fs::symlink(other.path(), place.path().join("common")).unwrap();
        std::os::unix::fs::symlink(place.path(), place.path().join("part/up")).unwrap();
        let parts = of(place.path(), &["python3", "drv.py"], &[]);
        let names: Vec<&str> = parts.files.keys().map(String::as_str).collect();
        assert_eq!(names, ["common/shared.py", "drv.py", "gains.json", "params.py", "part/deep.py"]);
    }
}

use std::env;
use std::path::Path;

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

/// What installs the Python package of falsify, and what a driver or a world of it needs, which these words start.
pub fn missing_package(words: &[String]) -> String {
    let name = words.iter().skip_while(|word| !word.starts_with("falsify_av")).nth(1);
    // Older versions of pip find no extra whose name has an underscore.
    let extra = name.map_or_else(String::new, |name| format!("[{}]", name.replace('_', "-")));
    format!(
        "the Python package of falsify is not installed: `pip install './python{extra}'` in a clone installs it and what the program needs"
    )
}

/// Whether a program runs scripts.
fn interprets(name: &str) -> bool {
    let file = Path::new(name).file_name().and_then(|file| file.to_str()).unwrap_or_default();
    INTERPRETERS.contains(&file.trim_end_matches(|end: char| end.is_ascii_digit() || end == '.'))
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
        find(&Program { words, folder: env!("CARGO_MANIFEST_DIR").into(), ..Program::default() }).err()
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
}

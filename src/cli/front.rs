//! Files → plan, with everything that is to be said about them on the error stream.

use std::cell::RefCell;
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use anstyle::{AnsiColor, Style};

use super::ExitCode;
use super::args::GivenOptions;
use crate::compile::{Catalog, Compiled, Overrides, Plan, compile_with};
use crate::diagnostic::{Colour, Diagnostic, Severity, Sources, render};
use crate::lang::{Reader, library};
use crate::process::ProcessOpener;
use crate::report::{Call, FileRecord};

const ERROR: Style = AnsiColor::Red.on_default().bold();
const WARNING: Style = AnsiColor::Yellow.on_default().bold();

/// The longest file that is read: a device may have no end.
const MOST_BYTES: u64 = 512 << 20;

/// Most diagnostics that are shown at once.
const SHOWN: usize = 50;

/// Writes a line to the error stream. Nobody can be told when that fails, and what was asked for is done all the same.
pub fn note(line: &str) {
    let _ = writeln!(anstream::stderr(), "{line}");
}

/// Says that something went wrong, in the manner of the diagnostics.
pub fn fail(message: &str) {
    note(&format!("{ERROR}error{ERROR:#}: {message}"));
}

/// Says something that may be of interest, but is no error.
pub fn warn(message: &str) {
    note(&format!("{WARNING}warning{WARNING:#}: {message}"));
}

/// The command of this process as a user would type it again.
pub fn command_line() -> String {
    let plain = |c: char| c.is_alphanumeric() || "-_./=:,@%+".contains(c);
    let quoted = |word: String| {
        if !word.is_empty() && word.chars().all(plain) { word } else { format!("'{}'", word.replace('\'', "'\\''")) }
    };
    let words = std::env::args().skip(1).map(quoted);
    std::iter::once("falsify".to_string()).chain(words).collect::<Vec<_>>().join(" ")
}

/// Whether something that was said could not be written.
static LOST: AtomicBool = AtomicBool::new(false);

/// Prints a line for the user. A reader that has gone away, as after `| head`, is no mistake; other losses are told by [`lost`].
pub fn say(line: &str) {
    let mut output = anstream::stdout();
    let written = writeln!(output, "{line}").and_then(|()| output.flush());
    if written.is_err_and(|error| error.kind() != std::io::ErrorKind::BrokenPipe) {
        LOST.store(true, Ordering::Relaxed);
    }
}

/// Whether something that was said could not be written, to a full disk perhaps.
pub fn lost() -> bool {
    LOST.load(Ordering::Relaxed)
}

/// Reads the files of the disk and keeps a record of each.
struct Files {
    /// Whether they are only counted: records have no digests.
    counted: bool,
    records: RefCell<Vec<FileRecord>>,
}

impl Files {
    fn record(&self, path: &Path, contents: &[u8]) -> FileRecord {
        let path = path.display().to_string();
        if self.counted { FileRecord { path, blake3: String::new() } } else { FileRecord::new(path, contents) }
    }
}

impl Reader for Files {
    fn text(&self, path: &Path) -> std::io::Result<String> {
        let text = String::from_utf8(self.bytes(path)?);
        text.map_err(|error| std::io::Error::new(std::io::ErrorKind::InvalidData, error))
    }

    fn bytes(&self, path: &Path) -> std::io::Result<Vec<u8>> {
        let file = std::fs::File::open(path)?;
        // Room for all of it and for seeing that it has ended.
        let size = file.metadata().map_or(0, |known| known.len().min(MOST_BYTES) + 1);
        let mut bytes = Vec::with_capacity(size as usize);
        file.take(MOST_BYTES + 1).read_to_end(&mut bytes)?;
        if bytes.len() as u64 > MOST_BYTES {
            return Err(std::io::Error::other(format!("it has more than {} MiB", MOST_BYTES >> 20)));
        }
        self.records.borrow_mut().push(self.record(path, &bytes));
        Ok(bytes)
    }
}

/// A number of things: `1 file`, `2 files`.
pub fn count(number: usize, thing: &str) -> String {
    format!("{number} {thing}{}", if number == 1 { "" } else { "s" })
}

/// Draws diagnostics on the error stream, the first of them if there are many.
pub fn show(diagnostics: &[Diagnostic], sources: &Sources) {
    for diagnostic in diagnostics.iter().take(SHOWN) {
        // The stream strips the colours where they are not wanted.
        note(&format!("{}\n", render(diagnostic, sources, Colour::Always)));
    }
    if diagnostics.len() > SHOWN {
        note(&format!("… and {} more\n", diagnostics.len() - SHOWN));
    }
}

/// What came of files, with their texts.
pub struct Gathered {
    /// The plan and what is to be said.
    pub compiled: Compiled,
    /// The texts.
    pub sources: Sources,
    /// A record of every file that was read, without its digest when the files were only to be checked.
    pub records: Vec<FileRecord>,
}

/// What the program was given, for whoever repeats it.
pub fn call(files: &[PathBuf], given: &GivenOptions) -> Call {
    let text = |path: &PathBuf| path.display().to_string();
    Call {
        folder: std::env::current_dir().map_or_else(|_| String::new(), |folder| text(&folder)),
        scenarios: files.iter().map(text).collect(),
        maps: given.map.iter().map(|(town, file)| format!("{town}={}", file.display())).collect(),
        set: given.set.clone(),
        allow_external: given.allow_external,
    }
}

/// Reads, checks and compiles files, and says nothing about their contents.
///
/// # Errors
/// The exit code, after the reason has been printed.
pub fn gather(files: &[PathBuf], given: &GivenOptions, overrides: Overrides) -> Result<Gathered, ExitCode> {
    let mut sources;
    let read = Files { counted: overrides.only_checked, records: RefCell::default() };
    let catalog = match given.allow_external {
        true => Catalog::builtin().with_opener(Arc::new(ProcessOpener::default())),
        false => Catalog::builtin(),
    };
    let mut left = files.to_vec();
    let compiled = loop {
        sources = Sources::default();
        match compile_with(&left, &overrides, &catalog, &read, &mut sources) {
            Ok(compiled) => break compiled,
            Err(error) => {
                fail(&error.to_string());
                left.retain(|each| *each != error.path);
            }
        }
    };
    if left.len() < files.len() {
        // What is wrong with the others can be told all the same.
        show(&compiled.diagnostics, &sources);
        return Err(ExitCode::Usage);
    }
    let mut records = read.records.take();
    let library = sources.iter().filter(|(_, source)| library::holds(&source.path));
    records.extend(library.map(|(_, source)| read.record(&source.path, source.text.as_bytes())));
    Ok(Gathered { compiled, sources, records })
}

/// Reads, checks and compiles files; gives the plan and a record of every file that was read.
///
/// # Errors
/// The exit code, after the reason has been printed.
pub fn compile_files(files: &[PathBuf], given: &GivenOptions) -> Result<(Plan, Vec<FileRecord>), ExitCode> {
    let gathered = gather(files, given, given.overrides())?;
    tell(&gathered, given, "nothing was run")?;
    Ok((gathered.compiled.plan.expect("no errors were told"), gathered.records))
}

/// Says what is wrong with files; `consequence` is what errors lead to.
///
/// # Errors
/// There are errors, or a map is given for a town that nothing uses.
pub fn tell(gathered: &Gathered, given: &GivenOptions, consequence: &str) -> Result<(), ExitCode> {
    let Compiled { plan, diagnostics, .. } = &gathered.compiled;
    show(diagnostics, &gathered.sources);
    let Some(plan) = plan else {
        let errors = diagnostics.iter().filter(|each| each.severity == Severity::Error).count();
        let consequence = if consequence.is_empty() { String::new() } else { format!("; {consequence}") };
        fail(&format!("{} found{consequence}", count(errors, "error")));
        return Err(ExitCode::Scenario);
    };
    match given.map.iter().map(|(name, _)| name).find(|name| !plan.has_town(name)) {
        None => Ok(()),
        Some(name) => {
            fail(&format!("--map names the town `{name}`, which nothing uses"));
            Err(ExitCode::Usage)
        }
    }
}

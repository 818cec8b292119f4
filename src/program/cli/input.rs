//! The input of a command, and the session that reads it.

use std::io::IsTerminal;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError, RwLock};

use clap::Args;

use super::failure::misused;
use super::progress::{Counting, Showing, heartbeat};
use super::{console, failure, interrupt, network_trial};
use crate::exit_code::ExitCode;
use crate::session::{Event, Input, Observer, Session, Stage};
use compile::Catalog;
use episode::MapWriter;
use process::ProcessOpener;
use world::av::external::Opener;

/// Options that replace parts of the files.
#[derive(Debug, Args)]
pub struct GivenArgs {
    /// The replacements.
    #[command(flatten)]
    pub input: Input,
    /// Let scenarios name programs as drivers, which `run` starts; use it only with files that you trust.
    #[arg(long, help_heading = "Scenario")]
    pub allow_external: bool,
}

impl GivenArgs {
    /// These files and their replacements.
    pub fn input(&self, files: &[PathBuf]) -> Input {
        Input { files: files.to_vec(), ..self.input.clone() }
    }
}

/// Makes the language of the commands in this process.
static LANGUAGE: RwLock<fn() -> Catalog> = RwLock::new(Catalog::builtin);

/// Sets the language of the commands.
pub fn speak(language: fn() -> Catalog) {
    *LANGUAGE.write().unwrap_or_else(PoisonError::into_inner) = language;
}

/// The language, without programs and without trials of networks.
pub fn language() -> Catalog {
    let make = *LANGUAGE.read().unwrap_or_else(PoisonError::into_inner);
    make()
}

/// The language of the commands without programs: networks are tried before they are loaded, and maps are written for other worlds.
fn without_programs() -> Catalog {
    language().with_network_trial(network_trial::trial()).with_map_writer(map_writer())
}

/// Writes the maps of towns for other worlds.
pub fn map_writer() -> Arc<MapWriter> {
    Arc::new(|town| export::town(town).map_err(|error| error.to_string()))
}

/// The language for editors: programs are looked up, and none is started.
pub fn catalog() -> Catalog {
    without_programs().with_opener(Arc::new(ProcessOpener::default()))
}

/// A session that reports on the error stream, with progress on a terminal alone, and stops at Ctrl-C.
pub fn session(allow_external: bool) -> Session {
    session_through(allow_external.then(|| Arc::new(ProcessOpener::of_program()) as Arc<dyn Opener>))
}

/// The same; scenarios start programs through this opener, if there is one.
pub fn session_through(opener: Option<Arc<dyn Opener>>) -> Session {
    session_in(match opener {
        Some(opener) => without_programs().with_opener(opener),
        None => without_programs(),
    })
}

/// The same for a check: a program that is not allowed is looked up, with a warning.
pub fn checking_session(allow_external: bool) -> Session {
    match allow_external {
        true => session(true),
        false => session_in(without_programs().looking_up(Arc::new(ProcessOpener::default()))),
    }
}

fn session_in(catalog: Catalog) -> Session {
    let session = Session::new(catalog);
    let showing = if std::io::stderr().is_terminal() { Showing::Bars } else { Showing::None };
    let session = session.with_observer(Arc::new(Reporter::new(showing))).with_stop(interrupt::stop());
    session.with_folder(std::env::current_dir().unwrap_or_default())
}

/// Reports diagnostics, notices and progress on the error stream.
#[derive(Debug)]
pub struct Reporter {
    showing: Showing,
    /// The stage that is under way, with its progress.
    stage: Arc<Mutex<Option<(Stage, Counting)>>>,
}

impl Reporter {
    /// With this form of the progress.
    pub fn new(showing: Showing) -> Self {
        let stage = Arc::default();
        if showing != Showing::None {
            heartbeat(&stage, |shown: &mut Option<(Stage, Counting)>| {
                shown.iter_mut().for_each(|(_, counting)| counting.beat());
            });
        }
        Self { showing, stage }
    }

    /// Removes the progress.
    pub fn end(&self) {
        *self.stage.lock().unwrap_or_else(PoisonError::into_inner) = None;
    }

    fn played(&self, stage: Stage, done: u64, all: u64) {
        let doing = match stage {
            Stage::Failures => "failures met again",
            Stage::Crossings => "episodes of the fixed list",
            Stage::Causes => "why: episodes, at most",
        };
        let mut shown = self.stage.lock().unwrap_or_else(PoisonError::into_inner);
        if shown.as_ref().is_none_or(|(known, _)| *known != stage) {
            *shown = None;
            *shown = Some((stage, Counting::new(doing, all, self.showing)));
        }
        shown.iter_mut().for_each(|(_, counting)| counting.reach(done));
    }
}

impl Observer for Reporter {
    fn event(&self, event: &Event<'_>) {
        match event {
            Event::Diagnostics(diagnostics, sources) => console::show(diagnostics, sources),
            Event::Notice(notice) => failure::notice(notice),
            Event::Played { stage: Stage::Causes, done, all } if done == all => self.end(),
            Event::Played { stage, done, all } => self.played(*stage, *done, *all),
            _ => {}
        }
    }
}

/// Refuses to write onto a file that is read, or two outputs into one file.
///
/// # Errors
/// The exit code, after the reason has been printed.
pub fn refuse_overwriting(outputs: &[Option<&PathBuf>], inputs: &[PathBuf]) -> Result<(), ExitCode> {
    let whole = |path: &PathBuf| {
        std::path::absolute(path).and_then(|path| {
            let folder = path.parent().map_or(Ok(path.clone()), std::fs::canonicalize)?;
            let whole = folder.join(path.file_name().unwrap_or_default());
            Ok(std::fs::canonicalize(&whole).unwrap_or(whole))
        })
    };
    let mut known: Vec<PathBuf> = inputs.iter().filter_map(|path| whole(path).ok()).collect();
    for output in outputs.iter().flatten() {
        let Ok(path) = whole(output) else { continue };
        if known.contains(&path) {
            let path = output.display();
            return Err(misused(format!("`{path}` is read, or written twice, by this command; choose another name")));
        }
        known.push(path);
    }
    Ok(())
}
